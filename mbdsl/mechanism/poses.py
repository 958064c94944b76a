"""Poses in the plane and in space: composition, inverse, motions; without numpy, for reading models."""

from __future__ import annotations

from collections.abc import Sequence
from math import cos, hypot, sin
from typing import Any, NamedTuple, TypeAlias

from mbdsl.expressions.symbolic import Expr, call


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
    found = SpatialPose((0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0))
    for angle, k in zip(angles, sequence, strict=True):
        found = found.step(f"r{'xyz'[k]}", angle)
    return found.axes


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


class PlanarPose(NamedTuple):
    """A pose in the plane, of numbers or of expressions in time."""

    x: Any = 0.0
    y: Any = 0.0
    phi: Any = 0.0

    @staticmethod
    def turn(phi: float) -> PlanarPose:
        """The pose that is turned by phi about the origin."""
        return PlanarPose(0.0, 0.0, phi)

    @property
    def origin(self) -> tuple[Any, ...]:
        return self.x, self.y

    @property
    def attitude(self) -> PlanarPose:
        """The pose without its translation."""
        return PlanarPose(0.0, 0.0, self.phi)

    def __matmul__(self, inner: Any) -> PlanarPose:
        """The pose ``inner``, given relative to this one, relative to the base of this one."""
        c, s = self._direction
        x, y = self.x + c * inner.x - s * inner.y, self.y + s * inner.x + c * inner.y
        return PlanarPose(*map(_plain, (x, y, self.phi + inner.phi)))

    def inverse(self) -> PlanarPose:
        """The pose of the base relative to this one."""
        c, s = self._direction
        return PlanarPose(*map(_plain, (-(c * self.x) - s * self.y, s * self.x - c * self.y, -self.phi)))

    def moved_to(self, origin: Sequence[float | None]) -> PlanarPose:
        """The pose with another origin; None: a coordinate that stays."""
        x, y = (old if new is None else new for new, old in zip(origin, self.origin, strict=True))
        return PlanarPose(x, y, self.phi)

    def turned_to(self, attitude: Any) -> PlanarPose:
        """The pose with another attitude."""
        return PlanarPose(self.x, self.y, attitude.phi)

    def carrying(self, frame: Any) -> PlanarPose:
        """The pose of a body one of whose frames is here: ``frame`` is its pose on the body."""
        return self.holding(frame, PlanarPose.turn(self.phi - frame.phi))

    def holding(self, frame: Any, attitude: Any) -> PlanarPose:
        """The pose of a body with this attitude whose ``frame`` has its origin here."""
        c, s = attitude._direction
        return PlanarPose(self.x - c * frame.x + s * frame.y, self.y - s * frame.x - c * frame.y, attitude.phi)

    def step(self, way: str, by: float) -> PlanarPose:
        """The pose moved along its x axis, or turned about z: "x", "rz"."""
        return self @ (PlanarPose(by, 0.0, 0.0) if way == "x" else PlanarPose.turn(by))

    @property
    def _direction(self) -> tuple[Any, Any]:
        if isinstance(self.phi, Expr):
            return call("cos", self.phi), call("sin", self.phi)
        return cos(self.phi), sin(self.phi)


class SpatialPose(tuple[float, ...]):
    """A pose in space as 12 numbers: the origin and the axes x, y, z."""

    @staticmethod
    def turn(phi: float) -> SpatialPose:
        """The pose that is turned by phi about the z axis."""
        return SpatialPose((0.0, 0.0, 0.0, *about((0.0, 0.0, 1.0), phi)))

    @staticmethod
    def of_axes(axes: Sequence[float]) -> SpatialPose:
        """The pose with the origin of the base."""
        return SpatialPose((0.0, 0.0, 0.0, *axes))

    @property
    def origin(self) -> tuple[float, ...]:
        return self[:3]

    @property
    def axes(self) -> tuple[float, ...]:
        return self[3:]

    @property
    def attitude(self) -> SpatialPose:
        """The pose without its translation."""
        return SpatialPose.of_axes(self.axes)

    def __matmul__(self, inner: Any) -> SpatialPose:
        """The pose ``inner``, given relative to this one, relative to the base of this one."""
        axes = self.axes
        origin = (x + d for x, d in zip(self.origin, turned(axes, inner[:3]), strict=True))
        return SpatialPose((*origin, *(x for k in (3, 6, 9) for x in turned(axes, inner[k : k + 3]))))

    def inverse(self) -> SpatialPose:
        """The pose of the base relative to this one."""
        transposed = tuple(self[3 + 3 * j + i] for i in range(3) for j in range(3))
        return SpatialPose((*(-x for x in turned(transposed, self.origin)), *transposed))

    def moved_to(self, origin: Sequence[float | None]) -> SpatialPose:
        """The pose with another origin; None: a coordinate that stays."""
        places = (old if new is None else new for new, old in zip(origin, self.origin, strict=True))
        return SpatialPose((*places, *self.axes))

    def turned_to(self, attitude: Any) -> SpatialPose:
        """The pose with another attitude."""
        return SpatialPose((*self.origin, *attitude.axes))

    def carrying(self, frame: Any) -> SpatialPose:
        """The pose of a body one of whose frames is here: ``frame`` is its pose on the body."""
        return self @ frame.inverse()

    def holding(self, frame: Any, attitude: Any) -> SpatialPose:
        """The pose of a body with this attitude whose ``frame`` has its origin here."""
        return self.turned_to(attitude @ frame).carrying(frame)

    def step(self, way: str, by: float) -> SpatialPose:
        """The pose moved along one of its axes, or turned about it: "x", ..., "rx", ..."""
        unit = tuple(float(i == way[-1]) for i in "xyz")
        if way[0] == "r":
            return self @ SpatialPose.of_axes(about(unit, by))
        return self @ SpatialPose((*(by * e for e in unit), *about((0.0, 0.0, 1.0), 0.0)))


Pose: TypeAlias = PlanarPose | SpatialPose  #: two poses that are combined are both of the plane or both of space


def pose(numbers: Sequence[float]) -> Pose:
    """The pose of (x, y, phi), or of an origin and axes (12 numbers)."""
    return PlanarPose(*numbers) if len(numbers) == 3 else SpatialPose(numbers[:12])


def _plain(x: Any) -> Any:
    """A number in place of a constant expression."""
    return x.value if isinstance(x, Expr) and x.op == "const" else x
