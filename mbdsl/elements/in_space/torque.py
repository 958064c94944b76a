"""Torque: acts on frame_b about the axis n of frame_a, and with the opposite sign on frame_a (default: the ground).

tau acts along z_a, which has the direction n
"""

from mbdsl.compilation.marks import kernel
from mbdsl.elements import torque
from mbdsl.elements.in_space import revolute
from mbdsl.elements.in_space.coordinates import PHI_A, PHI_B, Z, add_cross
from mbdsl.elements.in_space.kinds import in_space
from mbdsl.elements.in_space.vectors import W, both, direction, dot, total, wrench
from mbdsl.elements.kind import power

KIND = in_space(
    torque.KIND,
    doc="A torque on frame_b about the axis n of frame_a, and its reaction on frame_a.",
    parameters=(*torque.KIND.parameters, revolute.AXIS),
    signals=revolute.SIGNALS_OF_ANGLE,
    results=(power(f"tau*{dot(W, revolute.Z_A)}"),),
    resists=(),
    exerts=wrench(None, total(("tau", revolute.Z_A))),
    check=direction,
    follows="rotation",
    axes=both("z"),
)


@kernel
def gradient(frames, a, b, p, G):
    for i in range(3):
        G[0, PHI_A + i], G[0, PHI_B + i] = -frames[a, Z + i], frames[a, Z + i]


@kernel
def hessian(frames, a, b, p, s, H):
    x, y, z = s[0] * frames[a, Z], s[0] * frames[a, Z + 1], s[0] * frames[a, Z + 2]
    add_cross(x, y, z, H, PHI_A, PHI_A)
    add_cross(-x, -y, -z, H, PHI_B, PHI_A)
