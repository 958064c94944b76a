"""Torque: acts on frame_b, and with the opposite sign on frame_a (default: the ground).

g = phi_b - phi_a;  tau acts along g
"""

from mbdsl.compilation.marks import kernel
from mbdsl.elements import revolute
from mbdsl.elements.coordinates import angle
from mbdsl.elements.kind import ForceKind, Parameter, power

KIND = ForceKind(
    "Torque",
    doc="A torque on frame_b and its reaction on frame_a; positive is counter-clockwise on frame_b.",
    rows=1,
    optional_ports=("frame_a",),
    parameters=(Parameter("tau", "N.m", doc="the torque, a number or an expression", law=True),),
    signals=revolute.KIND.signals,
    results=(power("tau*w"),),
    resists=(("(-tau)", "phi"),),
    laws=("tau",),
    sign=1.0,
)


@kernel
def gradient(frames, a, b, p, G):
    angle(frames, a, b, G, 0)
