"""The part of the iteration matrix that belongs to two frames."""

from mbdsl.kernels import buffer_layout as L
from mbdsl.kernels.columns import SPACE
from mbdsl.kernels.marks import kernel, rare


@rare
def frame_block(C, slot, fr, fc, cT, T, cTd, Td, numbers, layout, matrix):
    """matrix, at the slots, += B_r^T (cT T B_c + cTd Td (B v)_q,c), with square blocks T and Td in ``numbers``, whose
    rows have the stride PAIR_POSE; returns the next slot."""
    nr, kr = layout[layout[L.FRAMES] + 2 * fr], layout[layout[L.FRAMES] + 2 * fr + 1]
    nc, kc = layout[layout[L.FRAMES] + 2 * fc], layout[layout[L.FRAMES] + 2 * fc + 1]
    if C is SPACE:
        in_space(C, slot, nr, kr, nc, kc, cT, T, cTd, Td, numbers, layout, matrix)
    else:
        in_plane(C, slot, nr, kr, nc, kc, cT, T, cTd, Td, numbers, layout, matrix)
    return slot + nr * nc


@kernel
def in_plane(C, slot, nr, kr, nc, kc, cT, T, cTd, Td, numbers, layout, matrix):
    """As ``frame_block``, for frames with nr and nc coordinates, and matrices B at kr and kc in ``numbers``."""
    for j in range(nc):
        t0, t1, t2 = 0.0, 0.0, 0.0
        for l in range(C.POSE):
            bl, dl = cT * numbers[kc + l * nc + j], cTd * numbers[kc + (C.POSE + l) * nc + j]
            t0 += numbers[T + l] * bl + numbers[Td + l] * dl
            t1 += numbers[T + C.PAIR_POSE + l] * bl + numbers[Td + C.PAIR_POSE + l] * dl
            t2 += numbers[T + 2 * C.PAIR_POSE + l] * bl + numbers[Td + 2 * C.PAIR_POSE + l] * dl
        for i in range(nr):
            matrix[layout[slot + i * nc + j]] += (
                numbers[kr + i] * t0 + numbers[kr + nr + i] * t1 + numbers[kr + 2 * nr + i] * t2
            )


@kernel
def row_times(C, k, cT, T, cTd, Td, kb, nb, j, numbers):
    """Entry j of row k of cT T B + cTd Td (B v)_q, in space; T and Td have rows of the length PAIR_POSE."""
    value, rate = 0.0, 0.0
    for l in range(C.POSE):
        value += numbers[T + C.PAIR_POSE * k + l] * numbers[kb + l * nb + j]
    if cTd != 0.0:
        for l in range(C.POSE):
            rate += numbers[Td + C.PAIR_POSE * k + l] * numbers[kb + (C.POSE + l) * nb + j]
    return cT * value + cTd * rate


@kernel
def in_space(C, slot, nr, kr, nc, kc, cT, T, cTd, Td, numbers, layout, matrix):
    """As ``in_plane``."""
    for j in range(nc):
        t0 = row_times(C, 0, cT, T, cTd, Td, kc, nc, j, numbers)
        t1 = row_times(C, 1, cT, T, cTd, Td, kc, nc, j, numbers)
        t2 = row_times(C, 2, cT, T, cTd, Td, kc, nc, j, numbers)
        t3 = row_times(C, 3, cT, T, cTd, Td, kc, nc, j, numbers)
        t4 = row_times(C, 4, cT, T, cTd, Td, kc, nc, j, numbers)
        t5 = row_times(C, 5, cT, T, cTd, Td, kc, nc, j, numbers)
        for i in range(nr):
            matrix[layout[slot + i * nc + j]] += (
                numbers[kr + i] * t0
                + numbers[kr + nr + i] * t1
                + numbers[kr + 2 * nr + i] * t2
                + numbers[kr + 3 * nr + i] * t3
                + numbers[kr + 4 * nr + i] * t4
                + numbers[kr + 5 * nr + i] * t5
            )
