"""Forces, torques and reactions of a mechanism, as arrows over time."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from mbdsl.elements.kind import ForceKind, JointKind
from mbdsl.kernels.arrays import Array
from mbdsl.mechanism.scene import Component
from mbdsl.simulation.trajectory import Trajectory
from mbdsl.system.tables import gravity
from mbdsl.viewing.motion import AnyMotion, Place, Spot

FORCES, REACTIONS = "forces", "reactions"
FORCE, TORQUE = "force", "torque"
MOST = 40  #: number of joints up to which reactions are on the page
MOST_ROWS = 4000  #: number of rows up to which reactions in space that are not known are solved for


@dataclass(frozen=True)
class Vector:
    """A force (N, 2 or 3) [N] or a torque (N, 1 or 3) [N.m] on a frame, in world axes.

    ``group`` is "forces" or "reactions", ``kind`` is "force" or "torque".
    """

    name: str
    group: str
    kind: str
    at: Spot | Place
    values: Array

    @property
    def key(self) -> str:
        """Arrows of a key have one scale."""
        return f"{self.group} {self.kind}"


def largest(vectors: Sequence[Vector], one_scale: bool = False) -> dict[str, float]:
    """The largest force or torque over all times, by key; of both groups together with ``one_scale``."""
    found: dict[str, float] = {}
    for v in vectors:
        key = v.kind if one_scale else v.key
        found[key] = max(found.get(key, 0.0), float(np.nanmax(np.linalg.norm(v.values, axis=1))))
    return {v.key: found[v.kind if one_scale else v.key] for v in vectors}


def vectors(trajectory: Trajectory, motion: AnyMotion) -> list[Vector]:
    """Forces and torques that are given, and the reactions on frame_b of joints.

    Parameters
    ----------
    trajectory : Trajectory
        The states over time.
    motion : Motion or SpaceMotion
        Its motion; vectors are at its frames.

    Returns
    -------
    list of Vector
        Those that are not zero all the time.
    """
    elements = [c for c in motion.scene.components.values() if len(c.ports) == 2]
    found = [v for c in elements if isinstance(c.kind, ForceKind) for v in _applied(c, trajectory, motion)]
    joints = [c for c in elements if isinstance(c.kind, JointKind)]
    if len(joints) <= MOST:
        found += [v for c in joints for v in _reactions(c, trajectory, motion)]
    return _not_zero(found)


def loads(trajectory: Trajectory, motion: AnyMotion) -> list[Vector]:
    """Weights of bodies, and what springs and dampers with a law of one force or torque exert on frame_b.

    Returns
    -------
    list of Vector
        Those that are not zero all the time.
    """
    field, N = np.array(gravity(motion.scene), float), len(motion.t)
    found = []
    for c in motion.scene.bodies():
        mass = float(c.kind.table(dict(c.values))[0])
        found.append(Vector(c.name, FORCES, FORCE, motion.spots[f"{c.name}.c"], np.tile(mass * field, (N, 1))))
    for c in motion.scene.components.values():
        if isinstance(c.kind, ForceKind) and len(c.ports) == 2:
            found += _spring(c, trajectory, motion)
    return _not_zero(found)


def _not_zero(found: Sequence[Vector]) -> list[Vector]:
    return [v for v in found if np.isfinite(v.values).any() and np.nanmax(np.abs(v.values)) > 0.0]


def _applied(c: Component, trajectory: Trajectory, motion: AnyMotion) -> Iterator[Vector]:
    """A force with components in the axes of frame_a, or a torque, in space about the z axis of one of the frames."""
    kind, spatial = c.kind, motion.scene.spatial
    assert isinstance(kind, ForceKind)
    if not spatial and kind.sign < 0:
        return
    a, b = (motion.spot_of(frame) for frame in c.ports.values())
    parts = _signals(trajectory, motion, [f"{c.name}.{law}" for law in kind.laws])
    if parts is None:
        return
    if tuple(kind.laws) == ("fx", "fy", "fz")[: motion.dimensions] or parts.shape[1] == 2:
        yield Vector(c.name, FORCES, FORCE, b, motion.turned(a, parts))
    elif spatial and tuple(kind.laws) == ("tau",):
        axis = motion.turned(b if c.values["axes"] == "frame_b" else a, np.array([0.0, 0.0, 1.0]))
        yield Vector(c.name, FORCES, TORQUE, b, parts * axis)
    elif not spatial and parts.shape[1] == 1 and kind.unit_of(kind.laws[0]) == "N.m":
        yield Vector(c.name, FORCES, TORQUE, b, parts)


def _spring(c: Component, trajectory: Trajectory, motion: AnyMotion) -> Iterator[Vector]:
    """What a spring, a damper or a stop with one law exerts on frame_b; in space springs between two points only."""
    kind, spatial = c.kind, motion.scene.spatial
    assert isinstance(kind, ForceKind)
    if spatial and kind.name == "SpringDamper":
        value = _signals(trajectory, motion, [f"{c.name}.force"])
    elif spatial or len(kind.laws) != 1 or kind.sign > 0:
        return
    else:
        value = _signals(trajectory, motion, [f"{c.name}.{kind.laws[0]}"])
    if value is None:
        return
    a, b = (motion.spot_of(frame) for frame in c.ports.values())
    if not spatial and kind.unit_of(kind.laws[0]) == "N.m":
        yield Vector(c.name, FORCES, TORQUE, b, -value)
    elif kind.name == "SpringDamper":
        apart = motion.positions(b) - motion.positions(a)
        length = np.linalg.norm(apart, axis=1)[:, None]
        along = np.divide(apart, length, out=np.zeros_like(apart), where=length > 0.0)
        yield Vector(c.name, FORCES, FORCE, b, -value * along)
    elif kind.name in ("TranslationalSpringDamper", "TranslationalStop"):
        yield Vector(c.name, FORCES, FORCE, b, -value * motion.turned(a, np.array([1.0, 0.0])))


def _reactions(c: Component, trajectory: Trajectory, motion: AnyMotion) -> Iterator[Vector]:
    assert isinstance(c.kind, JointKind)
    b = motion.spot_of(list(c.ports.values())[1])
    if motion.scene.spatial:
        for kind, key in ((FORCE, "f"), (TORQUE, "t")):
            if (parts := _signals(trajectory, motion, [f"{c.name}.{key}{i}" for i in "xyz"])) is not None:
                yield Vector(c.name, REACTIONS, kind, b, parts)
        return
    known = {key: _signals(trajectory, motion, [f"{c.name}.{key}"]) for key in c.kind.reaction}
    force = [known.get(key) for key in ("fx", "fy")]
    if any(x is not None for x in force):
        zero = np.zeros((len(motion.t), 1))
        yield Vector(c.name, REACTIONS, FORCE, b, np.hstack([zero if x is None else x for x in force]))
    if (tau := known.get("tau")) is not None:
        yield Vector(c.name, REACTIONS, TORQUE, b, tau)


def _signals(trajectory: Trajectory, motion: AnyMotion, names: Sequence[str]) -> Array | None:
    """Signals (N, n) at the frames of the motion; None if one is missing, or takes too long to solve for."""
    solved = motion.scene.spatial and len(trajectory.t) <= MOST_ROWS
    if not all(trajectory.is_at_hand(name) or (solved and name in trajectory) for name in names):
        return None
    return np.stack([np.asarray(trajectory[name], float)[motion.rows] for name in names], axis=1)
