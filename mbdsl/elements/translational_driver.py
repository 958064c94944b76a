"""TranslationalDriver: prescribes the position of frame_b along the x axis of frame_a (rheonomic).

g = t_a . (r_b - r_a) - u(t)                                                         (1 row)
"""

from mbdsl.compilation.marks import kernel
from mbdsl.elements import prismatic
from mbdsl.elements.coordinates import slide, slide_hessian
from mbdsl.elements.kind import AXIAL, JointKind, Parameter, power, wrench

KIND = JointKind(
    "TranslationalDriver",
    doc="A drive that moves a sliding joint as a given function of time.",
    rows=1,
    parameters=(Parameter("s", "m", doc="the position, an expression in time", law=True),),
    signals=prismatic.KIND.signals,
    reactions=wrench("-(cos(frame_a.phi)*lam[1])", "-(sin(frame_a.phi)*lam[1])"),
    results=(AXIAL, power("-(force*v)")),
    driver="s",
    along=("s",),
)


@kernel
def gradient(frames, a, b, p, G):
    slide(frames, a, b, G, 0)


@kernel
def hessian(frames, a, b, p, s, H):
    slide_hessian(frames, a, b, s[0], H)
