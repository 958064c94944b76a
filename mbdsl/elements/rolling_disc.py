"""RollingDisc: a disc about the origin of frame_b that rolls without slip on the x axis of frame_a, above it.

    g     = n_a . d - radius,  d = r_b - r_a                                             (1 row)
    Gamma = t_a . (v_b - v_a) + w_a (n_a . d) + radius (w_b - w_a) = 0                   (1 row, of velocities)

Gamma is the velocity along the line of the disc's lowest point, t_a . v_b + radius w_b, less that of the point of the
line below it, t_a . v_a - w_a (n_a . (d - radius n_a)). Its first two terms are the rate of s = t_a . d. The disc rolls
towards +x where it turns clockwise.
"""

from mbdsl.compilation.buffer_layout import VALUE
from mbdsl.compilation.marks import kernel
from mbdsl.elements import point_on_line
from mbdsl.elements.coordinates import offset, offset_hessian
from mbdsl.elements.kind import JointKind, Parameter, Signal, wrench

#: the lowest point of a circle, on the x axis of frame_a
BELOW = ("frame_b.x + radius*sin(frame_a.phi)", "frame_b.y - radius*cos(frame_a.phi)")
KIND = JointKind(
    "RollingDisc",
    doc="A disc with its centre at the origin of frame_b rolls without slip on the x axis of frame_a, above it.",
    rows=1,
    parameters=(Parameter("radius", "m", doc="radius of the disc", positive=True),),
    signals=tuple(
        Signal("v", "m/s", "der(s)", "velocity of the centre along the axis") if x.name == "v" else x
        for x in point_on_line.KIND.signals
    ),
    velocity_rows=("v + radius*w",),
    reactions=wrench(
        "sin(frame_a.phi)*lam[1] - cos(frame_a.phi)*lam[2]",
        "-(cos(frame_a.phi)*lam[1]) - sin(frame_a.phi)*lam[2]",
        "-(radius*lam[2])",
    ),
    touches=BELOW,
    table=lambda v: (v["radius"],),
    angle=("phi",),
    along=("s",),
)


@kernel
def gradient(frames, a, b, p, G):
    offset(frames, a, b, G, 0)
    G[0, VALUE] -= p[0]


@kernel
def hessian(frames, a, b, p, s, H):
    offset_hessian(frames, a, b, s[0], H)
