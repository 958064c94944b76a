"""RotationalDriver: prescribes the angle of frame_b relative to frame_a as a function of time (rheonomic).

    g = phi_b - phi_a - u(t)                                                             (1 row)
"""

from mbdsl.elements import revolute
from mbdsl.elements.kind import JointKind, Parameter, kernel

KIND = JointKind(
    "RotationalDriver",
    doc="A drive that turns a joint as a given function of time.",
    rows=1,
    parameters=(Parameter("phi", "rad", doc="the angle, an expression in time", law=True),),
    signals=revolute.KIND.signals,
    reaction=("tau",),
    driver="phi",
)


@kernel
def position(Z, a, b, p, g):
    g[0] = Z[b, 2] - Z[a, 2]


@kernel
def jacobian(Z, a, b, p, G):
    G[0, 2], G[0, 5] = -1.0, 1.0
