"""Bodies that drivers move, one after the other from the ground on, become part of the ground as functions of time.

A body belongs to it if only one joint and the driver of the joint's free coordinate connect it with the ground or with
bodies that belong to it already. The poses of its frames become expressions in time, which replace the coordinates of
these frames in laws and initial values.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import NamedTuple

from mbdsl.elements.kind import JointKind
from mbdsl.expressions.symbolic import Expr, expr, leaves, substitute
from mbdsl.mechanism.edge import Edge
from mbdsl.mechanism.graph import GROUND, MechanismGraph
from mbdsl.mechanism.poses import PlanarPose
from mbdsl.mechanism.reduction.note import Note
from mbdsl.mechanism.reduction.welds import RIGID
from mbdsl.mechanism.scene import Component, Frame, Scene


class Drive(NamedTuple):
    """``joint`` leaves one coordinate free, and ``driver`` prescribes it: u, an expression in time."""

    joint: Edge
    driver: Edge
    u: Expr


def carry(graph: MechanismGraph) -> tuple[Scene, list[Note]]:
    """The scene of ``graph`` without the bodies whose poses follow from drivers alone."""
    scene = graph.scene
    poses, drives = _driven(graph)
    if not poses:
        return scene, []
    components, frames, notes = dict(scene.components), dict(scene.frames), list[Note]()
    for body, drive in drives.items():
        for name in (body, drive.joint.name, drive.driver.name):
            del components[name]
        by = (drive.joint.name, drive.driver.name)
        notes.append(Note("moved", (body,), "its motion is a function of time", by, drive.driver.component.span))
    for name, frame in scene.frames.items():
        if frame.body in poses:
            x, y, phi = (expr(value) for value in poses[frame.body] @ frame.pose)
            driver = drives[frame.body].driver.component
            frames[name] = Frame(name, graph.ground.name, span=frame.span, motion=(x, y, phi), driver=driver)
    moved = replace(scene, components=components, frames=frames)
    known = moved.prescribed
    components = {name: rewritten(c, known) for name, c in components.items()}
    initial = tuple(replace(x, target=substitute(x.target, known)) for x in scene.initial)
    return replace(moved, components=components, initial=initial), notes


def rewritten(c: Component, known) -> Component:
    """The component with ``known`` expressions in place of leaves of its laws."""
    values = {k: substitute(v, known) if isinstance(v, Expr) else v for k, v in c.values.items()}
    return replace(
        c,
        values=values,
        velocity_constraints=tuple(substitute(e, known) for e in c.velocity_constraints),
        relations=tuple(substitute(e, known) for e in c.relations),
        friction=substitute(c.friction, known) if c.friction is not None else None,
        friction_rows=tuple(substitute(e, known) for e in c.friction_rows),
    )


def _driven(graph: MechanismGraph) -> tuple[dict[str, PlanarPose], dict[str, Drive]]:
    """Poses of the reference points of driven bodies, and their drives, from the ground outwards."""
    if not any(_drives(e) for e in graph.joints):
        return {}, {}
    at: dict[str, list[Edge]] = {GROUND: [], **{body: [] for body in graph.bodies}}
    for e in graph.joints:
        for body in {e.body_i, e.body_j, *e.also} if e.rows or e.velocity_rows else ():
            at[body].append(e)
    read = {name for e in (*graph.joints, *graph.forces) for name in e.reads}
    poses: dict[str, PlanarPose] = {}
    drives: dict[str, Drive] = {}
    reached = {GROUND}
    pending = [GROUND]
    for base in pending:
        for body in dict.fromkeys(e.other(base) for e in at[base]):
            if body in reached or graph.bodies[body].coordinates != RIGID:
                continue
            joins = [e for e in at[body] if e.other(body) in reached]
            drive = _drive(joins)
            if drive is None or drive.joint.name in read or drive.driver.name in read:
                continue
            poses[body] = _pose_of(graph.scene, body, drive, poses)
            drives[body] = drive
            reached.add(body)
            pending.append(body)
    # A body was accepted before all its neighbours were known; the outermost one with additional joints is removed.
    while wrong := [b for b in drives if sum(_closed(e, poses) for e in at[b]) > 2 + _children(b, drives)]:
        gone = [wrong[-1]]
        for body in gone:
            gone += [b for b, d in drives.items() if d.joint.other(b) == body]
            del poses[body]
        drives = {b: d for b, d in drives.items() if b in poses}
    return poses, drives


def _closed(e: Edge, poses: Mapping[str, PlanarPose]) -> bool:
    return all(b == GROUND or b in poses for b in (e.body_i, e.body_j))


def _children(body: str, drives: Mapping[str, Drive]) -> int:
    """The number of joints and drivers that connect driven bodies with this one, their parent."""
    return 2 * sum(d.joint.other(b) == body for b, d in drives.items())


def _drives(e: Edge) -> bool:
    return isinstance(e.component.kind, JointKind) and e.component.kind.driver is not None


def _drive(joins: list[Edge]) -> Drive | None:
    """The joint and the driver that hold a body, if they are its only two joints and u depends on time alone."""
    drivers = [e for e in joins if _drives(e)]
    others = [e for e in joins if not _drives(e)]
    if len(drivers) != 1 or len(others) != 1:
        return None
    driver, joint = drivers[0].component, others[0].component
    assert isinstance(driver.kind, JointKind) and isinstance(joint.kind, JointKind)
    if joint.kind.placing.pose is None or joint.kind.placing.free != driver.kind.driver or joint.velocity_constraints:
        return None
    u = expr(driver.values[driver.kind.driver])
    if dict(joint.ports) != dict(driver.ports) or any(leaf.op != "time" for leaf in leaves(u)):
        return None
    return Drive(others[0], drivers[0], u)


def _pose_of(scene: Scene, body: str, drive: Drive, poses: Mapping[str, PlanarPose]) -> PlanarPose:
    """Pose of a body's reference point in the world."""
    joint = drive.joint.component
    assert isinstance(joint.kind, JointKind) and joint.kind.placing.pose is not None
    relative = PlanarPose(*joint.kind.placing.pose(joint.values, drive.u))
    frame_a, frame_b = (scene.frames[joint.ports[port]] for port in joint.kind.ports)
    base, own = (frame_a, frame_b) if frame_b.body == body else (frame_b, frame_a)
    relative = relative if own is frame_b else relative.inverse()
    start = poses.get(base.body, PlanarPose()) @ base.pose
    return start @ relative @ own.pose.inverse()
