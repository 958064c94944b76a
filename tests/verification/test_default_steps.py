"""Models without Step and Tolerance: steps are controlled by default, and stiff contacts are resolved."""

import numpy as np
import pytest

from mbdsl import simulate
from mbdsl.integrators import compiled, declared
from mbdsl.lang.load import parse_text
from mbdsl.simulation.mechanism_run import MechanismRun
from mbdsl.simulation.plan import plan
from mbdsl.simulation.run_options import RunOptions

M, K, G, H = 1.0, 1e6, 9.81, 1.0
BALL = f"""model Ball Ground ground; PointMass ball(m = {M} kg);
  Force stop(ball.c, fy = if ball.y < 0 m then -{K} N/m*ball.y else 0 N);
initial equation ball.x = 0 m; ball.y = {H} m; ball.vx = 0 m/s; ball.vy = 0 m/s;
  annotation(experiment(StopTime = 1.1 s{{}})); end Ball;"""


def ball(more=""):
    return parse_text(BALL.format(more))


def closed_form(t):
    """Height (N,) [m] until the ball comes down again: fall, y = -g/w^2 + A cos(w t + phi) in contact, flight."""
    w, v, fall = np.sqrt(K / M), np.sqrt(2 * G * H), np.sqrt(2 * H / G)
    sag = M * G / K
    contact = 2 / w * (np.pi - np.arctan(v / (w * sag)))  # y = 0, -v -> y = 0, +v about the sagged position
    s = t - fall
    bent = -sag + sag * np.cos(w * s) - v / w * np.sin(w * s)
    r = s - contact
    return np.where(s < 0, H - G * t**2 / 2, np.where(r < 0, bent, v * r - G * r**2 / 2))


@pytest.mark.parametrize("method", ["hht-si2", "newmark"])
def test_a_ball_on_a_stiff_stop_comes_back_to_where_it_fell_from(method):
    run = simulate(ball(), method=method)
    # relative to the mechanism's size, 1 m; a factor of 2, as half of the tolerance is the target
    assert np.abs(run["ball.y"] - closed_form(run.t)).max() < 2e-4
    assert run.stats["tol"] == 1e-4 and run.stats["h"] is None


@pytest.mark.parametrize("method", compiled())
def test_what_is_taken_where_nothing_is_said(method):
    steps = declared(method).steps
    radau, controlled = steps[0] == "controlled", "controlled" in steps
    said = plan(ball(), RunOptions(method=method))
    assert (said.tol, said.asked) == ((1e-6 if radau else 1e-4) if controlled else None, False)
    if not controlled:
        assert plan(ball(", Step = 2 ms"), RunOptions(method=method)).h == 2e-3
        return
    said = plan(ball(", Tolerance = 1e-3"), RunOptions(method=method))
    assert (said.tol, said.asked) == (1e-3, True)
    said = plan(ball(", Step = 2 ms"), RunOptions(method=method))
    assert said.tol == (1e-6 if radau else None) and (radau or said.h == 2e-3)
    assert plan(ball(", Step = 2 ms"), RunOptions(method=method, tol=1e-5)).asked


def test_without_time_there_is_nothing_to_control():
    assert plan(ball(), RunOptions(stop=0.0)).tol is None
    assert MechanismRun(ball(), plan(ball(), RunOptions(stop=0.0))).steps == 0
