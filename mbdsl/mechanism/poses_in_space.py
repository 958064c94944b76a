"""Poses in space as 12 numbers, origin and axes, without numpy: for reading models."""

from __future__ import annotations

from collections.abc import Sequence
from math import cos, hypot, sin


def about(n: Sequence[float], phi: float) -> tuple[float, ...]:
    """The axes of a frame that is turned by phi about the direction n (9)."""
    length = hypot(*n)
    x, y, z = (a / length for a in n)
    c, s = cos(phi), sin(phi)
    # quarter turns are exact: the rounding of phi is below 2.3e-16 for angles up to pi
    c, s = (0.0 if abs(c) < 2.3e-16 else c), (0.0 if abs(s) < 2.3e-16 else s)
    d = 1.0 - c
    return (
        c + d * x * x, d * x * y + s * z, d * x * z - s * y,
        d * x * y - s * z, c + d * y * y, d * y * z + s * x,
        d * x * z + s * y, d * y * z - s * x, c + d * z * z,
    )  # fmt: skip


def turned_successively(angles: Sequence[float], sequence: Sequence[int] = (0, 1, 2)) -> tuple[float, ...]:
    """The axes of a frame that is turned by ``angles`` about the axes ``sequence`` (0, 1, 2 for x, y, z), each of the
    frame turned so far (9): Cardan angles by default."""
    pose: tuple[float, ...] = (0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0)
    for angle, k in zip(angles, sequence, strict=True):
        axis = [float(i == k) for i in range(3)]
        pose = composed(pose, (0.0, 0.0, 0.0, *about(axis, angle)))
    return pose[3:]


def of_quaternion(p: Sequence[float]) -> tuple[float, ...]:
    """The axes (9) for a quaternion of any length except 0, scalar part first."""
    size = hypot(*p)
    e, a, b, c = (x / size for x in p)
    return (
        1.0 - 2.0 * (b * b + c * c), 2.0 * (a * b + e * c), 2.0 * (a * c - e * b),
        2.0 * (a * b - e * c), 1.0 - 2.0 * (a * a + c * c), 2.0 * (b * c + e * a),
        2.0 * (a * c + e * b), 2.0 * (b * c - e * a), 1.0 - 2.0 * (a * a + b * b),
    )  # fmt: skip


def quaternion_of(axes: Sequence[float]) -> tuple[float, ...]:
    """The unit quaternion of axes (9), with the scalar part first and not negative."""
    xx, xy, xz, yx, yy, yz, zx, zy, zz = axes
    N = (
        (1.0 + xx + yy + zz, yz - zy, zx - xz, xy - yx),
        (yz - zy, 1.0 + xx - yy - zz, xy + yx, zx + xz),
        (zx - xz, xy + yx, 1.0 - xx + yy - zz, yz + zy),
        (xy - yx, zx + xz, yz + zy, 1.0 - xx - yy + zz),
    )  # 4 p p^T
    j = max(range(4), key=lambda k: N[k][k])
    size = hypot(*N[j])
    return tuple(x / (-size if N[j][0] < 0.0 else size) for x in N[j])


def product(a: Sequence[float], b: Sequence[float]) -> list[float]:
    """a x b."""
    return [a[j] * b[k] - a[k] * b[j] for j, k in ((1, 2), (2, 0), (0, 1))]


def turned(axes: Sequence[float], a: Sequence[float]) -> tuple[float, ...]:
    """The vector with the components a along ``axes`` (9)."""
    return tuple(axes[i] * a[0] + axes[3 + i] * a[1] + axes[6 + i] * a[2] for i in range(3))


def composed(first: Sequence[float], second: Sequence[float]) -> tuple[float, ...]:
    """The pose ``second``, given relative to ``first``, relative to the base of ``first``."""
    axes = first[3:]
    origin = (x + d for x, d in zip(first, turned(axes, second[:3]), strict=False))
    return (*origin, *(x for k in (3, 6, 9) for x in turned(axes, second[k : k + 3])))


def inverse(pose: Sequence[float]) -> tuple[float, ...]:
    """The pose of the base relative to ``pose``."""
    transposed = tuple(pose[3 + 3 * j + i] for i in range(3) for j in range(3))
    return (*(-x for x in turned(transposed, pose[:3])), *transposed)
