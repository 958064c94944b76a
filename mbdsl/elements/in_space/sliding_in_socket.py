"""Motions that friction in a ball joint resists: rotations about x_a, y_a and z_a (3 rows)."""

from mbdsl.compilation.marks import kernel
from mbdsl.elements.in_space.coordinates import X, Y, Z
from mbdsl.elements.in_space.sliding_friction import Motion, turn, turn_hessian

KIND = Motion(3)


@kernel
def gradient(frames, a, b, p, G):
    turn(frames, a, X, G, 0)
    turn(frames, a, Y, G, 1)
    turn(frames, a, Z, G, 2)


@kernel
def hessian(frames, a, b, p, s, H):
    turn_hessian(frames, a, X, s[0], H)
    turn_hessian(frames, a, Y, s[1], H)
    turn_hessian(frames, a, Z, s[2], H)
