"""Rotations of many states: rotation vectors, matrices and quaternions as arrays.

Rotation vectors psi (N, 3) have lengths up to pi; see :mod:`mbdsl.numerics.rotation` for the formulas.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from mbdsl.kernels.arrays import Array
from mbdsl.numerics.rotation import SMALL

#: of each axis, the next one, and the one after that
NEXT, AFTER = np.array([1, 2, 0]), np.array([2, 0, 1])


def quaternions(psi: Array) -> Array:
    """Unit quaternions (N, 4) of rotation vectors (N, 3)."""
    t2 = (psi**2).sum(axis=-1)
    t = np.sqrt(t2)
    small = t < SMALL
    s = np.where(small, 0.5 - t2 / 48.0 * (1.0 - t2 / 80.0), np.sin(0.5 * t) / np.where(small, 1.0, t))
    return np.concatenate([np.cos(0.5 * t)[..., None], s[..., None] * psi], axis=-1)


def vectors(p: Array) -> Array:
    """Rotation vectors (N, 3), of lengths up to pi, of unit quaternions (N, 4)."""
    p = np.where(p[..., :1] < 0.0, -p, p)
    size = np.sqrt((p[..., 1:] ** 2).sum(axis=-1, keepdims=True))
    k = np.where(size > 1e-150, 2.0 * np.arctan2(size, p[..., :1]) / np.where(size > 1e-150, size, 1.0), 2.0)
    return k * p[..., 1:]


def times(p: Array, q: Array) -> Array:
    """Quaternion products (N, 4), of the rotation q followed by p in world axes."""
    w = p[..., :1] * q[..., :1] - (p[..., 1:] * q[..., 1:]).sum(axis=-1, keepdims=True)
    v = p[..., :1] * q[..., 1:] + q[..., :1] * p[..., 1:] + cross(p[..., 1:], q[..., 1:])
    return np.concatenate([w, v], axis=-1)


def cross(a: Array, b: Array) -> Array:
    """Cross products a x b of vectors (N, 3); ``numpy.cross`` takes four times as long for a few of them."""
    return a.take(NEXT, -1) * b.take(AFTER, -1) - a.take(AFTER, -1) * b.take(NEXT, -1)


def matrices(psi: Array) -> Array:
    """Rotation matrices (N, 3, 3) of rotation vectors (N, 3)."""
    w, x, y, z = np.moveaxis(quaternions(psi), -1, 0)
    rows = [
        [1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y - w * z), 2.0 * (x * z + w * y)],
        [2.0 * (x * y + w * z), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z - w * x)],
        [2.0 * (x * z - w * y), 2.0 * (y * z + w * x), 1.0 - 2.0 * (x * x + y * y)],
    ]
    return np.stack([np.stack(row, axis=-1) for row in rows], axis=-2)


def turned(psi: Array, change: Array) -> Array:
    """Rotation vectors (N, 3) of the attitudes ``psi`` after the rotations ``change`` (N, 3) in body axes."""
    p = times(quaternions(psi), quaternions(change))
    return vectors(p / np.sqrt((p * p).sum(axis=-1, keepdims=True)))


def to_spin(psi: Array, rate: Array) -> Array:
    """Angular velocities (N, 3) in body axes, T(psi) psi', of rotation vectors and their rates (N, 3)."""
    t2 = (psi**2).sum(axis=-1, keepdims=True)
    t = np.sqrt(t2)
    small, some = t < SMALL, np.where(t < SMALL, 1.0, t)
    b = np.where(small, 0.5 - t2 / 24.0 * (1.0 - t2 / 30.0), (1.0 - np.cos(t)) / some**2)
    c = np.where(small, 1.0 / 6.0 - t2 / 120.0 * (1.0 - t2 / 42.0), (t - np.sin(t)) / some**3)
    across = cross(psi, rate)
    return rate - b * across + c * cross(psi, across)


def from_spin(psi: Array, w: Array) -> Array:
    """Rates (N, 3) of rotation vectors, T(psi)^{-1} w, of angular velocities in body axes (N, 3)."""
    t2 = (psi**2).sum(axis=-1, keepdims=True)
    t = np.sqrt(t2)
    some = np.where(t < SMALL, 1.0, t)
    half = 0.5 * some
    c = np.where(t < SMALL, 1.0 / 12.0 + t2 / 720.0 * (1.0 + t2 / 42.0), (1.0 - half / np.tan(half)) / some**2)
    across = cross(psi, w)
    return w + 0.5 * across + c * cross(psi, across)


def of_matrix(R: Array) -> Array:
    """The rotation vector (3,) of a rotation matrix (3, 3)."""
    # the quaternion is the eigenvector of the largest eigenvalue of a symmetric matrix, well-conditioned for any angle
    v = np.array([R[2, 1] - R[1, 2], R[0, 2] - R[2, 0], R[1, 0] - R[0, 1]])
    K = np.zeros((4, 4))
    K[0, 0], K[0, 1:], K[1:, 0] = np.trace(R), v, v
    K[1:, 1:] = R + R.T - np.trace(R) * np.eye(3)
    return vectors(np.linalg.eigh(K)[1][:, -1])


def cross_matrix(a: ArrayLike) -> Array:
    """The matrix (3, 3) of the cross product a x."""
    x, y, z = np.asarray(a, float)
    return np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])


def cross_matrices(a: Array) -> Array:
    """The matrices (..., 3, 3) of the cross products with the vectors a (..., 3)."""
    x, y, z = np.moveaxis(a, -1, 0)
    zero = 0.0 * x
    rows = [[zero, -z, y], [z, zero, -x], [-y, x, zero]]
    return np.stack([np.stack(row, axis=-1) for row in rows], axis=-2)
