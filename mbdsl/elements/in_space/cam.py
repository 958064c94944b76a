"""Cam: a cam that moves a follower along a line, by a function f of its angle.

    g = s - f(phi),  s = x_b . (r_b - r_a)                                               (1 row)

The follower moves along x_b, the direction n of frame_b, which its guide keeps from turning; s is its position from the
centre of the cam. phi is the angle of frame_a about the axis of the cam, relative to frame_b. The multiplier is the
contact force of a flat follower [N].
"""

from mbdsl.compilation.buffer_layout_in_space import VALUE
from mbdsl.compilation.marks import kernel
from mbdsl.elements import cam
from mbdsl.elements.coordinates_in_space import (
    PHI_A,
    PHI_B,
    R_A,
    R_B,
    X,
    Y,
    Z,
    add_cross,
    angle_about,
    angle_hessian,
)
from mbdsl.elements.in_space.line_of_centres import product
from mbdsl.elements.in_space.rack_and_pinion import axes, right_angle
from mbdsl.elements.kind import Parameter, Signal, in_space
from mbdsl.elements.motions import GRADIENT
from mbdsl.elements.rows import X_A, X_B, Y_A
from mbdsl.elements.vectors import D, W, cross, dot, reactions, total

DRAWING = "cam"
RATE = f"(-{dot(W, GRADIENT)})"

KIND = in_space(
    cam.KIND,
    doc="A cam about the origin of frame_a moves the origin of frame_b along n of frame_b, as a function of the cam "
    "angle.",
    parameters=(
        *cam.KIND.parameters,
        Parameter("n", "1", (1.0, 0.0, 0.0), "direction of the follower's motion", shape=(3,)),
        Parameter("axis", "1", (0.0, 0.0, 1.0), "axis of the cam, at right angles to n", shape=(3,)),
    ),
    signals=(
        Signal(
            "phi", "rad", f"angle(-{dot(Y_A, X_B)}, {dot(X_A, X_B)}, {RATE})", "angle of the cam relative to frame_b"
        ),
        Signal("w", "rad/s", RATE, "angular velocity of the cam"),
        Signal("s", "m", dot(X_B, D), "position of the follower along n, from the centre of the cam"),
        Signal("v", "m/s", "der(s)", "its rate"),
    ),
    reactions=reactions(total(("-lam[1]", X_B)), total(("-lam[1]", cross(X_B, D)), ("(-lam[1]*slope[1])", GRADIENT))),
    check=lambda v: right_angle(v, "the axis of the cam is not at right angles to the motion of the follower"),
    axes=axes,
    first_angles={"phi": "frame_a.phi - frame_b.phi"},
)


@kernel
def gradient(frames, a, b, p, G):
    """phi is minus the angle of frame_b relative to frame_a."""
    angle_about(frames, a, b, X, Y, Z, G, 0)
    x, y, z = frames[b, X], frames[b, X + 1], frames[b, X + 2]
    dx, dy, dz = frames[b, 0] - frames[a, 0], frames[b, 1] - frames[a, 1], frames[b, 2] - frames[a, 2]
    G[0, VALUE] = x * dx + y * dy + z * dz - p[0]
    G[0, R_A], G[0, R_A + 1], G[0, R_A + 2] = -x, -y, -z
    G[0, R_B], G[0, R_B + 1], G[0, R_B + 2] = x, y, z
    tx, ty, tz = product(x, y, z, dx, dy, dz)
    for i in range(3):
        G[0, PHI_A + i] *= p[1]
        G[0, PHI_B + i] *= p[1]
    G[0, PHI_B] += tx
    G[0, PHI_B + 1] += ty
    G[0, PHI_B + 2] += tz


@kernel
def hessian(frames, a, b, p, s, H):
    """Of s, of f' times the angle, and -f'' (dphi/dz) (dphi/dz)^T."""
    x, y, z = s[0] * frames[b, X], s[0] * frames[b, X + 1], s[0] * frames[b, X + 2]
    add_cross(x, y, z, H, R_A, PHI_B)
    add_cross(-x, -y, -z, H, R_B, PHI_B)
    add_cross(-x, -y, -z, H, PHI_B, R_A)
    add_cross(x, y, z, H, PHI_B, R_B)
    along, c, e, u = 0.0, 0.0, 0.0, 0.0
    for i in range(3):
        along += s[0] * frames[b, X + i] * (frames[b, i] - frames[a, i])
        c += frames[a, X + i] * frames[b, X + i]
        e += frames[a, Y + i] * frames[b, X + i]
        u += frames[a, Z + i] * frames[b, X + i]
    angle_hessian(frames, a, b, s[0] * p[1], H)
    ratio, second = u / (c * c + e * e), s[0] * p[2]
    for i in range(3):
        m = frames[a, Z + i] - ratio * (frames[b, X + i] - u * frames[a, Z + i])
        for j in range(3):
            n = frames[a, Z + j] - ratio * (frames[b, X + j] - u * frames[a, Z + j])
            H[PHI_A + i, PHI_A + j] -= second * m * n
            H[PHI_A + i, PHI_B + j] += second * m * n
            H[PHI_B + i, PHI_A + j] += second * m * n
            H[PHI_B + i, PHI_B + j] -= second * m * n
            H[PHI_B + i, PHI_B + j] += s[0] * frames[b, X + i] * (frames[b, j] - frames[a, j])
        H[PHI_B + i, PHI_B + i] -= along
