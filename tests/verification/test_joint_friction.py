"""Friction in a pin, driven by the pin's own reaction: a pendulum on a thick dry pin.

One degree of freedom, by hand: about the pin,  J alpha = -m g l cos(phi) - mu R N tanh(w/w_s)  with the reaction
N = |m a_c - m g|, a_c = l (alpha n - w^2 e): an implicit equation for alpha. No multiplier and no constraint in it.
"""

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

import mbdsl

M, L, G, MU, R, W_S = 2.0, 0.8, 9.81, 0.3, 0.05, 0.2
MODEL = f"""
model DryPin
  Ground ground(g = {G});
  Rod rod(m = {M}, length = {L});
  Revolute pin(ground, rod.a, mu = {MU}, radius = {R}, w_s = {W_S});
initial equation
  rod.phi = 0 rad;
  rod.w = 0.5 rad/s;
end DryPin;
"""
STEPS = [2.0**-k for k in range(6, 12)]
FINE = [2.0**-k for k in range(10, 16)]  #: for order 1, whose terms of order 2 have to be a tenth of those of order 1


def acceleration(phi, w):
    """alpha and the size of the reaction."""
    e, n = np.array([np.cos(phi), np.sin(phi)]), np.array([-np.sin(phi), np.cos(phi)])

    def reaction(alpha):
        return np.hypot(*(M * L / 2 * (alpha * n - w * w * e) + (0.0, M * G)))

    def balance(alpha):
        friction = MU * R * reaction(alpha) * np.tanh(w / W_S)
        return M * L**2 / 3 * alpha + M * G * L / 2 * np.cos(phi) + friction

    alpha = brentq(balance, -200.0, 200.0, xtol=1e-13, rtol=1e-14)
    return alpha, reaction(alpha)


@pytest.fixture(scope="module")
def exact():
    end = solve_ivp(
        lambda t, y: [y[1], acceleration(*y)[0]], (0, 2), [0.0, 0.5], method="DOP853", rtol=1e-11, atol=1e-13
    ).y[:, -1]
    return *end, acceleration(*end)[1]


def test_order(exact, method, order):
    scene = mbdsl.parse(MODEL)
    first = method == "newmark"
    steps, errors = FINE if first else STEPS, []
    for h in steps:
        end = mbdsl.simulate(scene, method=method, step=h, stop=2.0, interval=2.0)
        found = end["rod.phi"][-1], end["rod.w"][-1], np.hypot(end["pin.fx"][-1], end["pin.fy"][-1])
        errors.append(np.abs(np.subtract(found, exact)))
    low, high = (0.9, 1.15) if first else (1.85, 2.15)
    slopes = [order(steps, column) for column in np.transpose(errors)]
    assert all(low < slope < high for slope in slopes), slopes


def test_it_resists(method):
    """Much energy is lost, and friction does that much work: the signal is the acting force.

    Work and loss differ by the loss of the method itself, with its order: newmark's halves with the step.
    """
    missing = []
    for h in (2e-3, 1e-3) if method == "newmark" else (1e-3,):
        found = mbdsl.simulate(mbdsl.parse(MODEL), method=method, step=h, stop=1.5, interval=0.0)
        energy = found["energy.total"]
        work = np.trapezoid(found["pin.friction"] * found["pin.w"], found.t)
        assert energy[0] - energy[-1] > 0.3 * (found["energy.kinetic"].max())
        missing.append(1.0 - work / (energy[0] - energy[-1]))
    if method == "newmark":
        assert 1.85 < missing[0] / missing[1] < 2.15
    else:
        assert abs(missing[0]) < 2e-5


def test_without_friction_there_is_none_of_it():
    from mbdsl.mechanism import graph
    from mbdsl.system import build

    plain = mbdsl.parse(MODEL.replace(f"mu = {MU}, radius = {R}, w_s = {W_S}", "mu = 0"))
    text = build(plain, graph.build(plain)).code
    assert "law" not in text
    assert "tape" not in text
    dry = mbdsl.parse(MODEL)
    assert "loops.laws" in build(dry, graph.build(dry)).code
