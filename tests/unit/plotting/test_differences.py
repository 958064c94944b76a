"""Differences of results against closed forms."""

import numpy as np
import pytest

import mbdsl
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


def test_values_beside_a_jump_are_those_of_their_side():
    """A ball falls from 1 m and leaves the floor with 0.8 of its speed; errors are at most g h^2/2, not the jump."""
    t, g, h = np.linspace(0.0, 0.6, 61), 9.81, 0.01
    hit = np.sqrt(2.0 / g)

    def motion(t):
        back = t - hit
        rises = 0.8 * g * hit * back - g * back**2 / 2
        return np.where(t < hit, 1.0 - g * t**2 / 2, rises), np.where(t < hit, -g * t, 0.8 * g * hit - g * back)

    other = np.linspace(0.0, 0.6, 481)  # eight times as many
    (y, v), (y2, v2) = motion(t), motion(other)
    a, b = (
        result("a", other, p_y=y2, p_vy=v2, p_f=np.where(other < hit, -1.0, 1.0)),
        result("b", t, p_y=y, p_vy=v, p_f=np.where(t < hit, -1.0, 1.0)),
    )
    b.jumps = lambda impulses: np.array([hit])
    found = {name: read(Difference(b, a), name, 100)[1] for name in ("p.y", "p.vy", "p.f")}
    assert abs(found["p.y"]).max() <= g * h**2 / 2
    late = abs(found["p.vy"]) > 1e-9  # without accelerations, the velocity at the nearest output of its side
    assert abs(found["p.vy"]).max() <= g * h and abs(other[late] - hit).max() < h
    assert abs(found["p.f"]).max() == 0.0


def test_between_two_jumps_there_is_no_value():
    known, values = np.array([0.0, 1.0, 2.0]), np.array([1.0, 1.0, 5.0])
    found = interpolated(np.array([0.5, 1.1, 1.3, 1.6, 2.0]), known, values, None, np.array([1.2, 1.5]))
    assert np.array_equal(found, [1.0, 1.0, np.nan, 5.0, 5.0], equal_nan=True)


def test_runs_that_bounce_are_compared_on_both_sides_of_their_impacts(tmp_path):
    ball = mbdsl.parse(
        "model M Ground g; PointMass b(m = 1 kg); Contact f(gap = b.y, e = 0.8); initial equation b.x = 0 m; "
        "b.vx = 0 m/s; b.y = 1 m; b.vy = 0 m/s; end M;"
    )
    one, other = (mbdsl.simulate(ball, method="hht-si2", step=1e-3, stop=1.0, interval=h) for h in (2e-3, 1e-2))
    other.save(tmp_path / "other.npz")
    for second in (other, tmp_path / "other.npz"):
        plot = one.plot("b.vy", [second], difference=True)
        assert max(np.abs(s.y).max() for s in plot.panels[0].series if s.style != "guide") < 9.81 * 1e-2


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
