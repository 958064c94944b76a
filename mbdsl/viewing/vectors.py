"""Forces, torques and reactions of a mechanism, as arrows over time."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mbdsl.elements.kind import ForceKind, JointKind
from mbdsl.mechanism.scene import Component
from mbdsl.simulation.trajectory import Trajectory
from mbdsl.system.tables import gravity
from mbdsl.viewing.motion import Motion, Spot

Array = NDArray[np.float64]

FORCES, REACTIONS = "forces", "reactions"
MOST = 40  #: number of joints up to which reactions are on the page


@dataclass(frozen=True)
class Vector:
    """A force (N, 2) [N] in world axes or a torque (N, 1) [N.m] on a spot; ``group`` is "forces" or "reactions"."""

    name: str
    group: str
    at: Spot
    values: Array


def key_of(v: Vector) -> str:
    """Its group and its number of components: arrows of a key have one scale."""
    return f"{v.group}{v.values.shape[1]}"


def largest(vectors: Sequence[Vector], one_scale: bool = False) -> dict[str, float]:
    """The largest force or torque over all times, by key; of both groups together with ``one_scale``."""
    found: dict[str, float] = {}
    for v in vectors:
        most = float(np.nanmax(np.hypot.reduce(v.values, axis=1)))
        found[key_of(v)] = max(found.get(key_of(v), 0.0), most)
    if one_scale:
        return {key: max(x for other, x in found.items() if other[-1] == key[-1]) for key in found}
    return found


def vectors(trajectory: Trajectory, motion: Motion) -> list[Vector]:
    """Forces that are given as components or torques, and the reactions on frame_b of joints.

    Parameters
    ----------
    trajectory : Trajectory
        The states over time.
    motion : Motion
        Its motion; vectors are at its frames.

    Returns
    -------
    list of Vector
        Those that are not zero all the time.
    """
    components = list(motion.scene.components.values())
    found = [v for c in components if isinstance(c.kind, ForceKind) for v in _applied(c, trajectory, motion)]
    joints = [c for c in components if isinstance(c.kind, JointKind) and len(c.ports) == 2]
    if len(joints) <= MOST:
        found += [v for c in joints for v in _reactions(c, trajectory, motion)]
    return [v for v in found if np.isfinite(v.values).any() and np.nanmax(np.abs(v.values)) > 0.0]


def _applied(c: Component, trajectory: Trajectory, motion: Motion) -> Iterator[Vector]:
    """Laws that are components of a force in the axes of frame_a, or a torque."""
    if len(c.ports) != 2 or c.kind.sign < 0:  # type: ignore[attr-defined]
        return
    a, b = (motion.spot_of(frame) for frame in c.ports.values())
    columns = [_signal(trajectory, motion, f"{c.name}.{law}") for law in c.kind.laws]  # type: ignore[attr-defined]
    if any(column is None for column in columns):
        return
    values = np.stack(columns, axis=1)  # type: ignore[arg-type]
    if values.shape[1] == 2:
        phi = motion.pose(a)[:, 2]
        cos, sin = np.cos(phi), np.sin(phi)
        fx, fy = values.T
        yield Vector(c.name, FORCES, b, np.stack([cos * fx - sin * fy, sin * fx + cos * fy], axis=1))
    elif values.shape[1] == 1 and c.kind.unit_of(c.kind.laws[0]) == "N.m":  # type: ignore[attr-defined]
        yield Vector(c.name, FORCES, b, values)


def loads(trajectory: Trajectory, motion: Motion) -> list[Vector]:
    """Weights of bodies, and what springs and dampers with a law of one force or torque exert on frame_b.

    Parameters
    ----------
    trajectory : Trajectory
        The states over time.
    motion : Motion
        Its motion.

    Returns
    -------
    list of Vector
        Those that are not zero all the time.
    """
    scene, N = motion.scene, len(motion.t)
    field = gravity(scene)
    found = []
    for c in scene.bodies():
        mass = float(c.kind.table(dict(c.values))[0])  # type: ignore[attr-defined]
        found.append(Vector(c.name, FORCES, motion.spots[f"{c.name}.c"], np.tile(mass * field, (N, 1))))
    for c in scene.components.values():
        if not isinstance(c.kind, ForceKind) or len(c.ports) != 2 or len(c.kind.laws) != 1 or c.kind.sign > 0:
            continue
        law = c.kind.laws[0]
        value = _signal(trajectory, motion, f"{c.name}.{law}")
        if value is None:
            continue
        a, b = (motion.spot_of(frame) for frame in c.ports.values())
        unit = c.kind.unit_of(law)
        if unit == "N.m":
            found.append(Vector(c.name, FORCES, b, -value[:, None]))
        elif (along := _direction(c.kind.name, motion, a, b)) is not None:
            found.append(Vector(c.name, FORCES, b, -value[:, None] * along))
    return [v for v in found if np.isfinite(v.values).any() and np.nanmax(np.abs(v.values)) > 0.0]


def _direction(kind: str, motion: Motion, a: Spot, b: Spot) -> Array | None:
    """Unit vectors (N, 2) along which a spring or a stop resists; None for other kinds."""
    pa, pb = motion.pose(a), motion.pose(b)
    if kind in ("TranslationalSpringDamper", "TranslationalStop"):
        return np.stack([np.cos(pa[:, 2]), np.sin(pa[:, 2])], axis=1)
    if kind != "SpringDamper":
        return None
    apart = pb[:, :2] - pa[:, :2]
    length = np.hypot.reduce(apart, axis=1)[:, None]
    return np.divide(apart, length, out=np.zeros_like(apart), where=length > 0.0)


def _reactions(c: Component, trajectory: Trajectory, motion: Motion) -> Iterator[Vector]:
    assert isinstance(c.kind, JointKind)
    b = motion.spot_of(list(c.ports.values())[1])
    known = {key: _signal(trajectory, motion, f"{c.name}.{key}") for key in c.kind.reaction}
    force = [known.get(key) for key in ("fx", "fy")]
    if any(x is not None for x in force):
        zero = np.zeros(len(motion.t))
        yield Vector(c.name, REACTIONS, b, np.stack([zero if x is None else x for x in force], axis=1))
    if (tau := known.get("tau")) is not None:
        yield Vector(c.name, REACTIONS, b, tau[:, None])


def _signal(trajectory: Trajectory, motion: Motion, name: str) -> Array | None:
    """A signal at the frames of the motion; None if there is none, or all reactions would have to be solved for."""
    return np.asarray(trajectory[name], float)[motion.rows] if trajectory.is_at_hand(name) else None
