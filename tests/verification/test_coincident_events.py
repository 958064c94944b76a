"""Events that rounding separates: an impact at the time of a tick, and contacts that come to rest on one another."""

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
