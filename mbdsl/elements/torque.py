"""Torque: acts on frame_b, and with the opposite sign on frame_a (default: the ground).

In the plane tau acts along phi_b - phi_a; in space about z of frame_a, or of frame_b, which has the direction n.
"""

from dataclasses import replace

from mbdsl.elements.declaration import Parameter, power
from mbdsl.elements.kind import ForceKind, in_space
from mbdsl.elements.motions import AXIS_Z, TURNING, about_n
from mbdsl.elements.row import Row
from mbdsl.elements.rows import TURN, Z_A, Z_B
from mbdsl.elements.vectors import W, dot, total, wrench

#: the axis of the torque in space, and the rate about it
N = total(("(1 - own[1])", Z_A), ("own[1]", Z_B))
RATE = dot(W, N)

KIND = ForceKind(
    "Torque",
    doc="A torque on frame_b and its reaction on frame_a; positive is counter-clockwise on frame_b.",
    g=(Row(RATE, TURN),),
    optional_ports=("frame_a",),
    parameters=(Parameter("tau", "N.m", doc="the torque, a number or an expression", law=True),),
    signals=TURNING,
    results=(power("tau*w"),),
    resists=(("(-tau)", "phi"),),
    laws=("tau",),
    sign=1.0,
    drawing="nothing",
)
IN_SPACE = in_space(
    KIND,
    about_n,
    doc="A torque on frame_b about the axis n of frame_a, or of frame_b, and its reaction on frame_a.",
    parameters=(
        *KIND.parameters,
        replace(AXIS_Z, doc="axis of the torque, in the frame of `axes`"),
        Parameter("axes", "", "frame_a", "the frame whose axes n has", choices=("frame_a", "frame_b")),
    ),
    results=(power(f"tau*{RATE}"),),
    resists=(),
    exerts=wrench(None, total(("tau", N))),
    derive=lambda v: {"own": (1.0 if v["axes"] == "frame_b" else 0.0,)},
)
