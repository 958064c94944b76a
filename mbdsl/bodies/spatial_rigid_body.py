"""The body model of a rigid body in space: see :mod:`mbdsl.bodies.spatial_rigid_body_kernels`."""

from __future__ import annotations

import weakref
from collections.abc import Callable, Sequence

import numpy as np

from mbdsl.bodies.contract import SPATIAL_POSITIONS as POSITIONS
from mbdsl.bodies.contract import SPATIAL_VELOCITIES as VELOCITIES
from mbdsl.bodies.contract import Array, Described, Pose, UndeformedModel
from mbdsl.bodies.spatial_rigid_body_kernels import POINT, ROTATION_SIZE
from mbdsl.numerics.rotation_arrays import cross_matrix, matrices, of_matrix

#: principal moments of inertia below this part of the largest are zero: of a rod whose matrix of inertia is rounded
THIN = 1e-12
#: most attitudes that a body keeps
KEPT = 5000


class SpatialRigid(UndeformedModel):
    """A rigid body with the position x of its centre of mass and the rotation vector of its attitude R.

    A pose has 12 entries: the position s of a frame, and its axes x, y, z, in the body's axes.
    """

    n = 6

    def __init__(self, component: Described) -> None:
        m, *J = component.kind.table(component.values)
        self._m, self._J = float(m), np.array(J, float).reshape(3, 3)
        self._free = self._J  #: the inertia that resists a torque on the body alone
        self._last: tuple[Callable[[], Array | None], Array] = lambda: None, np.empty(0)

    def mass(self) -> Array:
        return np.concatenate([np.full(3, self._m), np.diag(self._J)])

    def massless(self) -> Array:
        """Directions (6, k) on which the mass matrix is zero."""
        moments, axes = np.linalg.eigh(self._J)
        axes = axes[:, moments <= THIN * max(moments[-1], 0.0)]
        moving = np.eye(6)[:, : 0 if self._m > 0.0 else 3]
        return np.hstack([moving, np.vstack([np.zeros((3, axes.shape[1])), axes])])

    def M(self, q: Array) -> Array:  # in world axes its couplings depend on the attitude: the kernels contain them
        M = np.zeros((6, 6))
        M[:3, :3], M[3:, 3:] = self._m * np.eye(3), self._J
        return M

    def weight(self, g: Array) -> Array:
        return np.concatenate([self._m * g, np.zeros(3)])

    def scale(self, size: float) -> Array:
        return np.array([1.0 / size] * 3 + [1.0] * 3)

    def record(self, buffers, d: int, first: int, poses: Sequence[Pose], g: Array) -> list[int]:
        """First coordinate, first frame, number of frames, offsets of their poses and of the rotation, first slot, and
        0 for no rotors."""
        offset = buffers.floats(value for pose in poses for value in pose[:POINT])
        singular = self.massless()[3:].any()
        inverse = np.zeros((3, 3)) if singular else np.linalg.inv(self._free)
        rotation = [*np.eye(3).ravel(), 1.0, 0.0, 0.0, 0.0, *np.eye(3).ravel(), *self._J.ravel(), *inverse.ravel()]
        at = buffers.floats([*rotation, *[0.0] * (ROTATION_SIZE - len(rotation))])
        buffers.rotations.append((d + 3, at))
        rows = range(d + 3, d + 6)
        return [d, first, len(poses), offset, at, buffers.slots(rows, rows), 0]

    def frame(self, pose: Pose, key: str, q: Array, v: Array, t: Array | None = None) -> Array:
        """Entry of a frame's pose or rate, in world axes."""
        k = (VELOCITIES if key in VELOCITIES else POSITIONS).index(key)
        i = k % 3
        if k < 3 and not any(pose[:3]):  # attitudes are costly
            return (v if key in VELOCITIES else q)[:, i] + 0.0
        if key in VELOCITIES[:3]:
            return v[:, i] + (self._attitudes(q)[:, i] * np.cross(v[:, 3:6], pose[:3])).sum(axis=1)
        row = self._attitudes(q)[:, i]
        if key in VELOCITIES:
            return (row * v[:, 3:6]).sum(axis=1)
        found = row @ np.array(pose[k - i : k - i + 3])
        return q[:, i] + found if k < 3 else found

    def _attitudes(self, q: Array) -> Array:
        """The rotation matrices (N, 3, 3) at coordinates q (N, 6); those of the last array are kept, unless it is long:
        a frame in space has 18 coordinates."""
        last, found = self._last
        if last() is not q:
            found = matrices(q[:, 3:6])
            if len(q) <= KEPT:
                self._last = weakref.ref(q), found
        return found

    def gradient(self, pose: Pose, q: Array, v: Array) -> tuple[Array, Array, Array]:
        """Derivatives of a frame's position and axes (12, 6) with respect to displacements of the body and rotations in
        its axes; of its velocities (6, 6) with respect to those of the body; of its velocities (6, 6) with respect to
        displacements and rotations."""
        R = matrices(q[None, 3:6])[0]
        B, G, rate = np.zeros((12, 6)), np.zeros((6, 6)), np.zeros((6, 6))
        B[:3, :3] = G[:3, :3] = np.eye(3)
        for k in range(4):
            B[3 * k : 3 * k + 3, 3:] = -R @ cross_matrix(pose[3 * k : 3 * k + 3])
        G[:3, 3:], G[3:, 3:] = B[:3, 3:], R
        rate[:3, 3:] = -R @ cross_matrix(np.cross(v[3:], pose[:3]))
        rate[3:, 3:] = -R @ cross_matrix(v[3:])
        return B, G, rate

    def placed(self, pose: Pose) -> tuple[Array, Array]:
        axes = np.array(pose[3:]).reshape(3, 3).T
        return np.concatenate([pose[:3], of_matrix(axes)]), np.eye(6)

    def rigid(self, q: Array) -> Array:
        return np.eye(6)

    def energies(self, q: Array, v: Array, g: Array) -> tuple[Array, Array]:
        kinetic = 0.5 * self._m * (v[:, :3] ** 2).sum(axis=1) + 0.5 * np.einsum(
            "ki,ij,kj->k", v[:, 3:], self._J, v[:, 3:]
        )
        return kinetic, -self._m * (q[:, :3] @ g)


MODEL = SpatialRigid
