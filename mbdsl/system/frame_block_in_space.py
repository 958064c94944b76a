"""The part of the iteration matrix that belongs to two frames, in space; as :mod:`mbdsl.system.frame_block`."""

from mbdsl.compilation.buffer_layout_in_space import FRAMES, PAIR_POSE, POSE
from mbdsl.compilation.marks import kernel, rare


@kernel
def row_times(k, cT, T, cTd, Td, kb, nb, j, numbers):
    """Entry j of row k of cT T B + cTd Td (B v)_q; T and Td have rows of the length PAIR_POSE."""
    value, rate = 0.0, 0.0
    for l in range(POSE):
        value += numbers[T + PAIR_POSE * k + l] * numbers[kb + l * nb + j]
    if cTd != 0.0:
        for l in range(POSE):
            rate += numbers[Td + PAIR_POSE * k + l] * numbers[kb + (POSE + l) * nb + j]
    return cT * value + cTd * rate


@rare
def frame_block(slot, fr, fc, cT, T, cTd, Td, numbers, layout, matrix):
    """matrix, at the slots, += B_r^T (cT T B_c + cTd Td (B v)_q,c), with 6 x 6 blocks T and Td in ``numbers``, whose
    rows have the stride PAIR_POSE."""
    nr, kr = layout[layout[FRAMES] + 2 * fr], layout[layout[FRAMES] + 2 * fr + 1]
    nc, kc = layout[layout[FRAMES] + 2 * fc], layout[layout[FRAMES] + 2 * fc + 1]
    for j in range(nc):
        t0 = row_times(0, cT, T, cTd, Td, kc, nc, j, numbers)
        t1 = row_times(1, cT, T, cTd, Td, kc, nc, j, numbers)
        t2 = row_times(2, cT, T, cTd, Td, kc, nc, j, numbers)
        t3 = row_times(3, cT, T, cTd, Td, kc, nc, j, numbers)
        t4 = row_times(4, cT, T, cTd, Td, kc, nc, j, numbers)
        t5 = row_times(5, cT, T, cTd, Td, kc, nc, j, numbers)
        for i in range(nr):
            matrix[layout[slot + i * nc + j]] += (
                numbers[kr + i] * t0
                + numbers[kr + nr + i] * t1
                + numbers[kr + 2 * nr + i] * t2
                + numbers[kr + 3 * nr + i] * t3
                + numbers[kr + 4 * nr + i] * t4
                + numbers[kr + 5 * nr + i] * t5
            )
    return slot + nr * nc
