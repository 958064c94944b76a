"""Steps that end in zones around peaks of laws, and records of the states at the ends of steps.

See :mod:`mbdsl.integrators.peak_zones`.
"""

from __future__ import annotations

from mbdsl.compilation.buffer_layout import N_ALL, N_Q, POSITION0, UNKNOWN0, VELOCITY0
from mbdsl.compilation.marks import rare
from mbdsl.integrators.loop.loop_state import NEXT_ZONE, NOTED, NOW, REALS, STEP, STEP_END, THIN, WITHIN, ZONE, ZONES
from mbdsl.integrators.loop.rotation_chart import leave_chart
from mbdsl.integrators.loop.thinned_records import thin


@rare
def until_zone(h, run):
    """The step size h, or a smaller one that ends after the part WITHIN of the next zone, if h would pass over it.

    0 if ``reals`` holds no further zone, and LOOK has to be returned. Writes NEXT_ZONE of ``integers``.
    """
    reals, integers = run.reals, run.integers
    while integers[NEXT_ZONE] < integers[ZONES] and reals[NOW] >= reals[ZONE + 2 * integers[NEXT_ZONE]]:
        integers[NEXT_ZONE] += 1
    if integers[NEXT_ZONE] == integers[ZONES]:
        return 0.0
    start, end = reals[ZONE + 2 * integers[NEXT_ZONE]], reals[ZONE + 2 * integers[NEXT_ZONE] + 1]
    return h if reals[NOW] + h <= end else (1.0 - reals[WITHIN]) * start + reals[WITHIN] * end - reals[NOW]


@rare
def note(run):
    """Append the time and the state at the end of the step (POSITION0, VELOCITY0, UNKNOWN0) to the records.

    The records are behind the other entries of ``reals``; NOTED of ``integers`` is their number.
    """
    reals, integers, vectors, layout = run.reals, run.integers, run.vectors, run.layout
    n, size = layout[N_Q], layout[N_ALL]
    o = REALS + integers[NOTED] * (1 + n + size)
    reals[o] = reals[STEP_END]
    for i in range(n):
        reals[o + 1 + i], reals[o + 1 + n + i] = vectors[POSITION0, i], vectors[VELOCITY0, i]
    leave_chart(reals[o + 1 :], run)
    for i in range(n, size):
        reals[o + 1 + n + i] = vectors[UNKNOWN0, i]
    integers[NOTED] += 1
    if integers[THIN] > 0 and (integers[STEP] & (integers[THIN] - 1)) == 0:
        thin(run)
