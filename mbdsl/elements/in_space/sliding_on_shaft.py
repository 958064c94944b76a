"""Motions that friction on a shaft resists: of the origin of frame b along x_a, and rotation about x_a (2 rows)."""

from mbdsl.compilation.marks import kernel
from mbdsl.elements.in_space.coordinates import X, dot2, dot2_hessian
from mbdsl.elements.in_space.sliding_friction import Motion, turn, turn_hessian

KIND = Motion(2)


@kernel
def gradient(frames, a, b, p, G):
    dot2(frames, a, X, b, G, 0)
    turn(frames, a, X, G, 1)


@kernel
def hessian(frames, a, b, p, s, H):
    dot2_hessian(frames, a, X, b, s[0], H)
    turn_hessian(frames, a, X, s[1], H)
