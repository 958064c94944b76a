"""The part of the iteration matrix that belongs to two frames, in the plane."""

from mbdsl.compilation.buffer_layout import FRAMES, PAIR_POSE, POSE
from mbdsl.compilation.marks import rare


@rare
def frame_block(slot, fr, fc, cT, T, cTd, Td, numbers, layout, matrix):
    """matrix, at the slots, += B_r^T (cT T B_c + cTd Td (B v)_q,c), with 3 x 3 blocks T and Td in ``numbers``, whose
    rows have the stride PAIR_POSE."""
    nr, kr = layout[layout[FRAMES] + 2 * fr], layout[layout[FRAMES] + 2 * fr + 1]
    nc, kc = layout[layout[FRAMES] + 2 * fc], layout[layout[FRAMES] + 2 * fc + 1]
    for j in range(nc):
        t0, t1, t2 = 0.0, 0.0, 0.0
        for l in range(POSE):
            bl, dl = cT * numbers[kc + l * nc + j], cTd * numbers[kc + (POSE + l) * nc + j]
            t0 += numbers[T + l] * bl + numbers[Td + l] * dl
            t1 += numbers[T + PAIR_POSE + l] * bl + numbers[Td + PAIR_POSE + l] * dl
            t2 += numbers[T + 2 * PAIR_POSE + l] * bl + numbers[Td + 2 * PAIR_POSE + l] * dl
        for i in range(nr):
            matrix[layout[slot + i * nc + j]] += (
                numbers[kr + i] * t0 + numbers[kr + nr + i] * t1 + numbers[kr + 2 * nr + i] * t2
            )
    return slot + nr * nc
