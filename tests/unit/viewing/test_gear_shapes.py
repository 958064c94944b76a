"""Shapes of gears and belts."""

import numpy as np
import pytest

from mbdsl.elements import kinds
from mbdsl.viewing import gear_shapes
from mbdsl.viewing.symbols import SYMBOLS


def test_a_gear_has_its_teeth_where_they_belong():
    """40 teeth of module 0.05 about a pitch radius of 1, one of them in the direction of 0.3 rad."""
    points = gear_shapes.toothed(1.0, 0.05, 0.3) @ [1, 1j]
    assert len(points) == 4 * 40
    outside = abs(points) > 1.0
    assert outside.sum() == 80
    tooth = np.exp(40j * np.angle(points[outside]))  # the angle times 40 has one value in the middle of all teeth
    assert np.angle(tooth.mean() * np.exp(-40j * 0.3)) == pytest.approx(0.0, abs=1e-9)
    assert abs(points).min() == pytest.approx(1 - 0.05) and abs(points).max() == pytest.approx(1 + 0.04)


@pytest.mark.parametrize(("small", "large"), [(18, 54), (24, 60), (16, 44), (1, 3), (12, 31)])
def test_both_gears_of_a_pair_have_whole_teeth(small, large):
    module = gear_shapes._module(small, large)
    teeth = np.array([2 * small / module, 2 * large / module])
    assert teeth == pytest.approx(np.rint(teeth), abs=0.2) and gear_shapes.FEWEST <= round(teeth[0]) <= gear_shapes.MOST


def test_all_symbols_of_gears_are_used():
    named = {kind.drawing for kind in kinds().values()} - {""}
    assert set(gear_shapes.SYMBOLS) <= named <= set(SYMBOLS)
