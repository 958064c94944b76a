"""Names of the coordinates of a frame in space, and the derivatives of expressions in them.

The pose of a frame is its origin x, y, z and its axes, in world axes: xx, xy, xz are the components of its x axis.
Rates are the velocity of the origin and the angular velocity, in world axes. A virtual motion (dr, dphi) of the frame
changes its origin by dr and each axis a by dphi x a.
"""

from __future__ import annotations

from mbdsl.expressions.symbolic import Expr, call, const, coordinate, diff

AXES = ("xx", "xy", "xz", "yx", "yy", "yz", "zx", "zy", "zz")
POSITIONS = ("x", "y", "z", *AXES)
VELOCITIES = ("vx", "vy", "vz", "wx", "wy", "wz")
COORDINATES = POSITIONS + VELOCITIES


#: names of the coordinates of a frame in models, and their units: phi is the angle of its x axis about the z axis
UNITS = {"x": "m", "y": "m", "z": "m", "phi": "rad", "vx": "m/s", "vy": "m/s", "vz": "m/s"}
UNITS |= dict.fromkeys(("wx", "wy", "wz", "w"), "rad/s") | dict.fromkeys(AXES, "1")
NAMES = tuple(UNITS)


def named(frame: str, key: str) -> Expr:
    """A coordinate of a frame by its name in models."""
    if key == "phi":
        x, y, z, wx, wy, wz = (coordinate(frame, name) for name in ("xx", "xy", "xz", "wx", "wy", "wz"))
        return call("angle", y, x, wz - z * call("ratio", wx * x + wy * y, x * x + y * y))
    return coordinate(frame, "wz" if key == "w" else key)


def virtual(root: Expr, frame: str) -> list[Expr]:
    """Derivatives of ``root`` with respect to the virtual displacement and rotation of ``frame``, in world axes (6)."""
    found = diff(root, *(coordinate(frame, key) for key in POSITIONS))
    rotation = [const(0.0)] * 3
    for n, axis in enumerate("xyz"):
        a = [coordinate(frame, axis + other) for other in "xyz"]
        d = found[3 + 3 * n : 6 + 3 * n]
        for i in range(3):  # d . (e_i x a) = e_i . (a x d)
            j, k = (i + 1) % 3, (i + 2) % 3
            rotation[i] = rotation[i] + (a[j] * d[k] - a[k] * d[j])
    return [*found[:3], *rotation]


def of_rates(root: Expr, frame: str) -> list[Expr]:
    """Derivatives of ``root`` with respect to the velocity and angular velocity of ``frame`` (6)."""
    return diff(root, *(coordinate(frame, key) for key in VELOCITIES))
