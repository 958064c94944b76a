"""Bounds of expressions along paths, and the operations that a search for peaks may take."""

import numpy as np
import pytest

import mbdsl
from mbdsl.expressions.symbolic import TIME, Expr, call, coordinate
from mbdsl.integrators import peak_zones
from mbdsl.mechanism.scene_parts import Table
from mbdsl.system import build, peaks_along_motion, peaks_in_time
from mbdsl.system.interval_tape import MOST
from mbdsl.system.paths import Program, Work, over_time
from mbdsl.system.peaks_along_motion import OnTheWay
from mbdsl.system.peaks_in_fixed_steps import InFixedSteps
from mbdsl.system.peaks_in_time import hiding, pace

WINDOWS = """
model Windows
  Ground ground(g = 0);
  Body b(m = 1.0, I = 1);
  Prismatic s(ground, b.c);
  TranslationalSpringDamper law(s, force = if mod(s.s, 0.1 m) < 2e-4 m then 10 N else 0 N);
initial equation
  s.s = 0.05 m; s.v = 1 m/s;
  annotation(experiment(StopTime = 1 s));
end Windows;
"""


def nested(depth):
    x = coordinate("b", "x")
    for _ in range(depth):
        x = x * x + call("sin", x)
    return x


def test_shared_expressions_are_computed_once():
    """y = y*y + sin(y), 89 times: three operations each, not 2^89."""
    assert Program([nested(89)]).length == 3 * 89


@pytest.mark.parametrize("of", [coordinate("b", "x"), TIME])
def test_shared_products_are_expanded_once(of):
    """y = (y + 1)*(y + 2), 60 times: not 2^60 expansions, and no bound of the frequency."""
    for _ in range(60):
        of = (call("sin", of) + 1.0) * (call("sin", of) + 2.0)
    assert 0 < len(hiding([of])) < 1000
    assert pace(of) == np.inf


@pytest.mark.parametrize("beyond", ["hold", "periodic"])
@pytest.mark.parametrize("points", [2, 3, 90, 128, 1000])
def test_ranges_of_linear_tables_are_those_of_their_points(points, beyond):
    """A piecewise linear function has its extreme values at its points and at the ends of the interval."""
    random = np.random.default_rng(points)
    u = np.cumsum(random.uniform(0.1, 1.0, points))
    y = random.normal(size=points)
    y[-1] = y[0]
    f = over_time(Expr("table", (TIME,), (Table("p", tuple(u), tuple(y), "linear", beyond), 0)))
    a = random.uniform(u[0], u[-1], 40)
    b = np.minimum(a + random.uniform(0.0, 1.0, 40) ** 3 * (u[-1] - u[0]), u[-1])
    jet = f.jets(np.zeros(40, int), a, b)
    for i in range(40):
        inside = np.concatenate([np.interp([a[i], b[i]], u, y), y[(u > a[i]) & (u < b[i])]])
        assert (jet.lo[i, 0], jet.hi[i, 0]) == pytest.approx((inside.min(), inside.max()), abs=1e-12)


def test_points_between_which_a_wave_is_monotone():
    """sin over two periods has extrema at pi/2 and the three that follow; a line has none, and is not reported."""
    f = over_time(call("sin", TIME))
    least, slight = np.full(1, 1e-9), np.full(1, 1e-6)
    ends = np.array([[0.0, 4.0 * np.pi]])
    ((k, points),) = f.monotone(0, np.zeros(1, int), ends, least, np.zeros(1), slight, Work(np.full(1, 1e9)))
    assert k == 0
    for at in np.pi * (0.5 + np.arange(4)):
        assert np.abs(points.s - at).min() < 2e-3
    slopes = np.cos(0.5 * (points.s[1:] + points.s[:-1]))
    assert (slopes * np.diff(points.y) >= -1e-12).all()
    line = over_time(3.0 * TIME)
    work = Work(np.full(1, 1e9))
    assert not list(line.monotone(0, np.zeros(1, int), ends, least, np.zeros(1), slight, work))
    assert work.each[0] == 3 * 2 * line.program.length


def test_too_many_intervals_are_reported_and_counted():
    f = over_time(call("sin", 1e6 * TIME))
    given = np.zeros(1, int), np.array([[0.0, 1.0]]), np.full(1, 1e-12), np.zeros(1), np.full(1, 1e-3)
    work = Work(np.full(1, 1e9))
    assert list(f.monotone(0, *given, work)) == [(0, None)]
    assert 0 < work.each[0] <= 3 * (2 + MOST) * f.program.length
    tired = Work(np.zeros(1))
    assert not list(f.monotone(0, *given, tired)) and tired.until == 0


def run(force=10.0, **given):
    text = WINDOWS.replace("10 N", f"{force!r} N")
    return mbdsl.simulate(mbdsl.parse(text), **{"tol": 1e-4, "method": "dop853", "interval": 0.01, **given})


