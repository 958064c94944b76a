"""The angle theta of the line from the origin of frame a to that of frame b, and pitch circles that roll on each other.

    theta = theta_0 + atan2(-sin(theta_0) dx + cos(theta_0) dy, cos(theta_0) dx + sin(theta_0) dy),  d = r_b - r_a

theta jumps by a turn where the line passes the direction theta_0 - pi, in which few machines have a line of centres.

Circles of radii r_a and r_b about these origins that roll on each other externally obey

    r_a (w_a - theta') + r_b (w_b - theta') = 0

(Willis' equation, with the line of centres as the carrier); r_b is negative if circle b surrounds circle a. Its
integral is a constraint of positions. Jumps of theta change it by multiples of 2 pi (r_a + r_b), which are removed.
"""

from math import atan2, cos, sin

from mbdsl.kernels.columns import PLANE as C
from mbdsl.kernels.marks import kernel

TURN = 6.283185307179586
THETA_0 = 0.6  #: [rad]
COS_0, SIN_0 = 0.8253356149096783, 0.5646424733950354
#: theta as a formula of signals
FORMULA = (
    f"({THETA_0} + atan2({COS_0}*(frame_b.y - frame_a.y) - {SIN_0}*(frame_b.x - frame_a.x), "
    f"{COS_0}*(frame_b.x - frame_a.x) + {SIN_0}*(frame_b.y - frame_a.y)))"
)
SQUARE = "((frame_b.x - frame_a.x)^2 + (frame_b.y - frame_a.y)^2)"


@kernel
def direction(frames, a, b):
    """theta [rad]."""
    dx, dy = frames[b, 0] - frames[a, 0], frames[b, 1] - frames[a, 1]
    return THETA_0 + atan2(COS_0 * dy - SIN_0 * dx, COS_0 * dx + SIN_0 * dy)


@kernel
def add_direction(frames, a, b, factor, G, k):
    """Row k of G += factor * d theta/dz; at zero distance the direction is undefined, and nothing is added."""
    dx, dy = frames[b, 0] - frames[a, 0], frames[b, 1] - frames[a, 1]
    square = dx * dx + dy * dy
    if square > 0.0:
        x, y = -factor * dy / square, factor * dx / square
        G[k, 0] -= x
        G[k, 1] -= y
        G[k, 3] += x
        G[k, 4] += y


@kernel
def direction_hessian(frames, a, b, factor, H):
    """H += factor * d^2 theta/dz^2."""
    dx, dy = frames[b, 0] - frames[a, 0], frames[b, 1] - frames[a, 1]
    square = dx * dx + dy * dy
    if square > 0.0:
        xx, xy = 2.0 * factor * dx * dy / square / square, factor * (dy * dy - dx * dx) / square / square
        for i in (0, 3):
            for j in (0, 3):
                sign = 1.0 if i == j else -1.0
                H[i, j] += sign * xx
                H[i, j + 1] += sign * xy
                H[i + 1, j] += sign * xy
                H[i + 1, j + 1] -= sign * xx


@kernel
def nearest(value, period):
    """``value`` without the multiple of ``period`` that is nearest to it."""
    if period == 0.0:
        return value
    turns = value / period + 0.5
    return value - period * (turns - turns % 1.0)  # floor fails for values that are not finite


@kernel
def rolling(frames, a, b, p, G):
    """Row 0 of G: g = r_a (phi_a - theta) + r_b (phi_b - theta) - c, for p = (r_a, r_b, c)."""
    both = p[0] + p[1]
    theta = direction(frames, a, b)
    g = p[0] * frames[a, 2] + p[1] * frames[b, 2] - p[2] - both * theta
    G[0, C.VALUE] = nearest(g, TURN * abs(both))
    for j in range(6):
        G[0, j] = 0.0
    G[0, 2], G[0, 5] = p[0], p[1]
    add_direction(frames, a, b, -both, G, 0)


@kernel
def rolling_hessian(frames, a, b, p, s, H):
    direction_hessian(frames, a, b, -(p[0] + p[1]) * s[0], H)
