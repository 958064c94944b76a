"""The results that docs/methods.md promises to be equal to the last bit."""

from pathlib import Path

import numpy as np
import pytest

import mbdsl
from mbdsl.system.system import build

CRANK = Path(__file__).parents[3] / "models" / "slider_crank.mbd"


@pytest.mark.parametrize("given", [{"method": "hht-si2", "step": 1e-3}, {"method": "radau5", "tol": 1e-6}])
def test_a_run_is_repeated_to_the_last_bit(given):
    """Another scene is solved in between, whose buffers and statics might be left behind."""
    first = mbdsl.simulate(CRANK, stop=0.05, interval=0.01, **given)
    mbdsl.simulate(CRANK, stop=0.02, parameters={"c": "4 N.s/m"}, **given)
    again = mbdsl.simulate(CRANK, stop=0.05, interval=0.01, **given)
    assert all(np.array_equal(getattr(first, x), getattr(again, x)) for x in ("t", "q", "v", "lam"))


def test_fixed_steps_do_not_know_of_outputs_nor_of_pauses():
    """The same steps with outputs every millisecond, every ten, and after pauses."""
    often = mbdsl.simulate(CRANK, method="hht-si2", step=1e-3, stop=0.05, interval=1e-3)
    seldom = mbdsl.simulate(CRANK, method="hht-si2", step=1e-3, stop=0.05, interval=1e-2)
    paused = mbdsl.Simulation(CRANK, method="hht-si2", step=1e-3)
    for _ in range(5):
        paused.step(10)
    for x in ("q", "v", "lam"):
        assert np.array_equal(getattr(often, x)[::10], getattr(seldom, x))
    assert np.array_equal(paused.q, seldom.q[-1]) and np.array_equal(paused.v, seldom.v[-1])


@pytest.mark.parametrize("model", ["slider_crank", "space/heavy_top", "gallery/robot_arm"])
def test_an_evaluation_does_not_know_of_those_before(model):
    """Wrenches of all frames begin at zero in each evaluation, also those of the ground's frames."""
    scene = mbdsl.load(CRANK.parent / f"{model}.mbd", allow_imports=CRANK.parent)
    system = build(scene)
    rng = np.random.default_rng(2)
    q, v, lam = (rng.normal(size=n) for n in (system.n, system.n, system.m + system.p))
    frames = [system._at(0.1, q, v, lam).frames.copy() for _ in range(3)]
    assert np.array_equal(frames[0], frames[1]) and np.array_equal(frames[0], frames[2])
