"""Events close behind corners of forces, and contacts that are just touched."""

import math

import numpy as np
import pytest

import mbdsl

SPRING = """model Spring "A mass runs on to a spring without pretension, whose force has a corner there"
  parameter Length d = 1 mm "compression at which it is thrown back";
  Ground ground(g = 0 m/s2);
  PointMass ball(m = 1 kg);
  Prismatic guide(ground, ball);
  Force spring(ball, fx = -100 N/m*max(0, ball.x - 1 m));
  Integer blows(start = 0);
initial equation
  ball.x = 0 m; ball.vx = 1 m/s;
equation
  when ball.x > 1 m + d then reinit(ball.vx, -ball.vx); blows = pre(blows) + 1; end when;
end Spring;"""


STEPS = [
    ("hht-si2", {"tol": 1e-6}, 1e-6),
    ("hht-si2", {"step": 7e-3}, 5e-4),
    ("radau5", {"tol": 1e-6}, 1e-7),
    ("nstiff", {"step": 7e-3}, 5e-4),
]


@pytest.mark.parametrize(("method", "steps", "error"), STEPS)
@pytest.mark.parametrize("d", [1e-9, 1e-5, 1e-3, 2e-2])
def test_an_event_behind_a_corner_is_not_passed_over(method, steps, error, d):
    """In the spring, x = 1 m + sin(w t)/w; it leaves as it came, after twice the time asin(w d)/w."""
    model = mbdsl.parse(SPRING.replace("d = 1 mm", f"d = {d} m"))
    run = mbdsl.simulate(model, method=method, stop=1.5, **steps)
    late = math.asin(10.0 * d) / 10.0
    assert run["blows"][-1] == 1
    assert run.events[-1].t == pytest.approx(1.0 + late, abs=error)
    assert run["ball.x"][-1] == pytest.approx(1.0 - (0.5 - 2.0 * late), abs=error)


@pytest.mark.parametrize(("method", "steps", "error"), STEPS)
@pytest.mark.parametrize("d", [1e-5, 1e-3])
def test_a_jump_of_a_force_behind_a_corner_is_not_passed_over(method, steps, error, d):
    """With y = x - 1 m, y'' = -100 y - 50 beyond d: it is back at d after twice the angle of (d + 0.5, v/w)."""
    jump = "Force wall(ball, fx = if ball.x > 1 m + d then -50 N else 0);\ninitial equation"
    model = SPRING.replace("d = 1 mm", f"d = {d} m").replace("initial equation", jump)
    run = mbdsl.simulate(
        mbdsl.parse(model.replace("ball.x > 1 m + d then reinit", "ball.x > 2 m then reinit")),
        method=method,
        stop=1.5,
        **steps,
    )
    late, v = math.asin(10.0 * d) / 10.0, math.sqrt(1.0 - 100.0 * d * d)
    beyond = 2.0 * math.atan2(v / 10.0, d + 0.5) / 10.0
    assert run["blows"][-1] == 0
    assert run["ball.x"][-1] == pytest.approx(1.0 - (0.5 - 2.0 * late - beyond), abs=error)


GRAZE = """model Graze "A mass on a spring returns to a stop exactly, again and again"
  Ground ground(g = 0 m/s2);
  PointMass hammer(m = 1 kg);
  Prismatic guide(ground, hammer);
  TranslationalSpringDamper spring(guide, k = 100 N/m, s0 = 0 m);
  Contact stop(gap = 0.1 m - hammer.x, e = 0.2);
initial equation
  hammer.x = -0.1 m; hammer.vx = 0 m/s;
end Graze;"""


def test_what_a_touch_may_do_falls_below_the_tolerance():
    """The stop is touched at rest, so that x = -0.1 m cos(w t); a deeper path would lose its speed, the root of the
    depth. Before, the runs ended with an error of 1.4e-4, with a depth of 1e-10 m."""
    run = mbdsl.simulate(mbdsl.parse(GRAZE), method="radau5", tol=1e-4, stop=2.0)
    assert run["hammer.x"] == pytest.approx(-0.1 * np.cos(10.0 * run.t), abs=1e-5)
    assert run.stats["error"] < 1e-4
    assert run.stats["steps"] < 5000
