"""Angles that count turns in kernels."""

from math import atan2, floor, pi

from mbdsl.kernels.marks import kernel


@kernel
def counted(y, x, p):
    """atan2(y, x) with the turns that are nearest to p[0], the angle at the end of the last accepted step [rad].

    p[1] becomes the angle of this evaluation.
    """
    phi = atan2(y, x)
    p[1] = phi + 2.0 * pi * floor((p[0] - phi) / (2.0 * pi) + 0.5)
    return p[1]
