"""Motions that friction on a plane resists: of the origin of frame b along x_a and y_a (2 rows)."""

from mbdsl.compilation.marks import kernel
from mbdsl.elements.in_space.coordinates import X, Y, dot2, dot2_hessian
from mbdsl.elements.in_space.sliding_friction import Motion

KIND = Motion(2)


@kernel
def gradient(frames, a, b, p, G):
    dot2(frames, a, X, b, G, 0)
    dot2(frames, a, Y, b, G, 1)


@kernel
def hessian(frames, a, b, p, s, H):
    dot2_hessian(frames, a, X, b, s[0], H)
    dot2_hessian(frames, a, Y, b, s[1], H)
