"""Torque: acts on frame_b about an axis n of frame_a or frame_b, and with the opposite sign on frame_a (default: the
ground).

tau acts along z of the frame of axes, which has the direction n
"""

from dataclasses import replace

from mbdsl.compilation.marks import kernel
from mbdsl.elements import torque
from mbdsl.elements.in_space import revolute
from mbdsl.elements.in_space.coordinates import PHI_A, PHI_B, Z, add_cross
from mbdsl.elements.in_space.kinds import in_space
from mbdsl.elements.in_space.vectors import W, both, direction, dot, total, wrench
from mbdsl.elements.kind import Parameter, power

#: the axis of the torque
N = total(("(1 - own[1])", revolute.Z_A), ("own[1]", revolute.Z_B))

KIND = in_space(
    torque.KIND,
    doc="A torque on frame_b about the axis n of frame_a, or of frame_b, and its reaction on frame_a.",
    parameters=(
        *torque.KIND.parameters,
        replace(revolute.AXIS, doc="axis of the torque, in the frame of `axes`"),
        Parameter("axes", "", "frame_a", "the frame whose axes n has", choices=("frame_a", "frame_b")),
    ),
    signals=revolute.SIGNALS_OF_ANGLE,
    results=(power(f"tau*{dot(W, N)}"),),
    resists=(),
    exerts=wrench(None, total(("tau", N))),
    check=direction,
    follows="rotation",
    axes=both("z"),
    derive=lambda v: {"own": (1.0 if v["axes"] == "frame_b" else 0.0,)},
    table=lambda v: v["own"],
)


@kernel
def gradient(frames, a, b, p, G):
    f = b if p[0] == 1.0 else a
    for i in range(3):
        G[0, PHI_A + i], G[0, PHI_B + i] = -frames[f, Z + i], frames[f, Z + i]


@kernel
def hessian(frames, a, b, p, s, H):
    f, turned = a, PHI_A
    if p[0] == 1.0:
        f, turned = b, PHI_B
    x, y, z = s[0] * frames[f, Z], s[0] * frames[f, Z + 1], s[0] * frames[f, Z + 2]
    add_cross(x, y, z, H, PHI_A, turned)
    add_cross(-x, -y, -z, H, PHI_B, turned)
