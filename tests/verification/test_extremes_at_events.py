"""Extremes and means of runs with events, against closed forms: limits on both sides of jumps, and constant pieces."""

import numpy as np
import pytest

import mbdsl

G = 9.81
#: a ball that reinit throws back, one on a rigid contact, a saw tooth, counted ticks, and what `initial()` sets
MODEL = mbdsl.parse("""model M
  Ground ground;
  PointMass a(m = 0.5 kg), b(m = 2 kg);
  FreeMotion fa(ground, a), fb(ground, b);
  Contact c(gap = b.y, e = 0.5);
  Real x(start = 0), y(start = 0);
  Boolean on(start = false), late(start = false);
  Integer n(start = 0), hits(start = 0);
initial equation
  a.x = 0; a.y = 1.3 m; a.vx = 0; a.vy = 0;
  b.x = 0; b.y = 2.1 m; b.vx = 0; b.vy = 0;
equation
  der(x) = 1/(1 s);
  der(y) = if late then 2/(1 s) else -1/(1 s);
  when a.y < 0 m then reinit(a.vy, -0.6*a.vy); hits = pre(hits) + 1; end when;
  when x > 0.3 then reinit(x, 0.1); end when;
  when sample(0.05 s, 0.1 s) then n = pre(n) + 1; end when;
  when initial() then on = true; end when;
  when y < -0.4 then late = true; end when;
  annotation(experiment(StopTime = 0.9 s));
end M;""")
T = 0.9
CASES = [{"step": 7e-3}, {"tol": 1e-5}, {"tol": 1e-5, "method": "dop853"}]


@pytest.mark.parametrize("given", CASES)
def test_extremes_and_means_across_jumps(given):
    run = mbdsl.simulate(MODEL, interval=0.05, **given)
    found = run.extremes(["a.vy", "b.vy", "a.y", "energy.total", "x", "y", "n", "on", "late", "hits", "c.impacts"])
    ta, tb = np.sqrt(2 * 1.3 / G), np.sqrt(2 * 2.1 / G)
    lost = 0.5 * G * 1.3 * (1 - 0.6**2)  # energy of the first ball at its hit
    stored = 0.5 * G * 1.3 + 2 * G * 2.1
    limits = {
        "a.vy": (-G * ta, 0.6 * G * ta),
        "b.vy": (-G * tb, 0.5 * G * tb),
        "a.y": (0, 1.3),
        "energy.total": (stored - lost - 2 * G * 2.1 * 0.75, stored),
        "x": (0, 0.3),
        "y": (-0.4, 0.6),
        "n": (0, 9),
        "on": (1, 1),
        "late": (0, 1),
        "hits": (0, 1),
        "c.impacts": (0, 1),
    }
    for name, (low, high) in limits.items():
        assert found[name].least == pytest.approx(low, abs=2e-5), name
        assert found[name].largest == pytest.approx(high, abs=2e-5), name
    ticks, hits = T - (0.05 + 0.1 * np.arange(9)), np.array([T - ta, T - tb])
    means = {
        "x": (0.045 + 3 * 0.04) / T,
        "n": ticks.sum() / T,
        "on": 1,
        "late": 0.5 / T,
        "hits": hits[0] / T,
        "c.impacts": hits[1] / T,
        "a.y": (1.3 * ta - G * ta**3 / 6 + 0.6 * G * ta * hits[0] ** 2 / 2 - G * hits[0] ** 3 / 6) / T,
    }
    squares = {
        "x": (0.3**3 + 3 * (0.3**3 - 0.1**3)) / (3 * T),
        "n": ((np.arange(1, 10) ** 2 - np.arange(9) ** 2) * ticks).sum() / T,
        "late": 0.5 / T,
        "c.impacts": hits[1] / T,
    }
    for name, mean in means.items():
        assert found[name].mean == pytest.approx(mean, abs=3e-5), name
    for name, square in squares.items():
        assert found[name].rms == pytest.approx(np.sqrt(square), abs=3e-5), name


@pytest.mark.parametrize("given", CASES[:2])
def test_outputs_shortly_before_an_event_are_those_before_it(given):
    """The last step before an event ends before it, and an output may lie between."""
    hit = np.sqrt(2 * 1.3 / G)
    times = hit - np.array([1e-6, 1e-7, 1e-8, 1e-9])
    run = mbdsl.simulate(MODEL, times=[*times, hit + 1e-6], **given)
    before, behind = run["a.vy"][-5:-1], run["a.vy"][-1]
    np.testing.assert_allclose(before, -G * times, atol=1e-5)
    assert behind == pytest.approx(0.6 * G * hit, abs=2e-5)
    assert run["hits"][-5:].tolist() == [0, 0, 0, 0, 1]
