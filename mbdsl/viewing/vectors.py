"""Forces, torques and reactions of a mechanism, as arrows over time."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mbdsl.elements.kind import ForceKind, JointKind
from mbdsl.mechanism.scene import Component
from mbdsl.simulation.trajectory import Trajectory
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
    elif values.shape[1] == 1:
        yield Vector(c.name, FORCES, b, values)


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
