"""Coordinates of third-party integrators: unit quaternions in the place of rotation vectors, which have singular poses.

For each rotation of a body in space, the vector part of a quaternion p takes the place of the rotation vector, and the
scalar parts of all quaternions follow the n coordinates; in the plane, x is q. With p^ = p/|p|, spins u in body axes,
and the product o of quaternions:

    p' = E(p^) u/2,   E(p) u = p o (0, u),   small rotation in body axes = 2 E(p^)^T dp/|p|

p^ alone determines the attitude; |p| is constant, and has no effect.
"""

from __future__ import annotations

import numpy as np

from mbdsl.kernels.arrays import Array, Integers
from mbdsl.numerics import rotation_arrays


class Quaternions:
    """The coordinates x of ``n`` coordinates q, of which ``first`` (rotations,) are the first ones of rotation vectors.

    Attributes
    ----------
    size : int
        Number of coordinates x.
    """

    def __init__(self, n: int, first: Integers) -> None:
        self.n, self._first = n, first
        self.size = n + len(first)
        self._vector = first[:, None] + np.arange(3)
        #: places of quaternions in x (rotations, 4)
        self.places = np.column_stack([n + np.arange(len(first)), self._vector]).astype(np.int64)

    def join(self, q: Array) -> Array:
        """x (size,) of q (n,)."""
        if not len(self._first):
            return q
        x = np.concatenate([q, np.zeros(len(self._first))])
        x[self.places] = rotation_arrays.quaternions(q[self._vector])
        return x

    def split(self, x: Array) -> Array:
        """q (n,) of x (size,), a copy."""
        q = x[: self.n].copy()
        if len(self._first):
            q[self._vector] = rotation_arrays.vectors(x[self.places])
        return q

    def units(self, x: Array) -> Array:
        """x (size,) with quaternions of length 1."""
        if not len(self._first):
            return x
        x, p = x.copy(), x[self.places]
        x[self.places] = p / np.linalg.norm(p, axis=1, keepdims=True)
        return x

    def rates(self, x: Array, v: Array) -> Array:
        """x' (size,) of the velocities v (n,)."""
        if not len(self._first):
            return v
        found = np.concatenate([v, np.zeros(len(self._first))])
        found[self.places] = 0.5 * _products(self.units(x)[self.places], v[self._vector])
        return found

    def moved(self, x: Array, change: Array) -> Array:
        """x (size,) after a displacement ``change`` (n,); the signs of the quaternions do not change."""
        if not len(self._first):
            return x + change
        found = x + np.concatenate([change, np.zeros(len(self._first))])
        turn = rotation_arrays.quaternions(change[self._vector])
        found[self.places] = rotation_arrays.times(x[self.places], turn)
        return self.units(found)

    def each(self, values: Array, factor: float) -> Array:
        """Values (n,) of q, the same for the three entries of a rotation, as values (size,) of x; ``factor`` of
        those of rotations."""
        found = np.concatenate([values, values[self._first]])
        found[self.places] *= factor
        return found

    def lifting(self, x: Array) -> Array:
        """E(p^)/2 of each rotation (rotations, 4, 3)."""
        p = self.units(x)[self.places]
        return 0.5 * np.stack([_products(p, np.tile(e, (len(p), 1))) for e in np.eye(3)], axis=-1)

    def lowering(self, x: Array) -> Array:
        """2 E(p^)^T/|p| of each rotation (rotations, 3, 4)."""
        sizes = np.linalg.norm(x[self.places], axis=1)
        return 4.0 * np.swapaxes(self.lifting(x), 1, 2) / sizes[:, None, None]

    def turning(self, x: Array, u: Array) -> Array:
        """The derivative of E(p^) u/2 by p of each rotation (rotations, 4, 4), for u (n,)."""
        p, u = x[self.places], u[self._vector]
        sizes = np.linalg.norm(p, axis=1)
        unit = p / sizes[:, None]
        right = np.stack([_products(np.tile(e, (len(p), 1)), u) for e in np.eye(4)], axis=-1)
        across = np.eye(4) - unit[:, :, None] * unit[:, None, :]
        return 0.5 * right @ across / sizes[:, None, None]


def _products(p: Array, u: Array) -> Array:
    """p o (0, u) of quaternions (N, 4) and vectors (N, 3)."""
    return rotation_arrays.times(p, np.concatenate([np.zeros((len(u), 1)), u], axis=1))
