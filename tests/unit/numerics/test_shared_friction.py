"""Shares of friction that is not unique: feasibility by a linear program, against closed forms."""

import numpy as np
import pytest

from mbdsl.numerics.friction_shares import FrictionLimits, largest_reserve

ONE = np.array([[1.0], [-1.0]])  # two joints that hold the same motion
NO_SLOPE = np.zeros((2, 1))


@pytest.mark.parametrize(("load", "holds"), [(0.5, True), (0.6 * (1 - 1e-9), True), (0.6 * (1 + 1e-6), False)])
def test_two_feet_hold_up_to_the_sum_of_their_friction(load, holds):
    limits = FrictionLimits([[0], [1]], np.array([0.6, 0.6]), np.array([0.9, 0.1]), NO_SLOPE)
    y = largest_reserve(np.array([load, 0.0]), ONE, limits)
    assert (y is not None) == holds
    if y is not None:
        assert np.abs(np.array([load, 0.0]) + ONE @ y) == pytest.approx(np.array([0.9, 0.1]) * load)


def test_friction_in_two_directions_is_a_circle():
    # one joint holds along x only, the other both: (0.6, 0.8) is on the circle of the second if the first carries 0.5
    limits = FrictionLimits([[0], [1, 2]], np.array([1.0, 1.0]), np.array([0.5, 1.0]), NO_SLOPE)
    Z = np.array([[1.0], [-1.0], [0.0]])
    for scale, holds in ((1 - 1e-8, True), (1 + 1e-6, False)):
        F = np.array([0.0, 0.5 + 0.6 * scale, 0.8 * scale])
        assert (largest_reserve(F, Z, limits) is not None) == holds


def test_shares_that_change_the_normal_forces():
    # y presses the first joint by 2 y: y <= 0.5 (1 + 2 y) and 1.2 - y <= 0.5 hold from y = 0.7 on
    limits = FrictionLimits([[0], [1]], np.array([0.5, 0.5]), np.array([1.0, 1.0]), np.array([[2.0], [0.0]]))
    y = largest_reserve(np.array([0.0, 1.2]), ONE, limits)
    assert y is not None
    assert y[0] >= 0.7 - 1e-9
