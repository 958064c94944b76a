"""TranslationalSpringDamper: a spring and damper along the axis of a sliding joint, by the signed position s.

s = x_a . (r_b - r_a);  force  k (s - s0) + c ds/dt, against the relative motion; in space with x along n
"""

from mbdsl.elements.declaration import Parameter, power
from mbdsl.elements.kind import ForceKind, Signal, in_space, law_or_spring, zero
from mbdsl.elements.motions import SLIDING, along_n
from mbdsl.elements.rows import along

KIND = ForceKind(
    "TranslationalSpringDamper",
    doc="A spring and damper along the x axis of frame_a; positive force resists a growing position s.",
    g=(along("x"),),
    parameters=(
        Parameter("k", "N/m", 0.0, "stiffness"),
        Parameter("c", "N.s/m", 0.0, "damping"),
        Parameter("s0", "m", 0.0, "position without force"),
        Parameter("force", "N", None, "force as an expression, e.g. of s and v; instead of k and c", law=True),
    ),
    signals=(*SLIDING, Signal("force", "N", "k*(s - s0) + c*v", "resisting force")),
    energy="0.5*k*(s - s0)^2",
    results=(power("-(force*v)"),),
    resists=(("force", "s"),),
    check=law_or_spring("force"),
    laws=("force",),
    effects={"damping": zero("c")},
    springs=lambda v: ((v["k"], v["c"], v["s0"]),),
    drawing="spring",
)
IN_SPACE = in_space(KIND, along_n)
