"""Controlled steps across discontinuities, against solutions put together from pieces in closed form."""

from math import cos, exp, pi, sin, sqrt

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import mbdsl
from mbdsl.errors import IntegrationError
from mbdsl.integrators import available
from mbdsl.integrators.events import SwitchEvents

METHODS = [name for name, method in available().items() if "controlled" in method.steps and "fixed" in method.steps]
SLIDE = """
model Slide
  Ground ground(g = 0);
  Body body(m = 1 kg, I = 1 kg.m2);
  Prismatic rail(ground, body.c);
  {more}
  TranslationalSpringDamper spring(rail, force = {force});
initial equation
  rail.s = {s} m;
  rail.v = {v} m/s;
  annotation(experiment(StopTime = {stop} s));
end Slide;
"""


def slide(force, s=0.0, v=0.0, stop=1.0, more=""):
    return mbdsl.parse(SLIDE.format(force=force, s=s, v=v, stop=stop, more=more))


@pytest.fixture
def seen(monkeypatch):
    """The events of the last run."""
    runs, begin = [], SwitchEvents.begin
    monkeypatch.setattr(SwitchEvents, "begin", lambda self, *given: (runs.append(self), begin(self, *given))[1])
    return lambda: runs[-1].times


# -- pieces ----------------------------------------------------------------------------------------------------------


def oscillation(x, v, t, w, d=0.0):
    """x'' = -w^2 x - 2 d x' from x, v."""
    n = sqrt(w * w - d * d)
    a, b, e = x, (v + d * x) / n, exp(-d * t)
    return e * (a * cos(n * t) + b * sin(n * t)), e * ((b * n - d * a) * cos(n * t) - (a * n + d * b) * sin(n * t))


def switched_force(t):
    """x'' = -100 x + 10 until 0.3137, -30 from there."""
    x, v = oscillation(-0.1, 0.0, min(t, 0.3137), 10.0)
    x += 0.1
    if t > 0.3137:
        x, v = oscillation(x + 0.3, v, t - 0.3137, 10.0)
        x -= 0.3
    return x, v


def end_stop(t, d=0.0):
    """Free until x = 0.5 at t = 0.3, there x'' = -1e4 (x - 0.5) - 2 d v until it is left again."""
    n = sqrt(1e4 - d * d)
    if t < 0.3:
        return 0.2 + t, 1.0
    x, v = oscillation(0.0, 1.0, min(t - 0.3, pi / n), 100.0, d)
    return 0.5 + x + max(0.0, t - 0.3 - pi / n) * v, v


