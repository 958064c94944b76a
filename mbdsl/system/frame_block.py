"""The part of the iteration matrix that belongs to two frames."""

from __future__ import annotations

from typing import NamedTuple

from mbdsl.kernels import buffer_layout as L
from mbdsl.kernels.columns import SPACE
from mbdsl.kernels.marks import kernel, rare


class Terms(NamedTuple):
    """What a frame contributes: cT T B + cTd Td (B v)_q.

    T and Td are the offsets in ``numbers`` of square blocks, whose rows have the stride PAIR_POSE.
    """

    cT: float
    T: int
    cTd: float
    Td: int


@rare
def frame_block(C, slot, fr, fc, x, numbers, layout, matrix):
    """matrix, at the slots, += B_r^T times the ``Terms`` x of frame fc; returns the next slot."""
    nr, kr = layout[layout[L.FRAMES] + 2 * fr], layout[layout[L.FRAMES] + 2 * fr + 1]
    nc, kc = layout[layout[L.FRAMES] + 2 * fc], layout[layout[L.FRAMES] + 2 * fc + 1]
    if C is SPACE:
        in_space(C, layout[slot:], (nr, kr), (nc, kc), x, numbers, matrix)
    else:
        in_plane(C, layout[slot:], (nr, kr), (nc, kc), x, numbers, matrix)
    return slot + nr * nc


@kernel
def in_plane(C, slots, row, column, x, numbers, matrix):
    """As ``frame_block``, for frames with (number of coordinates, offset of B in ``numbers``)."""
    (nr, kr), (nc, kc) = row, column
    for j in range(nc):
        t0, t1, t2 = 0.0, 0.0, 0.0
        for l in range(C.POSE):
            bl, dl = x.cT * numbers[kc + l * nc + j], x.cTd * numbers[kc + (C.POSE + l) * nc + j]
            t0 += numbers[x.T + l] * bl + numbers[x.Td + l] * dl
            t1 += numbers[x.T + C.PAIR_POSE + l] * bl + numbers[x.Td + C.PAIR_POSE + l] * dl
            t2 += numbers[x.T + 2 * C.PAIR_POSE + l] * bl + numbers[x.Td + 2 * C.PAIR_POSE + l] * dl
        for i in range(nr):
            matrix[slots[i * nc + j]] += (
                numbers[kr + i] * t0 + numbers[kr + nr + i] * t1 + numbers[kr + 2 * nr + i] * t2
            )


@kernel
def row_times(C, k, x, column, j, numbers):
    """Entry j of row k of the terms, in space."""
    nc, kc = column
    value, rate = 0.0, 0.0
    for l in range(C.POSE):
        value += numbers[x.T + C.PAIR_POSE * k + l] * numbers[kc + l * nc + j]
    if x.cTd != 0.0:
        for l in range(C.POSE):
            rate += numbers[x.Td + C.PAIR_POSE * k + l] * numbers[kc + (C.POSE + l) * nc + j]
    return x.cT * value + x.cTd * rate


@kernel
def in_space(C, slots, row, column, x, numbers, matrix):
    """As ``in_plane``."""
    (nr, kr), (nc, _) = row, column
    for j in range(nc):
        t0, t1, t2, t3, t4, t5 = tuple(row_times(C, k, x, column, j, numbers) for k in (0, 1, 2, 3, 4, 5))
        for i in range(nr):
            matrix[slots[i * nc + j]] += (
                numbers[kr + i] * t0
                + numbers[kr + nr + i] * t1
                + numbers[kr + 2 * nr + i] * t2
                + numbers[kr + 3 * nr + i] * t3
                + numbers[kr + 4 * nr + i] * t4
                + numbers[kr + 5 * nr + i] * t5
            )
