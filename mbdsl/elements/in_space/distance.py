"""Distance: a massless link that keeps two frame origins at a constant distance L > 0.

g = |r_b - r_a| - L                                                                  (1 row)
"""

from mbdsl.compilation.buffer_layout_in_space import VALUE
from mbdsl.compilation.marks import kernel
from mbdsl.elements.in_space.coordinates import length, length_hessian
from mbdsl.elements.in_space.vectors import D, dot, reactions, total
from mbdsl.elements.kind import AXIAL, JointKind, Parameter, Signal

SIGNALS = (
    Signal("s", "m", f"sqrt({dot(D, D)})", "distance of the frames"),
    Signal("v", "m/s", "der(s)", "its rate"),
)

KIND = JointKind(
    "Distance",
    doc="A massless rigid link: the distance of the two frame origins stays constant.",
    rows=1,
    parameters=(Parameter("length", "m", doc="the constant distance", positive=True),),
    signals=SIGNALS,
    reactions=reactions(total(("-lam[1]/s", D)), None),
    results=(AXIAL,),
    table=lambda v: (v["length"],),
    along=("s", "length"),
    size="length",
    spatial=True,
)


@kernel
def gradient(frames, a, b, p, G):
    length(frames, a, b, G, 0)
    G[0, VALUE] -= p[0]


@kernel
def hessian(frames, a, b, p, s, H):
    length_hessian(frames, a, b, s[0], H)
