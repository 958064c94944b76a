"""The columns of the buffers: each entry has one meaning, and none is left out."""

from itertools import pairwise

import pytest

from mbdsl.kernels import buffer_layout as L
from mbdsl.kernels.columns import PLANE, SPACE, columns_of


@pytest.mark.parametrize(("C", "pose", "rate", "lever"), [(PLANE, 3, 3, 2), (SPACE, 3 + 9, 6, 3)])
def test_columns_follow_each_other(C, pose, rate, lever):
    """Sizes from the definitions: x, y, phi or origin and axes; force and torque; the lever of a frame."""
    frames = [(0, pose), (C.RATE, rate), (C.WRENCH, rate), (C.LEVER, lever), (C.MU_WRENCH, rate)]
    frames += [(C.PAST_WRENCH, rate), (C.PAST_LEVER, lever), (C.COLUMNS, 0)]
    pair = 2 * rate
    gradients = [(0, pair), (C.VALUE, 1), (C.MAGNITUDE, 1), (C.GRADIENT_RATE, pair), (C.PAST_GRADIENT, pair)]
    for columns in (frames, [*gradients, (C.GRADIENT_COLUMNS, 0)]):
        for (start, size), (after, _) in pairwise(columns):
            assert start + size == after
    sizes = (C.POSE, C.PAIR_POSE, C.LEVERS, C.CARRIED, C.SQUARE, C.HALF, C.BLOCK_SIZE, C.TANGENT_SCRATCH)
    assert sizes == (rate, pair, lever, pose + rate, pair**2, pair**2 // 2, rate**2, 2 * pair**2)
    records = (C.LEAF, C.MOVED)
    assert records == (1 + pair, 1 + pose + rate + rate)
    assert columns_of(C is SPACE) is C


def test_rows_of_vectors_are_all_below_their_number():
    """Rows of the history: UNKNOWN and UNKNOWN2 of the last steps follow each other."""
    assert L.UNKNOWN0 + 2 * L.PAST == L.SCALE
    assert L.UNKNOWN2 == L.UNKNOWN + 1 and L.E_X == L.ROWS - 1
