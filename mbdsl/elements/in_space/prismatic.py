"""Prismatic: a slider along the z axis of both frames, without rotation.

    g = x_a . d,   y_a . d,   x_a . z_b,   y_a . z_b,   x_a . y_b                          (5 rows)
"""

from mbdsl.compilation.marks import kernel
from mbdsl.elements.in_space.coordinates import X, Y, Z, dot1, dot1_hessian, dot2, dot2_hessian
from mbdsl.elements.kind import JointKind

KIND = JointKind(
    "Prismatic", doc="A slider: frame_b moves along the z axis of frame_a and does not rotate.", rows=5, spatial=True
)


@kernel
def gradient(frames, a, b, p, G):
    dot2(frames, a, X, b, G, 0)
    dot2(frames, a, Y, b, G, 1)
    dot1(frames, a, X, b, Z, G, 2)
    dot1(frames, a, Y, b, Z, G, 3)
    dot1(frames, a, X, b, Y, G, 4)


@kernel
def hessian(frames, a, b, p, s, H):
    dot2_hessian(frames, a, X, b, s[0], H)
    dot2_hessian(frames, a, Y, b, s[1], H)
    dot1_hessian(frames, a, X, b, Z, s[2], H)
    dot1_hessian(frames, a, Y, b, Z, s[3], H)
    dot1_hessian(frames, a, X, b, Y, s[4], H)
