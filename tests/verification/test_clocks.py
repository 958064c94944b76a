"""Clocks, `sample`, with other events and with an uncertain rest of the model, against closed forms and counts."""

from collections import Counter

import numpy as np
import pytest

import mbdsl

#: a mass that nothing drives along y, a state that reaches a limit, and a sampled controller of the motion along x
FREE = """{kind} M
  Ground ground({gravity});
  PointMass b(m = 3 kg);
  FreeMotion f(ground, b);
  Real T(start = 4);
  Integer n(start = 0), k(start = 0);
  discrete Real F(unit = "N", start = 0);
  Force push(b, fx = F);
initial equation
  b.x = 0; b.y = 0; b.vx = 0; b.vy = 0.75 m/s;{z}
equation
  der(T) = (30 - T)/(0.4 s);
  when T > 21 then n = pre(n) + 1; end when;
  when sample(0, 30 ms) then k = pre(k) + 1; F = 20 N/m*(1 m - b.x) - 5 N.s/m*b.vx; end when;
  annotation(experiment(StopTime = 0.6 s));
end M;"""
PLANE = FREE.format(kind="model", gravity="g = 0 m/s2", z="")
SPACE = FREE.format(kind="spatial model", gravity="n = {0, 0, -1}", z=" b.z = 0; b.vz = 0;")


@pytest.mark.parametrize("method", ["hht-si2", "hht-i3", "generalized-alpha", "nstiff"])
def test_the_time_of_a_step_is_its_length(method):
    """y = v t at the ends of all steps, though a step was chosen before its clock ticked; one event per tick, though
    steps are taken again for the condition on T."""
    run = mbdsl.simulate(mbdsl.parse(PLANE), method=method, tol=1e-4, interval=0)
    assert np.abs(run["b.y"] - 0.75 * run.t).max() < 1e-12
    assert run.t[-1] == 0.6 and np.diff(run.t).min() > 1e-6
    kinds = Counter(x.kind for x in run.events)
    assert kinds == run.stats["kinds of events"] == {"sample": 21, "when": 1}
    ticks = [x.t for x in run.events if x.kind == "sample"]
    np.testing.assert_allclose(ticks, 0.03 * np.arange(21), atol=1e-12)
    at = np.array([0.004, 0.1, 0.331, 0.59])
    assert np.interp(at, run.t, run["b.y"]) == pytest.approx(0.75 * at, abs=1e-12)
    reached = next(x.t for x in run.events if x.kind == "when")
    assert reached == pytest.approx(0.4 * np.log(26 / 9), abs=1e-3)


def test_a_clock_and_a_condition_of_one_when_are_counted_each():
    """21 ticks, T = 21 between two of them, and the start of `initial()`, whose clock begins later."""
    both = PLANE.replace("when T > 21 then n = pre(n) + 1; end when;", "")
    both = both.replace("when sample(0, 30 ms) then", "when {sample(0, 30 ms), T > 21} then n = pre(n) + 1;")
    run = mbdsl.simulate(mbdsl.parse(both), tol=1e-4)
    assert run.stats["kinds of events"] == {"sample": 21, "when": 1} and run["n"][-1] == 22
    (reached,) = (x.t for x in run.events if x.kind == "when")
    assert reached == pytest.approx(0.4 * np.log(26 / 9), abs=1e-3)
    later = both.replace("{sample(0, 30 ms), T > 21}", "{initial(), sample(30 ms, 30 ms)}")
    assert mbdsl.simulate(mbdsl.parse(later), tol=1e-4).stats["kinds of events"] == {"sample": 20, "initial": 1}


def test_the_time_of_a_step_is_its_length_in_space():
    run = mbdsl.simulate(mbdsl.parse(SPACE), tol=1e-4, interval=0)
    assert np.abs(run["b.y"] - 0.75 * run.t).max() < 1e-12
    assert run.stats["kinds of events"] == {"sample": 21, "when": 1}


REST = """model M
  Ground ground(g = 0 m/s2);
  PointMass p(m = 1 kg);
  FreeMotion f(ground, p);
  Integer c(start = 0), d(start = 0), e(start = 0);
  discrete Real t1(unit = "s", start = -1);
initial equation
  p.x = 0; p.y = 0; p.vx = 1 m/s; p.vy = 0;
equation
  when {clock} then c = pre(c) + 1; t1 = if pre(c) == 0 then time else pre(t1); end when;
  when time > 0.6 s then d = pre(d) + 1; end when;
  when p.x > 0.8 m then e = pre(e) + 1; end when;
end M;"""


