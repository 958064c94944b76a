"""The body model of a gyrostat: see :mod:`mbdsl.bodies.gyrostat_kernels`."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from mbdsl.bodies.contract import SPATIAL_POSITIONS as POSITIONS
from mbdsl.bodies.contract import SPATIAL_VELOCITIES as VELOCITIES
from mbdsl.bodies.contract import Array, Described, Pose
from mbdsl.bodies.gyrostat_kernels import ANGLES
from mbdsl.bodies.spatial_rigid_body import SpatialRigid
from mbdsl.bodies.spatial_rigid_body_kernels import POINT
from mbdsl.numerics.rotation_arrays import cross_matrix


class Gyrostat(SpatialRigid):
    """A rigid body and its rotors: the coordinates of the body, then the angles of the rotors.

    A pose has 12 entries, as on a rigid body, or 13 on a rotor: its origin is on the axle, its axes are those at the
    angle zero, and the last entry is the number of the rotor, from one on.
    """

    def __init__(self, component: Described) -> None:
        super().__init__(component)
        rotors = component.values["rotors"]
        self._n = np.array([axle for axle, _ in rotors], float)  #: axles (k, 3)
        self._C = np.array([inertia for _, inertia in rotors], float)
        self._free = self._J - (self._n.T * self._C) @ self._n
        self.n = ANGLES + len(rotors)

    def mass(self) -> Array:
        return np.concatenate([super().mass(), self._C])

    def massless(self) -> Array:
        return np.zeros((self.n, 0))

    def M(self, q: Array) -> Array:
        M = np.zeros((self.n, self.n))
        M[:ANGLES, :ANGLES] = super().M(q)
        M[3:ANGLES, ANGLES:] = self._n.T * self._C
        M[ANGLES:, 3:ANGLES] = M[3:ANGLES, ANGLES:].T
        M[ANGLES:, ANGLES:] = np.diag(self._C)
        return M

    def weight(self, g: Array) -> Array:
        return np.concatenate([super().weight(g), 0.0 * self._C])

    def scale(self, size: float) -> Array:
        # angles as the rotations of the body that they cause: steps are as long as the motion of the body permits
        return np.concatenate([super().scale(size), self._C / np.einsum("ki,ij,kj->k", self._n, self._J, self._n)])

    def dofs(self, pose: Pose) -> tuple[int, ...]:
        return (*range(ANGLES), *(ANGLES - 1 + int(number) for number in pose[POINT:]))

    def record(self, buffers, d: int, first: int, poses: Sequence[Pose], g: Array) -> list[int]:
        """As of a rigid body, with the record of the rotors."""
        found = super().record(buffers, d, first, poses, g)
        rotations, angles = range(d + 3, d + ANGLES), range(d + ANGLES, d + self.n)
        buffers.slots(rotations, angles)
        buffers.slots(angles, rotations)
        rotors = buffers.floats(x for n, C in zip(self._n, self._C, strict=True) for x in (*n, C))
        turning = [(first + k, int(pose[POINT]) - 1) for k, pose in enumerate(poses) if len(pose) > POINT]
        record = buffers.ints([len(self._C), rotors, len(turning), *(x for pair in turning for x in pair)])
        return [*found[:-1], record]

    def frame(self, pose: Pose, key: str, q: Array, v: Array, t: Array | None = None) -> Array:
        if len(pose) == POINT or key in VELOCITIES[:3] or key in POSITIONS[:3]:
            return super().frame(pose[:POINT], key, q, v, t)
        r = int(pose[POINT]) - 1
        n, i = self._n[r], "xyz".index(key[-1])
        row = self._attitudes(q)[:, i]
        if key in VELOCITIES:
            return (row * (v[:, 3:ANGLES] + v[:, ANGLES + r, None] * n)).sum(axis=1)
        k = POSITIONS.index(key)
        return (row * turned_about(n, q[:, ANGLES + r], np.array(pose[k - i : k - i + 3]))).sum(axis=1)

    def gradient(self, pose: Pose, q: Array, v: Array) -> tuple[Array, Array, Array]:
        r = int(pose[POINT]) - 1 if len(pose) > POINT else None
        now = list(pose[:POINT])
        if r is not None:
            for k in (3, 6, 9):
                now[k : k + 3] = turned_about(self._n[r], q[[ANGLES + r]], np.array(now[k : k + 3]))[0]
        found = [np.zeros((len(A), self.n)) for A in (range(12), range(6), range(6))]
        for A, own in zip(found, super().gradient(tuple(now), q[:ANGLES], v[:ANGLES]), strict=True):
            A[:, :ANGLES] = own
        if r is not None:
            B, G, rate = found
            column, R, n = ANGLES + r, G[3:, 3:ANGLES], self._n[r]
            for k in (3, 6, 9):
                B[k : k + 3, column] = R @ np.cross(n, now[k : k + 3])
            G[3:, column] = R @ n
            rate[3:, 3:ANGLES] -= v[column] * R @ cross_matrix(n)
        return found[0], found[1], found[2]

    def placed(self, pose: Pose) -> tuple[Array, Array]:
        q, derivative = super().placed(pose)
        return np.concatenate([q, 0.0 * self._C]), np.vstack([derivative, np.zeros((len(self._C), 6))])

    def rigid(self, q: Array) -> Array:
        return np.vstack([np.eye(ANGLES), np.zeros((len(self._C), ANGLES))])

    def energies(self, q: Array, v: Array, g: Array) -> tuple[Array, Array]:
        kinetic, potential = super().energies(q[:, :ANGLES], v[:, :ANGLES], g)
        spin = v[:, ANGLES:]
        return kinetic + ((v[:, 3:ANGLES] @ self._n.T + 0.5 * spin) * spin) @ self._C, potential


def turned_about(n: Array, theta: Array, a: Array) -> Array:
    """The vector a (3,) turned about the unit vector n (3,) by the angles theta (N,); shape (N, 3)."""
    c, s = np.cos(theta)[:, None], np.sin(theta)[:, None]
    return c * a + s * np.cross(n, a) + (1.0 - c) * (n @ a) * n


MODEL = Gyrostat
