"""SpringDamper: a spring and a damper between two points, linear or by a law of distance s and its rate v.

s = |r_b - r_a|;  tension  k (s - s0) + c ds/dt
"""

from mbdsl.elements.declaration import Parameter, power
from mbdsl.elements.kind import ForceKind, Signal, in_space, law_or_spring, zero
from mbdsl.elements.motions import APART, APART_IN_SPACE
from mbdsl.elements.rows import LENGTH

KIND = ForceKind(
    "SpringDamper",
    doc="A spring and damper along the line between two points; positive force pulls them together.",
    g=(LENGTH,),
    parameters=(
        Parameter("k", "N/m", 0.0, "stiffness"),
        Parameter("c", "N.s/m", 0.0, "damping"),
        Parameter("s0", "m", 0.0, "free length"),
        Parameter("force", "N", None, "tension as an expression, e.g. of s and v; instead of k and c", law=True),
    ),
    signals=(*APART, Signal("force", "N", "k*(s - s0) + c*v", "tension")),
    energy="0.5*k*(s - s0)^2",
    results=(power("-(force*v)"),),
    resists=(("force", "s"),),
    check=law_or_spring("force"),
    laws=("force",),
    effects={"damping": zero("c")},
    springs=lambda v: ((v["k"], v["c"], v["s0"]),),
    drawing="spring",
)
IN_SPACE = in_space(KIND, signals=(*APART_IN_SPACE, KIND.signals[-1]))