@pytest.mark.parametrize("given", [{"tol": 1e-5}, {"tol": 1e-5, "method": "nstiff"}, {"step": 0.05}])
def test_a_tick_at_the_time_of_another_event(given):
    """Ticks at 0, 0.2, ..., 1; a time event at one of them and a condition of the state at another."""
    run = mbdsl.simulate(mbdsl.parse(REST.format(clock="sample(0, 0.2 s)")), stop=1.0, interval=0.1, **given)
    assert [run["c"][-1], run["d"][-1], run["e"][-1]] == [6, 1, 1]
    assert run["d"].tolist() == [0] * 6 + [1] * 5
    assert run["p.x"][-1] == pytest.approx(1.0, abs=1e-12)


@pytest.mark.parametrize(
    ("first", "start", "ticks"), [(-0.05, 0.0, [0.15, 0.35]), (0.3, 7.0, [7.1, 7.3]), (0.0, 2.0, [2.0, 2.2])]
)
@pytest.mark.parametrize("given", [{"step": 0.05}, {"tol": 1e-5}])
def test_ticks_before_the_start_are_none(first, start, ticks, given):
    model = mbdsl.parse(REST.format(clock=f"sample({first} s, 0.2 s)"))
    run = mbdsl.simulate(model, start=start, stop=start + 0.38, interval=0.01, **given)
    found = [x.t for x in run.events if x.kind == "sample"]
    np.testing.assert_allclose(found, ticks, atol=1e-9)
    assert run["t1"][-1] == pytest.approx(ticks[0], abs=1e-9)
    assert run["c"][-1] == len(ticks)


PULSES = """model M
  Ground ground(g = 0 m/s2);
  PointMass p(m = 1 kg);
  FreeMotion f(ground, p);
  Integer n(start = 0);
initial equation
  p.x = 0; p.y = 0; p.vx = 1 m/s; p.vy = 0;
equation
  when cos(40*time/(1 s)) < -0.995 then n = pre(n) + 1; end when;
end M;"""


@pytest.mark.parametrize("method", ["hht-si2", "radau5"])
def test_fixed_steps_pass_over_no_pulse_of_time(method):
    """Pulses of 5 ms around (2 k + 1) pi/40 s, and steps of 20 ms."""
    run = mbdsl.simulate(mbdsl.parse(PULSES), stop=2.0, step=0.02, method=method, interval=0.02)
    rise = (np.pi * (2 * np.arange(13) + 1) - np.arccos(0.995)) / 40
    np.testing.assert_allclose([x.t for x in run.events], rise, atol=1e-9)
    assert run["n"].tolist() == [(rise <= t).sum() for t in run.t]
    assert run["p.x"][-1] == pytest.approx(2.0, abs=1e-12)


def test_single_steps_pass_over_no_pulse_of_time():
    simulation = mbdsl.Simulation(mbdsl.parse(PULSES), step=0.02)
    for _ in range(50):
        simulation.step()
    assert simulation["n"] == 6  # up to pi 11/40 = 0.86 s


EXACT = """
model Exact
  Ground ground;
  PointMass p(m = 1 kg);
  FreeMotion free(ground, p);
  Integer n(start = 0), both(start = 0);
  discrete Real at(unit = "s", start = 0);
equation
  when sample(0.05 s, 2/3*1 s) then n = pre(n) + 1; at = time; end when;
  when {change(n), sample(0.05 s, 2 s)} then both = pre(both) + 1; end when;
end Exact;
"""


def test_a_clock_ticks_at_thirds_and_reads_its_own_time():
    """An event that Python does lies behind its tick by rounding, and `time` in it is that of the tick."""
    run = mbdsl.simulate(mbdsl.parse(EXACT), step=0.1, stop=20.5)
    assert run["n"][-1] == run["both"][-1] == 31
    assert run["at"][-1] == run.events[-1].t == 20.05


LARGE = """
model Large
  Ground ground(g = 0 m/s2);
  Body b(m = 1 kg, I = 1 kg.m2);
  Prismatic rail(ground, b.c);
  discrete Real n(start = 0), later(start = 0);
  Force push(b.c, fx = if time > 0.723 s and time < 0.724 s or time > 0.773 s and time < 0.774 s then 1 kN else 0 N);
initial equation
  rail.s = 0 m; rail.v = 0 m/s;
equation
  when sample(0, 0.1 s) then n = {value}; end when;
  when sample(2 s, 1 s) then later = 1/(1 - b.vx/(2 m/s)); end when;
end Large;
"""


@pytest.mark.parametrize("value", ["1 + time/1 s", "1e20*(1 + time/1 s)"], ids=["small", "large"])
@pytest.mark.parametrize("given", [{"step": 0.05}, {"tol": 1e-4}], ids=["step", "tol"])
def test_pulses_between_the_ticks_of_large_values_are_not_passed_over(value, given):
    """Each pulse has 1 N.s. Python does the ticks of values that are not whole numbers below 2^53; `later`, which is
    infinite behind the pulses, is not due."""
    run = mbdsl.simulate(mbdsl.parse(LARGE.format(value=value)), stop=1.0, **given)
    assert run["b.vx"][-1] == pytest.approx(2.0, abs=1e-9)
