"""Forces, torques and reactions of a mechanism in space, as arrows over time."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mbdsl.elements.kind import ForceKind, JointKind
from mbdsl.mechanism.scene import Component
from mbdsl.simulation.trajectory import Trajectory
from mbdsl.system.tables import gravity
from mbdsl.viewing.space.motion import Place, SpaceMotion
from mbdsl.viewing.vectors import FORCES, MOST, REACTIONS

Array = NDArray[np.float64]

FORCE, TORQUE = "force", "torque"
WORLD = "xyz"
MOST_ROWS = 4000  #: number of rows up to which reactions that are not known are solved for


@dataclass(frozen=True)
class SpaceVector:
    """A force [N] or torque [N.m] on a place, (N, 3) in world axes.

    ``group`` is "forces" or "reactions", ``kind`` is "force" or "torque".
    """

    name: str
    group: str
    kind: str
    at: Place
    values: Array

    @property
    def key(self) -> str:
        """Arrows of a key have one scale."""
        return f"{self.group} {self.kind}"


def largest(vectors: Sequence[SpaceVector], one_scale: bool = False) -> dict[str, float]:
    """The largest force or torque over all times, by key; of both groups together with ``one_scale``."""
    found: dict[str, float] = {}
    for v in vectors:
        key = v.kind if one_scale else v.key
        found[key] = max(found.get(key, 0.0), float(np.nanmax(np.linalg.norm(v.values, axis=1))))
    return {v.key: found[v.kind if one_scale else v.key] for v in vectors}


def vectors(trajectory: Trajectory, motion: SpaceMotion) -> list[SpaceVector]:
    """Forces and torques that are given, and the reactions on frame_b of joints.

    Parameters
    ----------
    trajectory : Trajectory
        The states over time.
    motion : SpaceMotion
        Its motion; vectors are at its frames.

    Returns
    -------
    list of SpaceVector
        Those that are not zero all the time.
    """
    elements = [c for c in motion.scene.components.values() if len(c.ports) == 2]
    found = [v for c in elements if isinstance(c.kind, ForceKind) for v in _applied(c, trajectory, motion)]
    joints = [c for c in elements if isinstance(c.kind, JointKind)]
    if len(joints) <= MOST:
        found += [v for c in joints for v in _reactions(c, trajectory, motion)]
    return _not_zero(found)


def loads(trajectory: Trajectory, motion: SpaceMotion) -> list[SpaceVector]:
    """Weights of bodies, and what springs between two points exert on frame_b; those that are not zero."""
    field, N = np.array(gravity(motion.scene), float), len(motion.t)
    found = []
    for c in motion.scene.bodies():
        mass = float(c.kind.table(dict(c.values))[0])  # type: ignore[attr-defined]
        found.append(SpaceVector(c.name, FORCES, FORCE, motion.spots[f"{c.name}.c"], np.tile(mass * field, (N, 1))))
    for c in motion.scene.components.values():
        force = _signal(trajectory, motion, f"{c.name}.force") if c.kind.name == "SpringDamper" else None
        if force is not None:
            a, b = (motion.spot_of(frame) for frame in c.ports.values())
            apart = motion.positions(b) - motion.positions(a)
            length = np.linalg.norm(apart, axis=1)[:, None]
            along = np.divide(apart, length, out=np.zeros_like(apart), where=length > 0.0)
            found.append(SpaceVector(c.name, FORCES, FORCE, b, -force[:, None] * along))
    return _not_zero(found)


def _not_zero(found: Sequence[SpaceVector]) -> list[SpaceVector]:
    return [v for v in found if np.isfinite(v.values).any() and np.nanmax(np.abs(v.values)) > 0.0]


def _applied(c: Component, trajectory: Trajectory, motion: SpaceMotion) -> Iterator[SpaceVector]:
    """A force with components in the axes of frame_a, or a torque about the z axis of one of the frames."""
    a, b = (motion.spot_of(frame) for frame in c.ports.values())
    laws = tuple(c.kind.laws)  # type: ignore[attr-defined]
    if laws == ("fx", "fy", "fz"):
        parts = [_signal(trajectory, motion, f"{c.name}.{law}") for law in laws]
        if all(part is not None for part in parts):
            force = np.stack(parts, axis=1)  # type: ignore[arg-type]
            yield SpaceVector(c.name, FORCES, FORCE, b, motion.turned(a, force))
    elif laws == ("tau",):
        tau = _signal(trajectory, motion, f"{c.name}.tau")
        if tau is not None:
            axis = motion.turned(b if c.values["axes"] == "frame_b" else a, np.array([0.0, 0.0, 1.0]))
            yield SpaceVector(c.name, FORCES, TORQUE, b, tau[:, None] * axis)


def _reactions(c: Component, trajectory: Trajectory, motion: SpaceMotion) -> Iterator[SpaceVector]:
    b = motion.spot_of(list(c.ports.values())[1])
    for kind, key in ((FORCE, "f"), (TORQUE, "t")):
        parts = [_signal(trajectory, motion, f"{c.name}.{key}{i}") for i in WORLD]
        if all(part is not None for part in parts):
            yield SpaceVector(c.name, REACTIONS, kind, b, np.stack(parts, axis=1))  # type: ignore[arg-type]


def _signal(trajectory: Trajectory, motion: SpaceMotion, name: str) -> Array | None:
    """A signal at the frames of the motion; None if there is none, or it takes too long to solve for."""
    if trajectory.is_at_hand(name) or (name in trajectory and len(trajectory.t) <= MOST_ROWS):
        return np.asarray(trajectory[name], float)[motion.rows]
    return None
