"""TranslationalSpringDamper: a spring and damper along the axis of a sliding joint, by the signed position s.

g = t_a . (r_b - r_a);  force  k (g - s0) + c dg/dt, against the relative motion
"""

from mbdsl.compilation.marks import kernel
from mbdsl.elements import prismatic
from mbdsl.elements.coordinates import slide, slide_hessian
from mbdsl.elements.kind import ForceKind, Parameter, Signal, law_or_spring, power, zero

KIND = ForceKind(
    "TranslationalSpringDamper",
    doc="A spring and damper along the x axis of frame_a; positive force resists a growing position s.",
    rows=1,
    parameters=(
        Parameter("k", "N/m", 0.0, "stiffness"),
        Parameter("c", "N.s/m", 0.0, "damping"),
        Parameter("s0", "m", 0.0, "position without force"),
        Parameter("force", "N", None, "force as an expression, e.g. of s and v; instead of k and c", law=True),
    ),
    signals=(*prismatic.KIND.signals, Signal("force", "N", "k*(s - s0) + c*v", "resisting force")),
    energy="0.5*k*(s - s0)^2",
    results=(power("-(force*v)"),),
    resists=(("force", "s"),),
    check=law_or_spring("force"),
    laws=("force",),
    effects={"damping": zero("c")},
    springs=lambda v: ((v["k"], v["c"], v["s0"]),),
)


@kernel
def gradient(frames, a, b, p, G):
    slide(frames, a, b, G, 0)


@kernel
def hessian(frames, a, b, p, s, H):
    slide_hessian(frames, a, b, s[0], H)
