"""Decimation of long curves: no extreme is lost, whatever the parts in which a curve is read."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from mbdsl.plotting.decimation import ThinnedRows, Visited, extremes


class Curve(ThinnedRows):
    """A curve over an ascending coordinate, in about so many columns."""

    def __init__(self, columns):
        super().__init__(["x", "y"], "x", 4 * columns, even=True)

    def add(self, x, y):
        super().add({"x": x, "y": y})

    x = property(lambda self: self.columns()["x"])
    y = property(lambda self: self.columns()["y"])


def added(curve, x, y, rows):
    for k in range(0, len(x), rows):
        curve.add(x[k : k + rows], y[k : k + rows])
    return curve


def points(curve):
    return set(zip(curve.x.tolist(), curve.y.tolist(), strict=True))


@pytest.mark.parametrize("rows", [37, 1000, 100_000])
@pytest.mark.parametrize("spacing", ["uniform", "clustered"])
def test_every_extreme_of_every_pixel_is_kept(rows, spacing):
    """The least and greatest value of each of 64 columns of pixels, from all rows and from the kept ones."""
    random = np.random.default_rng(1)
    t = np.sort(random.random(50_000) ** (4.0 if spacing == "clustered" else 1.0))
    y = np.cumsum(random.standard_normal(t.size))
    y[[123, 31_234]] = 1e4, -1e4  # spikes of one row
    curve = added(Curve(256), t, y, rows)
    assert curve.reduced
    assert curve.count == t.size
    assert len(curve.x) <= 4 * 256 + rows
    assert points(curve) <= set(zip(t.tolist(), y.tolist(), strict=True))
    assert (np.diff(curve.x) >= 0.0).all()
    assert (curve.x[0], curve.x[-1]) == (t[0], t[-1])
    assert (curve.y.min(), curve.y.max()) == (-1e4, 1e4)
    # The kept columns are narrower than a pixel, and not aligned with it: a pixel and its neighbours enclose them.
    pixel, kept = np.minimum((64 * t).astype(int), 63), np.minimum((64 * curve.x).astype(int), 63)
    for k in np.unique(kept):
        around = y[abs(pixel - k) <= 1]
        found = curve.y[abs(kept - k) <= 1]
        inside = y[pixel == k]
        assert around.min() <= found.min() <= inside.min()
        assert inside.max() <= found.max() <= around.max()


def test_short_curves_are_unchanged():
    t = np.linspace(0.0, 1.0, 400)
    curve = added(Curve(100), t, np.sin(t), 100)
    assert not curve.reduced
    assert np.array_equal(curve.x, t)
    assert np.array_equal(curve.y, np.sin(t))


def test_gaps_remain():
    t = np.linspace(0.0, 1.0, 10_000)
    y = np.sin(20.0 * t)
    y[5000] = np.nan
    y[7000:8000] = np.nan
    curve = added(Curve(64), t, y, 3000)
    gaps = curve.x[np.isnan(curve.y)]
    assert t[5000] in gaps
    assert ((gaps >= t[7000]) & (gaps < t[8000])).sum() > 2
    assert np.nanmax(curve.y) == np.nanmax(y)


@settings(deadline=None, max_examples=60)
@given(st.lists(st.tuples(st.integers(0, 5), st.floats(-9, 9) | st.just(float("nan"))), min_size=1, max_size=40))
def test_of_each_column_the_first_least_greatest_and_last(rows):
    rows.sort(key=lambda row: row[0])
    column, y = np.array([r[0] for r in rows]), np.array([r[1] for r in rows])
    chosen = extremes(column, y)
    assert (np.diff(chosen) > 0).all()
    for k in set(column.tolist()):
        (where,) = np.nonzero(column == k)
        mine = [i for i in chosen if column[i] == k]
        assert {where[0], where[-1]} <= set(mine)
        assert len(mine) <= 5
        if not np.isnan(y[where]).all():
            assert np.nanmin(y[mine]) == np.nanmin(y[where])
            assert np.nanmax(y[mine]) == np.nanmax(y[where])
        assert np.isnan(y[mine]).any() == np.isnan(y[where]).any()


@pytest.mark.parametrize("rows", [997, 60_000])
def test_phase_plot_visits_the_same_cells(rows):
    """A circle that is passed a hundred times: the same cells, few segments, and only points of the curve."""
    angle = np.linspace(0.0, 200.0 * np.pi, 60_000)
    x, y = np.cos(angle), np.sin(angle)
    curve = added(Visited((-1.0, 1.0), (-1.0, 1.0), (64, 64)), x, y, rows)

    def cells(a, b):
        place = np.minimum((np.column_stack([a, b]) + 1.0) / 2.0 * 64, 63).astype(int)
        return set(map(tuple, place.tolist()))

    drawn = ~np.isnan(curve.x)
    assert cells(curve.x[drawn], curve.y[drawn]) == cells(x, y)
    assert np.hypot(curve.x[drawn], curve.y[drawn]) == pytest.approx(1.0)
    assert len(curve.x) < 2500
    steps = np.hypot(np.diff(curve.x), np.diff(curve.y))
    assert np.nanmax(steps) < 3.0 * 2.0 / 64  # no chord through the circle


def test_phase_plot_of_noise_is_bounded():
    random = np.random.default_rng(2)
    x, y = random.random(40_000), random.random(40_000)
    curve = added(Visited((0.0, 1.0), (0.0, 1.0), most=2000), x, y, 8000)
    assert len(curve.x) <= 3 * 2000 + 3
    assert curve.count == 40_000
    assert curve.x[~np.isnan(curve.x)].size > 1000


def test_phase_plot_has_gaps():
    x = np.array([0.0, 1.0, np.nan, 0.0, 0.5])
    y = np.array([0.0, 1.0, 1.0, 1.0, 0.0])
    curve = added(Visited((0.0, 1.0), (0.0, 1.0), (8, 8)), x, y, 5)
    gaps = np.isnan(curve.x)
    pieces = [p.tolist() for p in np.split(curve.x, np.flatnonzero(gaps))]
    assert [[v for v in p if v == v] for p in pieces if len(p) > 1] == [[0.0, 1.0], [0.0, 0.5]]


def test_a_constant_is_drawn():
    curve = added(Visited((1.0, 1.0), (2.0, 2.0)), np.ones(100), np.full(100, 2.0), 30)
    assert (1.0, 2.0) in points(curve)
