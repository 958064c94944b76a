"""Signals that jump: flags, counters and held values are drawn with vertical lines, at the times of events."""

import numpy as np
import pytest

from mbdsl.plotting.curves import is_held, over_time, stepped
from mbdsl.results.stored import of_columns

T = np.arange(8.0)
NONE = np.empty(0)


def test_a_flag_jumps_at_every_change():
    """A pulse of one row is a rectangle, not a triangle."""
    t, y = stepped(T, np.array([1.0, 1, 1, 0, 1, 1, 0, 0]), NONE)
    assert np.array_equal(t, [0, 1, 2, 3, 3, 3, 4, 4, 4, 5, 6, 6, 6, 7])
    assert np.array_equal(y, [1, 1, 1, 1, 0, 0, 0, 1, 1, 1, 1, 0, 0, 0])


def test_a_value_that_is_constant_before_and_after_jumps_at_the_event():
    t, y = stepped(T, np.array([0.5, 0.5, 0.5, 2.5, 2.5, 2.5, 2.5, 2.5]), np.array([0.3, 2.25, 5.0]))
    assert np.array_equal(t[2:6], [2.0, 2.25, 2.25, 3.0]) and np.array_equal(y[2:6], [0.5, 0.5, 2.5, 2.5])


@pytest.mark.parametrize("y", [T, np.sin(T), np.where(T < 4, 0.0, T - 3.5), np.full(8, np.nan)])
def test_smooth_signals_are_lines_between_their_rows(y):
    """So is one that rests and then moves, and whole numbers that change in every row."""
    assert stepped(T, y, NONE)[0] is T


def test_curves_of_results_have_the_jumps_of_their_events():
    n = np.array([0.0, 0, 0, 1, 1, 1, 1, 2])
    result = of_columns("run", ["time", "n"], lambda name: "", {"time": T, "n": n}.__getitem__)
    result.jumps = lambda impulses: np.array([2.5, 6.75])
    (curve,) = over_time(result, ["n"])
    assert is_held(n) and not is_held(T)
    assert np.array_equal(curve.x[curve.y == 1.0][[0, -1]], [2.5, 6.75]) and curve.count == 8
