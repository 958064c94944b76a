"""Formulas of signals in space, made of vectors: each vector is a tuple of three formulas, in world axes."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from math import atan2, cos, hypot, sin

from mbdsl.elements.kind import Signal

Vector = tuple[str, str, str]
#: axes of a frame that is not turned
UNTURNED = (1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0)


def vector(components: Iterable[str]) -> Vector:
    x, y, z = components
    return x, y, z


def axis(port: str, name: str) -> Vector:
    """The axis x, y or z of the frame at a port."""
    return vector(f"{port}.{name}{i}" for i in "xyz")


def origin(port: str) -> Vector:
    return vector(f"{port}.{i}" for i in "xyz")


def spin(port: str) -> Vector:
    return vector(f"{port}.w{i}" for i in "xyz")


def velocity(port: str) -> Vector:
    return vector(f"{port}.v{i}" for i in "xyz")


def minus(a: Vector, b: Vector) -> Vector:
    return vector(f"({x} - {y})" for x, y in zip(a, b, strict=True))


def dot(a: Vector, b: Vector) -> str:
    return "(" + " + ".join(f"{x}*{y}" for x, y in zip(a, b, strict=True)) + ")"


def cross(a: Vector, b: Vector) -> Vector:
    return vector(f"({a[j]}*{b[k]} - {a[k]}*{b[j]})" for j, k in ((1, 2), (2, 0), (0, 1)))


def total(*terms: tuple[str, Vector]) -> Vector:
    """The sum of factors times vectors."""
    return vector("(" + " + ".join(f"{factor}*{a[i]}" for factor, a in terms) + ")" for i in range(3))


#: from frame_a to frame_b
D = minus(origin("frame_b"), origin("frame_a"))
#: angular velocity of frame_b relative to frame_a
W = minus(spin("frame_b"), spin("frame_a"))


def slip() -> Vector:
    """Velocity of the origin of frame_b relative to the point of frame_a's body at the same place."""
    return minus(minus(velocity("frame_b"), velocity("frame_a")), cross(spin("frame_a"), D))


def reactions(force: Vector | None, torque: Vector | None, about_n: str = "") -> tuple[Signal, ...]:
    """The wrench that a joint transmits to frame_b, at its origin in world axes.

    ``tau`` is the torque ``about_n``, a formula, of kinds that transmit one about their axis; else it equals ``tz``."""
    found = (
        []
        if force is None
        else [Signal(f"f{i}", "N", f, f"force along {i}") for i, f in zip("xyz", force, strict=True)]
    )
    if torque is not None:
        found += [Signal(f"t{i}", "N.m", f, f"torque about {i}") for i, f in zip("xyz", torque, strict=True)]
        meaning = "torque about the axis n" if about_n else "torque about the z axis of the world"
        found.append(Signal("tau", "N.m", about_n or torque[2], meaning))
    return tuple(found)


def wrench(force: Vector | None, torque: Vector | None) -> dict[str, str]:
    """``exerts`` of a kind, in world axes."""
    found = {} if force is None else {f"f{i}": f for i, f in zip("xyz", force, strict=True)}
    return found if torque is None else found | {f"t{i}": f for i, f in zip("xyz", torque, strict=True)}


def turned_to(default: str, n: Sequence[float]) -> tuple[float, ...]:
    """Axes (9) of a frame whose axis ``default``, x or z, has the direction n: turned by the smallest angle."""
    length = hypot(*n)
    x, y, z = (a / length for a in n)
    if default == "x":
        angle, along = atan2(hypot(y, z), x), (0.0, -z, y)
    else:
        angle, along = atan2(hypot(x, y), z), (-y, x, 0.0)
    size = hypot(*along)
    if size == 0.0:
        along = (0.0, 0.0, 1.0) if default == "x" else (1.0, 0.0, 0.0)
        size = 1.0
    return about(tuple(a / size for a in along), angle) if angle else UNTURNED


def cardan_angles() -> tuple[Signal, ...]:
    """The Cardan angles of frame_b relative to frame_a, the angles about x, y and z, and their rates."""
    (xa, ya, za), (xb, yb, zb) = ([axis(port, i) for i in "xyz"] for port in ("frame_a", "frame_b"))
    zx, zy, zz = (dot(a, zb) for a in (xa, ya, za))  # components of z_b in the axes of frame_a
    c, s = (
        f"(cos(phi_x)*{dot(ya, b)} + sin(phi_x)*{dot(za, b)})" for b in (yb, xb)
    )  # as of the Cardan angles of a frame, in mbdsl.expressions.spatial_coordinates
    return (
        Signal("phi_x", "rad", f"atan2(-{zy}, {zz})", "first Cardan angle of frame_b, about the x axis of frame_a"),
        Signal("phi_y", "rad", f"atan2({zx}, hypot({zy}, {zz}))", "second Cardan angle, about the turned y axis"),
        Signal("phi_z", "rad", f"atan2({s}, {c})", "third Cardan angle, about the z axis of frame_b"),
        *(Signal(f"w_{i}", "rad/s", f"der(phi_{i})", f"rate of phi_{i}") for i in "xyz"),
    )


def gradient_of_angle() -> Vector:
    """The direction m for which the angle of x_b about z_a has the rate m . W: z_a if x_b is normal to z_a."""
    x, y, z = (axis("frame_a", i) for i in "xyz")
    b = axis("frame_b", "x")
    along, across = dot(z, b), (dot(x, b), dot(y, b))
    size = f"({across[0]}*{across[0]} + {across[1]}*{across[1]})"
    return total(("1", z), (f"(-{along}*{across[0]}/{size})", x), (f"(-{along}*{across[1]}/{size})", y))


def about(n: Sequence[float], phi: float) -> tuple[float, ...]:
    """The axes of a frame that is turned by phi about the unit vector n (9)."""
    x, y, z = n
    c, s = cos(phi), sin(phi)
    d = 1.0 - c
    return (
        c + d * x * x, d * x * y + s * z, d * x * z - s * y,
        d * x * y - s * z, c + d * y * y, d * y * z + s * x,
        d * x * z + s * y, d * y * z - s * x, c + d * z * z,
    )  # fmt: skip


def both(default: str):
    """``axes`` of kinds whose axis is n, in both frames."""

    def axes(v):
        found = turned_to(default, v["n"])
        return {"frame_a": found, "frame_b": found}

    return axes


def least_minor(I, size: float) -> float:
    """The least principal minor, relative to the largest entry.

    A symmetric matrix has no negative eigenvalue if and only if no principal minor is negative.
    """
    if size == 0.0:
        return 0.0
    (a, d, e), (_, b, f), (_, _, c) = (tuple(x / size for x in row) for row in I)
    minors = (a, b, c, a * b - d * d, a * c - e * e, b * c - f * f)
    whole = a * (b * c - f * f) - d * (d * c - f * e) + e * (d * f - b * e)
    return min(*minors, whole)
