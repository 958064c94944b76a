"""The body model of a point mass in space: see :mod:`mbdsl.bodies.spatial_point_mass_kernels`."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from mbdsl.bodies.contract import SPATIAL_POSITIONS as POSITIONS
from mbdsl.bodies.contract import SPATIAL_VELOCITIES as VELOCITIES
from mbdsl.bodies.contract import Array, Described, Pose, UndeformedModel


class SpatialPoint(UndeformedModel):
    """A point mass with its position as coordinates."""

    n = 3

    def __init__(self, component: Described) -> None:
        (self._m,) = component.kind.table(component.values)

    def mass(self) -> Array:
        return np.full(3, self._m)

    def M(self, q: Array) -> Array:
        return self._m * np.eye(3)

    def weight(self, g: Array) -> Array:
        return self._m * g

    def scale(self, size: float) -> Array:
        return np.full(3, 1.0 / size)

    def record(self, buffers, d: int, first: int, poses: Sequence[Pose], g: Array) -> list[int]:
        """First coordinate, first frame, number of frames, offset of their axes."""
        return [d, first, len(poses), buffers.floats(value for pose in poses for value in pose[3:])]

    def frame(self, pose: Pose, key: str, q: Array, v: Array, t: Array | None = None) -> Array:
        if key in VELOCITIES:
            k = VELOCITIES.index(key)
            return v[:, k] if k < 3 else np.zeros(len(q))
        k = POSITIONS.index(key)
        return q[:, k] if k < 3 else np.full(len(q), pose[k])

    def gradient(self, pose: Pose, q: Array, v: Array) -> tuple[Array, Array, Array]:
        return np.eye(12, 3), np.eye(6, 3), np.zeros((6, 3))

    def placed(self, pose: Pose) -> tuple[Array, Array]:
        return np.array(pose[:3]), np.eye(3, 6)

    def rigid(self, q: Array) -> Array:
        return np.eye(3, 6)

    def energies(self, q: Array, v: Array, g: Array) -> tuple[Array, Array]:
        return 0.5 * self._m * (v**2).sum(axis=1), -self._m * (q @ g)


MODEL = SpatialPoint
