"""A law whose condition reads an angle that a driver determines, against a closed form."""

import numpy as np
import pytest

import mbdsl

MODEL = """
model M
  Ground ground(g = 0 m/s2);
  Body cam(m = 1 kg, I = 1 kg.m2), wheel(m = 1 kg, I = 1 kg.m2);
  Revolute axis(ground, cam.c), other(ground, wheel.c);
  RotationalDriver motor(axis, phi = 6.3 rad/s*time);
  RotationalSpringDamper link(cam.c, wheel.c, k = 1 N.m/rad);
  Torque push(other, tau = if sin(20*cam.phi) > 0 then 1 N.m else -1 N.m);
initial equation
  other.phi = 0; other.w = 0 rad/s;
equation
  when wheel.phi > 100 then terminate("never"); end when;
end M;
"""


def lag(stop):
    """u = wheel.phi - 6.3 t, and u': u'' = s - u, with s = 1 and -1 by turns, each for pi/126 seconds."""
    u, t, sense, half = np.array([0.0, -6.3]), 0.0, 1.0, np.pi / 126
    while t < stop:
        h = min(half, stop - t)
        c, s = np.cos(h), np.sin(h)
        u = np.array([[c, s], [-s, c]]) @ (u - [sense, 0.0]) + [sense, 0.0]
        t, sense = t + h, -sense
    return u


@pytest.mark.parametrize(
    ("method", "given", "within"),
    [("hht-si2", {"tol": 1e-4}, 1e-4), ("radau5", {"tol": 1e-4}, 1e-6), ("hht-si2", {"step": 0.01}, 1e-3)],
)
def test_events_of_a_driven_angle(method, given, within):
    """Rounding errors of the angle do not repeat an event without end. The stated error is true although events cut all
    steps, so that two runs have the same steps."""
    run = mbdsl.simulate(mbdsl.parse(MODEL), stop=3, interval=0.1, method=method, **given)
    u, rate = lag(3.0)
    assert run["other.phi"][-1] - 18.9 == pytest.approx(u, abs=within)
    assert run["other.w"][-1] - 6.3 == pytest.approx(rate, abs=6.3 * within)
