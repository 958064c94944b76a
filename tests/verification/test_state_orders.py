"""Orders of all methods in models with states: a pendulum with a DC motor and a filter of a reaction.

The reference is SciPy's DOP853 in one coordinate and two states. Inertia about the pin J = m l^2/3, torque k i, and
with the position c of the centre of mass the reaction f = m (c'' - g) on the rod:

    J phi'' = k i - m g l/2 cos(phi),   L i' = U - R i - k phi',   T z' = f_y - z
"""

from functools import cache

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import mbdsl

M, LENGTH, G, K, R = 0.5, 0.4, 9.81, 0.6, 2.0
TEXT = """
model Driven
  parameter Real L(unit = "H") = 0.1, T(unit = "s") = 0.2;
  Ground ground;
  Rod rod(m = 0.5 kg, length = 0.4 m);
  Revolute pin(ground, rod.a);
  Current i(start = 0.3 A);
  Force z(start = 1 N);
  Torque motor(pin, tau = 0.6 N.m/A*i);
initial equation
  pin.phi = 0.2; pin.w = 1 rad/s;
equation
  der(i) = (3 V*cos(2 rad/s*time) - 2 Ohm*i - 0.6 V.s*pin.w)/L;
  der(z) = (pin.fy - z)/T;
end Driven;
"""


@cache
def exact(inductance: float, filtered: float = 0.2) -> np.ndarray:
    """phi, w, f_y, i, z at 2 s."""
    J = M * LENGTH**2 / 3

    def rates(t, y):
        phi, w, i, z = y
        a = (K * i - M * G * LENGTH / 2 * np.cos(phi)) / J
        return [w, a, (3 * np.cos(2 * t) - R * i - K * w) / inductance, (reaction(phi, w, a) - z) / filtered]

    def reaction(phi, w, a):
        return M * (LENGTH / 2 * (a * np.cos(phi) - w * w * np.sin(phi)) + G)

    method = "DOP853" if inductance > 1e-3 else "Radau"
    found = solve_ivp(rates, (0.0, 2.0), [0.2, 1.0, 0.3, 1.0], method=method, rtol=1e-11, atol=1e-12)
    phi, w, i, z = found.y[:, -1]
    return np.array([phi, w, reaction(phi, w, rates(2.0, found.y[:, -1])[1]), i, z])


def errors(method: str, steps: int, inductance: float = 0.1) -> np.ndarray:
    scene = mbdsl.parse(TEXT).with_parameters(L=inductance)
    run = mbdsl.simulate(scene, stop=2, step=2 / steps, interval=2, method=method)
    return np.abs([run[name][-1] for name in ("pin.phi", "pin.w", "pin.fy", "i", "z")] - exact(inductance))


SECOND = ["hht-i3", "hht-si2", "hht-add", "nstiff", "nstiff-si2", "generalized-alpha", "generalized-alpha-i3"]


def slopes(method: str, first: int, inductance: float = 0.1) -> np.ndarray:
    one, two = (errors(method, steps, inductance) for steps in (first, 2 * first))
    return np.log2(one / two)


@pytest.mark.parametrize("method", SECOND)
def test_order_2(method):
    """Terms of order 2 of the filter z nearly cancel in hht-add, so that shorter steps show them."""
    assert slopes(method, 4096 if method == "hht-add" else 1024) == pytest.approx(2.0, abs=0.1)


def test_order_1():
    assert slopes("newmark", 4096) == pytest.approx(1.0, abs=0.1)


@pytest.mark.parametrize(("method", "first", "order"), [("radau5", 32, 5), ("radau9", 8, 9), ("dop853", 16, 8)])
def test_high_orders(method, first, order):
    assert np.median(slopes(method, first)) > order - 0.5


@pytest.mark.parametrize("method", ["hht-i3", "hht-si2", "generalized-alpha", "nstiff", "nstiff-si2"])
def test_stiff_states(method):
    """L = 1 uH: h f_x is -1.6e4. The current follows the motion, and q, v, lam, z keep order 2."""
    assert slopes(method, 512, 1e-6)[[0, 2, 4]] == pytest.approx(2.0, abs=0.1)


def test_stiff_states_in_radau5():
    assert np.median(slopes("radau5", 64, 1e-6)) == pytest.approx(5.0, abs=0.3)


STIFF = """
model Stiff
  Ground ground;
  Body b(m = 1 kg, I = 1 kg.m2);
  Prismatic s(ground, b.c);
  Real x(start = 1);
initial equation
  s.s = 0 m; s.v = 0 m/s;
equation
  der(x) = (0.25 - x)/(10 ns);
end Stiff;
"""


@pytest.mark.parametrize("method", ["newmark", *SECOND])
def test_a_stiff_state_that_begins_elsewhere(method):
    """h |f_x| = 1e6. The first steps are backward Euler, which divides the distance by it; with the formulas of HHT it
    would change its sign in each step and decrease by a third. Methods of this family warn."""
    run = mbdsl.simulate(mbdsl.parse(STIFF), stop=0.1, step=0.01, interval=0.01, method=method)
    assert run["x"][0] == 1.0
    assert np.abs(run["x"][1:] - 0.25).max() < 2e-6
    warned = [x for x in run.stats["warnings"] if "h |f_x| = 1e+06" in x and "write `der(x) = 0` in" in x]
    assert len(warned) == (0 if "nstiff" in method else 1)
