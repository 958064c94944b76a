"""The line from the origin of frame a to that of frame b as the carrier of two wheels about the z axes of these frames.

    phi = atan2(-y . d, x . d),   d = r_b - r_a, with the axes x, y of frame a or b

is the angle of a frame from the line, about its axis z. It counts turns. With m = (z x d)/rho^2 and the distance rho of
the origins across z,

    dphi = m . (dr_a - dr_b) - (m x d) . dphi_f      of frame f, a or b

Circles of radii r_a and r_b that roll on each other obey r_a phi_a + r_b phi_b = c, wherever the line points: other
than in :mod:`mbdsl.elements.line_of_centres`, no angle is measured from the axes of the world.
"""

from math import atan2, floor, pi

from mbdsl.elements.coordinates_in_space import PHI_A, PHI_B, R_A, R_B, X, Y, Z
from mbdsl.elements.kind import Signal
from mbdsl.elements.line_of_centres import FORMULA, TURN, nearest
from mbdsl.elements.vectors import D, Vector, axis, cross, dot, minus, spin, total, velocity
from mbdsl.kernels.columns import SPACE as C
from mbdsl.kernels.marks import kernel

#: angles of both frames at the start, up to less than half a turn
FIRST_ANGLES = {"phi_a": "frame_a.phi - theta", "phi_b": "frame_b.phi - theta"}
THETA = Signal("theta", "rad", FORMULA, "angle of the line from frame_a to frame_b about the z axis of the world")


def gradient_of(port: str) -> Vector:
    """m of the frame at a port, as formulas."""
    z = axis(port, "z")
    return total((f"1/({dot(D, D)} - {dot(z, D)}*{dot(z, D)})", cross(z, D)))


def rate_of(port: str) -> str:
    """The rate of the angle of the frame at a port from the line, as a formula."""
    relative = minus(velocity("frame_b"), velocity("frame_a"))
    return f"(-{dot(gradient_of(port), minus(relative, cross(spin(port), D)))})"


def angle_of(port: str) -> str:
    """The angle of the frame at a port from the line, as a formula."""
    return f"angle(-{dot(axis(port, 'y'), D)}, {dot(axis(port, 'x'), D)}, {rate_of(port)})"


ANGLES = (
    Signal("phi_a", "rad", angle_of("frame_a"), "angle of frame_a from the line of centres"),
    Signal("phi_b", "rad", angle_of("frame_b"), "angle of frame_b from the line of centres"),
)
M_A, M_B = gradient_of("frame_a"), gradient_of("frame_b")


@kernel
def product(ax, ay, az, bx, by, bz):
    """a x b."""
    return ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx


@kernel
def from_line(frames, a, b, f):
    """The angle of frame f from the line, between -pi and pi [rad]."""
    x, y = 0.0, 0.0
    for i in range(3):
        d = frames[b, i] - frames[a, i]
        x += frames[f, X + i] * d
        y += frames[f, Y + i] * d
    return atan2(-y, x)


@kernel
def counted_from_line(frames, a, b, f, p):
    """The same with its turns. p[0] is the angle at the end of the last accepted step; p[1] becomes this one."""
    phi = from_line(frames, a, b, f)
    p[1] = phi + 2.0 * pi * floor((p[0] - phi) / (2.0 * pi) + 0.5)
    return p[1]


@kernel
def gradient_from_line(frames, a, b, f):
    """d, m and rho^2 of frame f; m is zero where the line has no direction."""
    dx, dy, dz = frames[b, 0] - frames[a, 0], frames[b, 1] - frames[a, 1], frames[b, 2] - frames[a, 2]
    along = frames[f, Z] * dx + frames[f, Z + 1] * dy + frames[f, Z + 2] * dz
    square = dx * dx + dy * dy + dz * dz - along * along
    mx, my, mz = product(frames[f, Z], frames[f, Z + 1], frames[f, Z + 2], dx, dy, dz)
    scale = 1.0 / square if square > 0.0 else 0.0
    return dx, dy, dz, scale * mx, scale * my, scale * mz, square


