"""The body model of a rigid body, or of a point mass: see :mod:`mbdsl.bodies.rigid_body_kernels`."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from mbdsl.bodies.contract import POSITIONS, VELOCITIES, Array, Described, Pose, UndeformedModel

#: coordinates -> the directions of the rigid-body motions
_DIRECTIONS = {n: np.eye(n, 3) for n in (2, 3)}
for _directions in _DIRECTIONS.values():
    _directions.flags.writeable = False


class Rigid(UndeformedModel):
    """A rigid body with the coordinates x, y of its centre of mass and, unless it is a point mass, its angle.

    Bodies with the same values share one model: it has no state.
    """

    def __init__(self, component: Described) -> None:
        self._mass = np.array(component.kind.table(component.values), float)
        self.n = len(self._mass)

    def mass(self) -> Array:
        return self._mass

    def M(self, q: Array) -> Array:
        return np.diag(self._mass)

    def weight(self, g: Array) -> Array:
        return np.concatenate([self._mass[:2] * g, np.zeros(self.n - 2)])

    def scale(self, size: float) -> Array:
        return np.array([1.0 / size, 1.0 / size, 1.0])[: self.n]

    def record(self, buffers, d: int, first: int, poses: Sequence[Pose], g: Array) -> list[int]:
        """First coordinate, first frame, number of frames, offset of their poses, slot (phi, phi) or (y, y)."""
        last = d + self.n - 1
        offset = buffers.floats(value for pose in poses for value in pose)
        return [d, first, len(poses), offset, buffers.slots((last,), (last,))]

    def _lever(self, pose: Pose, phi):
        c, s = np.cos(phi), np.sin(phi)
        return c * pose[0] - s * pose[1], s * pose[0] + c * pose[1]

    def frame(self, pose: Pose, key: str, q: Array, v: Array, t: Array | None = None) -> Array:
        if self.n < 3:
            k = (POSITIONS if key in POSITIONS else VELOCITIES).index(key)
            constant = np.full(len(q), pose[2] if key == "phi" else 0.0)
            return constant if k == 2 else (q if key in POSITIONS else v)[:, k]
        if key in ("phi", "w"):
            return q[:, 2] + pose[2] if key == "phi" else v[:, 2]
        if pose[0] == 0.0 and pose[1] == 0.0:
            return {"x": q[:, 0], "y": q[:, 1], "vx": v[:, 0], "vy": v[:, 1]}[key]
        lx, ly = self._lever(pose, q[:, 2])
        w = v[:, 2]
        if key in ("x", "y"):
            return q[:, 0] + lx if key == "x" else q[:, 1] + ly
        return v[:, 0] - ly * w if key == "vx" else v[:, 1] + lx * w

    @staticmethod
    def gradients(poses: Array, q: Array, v: Array) -> tuple[Array, Array, Array, Array]:
        """Coordinates and rates (k, 3) of k frames at ``poses`` (k, 3) on as many bodies with n = 3 coordinates in the
        states q, v (k, 3), with their B and (B v)_q (k, 3, 3)."""
        c, s, w = np.cos(q[:, 2]), np.sin(q[:, 2]), v[:, 2]
        lx, ly = c * poses[:, 0] - s * poses[:, 1], s * poses[:, 0] + c * poses[:, 1]
        B, rate = np.tile(np.eye(3), (len(q), 1, 1)), np.zeros((len(q), 3, 3))
        B[:, 0, 2], B[:, 1, 2], rate[:, 0, 2], rate[:, 1, 2] = -ly, lx, -lx * w, -ly * w
        z = q + np.stack([lx, ly, poses[:, 2]], axis=1)
        return z, v + np.stack([-ly * w, lx * w, np.zeros(len(q))], axis=1), B, rate

    def gradient(self, pose: Pose, q: Array, v: Array) -> tuple[Array, Array]:
        B, rate = np.eye(3)[:, : self.n], np.zeros((3, self.n))
        if self.n == 3:
            lx, ly = self._lever(pose, q[2])
            B[:2, 2], rate[:2, 2] = (-ly, lx), (-lx * v[2], -ly * v[2])
        return B, rate

    def placed(self, pose: Pose) -> tuple[Array, Array]:
        return np.array(pose)[: self.n], _DIRECTIONS[self.n]

    def rigid(self, q: Array) -> Array:
        return _DIRECTIONS[self.n]

    def energies(self, q: Array, v: Array, g: Array) -> tuple[Array, Array]:
        return 0.5 * v**2 @ self._mass, -self._mass[0] * (q[:, :2] @ g)


MODEL = Rigid
