"""Backends across discontinuities, against solutions put together from pieces in closed form."""

import importlib.util
from pathlib import Path

import numpy as np
import pytest

import mbdsl
from mbdsl.errors import IntegrationError

spec = importlib.util.spec_from_file_location("events", Path(__file__).with_name("test_events.py"))
own = importlib.util.module_from_spec(spec)
spec.loader.exec_module(own)
CASES, slide, solved = own.CASES, own.slide, own.solved

METHODS = ("scipy-dop853", "scipy-radau", "scipy-lsoda", "ida")


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("name", CASES)
def test_accuracy_across_events(name, method):
    """The tolerance is reached; a jump is passed once. Without damping, the force at the stop has only a corner at the
    entry; at the exit, only rounding decides whether the switch changes."""
    scene, solution, times = CASES[name]
    found, error = solved(scene, solution, method, 1e-6)
    assert error <= 1e-5
    if name == "stop":
        assert found.stats["events"] <= 2
    else:
        assert found.stats["events"] == len(times)


def test_an_event_costs_few_steps():
    """For DOP853, which is exact on each piece of a table of six knots over time, only the longest step, 1/50 of the
    run, limits the steps."""
    scene, solution, times = CASES["table"]
    found, error = solved(scene, solution, "scipy-dop853", 1e-8)
    assert error < 1e-12 and found.stats["steps"] < 50 + 5 * (len(times) + 1)


@pytest.mark.parametrize("method", METHODS)
def test_reactions_jump_with_what_causes_them(method):
    """A constrained body, a jump in time and one at an angle."""
    found = mbdsl.simulate(mbdsl.parse(own.PENDULUM), method=method, tol=1e-5, interval=0.01)
    keep = np.abs(found.t - 0.4) > 1e-9
    exact = own.pendulum(found.t[keep])
    assert np.abs(found["pin.phi"][keep] - exact[:, 0]).max() <= 1e-4
    assert np.abs(found["pin.w"][keep] - exact[:, 1]).max() <= 1e-4 * np.abs(exact[:, 1]).max()
    assert found.stats["events"] == 2


@pytest.mark.parametrize("method", METHODS)
def test_sliding_along_a_switch_stops_and_says_so(method):
    """x'' = -2 sign(v) comes to rest at 0.5 s; x'' = -1e4 x - (60 if v > 0.5) cannot pass v = 0.5 where
    -0.006 < x < 0, and after one swing (x + 0.006)^2 + (v/100)^2 has led to -x there."""
    with pytest.raises(IntegrationError, match="back and forth") as caught:
        mbdsl.simulate(slide("2 N*sign(v)", 0.0, 1.0), method=method, tol=1e-4)
    assert "TranslationalSpringDamper spring" in str(caught.value) and "tanh" in caught.value.hint
    assert caught.value.span is not None
    end = caught.value.trajectory  # some detect it one output (2 ms) later, at rest
    assert -5e-5 < end.t[-1] - 0.5 < 2e-3 + 5e-5  # an error of 1e-4 of v is 5e-5 s of time
    assert end["rail.s"][-1] == pytest.approx(0.25, abs=1e-4) and abs(end["rail.v"][-1]) < 1e-4
    with pytest.raises(IntegrationError, match="back and forth") as caught:
        mbdsl.simulate(slide("1e4 N/m*s + (if v > 0.5 m/s then 60 N else 0 N)", 0.0, 1.0), method=method, tol=1e-6)
    end = caught.value.trajectory
    assert end["rail.v"][-1] == pytest.approx(0.5, abs=1e-5)
    assert end["rail.s"][-1] == pytest.approx(0.006 - np.sqrt(0.006**2 + 0.01**2 - 0.005**2), abs=1e-5)


@pytest.mark.parametrize("method", METHODS)
def test_an_edge_that_is_never_left(method):
    """Driven to x = 0 from both sides, from rest there."""
    with pytest.raises(IntegrationError, match="back and forth"):
        mbdsl.simulate(slide("if s > 0 m then 5 N else -5 N"), method=method, tol=1e-5)


@pytest.mark.parametrize("method", METHODS)
def test_the_end_of_a_table_is_told_exactly(method):
    table = 'Table u(table = [0 s, 1 N; 0.5 s, 2 N], extrapolation = "error");'
    with pytest.raises(IntegrationError, match="not finite") as caught:
        mbdsl.simulate(slide("-u(time)", more=table), method=method, tol=1e-4)
    assert caught.value.trajectory.t[-1] == pytest.approx(0.5, abs=1e-9)


@pytest.mark.parametrize("method", METHODS)
def test_noise_around_a_switch_is_no_event(method):
    law = "100 N/m*s + (if s > 0 m then 1e3 N/m*s else 0 N)"
    assert mbdsl.simulate(slide(law, 1e-17, 0.0), method=method, tol=1e-6).stats["events"] == 0


@pytest.mark.parametrize("method", METHODS)
def test_every_step(method):
    """Each event once, in order, up to the stop time; each state on the solution."""
    scene, solution, _ = CASES["force"]
    found = mbdsl.simulate(scene, method=method, tol=1e-6, interval=0.0)
    assert found.t[0] == 0.0 and found.t[-1] == 1.0 and (np.diff(found.t) > 0.0).all()
    assert len(found.t) == found.stats["steps"] + 1
    np.testing.assert_allclose(found["rail.s"], [solution(t)[0] for t in found.t], atol=1e-5)