@kernel
def add_from_line(frames, a, b, f, own, factor, G, k):
    """Row k of G += factor * dphi/dz of frame f, whose rotation has the first column ``own``."""
    dx, dy, dz, mx, my, mz, _square = gradient_from_line(frames, a, b, f)
    mx, my, mz = factor * mx, factor * my, factor * mz
    cx, cy, cz = product(mx, my, mz, dx, dy, dz)
    G[k, R_A] += mx
    G[k, R_A + 1] += my
    G[k, R_A + 2] += mz
    G[k, R_B] -= mx
    G[k, R_B + 1] -= my
    G[k, R_B + 2] -= mz
    G[k, own] -= cx
    G[k, own + 1] -= cy
    G[k, own + 2] -= cz


@kernel
def from_line_hessian(frames, a, b, f, own, factor, H):
    """H += factor * d(G^T)/dz: dm = (dz x d + z x dd - m d(rho^2))/rho^2, of a motion of b, then of a rotation of f."""
    dx, dy, dz, mx, my, mz, square = gradient_from_line(frames, a, b, f)
    if square > 0.0:
        zx, zy, zz = frames[f, Z], frames[f, Z + 1], frames[f, Z + 2]
        along = zx * dx + zy * dy + zz * dz
        for j in range(3):
            ex, ey, ez = 1.0 if j == 0 else 0.0, 1.0 if j == 1 else 0.0, 1.0 if j == 2 else 0.0
            # a motion of b along e
            ux, uy, uz = product(zx, zy, zz, ex, ey, ez)
            change = 2.0 * (dx * ex + dy * ey + dz * ez - along * (zx * ex + zy * ey + zz * ez))
            ux, uy, uz = (ux - mx * change) / square, (uy - my * change) / square, (uz - mz * change) / square
            cx, cy, cz = product(ux, uy, uz, dx, dy, dz)
            sx, sy, sz = product(mx, my, mz, ex, ey, ez)
            u, c = (ux, uy, uz), (cx + sx, cy + sy, cz + sz)
            add_column(u, c, factor, own, H, R_B + j)
            add_column(u, c, -factor, own, H, R_A + j)
            # a rotation of f about e
            wx, wy, wz = product(ex, ey, ez, zx, zy, zz)
            ux, uy, uz = product(wx, wy, wz, dx, dy, dz)
            change = -2.0 * along * (wx * dx + wy * dy + wz * dz)
            ux, uy, uz = (ux - mx * change) / square, (uy - my * change) / square, (uz - mz * change) / square
            add_column((ux, uy, uz), product(ux, uy, uz, dx, dy, dz), factor, own, H, own + j)


@kernel
def add_column(u, c, factor, own, H, j):
    """Column j of H: of d(dphi/dz) for the changes u of m and c of m x d."""
    H[R_A, j] += factor * u[0]
    H[R_A + 1, j] += factor * u[1]
    H[R_A + 2, j] += factor * u[2]
    H[R_B, j] -= factor * u[0]
    H[R_B + 1, j] -= factor * u[1]
    H[R_B + 2, j] -= factor * u[2]
    H[own, j] -= factor * c[0]
    H[own + 1, j] -= factor * c[1]
    H[own + 2, j] -= factor * c[2]


@kernel
def rolling(frames, a, b, p, G):
    """Row 0 of G: g = r_a phi_a + r_b phi_b - c, for p = (two of phi_a, two of phi_b, r_a, r_b, c)."""
    g = p[4] * counted_from_line(frames, a, b, a, p) + p[5] * counted_from_line(frames, a, b, b, p[2:]) - p[6]
    for j in range(12):
        G[0, j] = 0.0
    G[0, C.VALUE] = nearest(g, TURN * abs(p[4] + p[5]))
    add_from_line(frames, a, b, a, PHI_A, p[4], G, 0)
    add_from_line(frames, a, b, b, PHI_B, p[5], G, 0)


@kernel
def rolling_hessian(frames, a, b, p, s, H):
    from_line_hessian(frames, a, b, a, PHI_A, p[4] * s[0], H)
    from_line_hessian(frames, a, b, b, PHI_B, p[5] * s[0], H)
