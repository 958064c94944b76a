"""Location of changes: known zeros, and how many evaluations they take."""

import math

import numpy as np
import pytest

from mbdsl.numerics.first_change import first_change

CASES = [
    ([lambda s: 0.3 - s], 0.3, 4),
    ([lambda s: 1.0 - s - 20.0 * s * s], (math.sqrt(81.0) - 1.0) / 40.0, 14),
    ([lambda s: 0.7 - s, lambda s: 0.2 - s**3], 0.2 ** (1 / 3), 14),  # the first of two
    ([lambda s: 1.0 if s < 1e-3 else -1.0], 1e-3, 50),  # a jump
    ([lambda s: math.inf if s < 0.1 else -math.inf], 0.1, 40),  # no number shows the distance: halving
    ([lambda s: math.nan, lambda s: 0.25 - s if s < 0.5 else -1e9], 0.25, 40),  # a corner
]


@pytest.mark.parametrize(("quantities", "expected", "most"), CASES)
def test_the_time_is_just_behind_the_change(quantities, expected, most):
    count = 0

    def values(s):
        return np.array([f(s) for f in quantities])

    def look(s):
        nonlocal count
        count += 1
        return s < expected, values(s)

    found = first_change(look, 0.0, 1.0, (values(0.0), values(1.0)), (1e-9, 0.0))
    assert expected <= found <= expected * (1.0 + 1e-9)
    assert count <= most
