"""Reactions and accelerations of many states: closed forms, and the results of one state after the other."""

from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import mbdsl
from mbdsl.compilation import code_cache
from mbdsl.simulation import derived_signals
from mbdsl.system import batch_accelerations

MODELS = Path(__file__).parents[3] / "models"
compiled = pytest.mark.skipif(not code_cache.enabled(), reason="uncompiled, states are taken one by one")


@pytest.fixture
def both(monkeypatch):
    """Accelerations and multipliers of a run: of all states together, and of one after the other."""

    def find(run):
        found = []
        for many in (1, 10**9):
            monkeypatch.setattr(batch_accelerations, "MANY", many)
            run.__dict__.pop("_motion", None)
            found.append(run._motion)
        return found

    return find


@compiled
@pytest.mark.parametrize(
    "name",
    [
        *("slider_crank", "four_bar", "chaplygin_sleigh", "driven_crank", "flexible_slider_crank", "seven_body"),
        *("stick_slip_belt", "space/bennett", "space/bicycle", "space/heavy_top", "space/haug_slider_crank"),
    ],
)
def test_together_and_one_by_one(name, both):
    run = mbdsl.simulate(MODELS / f"{name}.mbd", tol=1e-3, stop=0.02)
    for many, single in zip(*both(run), strict=True):
        np.testing.assert_allclose(many, single, rtol=0.0, atol=1e-10 * np.abs(single).max())


@compiled
@pytest.mark.parametrize("method", ["radau5", "hht-si2"])
@pytest.mark.parametrize("name", ["slider_crank", "stick_slip_belt", "space/rssr", "space/gyroscope"])
def test_no_state_is_solved_in_python(name, method, monkeypatch):
    """In plane and space, with friction by reactions, with methods of one and two sets of multipliers."""

    def refuse(*_):
        raise AssertionError("one state after the other")

    run = mbdsl.simulate(MODELS / f"{name}.mbd", step=1e-3, stop=0.1, interval=1e-3, method=method)
    monkeypatch.setattr(derived_signals, "accelerations", refuse)
    assert len(run.t) == 101 and np.isfinite(run.a).all()


def test_accelerations_of_a_body_that_flips():
    """Euler's equations: I alpha = -w x (I w) in body axes, without forces."""
    run = mbdsl.simulate(MODELS / "space/dzhanibekov.mbd", tol=1e-6)
    w, p = (np.column_stack([run[f"nut.{key}{i}"] for i in axes]) for key, axes in (("w", "xyz"), ("p", "0123")))
    alpha = np.column_stack([run[f"nut.alpha{i}"] for i in "xyz"])
    R = Rotation.from_quat(p[:, [1, 2, 3, 0]])
    w, alpha, size = R.inv().apply(w), R.inv().apply(alpha), np.abs(alpha).max()
    inertia = np.array([3e-5, 2e-5, 1.2e-5])
    assert size > 20.0
    expected = -np.cross(w, w * inertia) / inertia
    np.testing.assert_allclose(alpha, expected, rtol=0.0, atol=1e-12 * size)


@compiled
def test_what_is_left_out_has_no_reaction(both):
    run = mbdsl.simulate(MODELS / "hard/spare_rocker.mbd", tol=1e-3, stop=0.5)
    (a, lam), (one_a, one_lam) = both(run)
    assert run.left_out and (lam[:, list(run.left_out)] == 0.0).all()
    np.testing.assert_allclose(lam, one_lam, rtol=0.0, atol=1e-9 * np.abs(one_lam).max())
    np.testing.assert_allclose(a, one_a, rtol=0.0, atol=1e-9 * np.abs(one_a).max())


def test_reaction_of_a_pendulum():
    """Closed form: the rod pulls with m l w^2 - m g sin(phi) along itself, at phi from the horizontal."""
    text = """model P
      Ground g(g = 9.81 m/s2); PointMass mass(m = 2 kg); Distance rod(g, mass, length = 0.5 m);
    initial equation guess mass.x = 0.5 m; mass.y = 0 m; mass.vy = 0 m/s;
      annotation(experiment(StopTime = 2 s)); end P;"""
    run = mbdsl.simulate(mbdsl.parse(text), tol=1e-6, interval=2.0 / batch_accelerations.MANY)
    assert len(run.t) > batch_accelerations.MANY
    x, y, vx, vy = (run[f"mass.{key}"] for key in ("x", "y", "vx", "vy"))
    pull = 2.0 * (vx**2 + vy**2) / 0.5 - 2.0 * 9.81 * y / 0.5
    np.testing.assert_allclose(run["mass.ax"], -pull * x / 0.5 / 2.0, rtol=0.0, atol=1e-5)
    np.testing.assert_allclose(run["mass.ay"], -pull * y / 0.5 / 2.0 - 9.81, rtol=0.0, atol=1e-5)


@compiled
def test_inputs_are_those_of_each_state(both):
    text = """model Pushed
      Ground g; Body b(m = 2 kg, I = 1 kg.m2); FreeMotion free(g, b.c); input Real F(start = 0, unit = "N");
      Force push(b.c, fx = F);
      annotation(experiment(StopTime = 1 s)); end Pushed;"""
    simulation = mbdsl.Simulation(mbdsl.parse(text), step=0.01)
    for k in range(20):
        simulation.inputs["F"] = float(k)
        simulation.step()
    run = simulation.trajectory()
    for a, _ in both(run):
        np.testing.assert_allclose(a[:, 0], run.inputs["F"] / 2.0, rtol=0.0, atol=1e-12)


@compiled
def test_singular_poses_are_taken_one_by_one(both):
    """A rod of no length has no direction: no reaction is determined."""
    run = mbdsl.simulate(MODELS / "pendulum.mbd", step=0.01, stop=0.1)
    run.q = np.where(np.arange(len(run.t))[:, None] % 2, run.q, 0.0)
    (a, lam), (one_a, one_lam) = both(run)
    assert np.array_equal(a, one_a, equal_nan=True) and np.array_equal(lam, one_lam, equal_nan=True)
    assert np.isfinite(a[1::2]).all()
