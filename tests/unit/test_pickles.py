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

MODELS = Path(__file__).parents[2] / "models"
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


@pytest.mark.parametrize("name", ["slider_crank", "flexible_pendulum", "chaplygin_sleigh"])
def test_trajectories(name):
    found = mbdsl.simulate(MODELS / f"{name}.mbd", stop=0.01)
    again = through(found)
    assert (again.status, again.message, again.stats) == (found.status, found.message, found.stats)
    assert (again.names, again.moved) == (found.names, found.moved)
    for signal in found.names:
        np.testing.assert_array_equal(again[signal], found[signal])


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


def fail(given):
    """Run in a worker: a simulation that ends where a rod is too short."""
    return mbdsl.simulate(given, step=1e-3, stop=2.0)


@pytest.mark.parametrize("given", ["path", "scene"])
def test_an_integration_error_crosses_processes(given):
    path = MODELS / "hard" / "beyond_reach.mbd"
    with pytest.raises(IntegrationError) as here:
        fail(path)
    with ProcessPoolExecutor(1, mp_context=multiprocessing.get_context("spawn")) as pool:
        there = pool.submit(fail, path if given == "path" else mbdsl.load(path)).exception()
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
