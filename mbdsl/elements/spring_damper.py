"""SpringDamper: a spring and a damper between two points, linear or by a law of distance s and its rate v.

g = |r_b - r_a|;  tension  k (g - s0) + c dg/dt
"""

from mbdsl.compilation.marks import kernel
from mbdsl.elements import distance_driver
from mbdsl.elements.coordinates import distance, distance_hessian
from mbdsl.elements.kind import ForceKind, Parameter, Signal, law_or_spring, power, zero

KIND = ForceKind(
    "SpringDamper",
    doc="A spring and damper along the line between two points; positive force pulls them together.",
    rows=1,
    parameters=(
        Parameter("k", "N/m", 0.0, "stiffness"),
        Parameter("c", "N.s/m", 0.0, "damping"),
        Parameter("s0", "m", 0.0, "free length"),
        Parameter("force", "N", None, "tension as an expression, e.g. of s and v; instead of k and c", law=True),
    ),
    signals=(*distance_driver.KIND.signals, Signal("force", "N", "k*(s - s0) + c*v", "tension")),
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
    distance(frames, a, b, G, 0)


@kernel
def hessian(frames, a, b, p, s, H):
    distance_hessian(frames, a, b, s[0], H)
