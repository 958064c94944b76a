"""Initial placement of bodies, from the ground outwards: at initial values, else as the joints require.

A joint's kind declares the signals and parameters that place a body by it as ``angle`` and ``along``.
"""

from __future__ import annotations

from math import atan2, cos, hypot, sin

import numpy as np
from numpy.typing import NDArray

from mbdsl.bodies.contract import POSITIONS
from mbdsl.elements.kind import JointKind
from mbdsl.expressions.symbolic import Expr, expr, leaves
from mbdsl.initial import placement_in_space
from mbdsl.mechanism.graph import MechanismGraph
from mbdsl.mechanism.scene import Component, InitialValue
from mbdsl.system.body_models import body_pose
from mbdsl.system.signals import values
from mbdsl.system.system import System

Array = NDArray[np.float64]


def place(system: System, graph: MechanismGraph, t: float, given: list[InitialValue]) -> Array:
    """Poses of all bodies (n,), from the ground outwards: at initial values, else as the joints require."""
    if system.scene.spatial:
        return placement_in_space.place(system, graph, t, given)
    scene, tables = system.scene, system.tables
    said: dict[Expr | None, float] = {x.target: x.value for x in sorted(given, key=lambda x: x.fixed)}
    # signals are evaluated only where initial values contain the coordinates that they depend on
    named = {leaf.value for x in given for leaf in leaves(x.target)}
    frames_named = {leaf.value[0] for x in given for leaf in leaves(x.target) if leaf.op == "coordinate"}  # type: ignore[index]
    pose = {name: _ground_pose(system, name, t) for name in scene.frames if not _coordinates(system, name)}
    frames_of: dict[str, list[str]] = {}
    for name, frame in scene.frames.items():
        frames_of.setdefault(frame.body, []).append(name)
    drivers = _drivers(system, t)
    q = np.zeros(system.n)
    for placement in graph.tree():
        body = scene.components[placement.body]
        x, y, phi = 0.0, 0.0, 0.0
        centre = f"{body.name}.c"
        values_said = [said.get(scene.signal_of(body, key)) if (centre, key) in named else None for key in POSITIONS]
        cx, cy, angle = values_said
        if placement.joint is not None and angle is None and cx is not None and cy is not None:
            values_said[2] = _aimed(system, placement.joint, body.name, pose, cx, cy)
        if drivers and placement.joint is not None and _driven(system, placement.joint, drivers):
            values_said = [None, None, None]  # a driver has priority over a guess
        if placement.joint is not None:
            # a given angle is a rotation about the joint instead of the centre of mass
            joint = scene.components[placement.joint]
            near = said if not frames_named.isdisjoint(joint.ports.values()) else {}
            x, y, phi = _by_joint(system, placement.joint, placement.body, pose, near, drivers, values_said[2])
        x, y, phi = (new if new is not None else old for new, old in zip(values_said, (x, y, phi), strict=True))
        d, model = tables.coordinates[body.name], tables.models[body.name]
        q[d : d + model.n] = model.placed((x, y, phi))[0]
        system.set_turn(body.name, phi)
        c, s = cos(phi), sin(phi)
        for name in frames_of.get(body.name, ()):
            sx, sy, f = body_pose(body, scene.frames[name])
            pose[name] = (x + c * sx - s * sy, y + s * sx + c * sy, phi + f)
    return q


def _coordinates(system: System, frame: str) -> tuple[str, ...]:
    return system.scene.components[system.scene.frames[frame].body].kind.coordinates


def _frame_pose(system: System, name: str) -> tuple[float, float, float]:
    frame = system.scene.frames[name]
    return body_pose(system.scene.components[frame.body], frame)


def _ground_pose(system: System, name: str, t: float) -> tuple[float, float, float]:
    motion = system.scene.frames[name].motion
    if motion is None:
        return _frame_pose(system, name)
    nowhere = np.zeros((1, system.n))
    x, y, phi = (float(value[0]) for value in values(system, motion, np.array([t]), nowhere, nowhere))
    return x, y, phi


def _drivers(system: System, t: float) -> dict[tuple[str, str, str], float]:
    """(frame_a, frame_b, "angle" or "along") -> its value at time t."""
    nowhere = np.zeros((1, system.n))
    found = {}
    for c in system.scene.components.values():
        if isinstance(c.kind, JointKind) and c.kind.driver and c.ports:
            law = [expr(c.values[c.kind.driver])]
            u = float(values(system, law, np.array([t]), nowhere, nowhere)[0][0])
            role = "angle" if c.kind.driver in c.kind.angle else "along"
            found[(c.ports["frame_a"], c.ports["frame_b"], role)] = u
    return found


def _driven(system: System, joint: str, drivers: dict[tuple[str, str, str], float]) -> bool:
    ports = system.scene.components[joint].ports
    return (ports["frame_a"], ports["frame_b"], "angle") in drivers


def _ends(system: System, joint: str, body: str) -> tuple[Component, bool, str, str]:
    """The joint, whether ``body`` is on its frame_b, the frame on the other body, the frame on ``body``."""
    component = system.scene.components[joint]
    frame_a, frame_b = component.ports["frame_a"], component.ports["frame_b"]
    forward = system.scene.frames[frame_b].body == body
    return component, forward, *((frame_a, frame_b) if forward else (frame_b, frame_a))


def _aimed(system: System, joint: str, body: str, pose: dict, x: float, y: float) -> float | None:
    """The angle at which a body with a known centre of mass points at its joint."""
    _, _, other, own = _ends(system, joint, body)
    sx, sy, _ = _frame_pose(system, own)
    dx, dy = pose[other][0] - x, pose[other][1] - y
    return atan2(dy, dx) - atan2(sy, sx) if hypot(sx, sy) * hypot(dx, dy) > 0.0 else None


def _by_joint(system, joint, body, pose, said, drivers, angle=None) -> tuple[float, float, float]:
    """Pose of ``body``'s centre of mass so that the frames of ``joint`` coincide, with its angle if that is known.

    ``said`` contains the initial values of the joint's signals.
    """
    component, forward, other, own = _ends(system, joint, body)
    base = pose[other]

    def known(role: str) -> float:
        names = getattr(component.kind, role)
        found = [said.get(system.scene.signal_of(component, name)) for name in names] if said else []
        found.append(drivers.get((component.ports["frame_a"], component.ports["frame_b"], role)))
        found += [component.values.get(name) for name in names]
        return next((float(value) for value in found if value is not None), 0.0)

    along = known("along")
    sx, sy, phi0 = _frame_pose(system, own)
    if angle is None:
        relative = known("angle")
        angle = base[2] + (relative if forward else -relative) - phi0
    phi = angle
    axis = base[2] if forward else phi + phi0
    shift = along if forward else -along
    x, y = base[0] + shift * cos(axis), base[1] + shift * sin(axis)
    return x - cos(phi) * sx + sin(phi) * sy, y - sin(phi) * sx - cos(phi) * sy, phi
