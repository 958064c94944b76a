"""Count of the turns of angles that are not coordinates, from step to step.

An evaluation takes the value of such an angle that is closest to its value at the end of the last accepted step;
rejected steps have no effect. See :mod:`mbdsl.bodies.ancf_cable_kernels`.
"""

from math import atan2, floor, pi

from mbdsl.compilation.buffer_layout import COUNTED, N_COUNTED, N_TURNS, POSITION, TURNS
from mbdsl.compilation.marks import kernel


@kernel
def count_turns(run):
    """Set the counted angles to those of the accepted step. Reads POSITION, and reads and writes ``numbers``."""
    vectors, numbers, layout = run.vectors, run.numbers, run.layout
    for k in range(layout[N_TURNS]):
        at, d = layout[layout[TURNS] + 2 * k], layout[layout[TURNS] + 2 * k + 1]
        angle = atan2(vectors[POSITION, d + 3] + 0.0, vectors[POSITION, d + 2])
        numbers[at] = angle + 2.0 * pi * floor((numbers[at] - angle) / (2.0 * pi) + 0.5)
    for k in range(layout[N_COUNTED]):
        at = layout[layout[COUNTED] + k]
        numbers[at] = numbers[at + 1]
