"""Count of the turns of angles that are not coordinates, from step to step.

An evaluation takes the value of such an angle that is closest to its value at the end of the last accepted step;
rejected steps have no effect. See :mod:`mbdsl.bodies.ancf_cable_kernels`.
"""

from math import atan2, floor, pi

from mbdsl.kernels import buffer_layout as L
from mbdsl.kernels.marks import kernel


@kernel
def count_turns(run):
    """Set the counted angles to those of the accepted step. Reads POSITION, and reads and writes ``numbers``."""
    vectors, numbers, layout = run.vectors, run.numbers, run.layout
    for k in range(layout[L.N_TURNS]):
        at, d = layout[layout[L.TURNS] + 2 * k], layout[layout[L.TURNS] + 2 * k + 1]
        angle = atan2(vectors[L.POSITION, d + 3] + 0.0, vectors[L.POSITION, d + 2])
        numbers[at] = angle + 2.0 * pi * floor((numbers[at] - angle) / (2.0 * pi) + 0.5)
    for k in range(layout[L.N_COUNTED]):
        at = layout[layout[L.COUNTED] + k]
        numbers[at] = numbers[at + 1]
