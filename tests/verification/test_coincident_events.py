"""Events that rounding separates: an impact at the time of a tick, and contacts that come to rest on one another."""

import numpy as np
import pytest

import mbdsl

TICK = """model Tick "The ball strikes the floor at t = 0.5 s, when the clock ticks"
  Ground ground(g = 10 m/s2);
  PointMass ball(m = 1 kg);
  Frame up(ground, phi = 90 deg);
  Prismatic guide(up, ball);
  Contact floor(gap = ball.y, e = 0.5);
  discrete Real F(unit = "N", start = -1), seen(unit = "m/s", start = 0);
  Force push(ball, fy = F);
initial equation
  ball.y = 1.25 m; ball.vy = 0 m/s;
equation
  when sample(0, 0.5 s) then F = pre(F) + 1; seen = ball.vy; end when;
end Tick;"""


@pytest.mark.parametrize(("method", "step"), [("hht-si2", 1e-3), ("hht-si2", 7e-4), ("nstiff", 1e-3), ("dop853", None)])
def test_a_clock_sees_the_velocity_behind_an_impact_at_its_tick(method, step):
    """It leaves with 2.5 m/s, and falls with 9 m/s2 from then on, whatever rounding says about the order."""
    run = mbdsl.simulate(mbdsl.parse(TICK), method=method, step=step, stop=0.8, interval=0.05)
    assert run["seen"][-1] == pytest.approx(2.5, abs=1e-9)
    assert run["ball.y"][-1] == pytest.approx(2.5 * 0.3 - 4.5 * 0.09, abs=1e-9)


JAM = """model Jam "Two masses come to rest between a force and a stop, from which another force pulls"
  Ground ground(g = 0 m/s2);
  PointMass a(m = 1 kg), b(m = 3 kg);
  Prismatic pa(ground, a), pb(ground, b);
  Force push(a, fx = 2 N), pull(b, fx = -0.5 N);
  Contact between(gap = b.x - a.x - 50 mm, e = 0.4), stop(gap = 0.8 m - b.x, e = 0.5);
initial equation
  a.x = 0.7 m; a.vx = 0 m/s; b.x = 0.79 m; b.vx = 0 m/s;
end Jam;"""


def test_contacts_that_support_one_another_come_to_rest():
    """`stop` comes to rest only because `between` does at the same time: alone, its force would pull."""
    run = mbdsl.simulate(mbdsl.parse(JAM), method="dop853", tol=1e-6, stop=1.0)
    assert run["between.force"][-1] == pytest.approx(2.0, abs=1e-9)
    assert run["stop.force"][-1] == pytest.approx(1.5, abs=1e-9)
    assert run["a.x"][-1] == pytest.approx(0.75, abs=1e-9)
    assert run.events[-1].t < 0.9


SHAKER = """model Shaker "A ball on a shaken table; it leaves it where the table falls with g, y = -A w^2 sin(w t)"
  Ground ground;
  Frame up(ground, phi = 90 deg);
  Body table(m = 1 kg, I = 1 kg.m2);
  PointMass ball(m = 0.1 kg);
  Prismatic guide(up, table.c), free(up, ball);
  TranslationalDriver d(guide, s = 0.02 m*sin(30 rad/s*time));
  Contact c(gap = ball.y - table.y, e = 0.3);
initial equation
  ball.y = 0 m; ball.vy = 0.6 m/s;
end Shaker;"""


@pytest.mark.parametrize("method", ["nstiff", "hht-i3"])
def test_bounces_die_away_on_a_driven_table(method):
    """Methods whose velocities leave the constraints strike where the gap has closed, as the others do.

    The ball leaves the table where it falls with g. In between, impacts die away as a geometric series.
    """
    run = mbdsl.simulate(mbdsl.parse(SHAKER), method=method, step=1e-3, stop=0.25)
    opens = [event.t for event in run.events if event.kind == "lift-off"]
    expected = (np.arcsin(9.81 / (0.02 * 30.0**2)) + 2.0 * np.pi * np.arange(2)) / 30.0
    assert opens == pytest.approx(expected, abs=1e-6)
    assert sum(event.kind == "impact" for event in run.events) < 20


BALL = """spatial model Ball "A ball slides and spins on a table"
  Ground ground(g = 9.81, n = {0, 0, -1});
  Body b(m = 1 kg, I = {0.004, 0.004, 0.004} kg.m2);
  Contact t(gap = b.z - 0.1 m, slip = b.vx - 0.1 m*b.wy, slip_2 = b.vy + 0.1 m*b.wx, mu = 0.2, e = 0.3);
initial equation
  b.x = 0 m; b.y = 0 m; b.z = 0.1 m; b.vx = 2 m/s; b.vy = 0 m/s; b.vz = 0 m/s;
  b.wx = 10 rad/s; b.wy = -5 rad/s; b.wz = 3 rad/s;
end Ball;"""


@pytest.mark.parametrize("method", ["hht-si2", "hht-i3", "generalized-alpha"])
def test_sliding_of_a_ball_ends_where_a_step_would_end(method):
    """The slip (2.5, 1) m/s keeps its direction and decreases by mu g (1 + m R^2/I); then the ball rolls."""
    run = mbdsl.simulate(mbdsl.parse(BALL), method=method, step=1e-3, stop=0.5)
    (sticks,) = (event.t for event in run.events if event.kind == "stick")
    assert sticks == pytest.approx(np.hypot(2.5, 1.0) / (0.2 * 9.81 * 3.5), abs=1e-5)
    assert run["b.vx"][-1] == pytest.approx(2.0 - 2.5 / 3.5, abs=1e-4)
    assert run["b.vy"][-1] == pytest.approx(-1.0 / 3.5, abs=1e-4)


def test_the_last_fixed_step_ends_at_the_stop_time():
    """49 steps of 0.5 s/49 miss 0.5 s by rounding: no further step of 6e-17 s may follow, whose reactions are noise."""
    run = mbdsl.simulate(mbdsl.parse(BALL), method="newmark", step=0.5 / 49, stop=0.5, interval=0)
    assert 49 * (0.5 / 49) < 0.5
    assert run.t[-1] == 0.5 and np.diff(run.t).min() > 1e-6
