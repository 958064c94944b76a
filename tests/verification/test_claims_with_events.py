"""Errors that runs with events state, against closed forms: an oscillator between events is an arc of a circle.

An output between the exact time of an event and that of the run counts with the difference of the times.
"""

import numpy as np
import pytest

import mbdsl
from mbdsl.errors import IntegrationError

MODEL = """model M
  Ground ground;
  Body b(m = 1 kg, I = 1 kg.m2);
  Prismatic rail(ground, b.c);
  TranslationalSpringDamper k(rail, k = 1 N/m);
  {declared}
initial equation
  rail.s = {s} m; rail.v = {v} m/s;
equation
  {events}
end M;"""


def model(declared, events, s=0.0, v=0.0):
    return mbdsl.parse(MODEL.format(declared=declared, events=events, s=s, v=v))


RELAY = "Boolean on(start = true); Force f(b.c, fx = if on then 1 N else -1 N);"
SWITCHES = "when rail.s > 0.5 m then on = false; elsewhen rail.s < -0.3 m then on = true; end when;"
WALL = "when rail.s < -0.4 m then reinit(rail.v, -0.7*rail.v); end when;"


def arcs(s, v, stop, force, limits, jump):
    """The arcs (t, s, v, force) of x'' = force - x from event to event: x reaches limits[force > 0] from above or, with
    a positive force, from below; ``jump``: the factor of the velocity there, or None: the force changes its sign."""
    found, t = [], 0.0
    while t < stop:
        found.append((t, s, v, force))
        r, phase, limit = np.hypot(s - force, v), np.arctan2(-v, s - force), limits[force > 0]
        turn = np.inf
        if abs(limit - force) < r:
            reached = [a * np.arccos((limit - force) / r) + 2 * np.pi * k for a in (1, -1) for k in (-1, 0, 1, 2)]
            turn = min(a - phase for a in reached if (-np.sin(a) > 0) == (force > 0) and a - phase > 1e-12)
        s, v, t = force + r * np.cos(phase + turn), -r * np.sin(phase + turn), t + turn
        force, v = (-force, v) if jump is None else (force, jump * v)
    return found


def exact(found, t):
    """x and v at times t (N,), and the distance of each to the closest event."""
    begins = np.array([arc[0] for arc in found])
    own = [found[k] for k in np.searchsorted(begins, t, side="right") - 1]
    t0, s, v, force = np.array(own).T
    c, d = np.cos(t - t0), np.sin(t - t0)
    away = np.abs(t[:, None] - begins[None, 1:]).min(axis=1, initial=np.inf)
    return np.array([force + (s - force) * c + v * d, v * c - (s - force) * d]), away


CASES = {
    "relay": (lambda: model(RELAY, SWITCHES, s=0.1), lambda: arcs(0.1, 0.0, 12.0, 1.0, (-0.3, 0.5), None)),
    "wall": (lambda: model("", WALL, s=1.0), lambda: arcs(1.0, 0.0, 12.0, 0.0, (-0.4, -0.4), -0.7)),
    "contact": (
        lambda: model("Contact stop(gap = rail.s + 0.4 m, e = 0.7);", "", s=1.0),
        lambda: arcs(1.0, 0.0, 12.0, 0.0, (-0.4, -0.4), -0.7),
    ),
}


@pytest.mark.parametrize("method", ["hht-si2", "radau5", "nstiff-si2"])
@pytest.mark.parametrize("name", CASES)
def test_stated_errors_are_true(name, method):
    """The true error is at most three times the requested one and ten times the stated one."""
    make, known = CASES[name]
    arcs_of, tol, stop = known(), 1e-4, 12.0
    run = mbdsl.simulate(make(), method=method, tol=tol, stop=stop, interval=stop / 997)
    (s, v), away = exact(arcs_of, run.t)
    size, speed = 1.0, float(np.abs(run["rail.v"]).max())  # a mechanism without extent: its displacement is its size
    size = max(size, float(np.abs(run["rail.s"]).max()))
    count = len(arcs_of) - 1
    assert count >= 3 and run.stats["events"] >= count
    dv = np.abs(run["rail.v"] - v) / speed
    late = tol * size / speed
    dv[away < late] = np.minimum(dv, speed / size * late)[away < late]
    error = max(float(np.abs(run["rail.s"] - s).max()) / size, float(dv.max()))
    assert error <= 3 * tol
    assert error <= 10 * max(run.stats["error"], 1e-13)


@pytest.mark.parametrize("method", ["hht-si2", "radau5"])
def test_an_event_that_the_error_decides_is_said(method):
    """x = sin t reaches 1 - 1e-13, or not: the run says which event, and from when."""
    grazes = model("Integer n(start = 0);", "when rail.s > 0.9999999999999 m then n = pre(n) + 1; end when;", v=1.0)
    with pytest.raises(IntegrationError, match=r"different events|so close to a condition"):
        mbdsl.simulate(grazes, method=method, tol=1e-4, stop=6.0)


GRAZES = {
    "peak": ("Integer n(start = 0);", "when rail.s > 0.999999 m then n = pre(n) + 1; end when;", "n", 10),
    "window": ("Integer n(start = 0);", "when abs(rail.s - 0.3 m) < 1e-6 m then n = pre(n) + 1; end when;", "n", 20),
    "contact": ("Contact c(gap = 0.999999 m - rail.s, e = 1);", "", "c.impacts", 10),
}


@pytest.mark.parametrize("method", ["hht-si2", "radau5", "dop853"])
@pytest.mark.parametrize("name", GRAZES)
def test_two_events_within_a_step(name, method):
    """x = sin t: a condition becomes true and false again within a part of a step, in every one of ten periods.

    The impacts at 1 - 1e-6 return 1.4e-3 of the velocity: each shortens the period by 2 acos(1 - 1e-6)."""
    declared, events, count, expected = GRAZES[name]
    run = mbdsl.simulate(model(declared, events, v=1.0), method=method, tol=1e-4, stop=60.0, interval=0.25)
    assert run[count][-1] == expected
    if name == "contact":
        b = np.arccos(1.0 - 1e-6)  # falling from an impact to the next one: x = cos(t + b)
        first, period = np.pi / 2 - b, 2 * (np.pi - b)
        since = (run.t - first) % period
        exact = np.where(run.t < first, np.sin(run.t), np.cos(since + b))
        assert np.abs(run["rail.s"] - exact).max() <= 3e-4
