"""Turns of what has angles but no coordinate that holds them: they are counted from step to step.

Evaluations take such an angle next to what it was when a step was accepted last, whatever has been tried since; see
:mod:`mbdsl.bodies.ancf_cable_kernels`.
"""

from math import atan2, floor, pi

from mbdsl.compilation.buffer_layout import N_TURNS, TURNS, Q
from mbdsl.compilation.marks import kernel


@kernel
def count_turns(Y, F, I):
    """The state in Y is accepted: turns are counted on from there."""
    for k in range(I[N_TURNS]):
        at, d = I[I[TURNS] + 2 * k], I[I[TURNS] + 2 * k + 1]
        angle = atan2(Y[Q, d + 3] + 0.0, Y[Q, d + 2])
        F[at] = angle + 2.0 * pi * floor((F[at] - angle) / (2.0 * pi) + 0.5)
