"""Motions that friction on a curve or a surface resists: of the origin of frame b along x_a, y_a and z_a (3 rows)."""

from mbdsl.compilation.marks import kernel
from mbdsl.elements.in_space.coordinates import X, Y, Z, dot2, dot2_hessian
from mbdsl.elements.in_space.sliding_friction import Motion

KIND = Motion(3)


@kernel
def gradient(frames, a, b, p, G):
    dot2(frames, a, X, b, G, 0)
    dot2(frames, a, Y, b, G, 1)
    dot2(frames, a, Z, b, G, 2)


@kernel
def hessian(frames, a, b, p, s, H):
    dot2_hessian(frames, a, X, b, s[0], H)
    dot2_hessian(frames, a, Y, b, s[1], H)
    dot2_hessian(frames, a, Z, b, s[2], H)
