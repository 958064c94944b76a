"""RotationalSpringDamper: a torsional spring and damper, linear or by a law of relative angle phi and rate w.

torque  k (phi - phi0) + c w, against the relative rotation; in space about the axis n
"""

from mbdsl.elements.declaration import Parameter, power
from mbdsl.elements.kind import ForceKind, Signal, in_space, law_or_spring, zero
from mbdsl.elements.motions import TURNING, about_n
from mbdsl.elements.rows import ANGLE

KIND = ForceKind(
    "RotationalSpringDamper",
    doc="A torsional spring and damper between two frames; positive torque resists a growing angle.",
    g=(ANGLE,),
    parameters=(
        Parameter("k", "N.m/rad", 0.0, "stiffness"),
        Parameter("c", "N.m.s/rad", 0.0, "damping"),
        Parameter("phi0", "rad", 0.0, "angle without torque"),
        Parameter("torque", "N.m", None, "torque as an expression, e.g. of phi and w; instead of k and c", law=True),
    ),
    signals=(*TURNING, Signal("torque", "N.m", "k*(phi - phi0) + c*w", "resisting torque")),
    energy="0.5*k*(phi - phi0)^2",
    results=(power("-(torque*w)"),),
    resists=(("torque", "phi"),),
    check=law_or_spring("torque"),
    laws=("torque",),
    effects={"damping": zero("c")},
    springs=lambda v: ((v["k"], v["c"], v["phi0"]),),
    drawing="turning spring",
)
IN_SPACE = in_space(KIND, about_n)
