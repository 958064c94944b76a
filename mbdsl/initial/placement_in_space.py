"""Initial placement of bodies in space, from the ground outwards: at initial values, else as the joints require."""

from __future__ import annotations

from math import atan2

import numpy as np
from numpy.typing import NDArray

from mbdsl.elements.kind import JointKind
from mbdsl.expressions.spatial_coordinates import named
from mbdsl.expressions.symbolic import Expr, expr
from mbdsl.mechanism.graph import MechanismGraph
from mbdsl.mechanism.poses_in_space import about, composed, inverse
from mbdsl.mechanism.scene import InitialValue
from mbdsl.system.body_models import body_pose
from mbdsl.system.signals import values as values_of
from mbdsl.system.system import System

Array = NDArray[np.float64]
Z = (0.0, 0.0, 1.0)


def place(system: System, graph: MechanismGraph, t: float, given: list[InitialValue]) -> Array:
    """Positions and attitudes of all bodies (n,)."""
    scene, tables = system.scene, system.tables
    said: dict[Expr | None, float] = {x.target: x.value for x in sorted(given, key=lambda x: x.fixed)}
    poses: dict[str, tuple[float, ...]] = {}
    turns: dict[str, float] = {}  # body -> its rotation about the z axis, with turns
    drivers = {c.name: _prescribed(system, c, t) for c in scene.components.values() if _drives_angle(c)}
    q = np.zeros(system.n)

    def frame_pose(name: str) -> tuple[float, ...]:
        frame = scene.frames[name]
        own = body_pose(scene.components[frame.body], frame)
        return composed(poses[frame.body], own) if frame.body in poses else own

    for placement in graph.tree():
        body = scene.components[placement.body]
        values = [said.get(scene.signal_of(body, key)) for key in ("x", "y", "z", "phi")]
        pose, turn = (0.0, 0.0, 0.0, *about(Z, values[3] or 0.0)), values[3] or 0.0
        if placement.joint is not None:
            joint = scene.components[placement.joint]
            assert isinstance(joint.kind, JointKind)
            a, b = (joint.ports[port] for port in ("frame_a", "frame_b"))
            forward = scene.frames[b].body == body.name
            angle, along = (_known(scene, joint, said, names) for names in (joint.kind.angle, joint.kind.along))
            ends = {scene.frames[a].body, scene.frames[b].body}
            for driver, u in drivers.items():
                ports = scene.components[driver].ports.values()
                if {scene.frames[f].body for f in ports} == ends:
                    angle = u if next(scene.frames[f].body for f in ports) == scene.frames[a].body else -u
            around = turns.get(scene.frames[other_of(a, b, forward)].body, 0.0)
            if values[3] is not None and not angle and joint.kind.angle:
                angle = (values[3] - around) if forward else (around - values[3])
                angle -= _turn_of(scene.frames[b]) - _turn_of(scene.frames[a])
            turn = around + (angle if forward else -angle) if values[3] is None else values[3]
            relative = (along, 0.0, 0.0, *about(Z, angle))
            other, own = (a, b) if forward else (b, a)
            to_centre = inverse(body_pose(body, scene.frames[own]))
            pose = composed(composed(frame_pose(other), relative if forward else inverse(relative)), to_centre)
        origin = (old if new is None else new for new, old in zip(values[:3], pose, strict=False))
        turns[body.name] = turn
        poses[body.name] = pose = (*origin, *pose[3:])
        d, model = tables.coordinates[body.name], tables.models[body.name]
        q[d : d + model.n] = model.placed(pose)[0]
    for c in scene.components.values():
        for key in c.signals:
            node = scene.signal_of(c, key)
            if node is not None and node.op == "angle":
                system.set_first_angle(node, _first_angle(system, c, node, said, turns, drivers))
    for name, frame in scene.frames.items():
        system.set_first_angle(named(name, "phi"), turns.get(frame.body, 0.0) + _turn_of(frame))
    return q


def other_of(a: str, b: str, forward: bool) -> str:
    """The frame of a joint that is already placed."""
    return a if forward else b


def _turn_of(frame) -> float:
    """The angle of a frame about the z axis of its body."""
    return atan2(frame.axes[1], frame.axes[0])


def _drives_angle(c) -> bool:
    return isinstance(c.kind, JointKind) and c.kind.driver is not None and c.kind.driver in c.kind.angle


def _prescribed(system: System, c, t: float) -> float:
    nowhere = np.zeros((1, system.n))
    return float(values_of(system, [expr(c.values[c.kind.driver])], np.array([t]), nowhere, nowhere)[0][0])


def _first_angle(system: System, c, node: Expr, said, turns: dict[str, float], drivers: dict[str, float]) -> float:
    """An angle at the start, up to less than half a turn: as given, as driven, or from the turns of both bodies."""
    if node in said:
        return said[node]
    if c.name in drivers:
        return drivers[c.name]
    scene = system.scene
    if not c.ports:
        return turns.get(c.name, 0.0)
    a, b = (scene.frames[c.ports[port]] for port in ("frame_a", "frame_b"))
    return turns.get(b.body, 0.0) + _turn_of(b) - turns.get(a.body, 0.0) - _turn_of(a)


def _known(scene, joint, said, names: tuple[str, ...]) -> float:
    """The value of a free coordinate of a joint at the start, 0 if none is given."""
    found = [said.get(scene.signal_of(joint, name)) for name in names]
    return next((float(value) for value in found if value is not None), 0.0)
