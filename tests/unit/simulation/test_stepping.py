"""Runs step by step: the same as uninterrupted runs, and inputs that jump without a loss of order.

The controlled arm is a rod on a pin, phi'' = 3 (u - g/2 cos phi); its reference is the same controller on this
equation, integrated between the controller's instants to 1e-12.
"""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import mbdsl
from mbdsl.errors import IntegrationError, UsageError
from mbdsl.integrators import compiled as methods

METHODS = sorted(methods())
ARM = """
model Arm
  input Torque u(start = 0.5 N.m);
  Ground ground;
  Rod arm(m = 1 kg, length = 1 m);
  Revolute pin(ground, arm.a);
  Torque motor(ground, arm.a, tau = u);
initial equation
  arm.phi = 0.3 rad;
  arm.w = 0 rad/s;
end Arm;
"""
PERIOD = 8e-3


def controlled():
    """Angle and angular velocity of the controlled arm at 1 s."""
    y = np.array([0.3, 0.0])
    for _ in range(round(1.0 / PERIOD)):
        u = -20.0 * y[0] - 3.0 * y[1]
        y = solve_ivp(
            lambda t, y, u=u: [y[1], 3.0 * (u - 9.81 / 2 * np.cos(y[0]))], (0, PERIOD), y, rtol=1e-12, atol=1e-14
        ).y[:, -1]
    return y


@pytest.fixture(scope="module")
def reference():
    return controlled()


@pytest.mark.parametrize("method", METHODS)
def test_order_over_jumps_of_inputs(method, reference, slopes):
    """125 jumps a second; without a restart of the method's history, the order would be 1."""
    errors = []
    for h in (2e-3, 1e-3, 0.5e-3):
        sim = mbdsl.Simulation(mbdsl.parse(ARM), method=method, step=h)
        for _ in range(round(1.0 / PERIOD)):
            sim.inputs["u"] = -20.0 * sim["arm.phi"] - 3.0 * sim["arm.w"]
            sim.step(round(PERIOD / h))
        errors.append(np.abs([sim["arm.phi"] - reference[0], sim["arm.w"] - reference[1]]))
    if methods()[method].order > 4:  # only rounding remains
        assert np.max(errors) < 1e-11
        return
    found = np.log2(np.array(errors[:-1]) / errors[1:])
    low, high = slopes(method)
    assert ((low < found) & (found < high)).all()


@pytest.mark.parametrize("method", METHODS)
def test_reaction_behind_a_jump(method):
    """The pin holds the arm against the new torque at once: lam just behind the jump, from Newton and Euler by hand."""
    sim = mbdsl.Simulation(mbdsl.parse(ARM), method=method, step=1e-5)
    sim.step(20)
    sim.inputs["u"] = 40.0
    sim.step()
    phi, w = sim["arm.phi"], sim["arm.w"]
    alpha = 3.0 * (40.0 - 9.81 / 2 * np.cos(phi))
    along, across = np.array([np.cos(phi), np.sin(phi)]), np.array([-np.sin(phi), np.cos(phi)])
    force = 0.5 * (alpha * across - w * w * along) + (0.0, 9.81)
    assert [sim["pin.fx"], sim["pin.fy"]] == pytest.approx(force, rel=1e-3)


@pytest.mark.parametrize("method", METHODS)
def test_the_same_as_in_one_go(method):
    """Bit for bit, if no input changes."""
    scene = mbdsl.parse(ARM)
    sim = mbdsl.Simulation(scene, method=method, step=1e-3)
    sim.step(100)
    whole = mbdsl.simulate(scene, method=method, step=1e-3, stop=0.1, interval=0.0)
    trajectory = sim.trajectory()
    assert np.array_equal(trajectory.q, whole.q)
    assert np.array_equal(trajectory.v, whole.v)
    assert np.array_equal(trajectory.lam, whole.lam)
    assert np.array_equal(trajectory["u"], np.full(101, 0.5))
    assert sim.time == pytest.approx(0.1)
    assert sim["pin.fx"] == pytest.approx(whole["pin.fx"][-1])


def test_inputs_are_in_the_trajectory():
    sim = mbdsl.Simulation(mbdsl.parse(ARM), step=1e-3)
    sim.step(2)
    sim.inputs["u"] = 2.0
    sim.step(2)
    trajectory = sim.trajectory()
    assert trajectory["u"].tolist() == [0.5, 0.5, 0.5, 2.0, 2.0]
    assert trajectory["motor.tau"].tolist() == [0.5, 0.5, 0.5, 2.0, 2.0]
    assert trajectory.unit("u") == "N.m"
    # accelerations and reactions are found with the input of each instant
    assert trajectory["arm.alpha"] == pytest.approx(3.0 * (trajectory["u"] - 9.81 / 2 * np.cos(trajectory["arm.phi"])))


def test_only_the_present_is_kept_on_request():
    sim = mbdsl.Simulation(mbdsl.parse(ARM), step=1e-3, record=False)
    sim.step(50)
    assert sim.trajectory().t == pytest.approx([0.05])


def test_what_makes_no_sense():
    sim = mbdsl.Simulation(mbdsl.parse(ARM), step=1e-3)
    with pytest.raises(UsageError, match="no input `v`") as caught:
        sim.inputs["v"] = 1.0
    assert "u" in caught.value.hint
    with pytest.raises(UsageError, match="not a finite number"):
        sim.inputs["u"] = float("nan")
    with pytest.raises(UsageError, match=r"no signal `arm\.angle`"):
        sim["arm.angle"]
    with pytest.raises(UsageError, match="no method `rk4`"):
        mbdsl.Simulation(mbdsl.parse(ARM), method="rk4")
    with pytest.raises(UsageError, match="above zero"):
        mbdsl.Simulation(mbdsl.parse(ARM), step=0.0)


def test_a_step_that_fails_keeps_the_others():
    sim = mbdsl.Simulation(mbdsl.parse(ARM.replace("tau = u", "tau = 1 N.m*sqrt(u/1 N.m)")), step=1e-3)
    sim.step(3)
    sim.inputs["u"] = 1e-12
    sim.step()
    sim.inputs["u"] = -1.0
    with pytest.raises(mbdsl.MbdslError) as caught:
        sim.step()
    assert "not finite" in str(caught.value)
    if isinstance(caught.value, IntegrationError):
        assert len(caught.value.trajectory) == 5
