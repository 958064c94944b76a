"""Long regular motions: errors grow with time, not exponentially, and no run ends for an amplification that is none."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import mbdsl

PENDULUM = """model Pendulum
  Ground ground(g = 9.81 m/s2);
  PointMass b(m = 1 kg);
  Distance d(ground, b, length = 1 m);
initial equation
  b.x = {x!r} m; guess b.y = {y!r} m; b.vx = 0 m/s;
  annotation(experiment(StopTime = {stop} s));
end Pendulum;"""


@pytest.mark.parametrize("method", ["radau5", "dop853", "radau9"])
@pytest.mark.parametrize("angle", [1.0, 2.4, 2.8])
def test_a_pendulum_that_swings_far(method, angle):
    """From rest at ``angle``, 120 s: against its angle by SciPy, whose perturbations grow in proportion to time."""
    text = PENDULUM.format(x=float(np.sin(angle)), y=float(-np.cos(angle)), stop=120)
    run = mbdsl.simulate(mbdsl.parse(text), method=method, tol=1e-6)
    phi = solve_ivp(
        lambda t, y: [y[1], -9.81 * np.sin(y[0])], (0.0, 120.0), [angle, 0.0], "DOP853", run.t, rtol=1e-13, atol=1e-13
    ).y[0]
    error = max(np.abs(run["b.x"] - np.sin(phi)).max(), np.abs(run["b.y"] + np.cos(phi)).max())
    assert error <= min(run.stats["error"], 1e-6)


def test_an_orbit():
    """An ellipse of eccentricity 0.6, 40 times around: back at the start, by Kepler's third law."""
    text = """model Orbit
      parameter Real mu(unit = "m3/s2") = 1;
      Ground sun(g = 0);
      PointMass planet(m = 1 kg);
      FreeMotion free(sun, planet);
      Variable Length r = hypot(planet.x, planet.y);
      Force pull(planet.c, fx = -1 kg*mu*planet.x/r^3, fy = -1 kg*mu*planet.y/r^3);
    initial equation
      planet.x = 0.4 m; planet.y = 0 m; planet.vx = 0 m/s; planet.vy = 2 m/s;
    end Orbit;"""
    stop = 40 * 2.0 * np.pi
    run = mbdsl.simulate(mbdsl.parse(text.replace("Variable Length", "Length")), method="dop853", tol=1e-6, stop=stop)
    assert run.stats["error"] <= 1e-6
    assert [run["planet.x"][-1], run["planet.y"][-1]] == pytest.approx([0.4, 0.0], abs=2e-6)


def test_a_motion_whose_errors_grow_exponentially_is_refused():
    """A double pendulum of large swings for 60 s: its rounding errors become as large as the motion."""
    text = """model Chaos
      Ground ground;
      Rod one(m = 1 kg, length = 1 m);
      Rod two(m = 1 kg, length = 1 m);
      Revolute A(ground, one.a);
      Revolute B(one.b, two.a);
    initial equation
      A.phi = 100 deg; B.phi = 40 deg;
      annotation(experiment(StopTime = 60 s));
    end Chaos;"""
    with pytest.raises(mbdsl.IntegrationError, match=r"is not reached") as found:
        mbdsl.simulate(mbdsl.parse(text), method="radau5", tol=1e-6)
    assert 1.0 < found.value.trajectory.stats["horizon"] < 60.0
