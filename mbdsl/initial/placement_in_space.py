"""Initial placement of bodies in space, from the ground outwards: at initial values, else as the joints require."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from mbdsl.expressions.symbolic import Expr
from mbdsl.mechanism.graph import MechanismGraph
from mbdsl.mechanism.poses_in_space import about, composed, inverse
from mbdsl.mechanism.scene import InitialValue
from mbdsl.system.body_models import body_pose
from mbdsl.system.system import System

Array = NDArray[np.float64]
Z = (0.0, 0.0, 1.0)


def place(system: System, graph: MechanismGraph, t: float, given: list[InitialValue]) -> Array:
    """Positions and attitudes of all bodies (n,)."""
    scene, tables = system.scene, system.tables
    said: dict[Expr | None, float] = {x.target: x.value for x in sorted(given, key=lambda x: x.fixed)}
    poses: dict[str, tuple[float, ...]] = {}
    q = np.zeros(system.n)

    def frame_pose(name: str) -> tuple[float, ...]:
        frame = scene.frames[name]
        own = body_pose(scene.components[frame.body], frame)
        return composed(poses[frame.body], own) if frame.body in poses else own

    for placement in graph.tree():
        body = scene.components[placement.body]
        values = [said.get(scene.signal_of(body, key)) for key in ("x", "y", "z", "phi")]
        pose = (0.0, 0.0, 0.0, *about(Z, values[3] or 0.0))
        if placement.joint is not None:
            joint = scene.components[placement.joint]
            a, b = (joint.ports[port] for port in ("frame_a", "frame_b"))
            forward = scene.frames[b].body == body.name
            angle, along = (_known(scene, joint, said, names) for names in (joint.kind.angle, joint.kind.along))
            relative = (0.0, 0.0, along, *about(Z, angle))
            other, own = (a, b) if forward else (b, a)
            to_centre = inverse(body_pose(body, scene.frames[own]))
            pose = composed(composed(frame_pose(other), relative if forward else inverse(relative)), to_centre)
        origin = (old if new is None else new for new, old in zip(values[:3], pose, strict=False))
        poses[body.name] = pose = (*origin, *pose[3:])
        d, model = tables.coordinates[body.name], tables.models[body.name]
        q[d : d + model.n] = model.placed(pose)[0]
    return q


def _known(scene, joint, said, names: tuple[str, ...]) -> float:
    """The value of a free coordinate of a joint at the start, 0 if none is given."""
    found = [said.get(scene.signal_of(joint, name)) for name in names]
    return next((float(value) for value in found if value is not None), 0.0)