def friction(t):
    """x'' = -100 x - 2 sign(v) from rest at 1: half oscillations, each nearer by 0.04."""
    halves = int(t // (pi / 10))
    x = (1 - 0.04 * halves) * (-1) ** halves
    shift = 0.02 * np.sign(x)
    x, v = oscillation(x - shift, 0.0, t - halves * pi / 10, 10.0)
    return x + shift, v


KNOTS, VALUES = (0.0, 0.2, 0.31, 0.5, 0.77, 1.0), (0.0, 10.0, -5.0, 3.0, 20.0, 0.0)


def by_table(t):
    x = v = 0.0
    for a, b, p, q in zip(KNOTS, KNOTS[1:], VALUES, VALUES[1:], strict=False):
        s, r = min(max(t - a, 0.0), b - a), (q - p) / (b - a)
        x, v = x + v * s + p * s * s / 2 + r * s**3 / 6, v + p * s + r * s * s / 2
    return x, v


TABLE = "Table u(table = [" + "; ".join(f"{u} s, {y} N" for u, y in zip(KNOTS, VALUES, strict=True)) + "]);"
STOP = "if s > 0.5 m then 1e4 N/m*(s - 0.5 m) + {c} N.s/m*v else 0 N"
LEAVES = 0.3 + pi / sqrt(1e4 - 400)
#: scene, solution, times of events
CASES = {
    "force": (slide("100 N/m*s - (if time < 0.3137 s then 10 N else -30 N)"), switched_force, [0.3137]),
    "stop": (slide(STOP.format(c=0), 0.2, 1.0, 0.8), end_stop, [0.3, 0.3 + pi / 100]),
    "damped stop": (slide(STOP.format(c=40), 0.2, 1.0, 0.8), lambda t: end_stop(t, 20.0), [0.3, LEAVES]),
    "friction": (slide("100 N/m*s + 2 N*sign(v)", 1.0), friction, [0.0, pi / 10, pi / 5, 3 * pi / 10]),
    "table": (slide("-u(time)", more=TABLE), by_table, list(KNOTS[1:-1])),
}
#: scenes whose forces do not jump
CORNERS = ("stop", "table")


def solved(scene, solution, method, tol):
    """The trajectory, its largest error of x and v (relative to the largest speed)."""
    found = mbdsl.simulate(scene, method=method, tol=tol, interval=0.01)
    exact = np.array([solution(t) for t in found.t])
    x, v = np.abs(np.array([found["rail.s"], found["rail.v"]]).T - exact).max(axis=0)
    return found, max(x, v / np.abs(exact[:, 1]).max())


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("name", CASES)
def test_accuracy_across_events(name, method, seen):
    """The run keeps the tolerance and takes no longer than the tolerance allows; an event costs a few steps."""
    scene, solution, times = CASES[name]
    tol = 1e-3 if available()[method].order == 1 else 1e-5
    found, error = solved(scene, solution, method, tol)
    assert error <= 10 * tol
    if name in CORNERS:  # a step ends at an event only if a step across it would be wrong
        times = [t for t in times if any(abs(t - x) < 1e-3 for x in seen())]
    # the error of an event's time follows from the error of the motion
    assert seen() == pytest.approx(times, abs=10 * tol)
    assert found.stats["events"] == len(times)
    assert found.stats["rejected"] <= 4 * len(CASES[name][2]) + 6


@pytest.mark.parametrize("name", CASES)
def test_radau5_across_events_to_eight_digits(name):
    """The same scenes without events: with error control alone, the errors are 2 to 12 times the tolerance (0.2 times
    with the switched force), with ten times as many rejected steps."""
    scene, solution, times = CASES[name]
    found, error = solved(scene, solution, "radau5", 1e-8)
    assert error <= 2e-9
    assert found.stats["events"] == len(times)
    assert found.stats["rejected"] <= 4 * len(times)


def test_every_step_of_radau5_is_written():
    """Output times, also if they coincide with a jump."""
    scene, solution, _ = CASES["force"]
    found = mbdsl.simulate(scene, method="radau5", tol=1e-6, interval=0)
    assert len(found.t) == found.stats["steps"] + 1 and found.t[-1] == 1.0
    assert np.abs(found.t - 0.3137).min() < 1e-12 and np.diff(found.t).min() > 0.0
    assert found["rail.s"] == pytest.approx([solution(t)[0] for t in found.t], abs=1e-6)


def test_events_where_the_motion_is_known_exactly(seen):
    """Located to 1e-12: known in advance if it depends on time; by bisection at a stop that is reached with constant
    speed."""
    for name, expected in (("force", 0.3137), ("damped stop", 0.3)):
        scene, solution, _ = CASES[name]
        solved(scene, solution, "hht-si2", 1e-4)
        assert seen()[0] == pytest.approx(expected, abs=1e-12)


def test_a_stop_is_stepped_onto(seen):
    """With a stop that is stiff enough to matter."""
    scene, solution, times = CASES["stop"]
    solved(scene, solution, "hht-si2", 1e-5)
    assert seen()[:1] == pytest.approx(times[:1], abs=1e-12)


@pytest.mark.parametrize("name", ["force", "friction"])
def test_order_is_kept(name):
    """100 times as accurate: with order 2 some 10 times as many steps, with order 1 there were 100 times as many."""
    scene, solution, _ = CASES[name]
    coarse, error = solved(scene, solution, "hht-i3", 1e-4)
    fine, smaller = solved(scene, solution, "hht-i3", 1e-6)
    assert smaller < error / 20
    assert fine.stats["steps"] < 20 * coarse.stats["steps"]


PENDULUM = """
model Pendulum
  Ground ground;
  Rod rod(m = 3 kg, length = 1 m);
  Revolute pin(ground, rod.a);
  RotationalSpringDamper motor(pin, torque = (if phi > -1 rad then 3 N.m else -4 N.m) - (if time < 0.4 s then 0 N.m
    else 20 N.m));
initial equation
  pin.phi = -2 rad;
  pin.w = 0 rad/s;
  annotation(experiment(StopTime = 1 s));
end Pendulum;
"""


def pendulum(times):
    """phi'' = (torque - m g l/2 cos phi)/(m l^2/3), event by event."""

    def rate(late, above):
        torque = -(3.0 if above else -4.0) + (20.0 if late else 0.0)
        return lambda t, y: [y[1], torque - 1.5 * 9.81 * cos(y[0])]

    def meets(t, y):
        return y[0] + 1.0

    meets.terminal = True
    t, y, found = 0.0, np.array([-2.0, 0.0]), {}
    while t < 1.0:
        end = 0.4 if t < 0.4 else 1.0
        # at the switch itself, the motion may go to either side
        above = y[0] > -1.0 if abs(y[0] + 1.0) > 1e-9 else y[1] > 0.0
        run = solve_ivp(
            rate(t >= 0.4, above), (t, end), y, "DOP853", rtol=1e-12, atol=1e-13, dense_output=True, events=meets
        )
        found.update({x: run.sol(x) for x in times if t <= x <= run.t[-1]})
        t, y = run.t[-1], run.y[:, -1]
        if run.status == 1:  # a little further, so that it does not end where it begins
            y = y + 1e-10 * np.array(rate(t >= 0.4, y[1] > 0.0)(t, y))
            t += 1e-10
    return np.array([found[x] for x in times])


@pytest.mark.parametrize("method", METHODS)
def test_reactions_jump_with_what_causes_them(method):
    """A constrained body: after each jump its velocities satisfy the constraints, and its reactions are those of the
    new forces."""
    tol = 1e-3 if available()[method].order == 1 else 1e-5
    found = mbdsl.simulate(mbdsl.parse(PENDULUM), method=method, tol=tol, interval=0.01)
    keep = np.abs(found.t - 0.4) > 1e-9
    exact = pendulum(found.t[keep])
    phi, w = np.asarray(found["pin.phi"])[keep], np.asarray(found["pin.w"])[keep]
    assert np.abs(phi - exact[:, 0]).max() <= 10 * tol
    assert np.abs(w - exact[:, 1]).max() <= 10 * tol * np.abs(exact[:, 1]).max()
    assert found.stats["events"] >= 2


# -- no events -------------------------------------------------------------------------------------------------------


def test_sliding_along_a_switch_stops_and_says_so():
    """x'' = -2 sign(v) comes to rest at 0.5 s, where no value of the sign gives a motion."""
    scene = slide("2 N*sign(v)", 0.0, 1.0)
    with pytest.raises(IntegrationError, match="back and forth") as caught:
        mbdsl.simulate(scene, method="hht-si2", tol=1e-4)
    assert "TranslationalSpringDamper spring" in str(caught.value) and "tanh" in caught.value.hint
    # v vanishes there to the tolerance, which equals 2 N/kg times an error of the time
    assert caught.value.trajectory.t[-1] == pytest.approx(0.5, abs=5e-5)


def test_smooth_friction_has_no_events():
    """s at rest is v_s^2/2 times the integral of u coth(u) up to v_0/v_s = 100: 1/4 + (pi v_s)^2/24."""
    found = mbdsl.simulate(slide("2 N*tanh(v/(1 cm/s))", 0.0, 1.0), tol=1e-4)
    assert found.stats["events"] == 0
    assert found["rail.s"][-1] == pytest.approx(0.25 + (np.pi * 0.01) ** 2 / 24, abs=1e-4)


def test_a_corner_that_steps_do_not_notice_is_passed():
    """A force of |x| has a corner without effect on the error: a = 1e-6 |x|."""
    found = mbdsl.simulate(slide("1e-6 N/m*abs(s)", -0.5, 1.0), method="hht-si2", tol=1e-4)
    assert found.stats["events"] == 0 and found.stats["rejected"] == 0
    assert found["rail.s"][-1] == pytest.approx(0.5, abs=1e-6)


def test_many_knots_cost_no_steps():
    """A measured force: 500 corners of a table that have no effect on the error, between points of 7 rad/s."""
    points = "; ".join(f"{k / 500!r} s, {sin(7 * k / 500)!r} N" for k in range(501))
    found = mbdsl.simulate(slide("-u(time)", more=f"Table u(table = [{points}]);"), method="hht-si2", tol=1e-4)
    assert found["rail.s"][-1] == pytest.approx(1 / 7 - sin(7) / 49, abs=1e-3)
    assert found.stats["events"] < 50 and found.stats["steps"] < 1000


def test_noise_around_a_switch_is_no_event():
    """A coordinate that stays at a corner of its law except for rounding, in a mechanism of a metre."""
    law = "100 N/m*s + (if s > 0 m then 1e3 N/m*s else 0 N)"
    rod = "Rod far(m = 1 kg, length = 1 m); Fixed hold(ground, far.a);"
    found = mbdsl.simulate(slide(law, 1e-17, 0.0, more=rod), tol=1e-6)
    assert 0 < np.abs(found["rail.s"]).max() < 1e-15 and found.stats["events"] == 0


def test_the_end_of_a_table_is_told_exactly():
    table = 'Table u(table = [0 s, 1 N; 0.5 s, 2 N], extrapolation = "error");'
    with pytest.raises(IntegrationError, match="not finite") as caught:
        mbdsl.simulate(slide("-u(time)", more=table), tol=1e-4)
    assert caught.value.trajectory.t[-1] == pytest.approx(0.5, abs=1e-9)
