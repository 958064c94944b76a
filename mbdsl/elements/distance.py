"""Distance: a massless link that keeps two frame origins at a constant distance L > 0.

g = |r_b - r_a| - L                                                                  (1 row)
"""

from mbdsl.compilation.buffer_layout import VALUE
from mbdsl.compilation.marks import kernel
from mbdsl.elements.coordinates import distance, distance_hessian
from mbdsl.elements.kind import AXIAL, JointKind, Parameter, Signal, wrench

KIND = JointKind(
    "Distance",
    doc="A massless rigid link: the distance of the two frame origins stays constant.",
    rows=1,
    parameters=(Parameter("length", "m", doc="the constant distance", positive=True),),
    signals=(
        Signal("s", "m", "hypot(frame_b.x - frame_a.x, frame_b.y - frame_a.y)", "distance of the frames"),
        Signal("v", "m/s", "der(s)", "its rate"),
    ),
    reactions=wrench("-(lam[1]*(frame_b.x - frame_a.x)/s)", "-(lam[1]*(frame_b.y - frame_a.y)/s)"),
    results=(AXIAL,),
    table=lambda v: (v["length"],),
    along=("s", "length"),
    size="length",
)


@kernel
def gradient(frames, a, b, p, G):
    distance(frames, a, b, G, 0)
    G[0, VALUE] -= p[0]


@kernel
def hessian(frames, a, b, p, s, H):
    distance_hessian(frames, a, b, s[0], H)
