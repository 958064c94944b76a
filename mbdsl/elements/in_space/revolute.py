"""Revolute: a hinge, whose axis is the z axis of both frames.

    g = r_b - r_a,   x_a . z_b,   y_a . z_b                                              (5 rows)
"""

from mbdsl.compilation.marks import kernel
from mbdsl.elements.in_space.coordinates import X, Y, Z, dot1, dot1_hessian, point
from mbdsl.elements.kind import JointKind

KIND = JointKind(
    "Revolute", doc="A hinge: the origins and the z axes of frame_a and frame_b coincide.", rows=5, spatial=True
)


@kernel
def gradient(frames, a, b, p, G):
    point(frames, a, b, G, 0)
    dot1(frames, a, X, b, Z, G, 3)
    dot1(frames, a, Y, b, Z, G, 4)


@kernel
def hessian(frames, a, b, p, s, H):
    dot1_hessian(frames, a, X, b, Z, s[3], H)
    dot1_hessian(frames, a, Y, b, Z, s[4], H)
