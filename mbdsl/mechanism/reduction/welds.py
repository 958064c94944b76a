"""Welded bodies become one body; bodies welded to the ground become part of it.

The frames of all bodies are kept and fixed to the resulting body. Joints, forces, signals and initial values refer to
frames only, so that they need no change.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import replace

from mbdsl.elements import find
from mbdsl.elements.kind import BodyKind, JointKind
from mbdsl.mechanism.edge import Edge
from mbdsl.mechanism.graph import GROUND, MechanismGraph
from mbdsl.mechanism.poses import PlanarPose
from mbdsl.mechanism.reduction.note import Note
from mbdsl.mechanism.scene import Component, Frame, Scene

RIGID = ("x", "y", "phi")  #: coordinates of a rigid body


def merge(graph: MechanismGraph) -> tuple[Scene, list[Note]]:
    """The scene of ``graph`` with welded bodies merged."""
    scene, notes = graph.scene, list[Note]()
    welds = [e for e in graph.joints if _welds(e.component)]
    if not welds:
        return scene, notes
    read = {name for e in (*graph.joints, *graph.forces) for name in e.reads}
    usable = []
    for e in welds:
        ends = [b for b in (e.body_i, e.body_j) if b != GROUND]
        if e.name in read:
            notes.append(_kept(e, "a law reads its reactions"))
        elif any(graph.bodies[b].coordinates != RIGID for b in ends):
            notes.append(_kept(e, "it connects a body that is not rigid"))
        else:
            usable.append(e)
    components, frames = dict(scene.components), dict(scene.frames)
    groups = _groups(graph, usable)
    more = _more(graph, groups)
    for k, (group, tree) in enumerate(groups):
        if k in more:
            notes += [_kept(e, f"{more[k].name} joins the same bodies once more") for e in tree]
            continue
        root = GROUND if GROUND in group else _root(scene, group)
        poses = _poses(scene, root, tree)
        owner = graph.ground.name if root == GROUND else root
        for name, frame in scene.frames.items():
            if frame.body in poses:
                frames[name] = _moved(frame, owner, poses[frame.body] @ frame.pose)
        for e in tree:
            del components[e.name]
        rest = [b for b in group if b not in (root, GROUND)]
        by = tuple(e.name for e in tree)
        if root == GROUND:
            for body in rest:
                del components[body]
            notes.append(Note("grounded", tuple(rest), "welded to the ground", by, tree[0].component.span))
        else:
            components[root] = _sum(components[root], [(components[b], poses[b]) for b in (root, *rest)])
            for body in rest:
                del components[body]
            notes.append(Note("merged", (root, *rest), "welded together", by, tree[0].component.span))
    return replace(scene, components=components, frames=frames), notes


def _welds(c: Component) -> bool:
    return isinstance(c.kind, JointKind) and c.kind.placing.pose is not None and not c.kind.placing.free


def _more(graph: MechanismGraph, groups: list[tuple[list[str], list[Edge]]]) -> dict[int, Edge]:
    """Number of a group -> a joint that connects bodies of this group only, in addition to its tree of welds."""
    number = {body: k for k, (group, _) in enumerate(groups) for body in group}
    used = {e.name for _, tree in groups for e in tree}
    found: dict[int, Edge] = {}
    for e in graph.joints:
        if e.name not in used and (e.rows or e.velocity_rows):
            ends = (e.body_i, e.body_j) if e.component.ports else (e.body_i, e.body_j, *e.also)
            into = {number.get(b, -1) for b in ends}
            if len(into) == 1 and into != {-1}:
                found.setdefault(into.pop(), e)
    return found


def _kept(e: Edge, why: str) -> Note:
    return Note("kept", (e.name,), why, (e.name,), e.component.span)


def _groups(graph: MechanismGraph, welds: Iterable[Edge]) -> list[tuple[list[str], list[Edge]]]:
    """Groups of bodies connected by welds, each from the ground or its first body outwards, with a tree of welds."""
    at: dict[str, list[Edge]] = {}
    for e in welds:
        at.setdefault(e.body_i, []).append(e)
        at.setdefault(e.body_j, []).append(e)
    done: set[str] = set()
    found = []
    for start in (GROUND, *graph.bodies):
        if start in done or start not in at:
            continue
        group, tree = [start], []
        done.add(start)
        for body in group:
            for e in at[body]:
                if (other := e.other(body)) not in done:
                    done.add(other)
                    group.append(other)
                    tree.append(e)
        found.append((group, tree))
    return found


def _root(scene: Scene, group: list[str]) -> str:
    """The body whose angle has an initial value, which then determines the placement; else the first body."""
    said = {x.target for x in scene.initial}
    return next((b for b in group if scene.signal_of(scene.components[b], "phi") in said), group[0])


def _poses(scene: Scene, root: str, tree: list[Edge]) -> Mapping[str, PlanarPose]:
    """Pose of every body's reference point in the axes of the root's."""
    poses = {root: PlanarPose()}
    pending = list(tree)
    while pending:
        e = pending.pop(0)
        if e.body_i not in poses and e.body_j not in poses:
            pending.append(e)  # the root may be inside the tree
            continue
        a, b = (scene.frames[e.component.ports[port]].pose for port in e.component.kind.ports)
        assert isinstance(e.component.kind, JointKind) and e.component.kind.placing.pose is not None
        relative = PlanarPose(*e.component.kind.placing.pose(e.component.values, None))
        if e.body_i in poses:
            poses[e.body_j] = poses[e.body_i] @ a @ relative @ b.inverse()
        else:
            poses[e.body_i] = poses[e.body_j] @ b @ relative.inverse() @ a.inverse()
    del poses[root]
    return {**poses, root: PlanarPose()} if root != GROUND else poses


def _moved(frame: Frame, owner: str, pose: PlanarPose) -> Frame:
    x, y, phi = pose
    return replace(frame, body=owner, x=x, y=y, phi=phi)


def _sum(root: Component, members: list[tuple[Component, PlanarPose]]) -> Component:
    """One rigid body with the mass, centre of mass and moment of inertia of all, in the axes of ``root``."""
    parts = []
    for c, pose in members:
        assert isinstance(c.kind, BodyKind)
        mass, _, inertia = c.kind.table(c.values)
        cx, cy = c.kind.com(c.values)
        x, y, _ = pose @ PlanarPose(cx, cy)
        parts.append((mass, float(x), float(y), inertia))
    mass = sum(p[0] for p in parts)
    x, y = (sum(p[0] * p[k] for p in parts) / mass if mass > 0.0 else parts[0][k] for k in (1, 2))
    inertia = sum(I + m * ((cx - x) ** 2 + (cy - y) ** 2) for m, cx, cy, I in parts)
    values = {"m": mass, "I": inertia, "length": root.values.get(root.kind.size), "com": (x, y), "frames": ()}
    # its coordinates are those of the common centre of mass, for which there is no signal
    rigid = find("Body")
    assert rigid is not None
    return replace(root, kind=rigid, values=values, signals=("phi", "w"))
