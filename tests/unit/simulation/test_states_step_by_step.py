"""States in simulations step by step, in checkpoints, files, sweeps and pictures."""

import copy

import numpy as np
import pytest

import mbdsl
from mbdsl.errors import UsageError

TEXT = """
model M
  parameter Real T(unit = "s") = 0.5;
  Ground ground;
  Rod rod(m = 1 kg, length = 1 m);
  Revolute pin(ground, rod.a);
  Real x(start = 1), y(start = 0);
  Torque t(pin, tau = 1 N.m*x);
initial equation
  pin.phi = 0.3; pin.w = 0 rad/s;
equation
  der(x) = -x/T;
  der(y) = (pin.phi - y)/(0.1 s);
  annotation(experiment(StopTime = 1 s, Step = 1 ms, Interval = 0.1 s));
end M;
"""


@pytest.fixture(scope="module")
def scene():
    return mbdsl.parse(TEXT)


def test_simulation_reads_and_sets_states(scene):
    sim = mbdsl.Simulation(scene, step="1 ms")
    sim.step(500)
    assert sim["x"] == pytest.approx(np.exp(-1), rel=1e-6)
    assert sim["der(x)"] == pytest.approx(-2 * np.exp(-1), rel=1e-6)
    state, phi = sim.state, sim["pin.phi"]
    sim["x"] = 3.0
    assert sim["x"] == 3.0 and sim["pin.phi"] == phi
    sim.step(500)
    assert sim["x"] == pytest.approx(3 * np.exp(-1), rel=1e-6)
    there = sim["pin.phi"]
    assert sim.trajectory()["x"][-1] == pytest.approx(3 * np.exp(-1), rel=1e-6)
    sim.state = state
    sim["x"] = 3.0
    other = copy.copy(sim)
    other.step(500)
    assert other["pin.phi"] == there
    sim.reset()
    assert sim["x"] == 1.0


@pytest.mark.parametrize(("name", "value"), [("pin.phi", 1.0), ("der(x)", 1.0), ("x", float("nan"))])
def test_only_states_are_set(scene, name, value):
    with pytest.raises(UsageError):
        mbdsl.Simulation(scene, step="1 ms")[name] = value


@pytest.mark.parametrize(("method", "order"), [("hht-i3", 2), ("nstiff", 2), ("generalized-alpha", 2), ("newmark", 1)])
def test_order_behind_a_set_state(scene, method, order):
    """phi and y half a second after x was set, against runs with short steps."""

    def end(h: float) -> np.ndarray:
        sim = mbdsl.Simulation(scene, step=h, method=method)
        sim.step(round(0.5 / h))
        sim["x"] = 3.0
        sim.step(round(0.5 / h))
        return np.array([sim["pin.phi"], sim["pin.w"], sim["y"]])

    exact = end(0.5 / 16384) if order == 2 else 2 * end(0.5 / 16384) - end(0.5 / 8192)
    one, two = (np.abs(end(0.5 / n) - exact).max() for n in (128, 256))
    assert np.log2(one / two) == pytest.approx(order, abs=0.15)


def test_result_files_hold_states(scene, tmp_path):
    from mbdsl.viewing.stored_result import stored_trajectory

    run = mbdsl.simulate(scene)
    for suffix in ("csv", "npz"):
        file = tmp_path / f"run.{suffix}"
        run.save(file)
        stored, _ = stored_trajectory(file, scene)
        assert stored["x"] == pytest.approx(run["x"], rel=1e-12)


def test_sweep_of_states(scene):
    found = mbdsl.sweep(scene, {"T": [0.25, 0.5]}, ["min(x)", "max(der(y))"], workers=1)
    assert found["min(x)"] == pytest.approx(np.exp([-4, -2]), rel=1e-5)


def test_pictures_have_no_states(scene):
    from mbdsl.viewing.motion import motion

    shown = motion(mbdsl.simulate(scene))
    assert shown.tracks == ["rod"] and "x.c" not in shown.spots


def test_tolerance_counts_states(scene):
    """y follows phi: both, and a state of millions, have the error that was asked for."""
    text = TEXT.replace("Real x(", "Pressure big(start = 1e6); Real x(").replace(
        "der(x) =", "der(big) = (1e6*pin.phi*(1 Pa) - big)/(0.02 s); der(x) ="
    )
    run = mbdsl.simulate(mbdsl.parse(text), tol=1e-6, interval=0.1)
    exact = mbdsl.simulate(mbdsl.parse(text), tol=1e-11, interval=0.1, method="radau9")
    for name in ("big", "y", "x"):
        assert np.abs(run[name] - exact[name]).max() <= 2e-6 * np.abs(exact[name]).max()


@pytest.mark.parametrize("method", ["hht-si2", "hht-i3", "nstiff", "generalized-alpha"])
def test_a_state_that_begins_at_zero_and_at_rest(method):
    """Its size is not known at the start; fixed steps go on all the same."""
    text = TEXT.replace("der(y) = (pin.phi - y)/(0.1 s)", "der(y) = (pin.w/(1 rad/s) - y)/(0.01 s)")
    run = mbdsl.simulate(mbdsl.parse(text), method=method)
    exact = run["pin.w"][-1] - 0.01 * run["rod.alpha"][-1]  # y = w - T w' + ...
    assert run["y"][-1] == pytest.approx(exact, rel=2e-3)
