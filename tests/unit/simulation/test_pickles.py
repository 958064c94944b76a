"""Scenes, trajectories and errors can be sent to other processes and back, and stay the same."""

import copy
import multiprocessing
import pickle
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path

import numpy as np
import pytest

import mbdsl
from mbdsl import errors
from mbdsl.elements import kinds
from mbdsl.errors import IntegrationError, MbdslError, Span
from mbdsl.expressions.symbolic import TIME, coordinate

MODELS = Path(__file__).parents[3] / "models"
SHIPPED = sorted(path for path in MODELS.glob("*.mbd"))


def through(x):
    return pickle.loads(pickle.dumps(x))


@pytest.mark.parametrize("name", kinds())
def test_kinds_by_name(name):
    assert through(kinds()[name]) is kinds()[name]
    assert copy.deepcopy(kinds()[name]) is kinds()[name]


@pytest.mark.parametrize("path", SHIPPED, ids=lambda path: path.stem)
def test_scenes(path):
    scene = mbdsl.load(path)
    again = through(scene)
    assert again == scene  # all of its content
    assert (again.files, again.signals()) == (scene.files, scene.signals())
    assert [c.span for c in again.components.values()] == [c.span for c in scene.components.values()]


def test_long_expressions():
    """Chains of thousands of terms, as loops produce them, and terms that occur in many places."""
    x = coordinate("r.c", "x")
    for k in range(20_000):
        x = x * TIME + float(k)
    for _ in range(60):  # 2^60 paths through some hundred nodes
        x = x + x * x
    assert through(x) is x


AGAIN = pytest.mark.parametrize("again", [through, copy.deepcopy, copy.copy], ids=["pickle", "deepcopy", "copy"])


def same(one, other):
    """Whether two trajectories have the same settings, and the same bits of every signal."""
    assert (one.status, one.message, one.stats) == (other.status, other.message, other.stats)
    assert (one.names, one.moved) == (other.names, other.moved)
    for signal in other.select("*"):
        np.testing.assert_array_equal(one[signal], other[signal])


@AGAIN
@pytest.mark.parametrize("name", ["slider_crank", "flexible_pendulum", "chaplygin_sleigh"])
def test_trajectories(name, again):
    found = mbdsl.simulate(MODELS / f"{name}.mbd", stop=0.01)
    same(again(found), found)


@AGAIN
def test_parts_of_trajectories(again):
    found = mbdsl.simulate(MODELS / "slider_crank.mbd", stop=0.01)
    for part in (found["crank.*"], found[0.002:0.007], found[["O.fx"]][:"5 ms"]):
        same(again(part), part)


@AGAIN
def test_revolutions_that_no_coordinate_contains(again):
    """A cable stores the directions of its ends; the number of its turns belongs to the System."""
    found = mbdsl.simulate(MODELS / "flexible_pendulum.mbd", stop=0.01, initial={"cable.phi": "400 deg"})
    assert found["pin.phi"][0] == pytest.approx(np.radians(400.0), rel=1e-9)
    same(again(found), found)
    part = found[0.002:0.007]
    for signal in found.names:
        np.testing.assert_array_equal(part[signal], found[signal][100:351])
    same(again(part), part)
    t, q, v = found.t[-1], found.q[-1], found.v[-1]
    for one, other in zip(again(found.system).evaluate(t, q, v), found.system.evaluate(t, q, v), strict=True):
        np.testing.assert_array_equal(one, other)


#: of the structure of that in test_stepping.py, so that its code is compiled once
ARM = """
model Arm
  input Torque u(start = 0.5 N.m);
  Ground ground;
  Rod arm(m = 1 kg, length = 1 m);
  Revolute pin(ground, arm.a);
  Torque motor(ground, arm.a, tau = u);
end Arm;
"""


