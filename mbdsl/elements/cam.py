"""Cam: a cam that moves a follower along a line, by a function f of its angle.

    g = s - f(phi),  s = t_b . (r_b - r_a),  phi = phi_a - phi_b                         (1 row)

The follower moves along the x axis of frame_b, which its guide keeps from turning; s is its position from the centre of
the cam. A flat follower touches the cam at the distance f'(phi) from the axis, and the multiplier is the contact
force [N]. For other followers the contact force also has a component across the guide, which does no work and is left
out.
"""

from math import cos, sin

from mbdsl.compilation.buffer_layout import VALUE
from mbdsl.compilation.marks import kernel
from mbdsl.elements.kind import JointKind, Parameter, Signal, wrench

DRAWING = "cam"
KIND = JointKind(
    "Cam",
    doc="A cam about the origin of frame_a moves the origin of frame_b along the x axis of frame_b, as a function of "
    "the cam angle.",
    rows=1,
    parameters=(Parameter("s", "m", doc="position of the follower at the cam angle phi", law=True),),
    signals=(
        Signal("phi", "rad", "frame_a.phi - frame_b.phi", "angle of the cam relative to the axis of the follower"),
        Signal("w", "rad/s", "der(phi)", "angular velocity of the cam"),
        Signal(
            "s",
            "m",
            "cos(frame_b.phi)*(frame_b.x - frame_a.x) + sin(frame_b.phi)*(frame_b.y - frame_a.y)",
            "position of the follower along its x axis, from the centre of the cam",
        ),
        Signal("v", "m/s", "der(s)", "its rate"),
    ),
    reactions=wrench(
        "-(cos(frame_b.phi)*lam[1])",
        "-(sin(frame_b.phi)*lam[1])",
        "-(lam[1]*(cos(frame_b.phi)*(frame_b.y - frame_a.y) - sin(frame_b.phi)*(frame_b.x - frame_a.x) + slope[1]))",
    ),
    coupling=("s", "phi"),
    table=lambda v: (0.0, 0.0, 0.0),
)


@kernel
def gradient(frames, a, b, p, G):
    c, s = cos(frames[b, 2]), sin(frames[b, 2])
    dx, dy = frames[b, 0] - frames[a, 0], frames[b, 1] - frames[a, 1]
    G[0, VALUE] = c * dx + s * dy - p[0]
    G[0, 0], G[0, 1], G[0, 2] = -c, -s, -p[1]
    G[0, 3], G[0, 4], G[0, 5] = c, s, c * dy - s * dx + p[1]


@kernel
def hessian(frames, a, b, p, s, H):
    co, si = s[0] * cos(frames[b, 2]), s[0] * sin(frames[b, 2])
    dx, dy = frames[b, 0] - frames[a, 0], frames[b, 1] - frames[a, 1]
    for i, x, y in ((0, si, -co), (3, -si, co)):
        H[i, 5] += x
        H[5, i] += x
        H[i + 1, 5] += y
        H[5, i + 1] += y
    second = s[0] * p[2]
    H[2, 2] -= second
    H[2, 5] += second
    H[5, 2] += second
    H[5, 5] -= second + co * dx + si * dy
