"""The body model of a state: see :mod:`mbdsl.elements.state`."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from mbdsl.bodies.contract import Array, Described, Pose, UndeformedModel


class State(UndeformedModel):
    """A state x, with its integral s as the coordinate. It has neither weight nor energy."""

    n = 1

    def __init__(self, component: Described) -> None:
        self._spatial = bool(component.kind.spatial)
        self.nominal: float | None = component.values["nominal"]
        self.unit = self.nominal or 1.0  #: of the coordinate, for norms; see :mod:`mbdsl.system.state_sizes`

    def mass(self) -> Array:
        return np.ones(1)

    def M(self, q: Array) -> Array:
        return np.eye(1)

    def weight(self, g: Array) -> Array:
        return np.zeros(1)

    def scale(self, size: float) -> Array:
        return np.full(1, 1.0 / self.unit)

    def record(self, buffers, d: int, first: int, poses: Sequence[Pose], g: Array) -> list[int]:
        """First coordinate, first frame, number of frames, and two unused entries."""
        return [d, first, len(poses), 0, 0]

    def frame(self, pose: Pose, key: str, q: Array, v: Array, t: Array | None = None) -> Array:
        if key in ("x", "vx"):
            return (q if key == "x" else v)[:, 0]
        return np.full(len(q), float(key in ("xx", "yy", "zz")))

    def gradient(self, pose: Pose, q: Array, v: Array) -> tuple[Array, ...]:
        if self._spatial:
            return np.eye(12, 1), np.eye(6, 1), np.zeros((6, 1))
        return np.eye(3, 1), np.zeros((3, 1))

    def placed(self, pose: Pose) -> tuple[Array, Array]:
        return np.array(pose[:1]), np.eye(1, 6 if self._spatial else 3)

    def rigid(self, q: Array) -> Array:
        return np.eye(1, 6 if self._spatial else 3)

    def energies(self, q: Array, v: Array, g: Array) -> tuple[Array, Array]:
        return np.zeros(len(q)), np.zeros(len(q))


MODEL = State
