"""Differences of results against closed forms."""

import numpy as np
import pytest

from mbdsl.errors import UsageError
from mbdsl.plotting.differences import Difference, interpolated
from mbdsl.results.stored import of_columns

UNITS = {"x": "m", "vx": "m/s", "f": "N"}


def result(label, t, **columns):
    columns = {"time": t, **{name.replace("_", "."): x for name, x in columns.items()}}
    return of_columns(label, list(columns), lambda name: UNITS.get(name.rpartition(".")[2], ""), columns.__getitem__)


def read(difference, name, rows):
    parts = [(t, columns[name]) for t, columns in difference.chunks([name], rows)]
    return tuple(np.concatenate(p) for p in zip(*parts, strict=True))


@pytest.mark.parametrize("rows", [7, 64, 10_000])
def test_two_known_motions(rows):
    """cos t from 331 times minus sin t at 200 other times; errors of interpolation: h^4/384 and h^2/8."""
    t, other = np.linspace(0.0, 6.0, 200), np.linspace(0.0, 6.0, 331)
    a = result("a", t, p_x=np.sin(t), p_vx=np.cos(t), p_f=np.sin(t))
    b = result("b", other, p_x=np.cos(other), p_vx=-np.sin(other), p_f=np.cos(other))
    difference, h = Difference(b, a), 6.0 / 330
    for name, bound in (("p.x", h**4 / 384.0), ("p.f", h**2 / 8.0)):
        times, values = read(difference, name, rows)
        assert np.array_equal(times, t)
        error = abs(values - (np.cos(t) - np.sin(t))).max()
        assert 0.2 * bound < error <= bound * (1.0 + 1e-6) + 1e-15
    assert difference.interpolated
    assert difference.rates(["p.x", "p.f"]) == ["p.x"]
    assert (difference.unit("p.x"), difference.unit("p.f")) == ("m", "N")


def test_equal_times_are_not_interpolated():
    t = np.linspace(0.0, 1.0, 50)
    a, b = result("a", t, p_x=t**2, p_vx=2 * t), result("b", t, p_x=t**3, p_vx=np.zeros(50))
    difference = Difference(b, a)
    assert np.array_equal(read(difference, "p.x", 9)[1], t**3 - t**2)
    assert not difference.interpolated


def test_outside_the_range_there_is_no_value():
    t = np.linspace(0.0, 1.0, 11)
    a, b = result("a", t, p_f=t), result("b", t[3:8] + 0.05, p_f=t[3:8] + 0.05)
    values = read(Difference(b, a), "p.f", 4)[1]
    assert np.isnan(values).tolist() == [not 0.35 <= x <= 0.75 for x in t]
    assert values[4:8] == pytest.approx(0.0, abs=1e-15)


def test_a_jump_between_two_equal_times():
    known, values = np.array([0.0, 1.0, 1.0, 2.0]), np.array([0.0, 0.0, 5.0, 5.0])
    found = interpolated(np.array([0.5, 1.0, 1.5, 2.0]), known, values, None)
    assert found.tolist() == [0.0, 5.0, 5.0, 5.0]


def test_without_a_rate_at_one_time():
    """At a singular pose accelerations are nan: the two neighbouring pieces are linear."""
    known, rates = np.arange(5.0), 2.0 * np.arange(5.0)
    rates[2] = np.nan
    found = interpolated(np.array([0.5, 1.5, 2.0, 2.5, 3.5]), known, known**2, rates)
    assert found.tolist() == [0.25, 2.5, 4.0, 6.5, 12.25]


def test_results_that_do_not_fit():
    t = np.linspace(0.0, 1.0, 5)
    with pytest.raises(UsageError, match="no signal in common"):
        Difference(result("b", t, q_x=t), result("a", t, p_x=t))
    other = of_columns("b", ["time", "p.x"], lambda name: "rad", {"time": t, "p.x": t}.__getitem__)
    with pytest.raises(UsageError, match="unit m in a and rad in b"):
        Difference(other, result("a", t, p_x=t))
