"""Steps that end in zones around peaks of laws, and records of the states at the ends of steps.

See :mod:`mbdsl.integrators.peak_zones`.
"""

from mbdsl.integrators.loop import loop_state as S
from mbdsl.integrators.loop.rotation_chart import attitudes
from mbdsl.integrators.loop.thinned_records import thin
from mbdsl.kernels import buffer_layout as L
from mbdsl.kernels.marks import kernel, rare


@rare
def until_zone(h, run):
    """The step size h, or a smaller one that ends after the part WITHIN of the next zone, if h would pass over it.

    0 if ``reals`` holds no further zone, and LOOK has to be returned. Writes NEXT_ZONE of ``integers``.
    """
    reals, integers = run.reals, run.integers
    while integers[S.NEXT_ZONE] < integers[S.ZONES] and reals[S.NOW] >= reals[S.ZONE + 2 * integers[S.NEXT_ZONE]]:
        integers[S.NEXT_ZONE] += 1
    if integers[S.NEXT_ZONE] == integers[S.ZONES]:
        return 0.0
    start, end = reals[S.ZONE + 2 * integers[S.NEXT_ZONE]], reals[S.ZONE + 2 * integers[S.NEXT_ZONE] + 1]
    if reals[S.NOW] + h <= end:
        return h
    landing = (1.0 - reals[S.WITHIN]) * start + reals[S.WITHIN] * end - reals[S.NOW]
    return max(landing, min(end - reals[S.NOW], reals[S.SLIVER] * reals[S.GRID]))


@kernel
def note(run):
    """Append the time and the state at the end of the step (POSITION0, VELOCITY0, UNKNOWN0) to the records.

    The records are behind the other entries of ``reals``; NOTED of ``integers`` is their number.
    """
    reals, integers, vectors, layout = run.reals, run.integers, run.vectors, run.layout
    n, size = layout[L.N_Q], layout[L.N_ALL]
    o = S.REALS + integers[S.NOTED] * (1 + n + size)
    reals[o] = reals[S.STEP_END]
    for i in range(n):
        reals[o + 1 + i], reals[o + 1 + n + i] = vectors[L.POSITION0, i], vectors[L.VELOCITY0, i]
    attitudes(reals[o + 1 :], run)
    for i in range(n, size):
        reals[o + 1 + n + i] = vectors[L.UNKNOWN0, i]
    integers[S.NOTED] += 1
    if integers[S.THIN] > 0 and (integers[S.STEP] & (integers[S.THIN] - 1)) == 0:
        thin(run)
