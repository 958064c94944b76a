"""Equilibria, eigenvalues and linear models of a servo with two states, against its equations by hand.

With J = m l^2/3, u = 4 (target - phi) + 3 z - 0.8 w:

    J w' = k i - m g l/2 cos(phi),   L i' = u - R i - k w,   z' = target - phi
"""

import numpy as np
import pytest

import mbdsl
from mbdsl.errors import EquilibriumError

TEXT = """
model Servo
  parameter Angle target = 0.5;
  Ground ground;
  Rod rod(m = 0.2 kg, length = 0.3 m);
  Revolute pin(ground, rod.a);
  Current i(start = 1 A);
  Angle z(start = 0);
  input Voltage extra;
  Voltage u = 4 V*(target - pin.phi) + 3 V*z - 0.8 V.s*pin.w + extra;
  Torque motor(pin, tau = 0.1 N.m/A*i);
initial equation
  pin.phi = 0.3; pin.w = 0 rad/s;
equation
  der(i) = (u - 0.5 Ohm*i - 0.1 V.s*pin.w)/(5 mH);
  der(z) = (target - pin.phi)/(1 s);
end Servo;
"""
J, WEIGHT = 0.2 * 0.3**2 / 3, 0.2 * 9.81 * 0.15
CURRENT = WEIGHT * np.cos(0.5) / 0.1


def matrix(phi: float) -> np.ndarray:
    """A of (phi, w, i, z)."""
    return np.array(
        [
            [0, 1, 0, 0],
            [WEIGHT * np.sin(phi) / J, 0, 0.1 / J, 0],
            [-4 / 5e-3, -0.9 / 5e-3, -0.5 / 5e-3, 3 / 5e-3],
            [-1, 0, 0, 0],
        ]
    )


@pytest.fixture(scope="module")
def servo():
    return mbdsl.parse(TEXT)


def test_equilibrium(servo):
    found = mbdsl.static(servo)
    assert found["pin.phi"] == pytest.approx(0.5, abs=1e-12)
    assert found["i"] == pytest.approx(CURRENT, rel=1e-12)
    assert found["z"] == pytest.approx(CURRENT * 0.5 / 3, rel=1e-12)
    assert "i  " in str(found)
    run = mbdsl.simulate(servo, initial="static", stop=0.1, step=1e-2)
    assert run["i"] == pytest.approx(CURRENT, rel=1e-10)


def test_steady_models_begin_at_the_equilibrium():
    text = TEXT.replace("initial equation\n  pin.phi = 0.3; pin.w = 0 rad/s;", "initial(state = steady);")
    run = mbdsl.simulate(mbdsl.parse(text), stop=0.1, step=1e-2)
    assert run["i"] == pytest.approx(CURRENT, rel=1e-10)


def test_no_equilibrium():
    with pytest.raises(EquilibriumError, match="z"):
        mbdsl.static(mbdsl.parse(TEXT.replace("(target - pin.phi)/(1 s)", "1/(1 s)")))


def test_linear_model(servo):
    found = mbdsl.linearise(servo)
    assert found.states == ["pin.phi", "pin.w", "i", "z"]
    assert found.state_units == ["rad", "rad/s", "A", "rad"]
    assert pytest.approx(matrix(0.5), abs=1e-9) == found.A
    assert found.B[:, 0] == pytest.approx([0, 0, 200, 0])
    assert found.x0 == pytest.approx([0.5, 0, CURRENT, CURRENT / 6], abs=1e-12)


@pytest.mark.parametrize("at", ["static", "start"])
def test_eigenvalues(servo, at):
    exact = np.linalg.eigvals(matrix({"static": 0.5, "start": 0.3}[at]))
    modes = mbdsl.eigen(servo, at)
    expected = sorted((s for s in exact if s.imag >= 0), key=abs)
    assert [mode.eigenvalue for mode in modes.modes] == pytest.approx(expected, rel=1e-8)


def test_eigenvalues_of_states_in_other_units():
    """A pressure of 1e7 Pa and a pure number: the eigenvalues are those of the two lags."""
    text = """
    model M
      Ground ground;
      PointMass p(m = 1 kg);
      Bushing spring(ground, p, k = {4 N/m, 9 N/m});
      Pressure a(start = 1e7);
      Real b(start = 1e-3);
      Force f(p, fx = 1e-7 m2*a);
    equation
      der(a) = -a/(0.1 s);
      der(b) = -b/(10 s) + 1e-7*a/(1 Pa.s);
    end M;
    """
    found = [mode.eigenvalue for mode in mbdsl.eigen(mbdsl.parse(text), "start").modes]
    assert sorted(found, key=abs) == pytest.approx([-0.1, 2j, 3j, -10], rel=1e-6)


def test_step_response(servo):
    """z at a step of `extra` by the exponential of A."""
    from scipy.linalg import expm

    found = mbdsl.linearise(servo, signals="i").step_response(np.linspace(0, 0.1, 11))
    A, B = matrix(0.5), np.array([0, 0, 200, 0])
    whole = np.block([[A, B[:, None]], [np.zeros((1, 5))]])
    exact = [expm(whole * t)[2, 4] for t in found.t]
    assert found.y[:, 0, 0] == pytest.approx(exact, rel=1e-9)
