"""Names of the coordinates of a frame in space, and the derivatives of expressions in them.

The pose of a frame is its origin x, y, z and its axes, in world axes: xx, xy, xz are the components of its x axis.
Rates are the velocity of the origin and the angular velocity, in world axes. A virtual motion (dr, dphi) of the frame
changes its origin by dr and each axis a by dphi x a.

Models name further coordinates, which are functions of these: Cardan angles phi_x, phi_y, phi_z, the angular velocity
wx_local, wy_local, wz_local in the axes of the frame, and the quaternion p0, p1, p2, p3. Cardan angles turn about x,
then about the turned y, then about the turned z axis. They are between -pi and pi, phi_y between -pi/2 and pi/2; where
phi_y is one of these, only the sum or difference of phi_x and phi_z is determined, and their rates are not finite.
"""

from __future__ import annotations

from mbdsl.expressions.derivatives import diff
from mbdsl.expressions.symbolic import Expr, call, const, coordinate

AXES = ("xx", "xy", "xz", "yx", "yy", "yz", "zx", "zy", "zz")
POSITIONS = ("x", "y", "z", *AXES)
VELOCITIES = ("vx", "vy", "vz", "wx", "wy", "wz")
COORDINATES = POSITIONS + VELOCITIES

CARDAN = ("phi_x", "phi_y", "phi_z")
LOCAL = ("wx_local", "wy_local", "wz_local")
QUATERNION = ("p0", "p1", "p2", "p3")
#: names of the coordinates of a frame in models, and their units
UNITS = {"x": "m", "y": "m", "z": "m", "phi": "rad", "vx": "m/s", "vy": "m/s", "vz": "m/s"}
UNITS |= dict.fromkeys(("wx", "wy", "wz", "w"), "rad/s") | dict.fromkeys(CARDAN, "rad")
UNITS |= dict.fromkeys(LOCAL, "rad/s") | dict.fromkeys((*QUATERNION, *AXES), "1")
NAMES = tuple(UNITS)
MEANINGS = {i: f"position along {i}" for i in "xyz"} | {f"v{i}": f"velocity along {i}" for i in "xyz"}
MEANINGS |= {f"w{i}": f"angular velocity about the {i} axis of the world" for i in "xyz"}
MEANINGS |= {
    "phi": "angle of the x axis about the z axis of the world",
    "w": "angular velocity about the z axis of the world",
    "phi_x": "first Cardan angle, about the x axis of the world",
    "phi_y": "second Cardan angle, about the turned y axis",
    "phi_z": "third Cardan angle, about the own z axis",
}
MEANINGS |= {f"w{i}_local": f"angular velocity about the own {i} axis" for i in "xyz"}
MEANINGS |= {f"p{k}": f"quaternion, {'scalar' if k == 0 else 'xyz'[k - 1]} part" for k in range(4)}
MEANINGS |= {a: f"component along {a[1]} of the own {a[0]} axis" for a in AXES}


def named(frame: str, key: str) -> Expr:
    """A coordinate of a frame by its name in models.

    Source of the quaternion: S. W. Shepperd, J. Guidance and Control 1 (1978) 223-224.
    """
    if key in ("wz", "w"):
        return coordinate(frame, "wz")
    if key == "phi":
        x, y, z, wx, wy, wz = (coordinate(frame, name) for name in ("xx", "xy", "xz", "wx", "wy", "wz"))
        return call("angle", y, x, wz - z * call("ratio", wx * x + wy * y, x * x + y * y))
    if key in CARDAN:
        return _cardan(frame, key)
    if key in LOCAL:
        x, y, z = (coordinate(frame, key[1] + i) * coordinate(frame, f"w{i}") for i in "xyz")
        return x + y + z
    return _quaternion(frame, QUATERNION.index(key)) if key in QUATERNION else coordinate(frame, key)


def _cardan(frame: str, key: str) -> Expr:
    """A Cardan angle: R = R_x(phi_x) R_y(phi_y) R_z(phi_z).

    phi_z is that of R_x(phi_x)^T R, so that the angles give R to rounding also where phi_x is not determined.
    """
    xy, xz, yy, yz, zx, zy, zz = (coordinate(frame, name) for name in ("xy", "xz", "yy", "yz", "zx", "zy", "zz"))
    if key == "phi_y":
        return call("atan2", zx, call("hypot", zy, zz))
    phi_x = call("atan2", -zy, zz)
    if key == "phi_x":
        return phi_x
    c, s = call("cos", phi_x), call("sin", phi_x)
    return call("atan2", c * xy + s * xz, c * yy + s * yz)


def _quaternion(frame: str, k: int) -> Expr:
    """A part of the quaternion p with p0 >= 0, from the largest of its parts, so that no part loses digits.

    The matrix N = 4 p p^T is linear in the components of the axes: p_k = N_jk/(2 sqrt(N_jj)), for any j.
    """
    xx, xy, xz, yx, yy, yz, zx, zy, zz = (coordinate(frame, name) for name in AXES)
    squares = [1.0 + xx + yy + zz, 1.0 + xx - yy - zz, 1.0 - xx + yy - zz, 1.0 - xx - yy + zz]
    products = {(0, 1): yz - zy, (0, 2): zx - xz, (0, 3): xy - yx, (1, 2): xy + yx, (1, 3): zx + xz, (2, 3): yz + zy}

    def of(j: int) -> Expr:
        entry = squares[k] if j == k else products[min(j, k), max(j, k)]
        found = entry / (2.0 * call("sqrt", squares[j]))
        return found if j == 0 else call("select", call("lt", products[0, j], 0.0), -found, found)

    found, largest = of(3), squares[3]
    for j in (2, 1, 0):
        found, largest = call("select", call("le", largest, squares[j]), of(j), found), call("max", largest, squares[j])
    return found


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
