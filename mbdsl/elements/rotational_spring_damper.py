"""RotationalSpringDamper: a torsional spring and damper, linear or by a law of relative angle phi and rate w.

g = phi_b - phi_a;  torque  k (g - phi0) + c dg/dt, against the relative rotation
"""

from mbdsl.compilation.marks import kernel
from mbdsl.elements import revolute
from mbdsl.elements.coordinates import angle
from mbdsl.elements.kind import ForceKind, Parameter, Signal, law_or_spring, power, zero

KIND = ForceKind(
    "RotationalSpringDamper",
    doc="A torsional spring and damper between two frames; positive torque resists a growing angle.",
    rows=1,
    parameters=(
        Parameter("k", "N.m/rad", 0.0, "stiffness"),
        Parameter("c", "N.m.s/rad", 0.0, "damping"),
        Parameter("phi0", "rad", 0.0, "angle without torque"),
        Parameter("torque", "N.m", None, "torque as an expression, e.g. of phi and w; instead of k and c", law=True),
    ),
    signals=(*revolute.KIND.signals, Signal("torque", "N.m", "k*(phi - phi0) + c*w", "resisting torque")),
    energy="0.5*k*(phi - phi0)^2",
    results=(power("-(torque*w)"),),
    resists=(("torque", "phi"),),
    check=law_or_spring("torque"),
    laws=("torque",),
    effects={"damping": zero("c")},
    springs=lambda v: ((v["k"], v["c"], v["phi0"]),),
)


@kernel
def gradient(frames, a, b, p, G):
    angle(frames, a, b, G, 0)
