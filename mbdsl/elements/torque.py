"""Torque: acts on frame_b, and with the opposite sign on frame_a (the ground where it is left out).

    g = phi_b - phi_a;  tau acts along g
"""

from mbdsl.elements import revolute
from mbdsl.elements.kind import ForceKind, Parameter, kernel

KIND = ForceKind(
    "Torque",
    doc="A torque on frame_b and its reaction on frame_a; positive is counter-clockwise on frame_b.",
    rows=1,
    optional_ports=("frame_a",),
    parameters=(Parameter("tau", "N.m", doc="the torque, a number or an expression", law=True),),
    signals=revolute.KIND.signals,
    laws=("tau",),
    sign=1.0,
)


@kernel
def position(Z, a, b, p, g):
    g[0] = Z[b, 2] - Z[a, 2]


@kernel
def jacobian(Z, a, b, p, G):
    G[0, 2], G[0, 5] = -1.0, 1.0