def limited(monkeypatch, operations):
    """Searches end after this number of operations."""
    monkeypatch.setattr(peaks_along_motion, "LEAST", operations)
    monkeypatch.setattr(OnTheWay, "AT_ONCE", 0.0)
    monkeypatch.setattr(OnTheWay, "A_STEP", 0.0)
    monkeypatch.setattr(InFixedSteps, "A_STEP", 0.0)


def test_windows_are_found_with_a_twentieth_of_the_operations(monkeypatch):
    """Each of ten windows takes 10 N over 0.2 mm from a mass of 1 kg."""
    limited(monkeypatch, 5e4)
    found = run()
    assert found["s.v"][-1] == pytest.approx(np.sqrt(1.0 - 2.0 * 10 * 10.0 * 2e-4), rel=1e-3)
    assert not found.stats["warnings"]


@pytest.mark.parametrize("given", [{}, {"method": "scipy-dop853"}, {"tol": None, "method": "hht-si2", "step": 0.02}])
def test_a_search_that_takes_too_long_is_given_up_with_a_warning(monkeypatch, given):
    """The force is so small that the motion is uniform."""
    limited(monkeypatch, 0.0)
    found = run(1e-9, **given)
    (text,) = found.stats["warnings"]
    assert "was given up at t = " in text and "a peak within a step may be missed" in text
    assert found["s.s"][-1] == pytest.approx(1.05, abs=1e-6)


def test_a_search_in_time_is_given_up_with_a_warning(monkeypatch):
    """As above, with 318 windows of time; with enough operations all of them are found."""
    text = WINDOWS.replace("mod(s.s, 0.1 m) < 2e-4 m", "sin(2000*time) > 0.99999").replace("10 N", "1e-9 N")
    model, given = mbdsl.parse(text), {"tol": 1e-4, "method": "radau5", "interval": 0.01}
    system = build(model)
    tops = np.array([0.5 * (zone.start + zone.end) for zone in system.time_zones(0.0, 1.0)])
    for k in range(318):
        assert np.abs(tops - (0.5 + 2.0 * k) * np.pi / 2000.0).min() < np.arccos(0.99999) / 2000.0
    assert not system.zones_end
    monkeypatch.setattr(peaks_in_time, "CREDIT", 0.0)
    monkeypatch.setattr(peaks_in_time, "A_ZONE", 0.0)
    found = mbdsl.simulate(model, **given)
    (warning,) = found.stats["warnings"]
    assert "was given up at t = " in warning
    assert found["s.s"][-1] == pytest.approx(1.05, abs=1e-6)


def test_where_a_search_is_given_up_does_not_depend_on_the_steps_searched_together(monkeypatch):
    """Nor does the motion depend on where the run returns for interruptions."""
    limited(monkeypatch, 2e3)
    found = []
    for few, pause in ((1, 3e6), (3, 1.0), (200, 3e6)):
        monkeypatch.setattr(peak_zones, "FEW", few)
        monkeypatch.setattr(peak_zones, "PAUSE", pause)
        found.append(run(1e-9, method="radau5"))
    (text,) = found[0].stats["warnings"]
    assert "was given up at t = 0." in text
    for other in found[1:]:
        assert other.stats["warnings"] == [text]
        assert (other["s.s"] == found[0]["s.s"]).all()


def test_a_run_returns_while_it_searches(monkeypatch):
    """So that signals are handled: after every search of a window, if a search is as long as the pause."""
    monkeypatch.setattr(peak_zones, "PAUSE", 1.0)
    advance, calls = peak_zones.Landings.advance, []

    def counted(landings, steps, call):
        spent = landings._looks.spent
        status = advance(landings, steps, call)
        calls.append(landings._looks.spent - spent)
        return status

    monkeypatch.setattr(peak_zones.Landings, "advance", counted)
    found = run(1e-9)
    assert sum(spent > 0 for spent in calls) >= 10
    assert found["s.s"][-1] == pytest.approx(1.05, abs=1e-6)


def test_nested_laws_do_not_stop_a_run():
    """The law is zero: the motion is uniform."""
    aliases = "".join(f"  Real y{i} = y{i - 1}*y{i - 1} + sin(y{i - 1});\n" for i in range(1, 90))
    text = WINDOWS.replace("mod(s.s, 0.1 m) < 2e-4 m", "y89 > 1e300")
    text = text.replace("  Ground", f"  Real y0 = 0.3*s.s/(1 m);\n{aliases}  Ground")
    found = mbdsl.simulate(mbdsl.parse(text), tol=1e-4, method="dop853", stop=0.1)
    assert found["s.s"][-1] == pytest.approx(0.15, abs=1e-5)
