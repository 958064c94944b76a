"""Between the steps of a Simulation: signals, states that are saved and restored, copies, vectors of inputs.

Signals are compared with those of the stored trajectory, which evaluates arrays; states bit for bit with a run that was
not interrupted.
"""

import copy
import pickle
from pathlib import Path

import numpy as np
import pytest

import mbdsl
from mbdsl.errors import UsageError

MODELS = Path(__file__).parents[3] / "models"
ARM = """
model Arm
  input Torque u(start = 0.5 N.m);
  input Force f;
  Ground ground;
  Rod arm(m = 1 kg, length = 1 m);
  Rod hand(m = 1 kg, length = 1 m);
  Revolute pin(ground, arm.a);
  Revolute wrist(arm.b, hand.a);
  Torque motor(ground, arm.a, tau = u*(if time < 5.5 ms then 1 else 0.5));
  Force wind(frame_b = hand.b, fx = f);
  Real reach = hypot(hand.b.x/1 m, hand.b.y/1 m);
initial equation
  arm.phi = 0.3 rad;
  arm.w = 0 rad/s;
  hand.phi = 0.1 rad;
  hand.w = 0 rad/s;
end Arm;
"""
STEP = 1e-3


def simulation(**given):
    return mbdsl.Simulation(mbdsl.parse(ARM), step=STEP, **given)


def controlled(sim, first, last):
    """Steps with inputs that change at every other one."""
    for k in range(first, last):
        if k % 2:
            sim.inputs["u"], sim.inputs["f"] = np.sin(k), np.cos(k)
        sim.step()


def assert_same(one, other):
    one, other = one.trajectory(), other.trajectory()
    for x in ("t", "q", "v", "lam"):
        assert np.array_equal(getattr(one, x), getattr(other, x))
    assert all(np.array_equal(one.inputs[name], other.inputs[name]) for name in one.inputs)


# -- signals -----------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    "name", ["slider_crank", "driven_crank", "rolling_disc", "stick_slip_belt", "flexible_pendulum"]
)
def test_every_signal_is_that_of_the_trajectory(name):
    """Bodies that are reduced, driven or bend, and signals with and without a place in the buffers."""
    sim = mbdsl.Simulation(MODELS / f"{name}.mbd", step=STEP)
    sim.step(3)
    trajectory = sim.trajectory()
    for signal in trajectory.names:
        size = max(1.0, abs(trajectory[signal][-1]))
        assert sim[signal] == pytest.approx(trajectory[signal][-1], rel=1e-12, abs=1e-11 * size, nan_ok=True), signal


def test_signals_follow_steps_inputs_and_states():
    sim = simulation()
    read = sim.reader("pin.phi", "hand.b.x", "arm.alpha", "reach", "u", "time")
    assert read.names == ("pin.phi", "hand.b.x", "arm.alpha", "reach", "u", "time")
    assert read.units == ("rad", "m", "rad/s2", "", "N.m", "s")
    first, start = read(), sim.state
    controlled(sim, 0, 1500)  # the record grows meanwhile
    trajectory = sim.trajectory()
    assert len(trajectory) == 1501
    assert read() == pytest.approx([trajectory[name][-1] for name in read.names], rel=1e-12)
    found = np.zeros(6)
    assert read(out=found) is found and np.array_equal(found, read())
    sim.state = start
    assert np.array_equal(read(), first)


def test_an_operation_without_a_value_is_nan():
    text = ARM.replace("hypot(hand.b.x/1 m, hand.b.y/1 m)", "sqrt(-1 - (hand.b.x/1 m)^2)")
    sim = mbdsl.Simulation(mbdsl.parse(text), step=STEP)
    assert np.isnan(sim["reach"]) and np.isnan(sim.reader("pin.phi", "reach")()).tolist() == [False, True]


