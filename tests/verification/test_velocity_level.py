"""Velocity drivers and velocity constraints written by users, compared with closed forms, by all methods."""

import numpy as np
import pytest

import mbdsl

DRIVEN = """
model Driven
  Ground ground(g = 0 m/s2);
  Body wheel(m = 1 kg, I = 0.5 kg.m2);
  Body block(m = 2 kg, I = 1 kg.m2);
  Revolute pin(ground, wheel.c);
  RotationalVelocityDriver motor(pin, w = 3 rad/s2*time + 1 rad/s);
  Prismatic slide(ground, block.c);
  TranslationalVelocityDriver actuator(slide, v = 0.5 m/s*sin(2 rad/s*time));
initial equation
  wheel.phi = 0.2 rad;
  block.x = 0 m;
end Driven;
"""
GEARED = """
model Geared
  Ground ground(g = 0 m/s2);
  Body a(m = 1 kg, I = 0.5 kg.m2);
  Body b(m = 1 kg, I = 0.8 kg.m2);
  Revolute A(ground, a.c);
  Frame there(ground, r = {1 m, 0});
  Revolute B(there, b.c);
  VelocityConstraint gear(gamma = a.w + 2*b.w);
  Torque drive(a.c, tau = 0.3 N.m);
initial equation
  a.w = 1 rad/s;
end Geared;
"""
CRUISE = """
model Cruise "as fast as it started, whatever gravity does: nonlinear in velocities"
  Ground ground(g = 9.81 m/s2);
  PointMass p(m = 2 kg);
  VelocityConstraint cruise(gamma = p.vx*p.vx + p.vy*p.vy - 25 m2/s2);
initial equation
  p.x = 0 m;
  p.y = 0 m;
  p.vx = 3 m/s;
  guess p.vy = 4 m/s;
end Cruise;
"""


def test_velocity_drivers(method):
    found = mbdsl.simulate(mbdsl.parse(DRIVEN), method=method, step=1e-3, stop=1.0, interval=0.1)
    t = found.t
    assert found["wheel.w"] == pytest.approx(1 + 3 * t, abs=1e-9)
    assert found["block.vx"] == pytest.approx(0.5 * np.sin(2 * t), abs=1e-9)
    # positions are integrated by the method: quadrature of the velocity, of order 2 (newmark: 1)
    error = 2e-3 if method == "newmark" else 2e-6
    assert found["wheel.phi"] == pytest.approx(0.2 + t + 1.5 * t**2, abs=error)
    assert found["block.x"] == pytest.approx(0.25 * (1 - np.cos(2 * t)), abs=error)
    assert found["motor.tau"][1:] == pytest.approx(0.5 * 3.0, rel=1e-6)
    assert found["actuator.fx"][1:] == pytest.approx(2.0 * np.cos(2 * t[1:]), abs=5e-3)
    assert max(np.abs(found[row]).max() for row in found.select(["*.Gam[*]"])) < 1e-9


def test_gear(method):
    """(I_a + I_b/4) alpha = tau, and the gear's torques on both."""
    found = mbdsl.simulate(mbdsl.parse(GEARED), method=method, step=1e-3, stop=1.0, interval=0.1)
    alpha = 0.3 / (0.5 + 0.8 / 4)
    assert found["a.w"] == pytest.approx(1 + alpha * found.t, abs=1e-9)
    assert found["b.w"] == pytest.approx(-found["a.w"] / 2, abs=1e-9)
    assert found["a.alpha"] == pytest.approx(alpha)
    assert found["a.phi"] == pytest.approx(found.t + alpha / 2 * found.t**2, abs=1e-4 if method == "newmark" else 1e-9)


def test_nonlinear_constraint(method, order):
    """Force along the velocity only: theta' = -g cos(theta)/v, so sin(theta) = tanh(artanh(sin theta_0) - g t/v)."""
    steps, errors = [2.0**-k for k in range(6, 12)], []
    sine = np.tanh(np.arctanh(0.8) - 9.81 * 0.5 / 5.0)
    for h in steps:
        found = mbdsl.simulate(mbdsl.parse(CRUISE), method=method, step=h, stop=0.5, interval=0.5)
        assert np.hypot(found["p.vx"][-1], found["p.vy"][-1]) == pytest.approx(5.0, abs=1e-9)
        errors.append(abs(found["p.vy"][-1] - 5.0 * sine))
    low, high = (0.9, 1.15) if method == "newmark" else (1.85, 2.15)
    assert low < order(steps, errors) < high