@AGAIN
def test_systems(again):
    """Values and derivatives, bit for bit, with the inputs that are set."""
    system = mbdsl.Simulation(mbdsl.parse(ARM), step=1e-3).system
    system.set_input("u", 3.5)
    other = again(system)
    assert (other.scene, other.names()) == (system.scene, system.names())
    for one in (system, other):
        one.kernels(2)  # those of the Simulation
    state = (0.1, np.arange(1.0, system.n + 1), np.arange(2.0, system.n + 2))
    for one, two in zip(other.evaluate(*state), system.evaluate(*state), strict=True):
        np.testing.assert_array_equal(one, two)
    for name in ("Phi_q", "stiffness", "damping", "M"):
        given = state if name in ("stiffness", "damping") else state[:2]
        np.testing.assert_array_equal(getattr(other, name)(*given), getattr(system, name)(*given))


def test_results_cross_processes():
    """Trajectories, selections and equilibria that a spawned process computes have the bits of those of this one."""
    path = MODELS / "slider_crank.mbd"
    given = {"stop": "10 ms", "step": "1 ms"}
    with ProcessPoolExecutor(1, mp_context=multiprocessing.get_context("spawn")) as pool:
        first = pool.submit(mbdsl.simulate, path, **given)
        second = pool.submit(mbdsl.simulate, mbdsl.load(path), signals=["O.fx"], **given)
        third = pool.submit(mbdsl.static, path)
        for there, here in (
            (first, mbdsl.simulate(path, **given)),
            (second, mbdsl.simulate(path, signals=["O.fx"], **given)),
        ):
            found = there.result()
            seconds = found.stats.pop("seconds"), here.stats.pop("seconds")
            assert seconds[0].keys() == seconds[1].keys()
            same(found, here)
        np.testing.assert_array_equal(third.result().q, mbdsl.static(path).q)


def test_a_model_of_the_builder_runs_the_same_when_it_comes_back():
    b = mbdsl.Builder("P")
    b.Revolute("pin", b.Ground("ground"), b.Rod("rod", m=1.0, length=1.0).a)
    b.Torque("motor", "rod.a", tau="1 N.m*sin(3*time) - 0.1*rod.w")
    scene = b.scene()
    one, other = (mbdsl.simulate(s, stop=0.02, step=1e-3) for s in (scene, through(scene)))
    np.testing.assert_array_equal(one.q, other.q)


ERRORS = [x for x in vars(errors).values() if isinstance(x, type) and issubclass(x, MbdslError)]


@pytest.mark.parametrize("kind", ERRORS, ids=lambda kind: kind.__name__)
def test_errors(kind):
    given = kind("found a", Span("m.mbd", 3, 2, 4, "  text"), "try b", (("see", Span("m.mbd", 1, 1)),))
    again = through(given)
    assert type(again) is kind
    assert (again.render(), again.exit_code) == (given.render(), given.exit_code)
    assert (again.span, again.notes, again.hint) == (given.span, given.notes, given.hint)


@pytest.mark.parametrize("given", ["path", "scene"])
def test_an_integration_error_crosses_processes(given):
    path, until = MODELS / "hard" / "beyond_reach.mbd", {"step": 1e-3, "stop": 2.0}  # where a rod is too short
    with pytest.raises(IntegrationError) as here:
        mbdsl.simulate(path, **until)
    with ProcessPoolExecutor(1, mp_context=multiprocessing.get_context("spawn")) as pool:
        there = pool.submit(mbdsl.simulate, path if given == "path" else mbdsl.load(path), **until).exception()
    assert isinstance(there, IntegrationError)
    assert (there.render(), there.exit_code) == (here.value.render(), 4)
    ours, theirs = here.value.trajectory, there.trajectory
    assert (theirs.status, theirs.message) == (ours.status, ours.message)
    np.testing.assert_array_equal(theirs.t, ours.t)
    for signal in ours.default_names:
        np.testing.assert_array_equal(theirs[signal], ours[signal])


def test_a_simulation_continues_where_it_was_pickled():
    simulation = mbdsl.Simulation(MODELS / "pendulum.mbd", step=1e-3)
    simulation.step(7)
    again = through(simulation)
    assert again.time == simulation.time
    for one in (simulation, again):
        one.step(5)
    ours, theirs = simulation.trajectory(), again.trajectory()
    for x in ("t", "q", "v", "lam"):
        np.testing.assert_array_equal(getattr(theirs, x), getattr(ours, x))