def test_inputs_as_vectors():
    one, other = simulation(), simulation()
    write = one.writer("f", "u")
    write(np.array([2.0, 3.0]))
    other.inputs.update(u=3.0, f=2.0)
    assert (one.inputs["f"], one.inputs["u"]) == (2.0, 3.0)
    one.step(4)
    other.step(4)
    assert_same(one, other)
    one.writer()([1.0, -1.0])
    assert dict(one.inputs) == {"u": 1.0, "f": -1.0}
    for values in ([1.0], [1.0, np.nan], [1.0, "x"]):
        with pytest.raises((UsageError, ValueError)):
            write(values)
    assert dict(one.inputs) == {"u": 1.0, "f": -1.0}
    with pytest.raises(UsageError, match="no input `g`"):
        one.writer("g")
    with pytest.raises(UsageError, match="named twice"):
        one.writer("u", "u")
    with pytest.raises(UsageError, match=r"no signal `pin\.angle`"):
        one.reader("pin.angle")


# -- states ------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("method", ["hht-si2", "radau5"])
def test_a_restored_state_continues_bit_for_bit(method):
    """Across the jump of the torque at 5.5 ms, which begins a new search for jumps."""
    whole, sim = simulation(method=method), simulation(method=method)
    controlled(whole, 0, 12)
    controlled(sim, 0, 4)
    kept = sim.state
    controlled(sim, 5, 9)  # another past, which must leave no trace
    later = sim.state
    sim.state = kept
    assert sim.time == pytest.approx(4 * STEP) and len(sim.trajectory()) == 5
    controlled(sim, 4, 12)
    assert_same(sim, whole)
    sim.state = later
    assert len(sim.trajectory()) == 9 and sim.time == pytest.approx(8 * STEP)
    sim.state = pickle.loads(pickle.dumps(kept))
    controlled(sim, 4, 12)
    assert_same(sim, whole)


def test_reset_returns_to_the_start():
    sim, new = simulation(), simulation()
    controlled(sim, 0, 7)
    sim.reset()
    assert dict(sim.inputs) == {"u": 0.5, "f": 0.0} and sim.time == 0.0 and len(sim.trajectory()) == 1
    for one in (sim, new):
        controlled(one, 0, 7)
    assert_same(sim, new)


@pytest.mark.parametrize("make", [mbdsl.Simulation.copy, copy.copy, copy.deepcopy], ids=lambda f: f.__name__)
def test_a_copy_is_independent(make):
    sim, new = simulation(), simulation()
    controlled(sim, 0, 4)
    sim.inputs["u"] = 9.0  # not yet in force
    other = make(sim)
    other.step(20)
    assert other.inputs["u"] == 9.0
    controlled(new, 0, 4)
    for one in (sim, new):
        one.inputs["u"] = 0.0
        controlled(one, 4, 12)
    assert_same(sim, new)
    assert len(other.trajectory()) == 25


def test_independent_parts_are_restored_together():
    text = """model Two Ground ground; Rod a(m = 1 kg, length = 1 m); Rod b(m = 1 kg, length = 2 m);
        Revolute A(ground, a.a); Revolute B(ground, b.a); initial equation a.phi = 0.1 rad; b.phi = 1 rad; end Two;"""
    sim = mbdsl.Simulation(mbdsl.parse(text), step=STEP)
    assert len(sim._motion.parts) == 2
    sim.step(3)
    kept = sim.state
    sim.step(9)
    wanted = sim.trajectory()
    sim.state = kept
    sim.step(9)
    assert np.array_equal(sim.trajectory().q, wanted.q) and len(wanted) == 13
    assert sim["B.phi"] == wanted["B.phi"][-1]


def test_a_state_fits_its_model_only():
    sim = simulation()
    for other in (simulation(method="hht-i3"), mbdsl.Simulation(MODELS / "pendulum.mbd"), simulation(record=False)):
        with pytest.raises(UsageError, match="another model or to other settings"):
            sim.state = other.state
    with pytest.raises(UsageError, match="expected a state"):
        sim.state = 3


def test_the_state_cannot_be_written():
    sim = simulation()
    for name in ("q", "v", "lam"):
        with pytest.raises(ValueError, match="read-only"):
            getattr(sim, name)[0] = 1.0
    for name in ("q", "v"):
        with pytest.raises(UsageError, match="follows from the motion"):
            setattr(sim, name, np.zeros(6))
