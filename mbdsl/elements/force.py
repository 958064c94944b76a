"""Force: acts at the origin of frame_b, with components in the axes of frame_a (default: world axes).

f = fx t_a + fy n_a.  frame_a only defines the directions: no reaction acts on it.
"""

from math import cos, sin

from mbdsl.compilation.marks import kernel
from mbdsl.elements.kind import ForceKind, Parameter, power

FX, FY = "(fx*cos(frame_a.phi) - fy*sin(frame_a.phi))", "(fx*sin(frame_a.phi) + fy*cos(frame_a.phi))"

KIND = ForceKind(
    "Force",
    doc="A force on the origin of frame_b, with components in the axes of frame_a, or of the world without frame_a. No "
    "reaction acts on frame_a. With frame_a = frame_b it is a follower force.",
    rows=2,
    optional_ports=("frame_a",),
    parameters=(
        Parameter("fx", "N", 0.0, "component along x, a number or an expression", law=True),
        Parameter("fy", "N", 0.0, "component along y, a number or an expression", law=True),
    ),
    results=(power(f"{FX}*frame_b.vx + {FY}*frame_b.vy"),),
    exerts={"fx": FX, "fy": FY},
    reacts=False,
    laws=("fx", "fy"),
    sign=1.0,
)


@kernel
def gradient(frames, a, b, p, G):
    c, s = cos(frames[a, 2]), sin(frames[a, 2])
    G[0, 3], G[0, 4] = c, s
    G[1, 3], G[1, 4] = -s, c


@kernel
def hessian(frames, a, b, p, s, H):
    co, si = cos(frames[a, 2]), sin(frames[a, 2])
    H[3, 2] += -si * s[0] - co * s[1]
    H[4, 2] += co * s[0] - si * s[1]
