"""RotationalDriver: prescribes the angle of frame_b relative to frame_a as a function of time (rheonomic).

g = phi_b - phi_a - u(t)                                                             (1 row)
"""

from mbdsl.compilation.marks import kernel
from mbdsl.elements import revolute
from mbdsl.elements.coordinates import angle
from mbdsl.elements.kind import JointKind, Parameter, power, wrench

KIND = JointKind(
    "RotationalDriver",
    doc="A drive that turns a joint as a given function of time.",
    rows=1,
    parameters=(Parameter("phi", "rad", doc="the angle, an expression in time", law=True),),
    signals=revolute.KIND.signals,
    reactions=wrench(tau="-lam[1]"),
    results=(power("tau*w"),),
    driver="phi",
    angle=("phi",),
)


@kernel
def gradient(frames, a, b, p, G):
    angle(frames, a, b, G, 0)
