"""States, `der(x) = f`, against SciPy's solutions of the same equations in minimal coordinates."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import mbdsl
from mbdsl.integrators import compiled

BOOM = """model Boom
  parameter Area A = 2000 mm2, B = 1200 mm2;
  parameter Pressure E = 1.2 GPa;
  parameter VolumeFlowRate Q = 3.1623e-5 m3/s "of the open valve at 1 bar";
  Ground ground(frames(base = {0.4 m, -0.8 m}));
  Rod boom(m = 200 kg, length = 3 m, frames(lug = {-0.3 m, 0}));
  Revolute pin(ground, boom.a);
  Pressure pA(start = 18.573 bar), pB(start = 1 bar);
  Real y(start = 0) "spool", nA = (150 bar - pA)/(1 bar), nB = (pB - 1 bar)/(1 bar);
  VolumeFlowRate leak = 3e-11 m3/s/Pa*(pA - pB);
  SpringDamper cylinder(ground.base, boom.lug, force = pB*B - pA*A);
initial equation
  pin.phi = 10 deg; pin.w = 0 rad/s;
equation
  der(y) = (1 - y)/(0.1 s);
  der(pA) = E/(2e-4 m3 + A*(cylinder.s - 0.9 m))*(Q*y*nA/(nA^2 + 1)^0.25 - leak - A*cylinder.v);
  der(pB) = E/(2e-4 m3 + B*(1.9 m - cylinder.s))*(-Q*y*nB/(nB^2 + 1)^0.25 + leak + B*cylinder.v);
end Boom;"""


def boom(t):
    """Angle of the boom, both pressures and the spool at times t, with one coordinate, by LSODA."""
    A, B, E, Q = 2000e-6, 1200e-6, 1.2e9, 3.1623e-5

    def f(_, x):
        phi, w, a, b, y = x
        direction, base = np.array([np.cos(phi), np.sin(phi)]), np.array([0.4, -0.8])
        way = 1.2 * direction - base
        s = np.hypot(*way)
        v = 1.2 * w * (way @ np.array([-direction[1], direction[0]])) / s
        force = (a * A - b * B) * way / s
        torque = 1.2 * (direction[0] * force[1] - direction[1] * force[0]) - 200 * 9.81 * 1.5 * direction[0]
        n_a, n_b, leak = (150e5 - a) / 1e5, (b - 1e5) / 1e5, 3e-11 * (a - b)
        into_a, into_b = Q * y * n_a / (n_a**2 + 1) ** 0.25, Q * y * n_b / (n_b**2 + 1) ** 0.25
        rate_a = E / (2e-4 + A * (s - 0.9)) * (into_a - leak - A * v)
        rate_b = E / (2e-4 + B * (1.9 - s)) * (-into_b + leak + B * v)
        return [w, torque / 600, rate_a, rate_b, (1 - y) / 0.1]

    start = [np.radians(10), 0, 18.573e5, 1e5, 0]
    found = solve_ivp(f, (0, t[-1]), start, "LSODA", t, rtol=1e-11, atol=1e-9)
    return found.y


@pytest.mark.parametrize("method", ["newmark", *sorted(set(compiled()) - {"newmark", "kinematic"})])
def test_hydraulic_boom(method):
    """Two pressures of 1e6 Pa, a spool and the boom, which act on one another."""
    t = np.linspace(0.1, 1.0, 10)
    phi, _, a, b, y = boom(t)
    run = mbdsl.simulate(mbdsl.parse(BOOM), method=method, step=1e-3, stop=1.0, interval=0.1)
    within = 2e-3 if method == "newmark" else 1e-4
    assert run["pin.phi"][1:] == pytest.approx(phi, abs=0.05 * within)
    assert run["pA"][1:] == pytest.approx(a, rel=10 * within)
    assert run["pB"][1:] == pytest.approx(b, rel=10 * within, abs=1e3)
    assert run["y"][1:] == pytest.approx(y, abs=within)


FILTER = """model Filter
  Ground ground;
  Rod rod(m = 1 kg, length = 1 m);
  Revolute pin(ground, rod.a);
  Real f(unit = "N", start = 0);
initial equation
  pin.phi = 0; pin.w = 0 rad/s;
equation
  der(f) = (pin.fy - f)/(50 ms);
end Filter;"""


@pytest.mark.parametrize("method", ["hht-i3", "hht-si2", "nstiff", "nstiff-si2", "generalized-alpha"])
def test_filtered_reaction_has_the_order_of_the_method(method):
    """A first-order filter of a reaction of a pendulum: errors fall by four when the step is halved.

    Not with HHT-ADD, whose multipliers in laws have order 1.
    """

    def f(_, x):
        phi, w, y = x
        a = -1.5 * 9.81 * np.cos(phi)
        force = 9.81 + 0.5 * (a * np.cos(phi) - w**2 * np.sin(phi))
        return [w, a, (force - y) / 0.05]

    true = solve_ivp(f, (0, 0.5), [0, 0, 0], "DOP853", rtol=1e-12, atol=1e-12).y[2, -1]
    errors = [
        abs(mbdsl.simulate(mbdsl.parse(FILTER), method=method, step=h, stop=0.5, interval=0.5)["f"][-1] - true)
        for h in (4e-3, 2e-3, 1e-3)
    ]
    assert np.log2(np.array(errors[:-1]) / errors[1:]) == pytest.approx(2.0, abs=0.15)
