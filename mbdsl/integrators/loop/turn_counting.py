"""Turns of what has angles but no coordinate that holds them: they are counted from step to step.

Evaluations take such an angle next to what it was when a step was accepted last, whatever has been tried since; see
:mod:`mbdsl.bodies.ancf_cable_kernels`.
"""

from math import atan2, floor, pi

from mbdsl.compilation.buffer_layout import N_TURNS, POSITION, TURNS
from mbdsl.compilation.marks import kernel


@kernel
def count_turns(run):
    """The state at the end of the step is accepted: turns are counted on from there."""
    vectors, numbers, layout = run.vectors, run.numbers, run.layout
    for k in range(layout[N_TURNS]):
        at, d = layout[layout[TURNS] + 2 * k], layout[layout[TURNS] + 2 * k + 1]
        angle = atan2(vectors[POSITION, d + 3] + 0.0, vectors[POSITION, d + 2])
        numbers[at] = angle + 2.0 * pi * floor((numbers[at] - angle) / (2.0 * pi) + 0.5)
