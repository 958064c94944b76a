"""Runs step by step in space: the bits of a run, saved states, copies, and angles that count turns."""

import pickle
from pathlib import Path

import numpy as np
import pytest

import mbdsl
from mbdsl.errors import UsageError

TOP = Path(__file__).parents[3] / "models" / "space" / "heavy_top.mbd"
WOUND = """
spatial model Wound "A flywheel on a torsional spring, about a tilted axis"
  Ground ground(g = 0);
  Body wheel(m = 1 kg, I = {1, 1, 1} kg.m2);
  Revolute hinge(ground, wheel.c, n = {1, 2, 2});
  RotationalSpringDamper spring(ground, wheel.c, n = {1, 2, 2}, k = 0.01 N.m/rad);
initial equation
  hinge.w = 10 rad/s;
end Wound;
"""


@pytest.mark.parametrize("method", ["hht-si2", "nstiff", "radau5", "radau9", "dop853"])
def test_the_same_bits_as_a_run(method):
    steps = mbdsl.Simulation(TOP, step=1e-3, method=method)
    steps.step(50)
    found = steps.trajectory()
    run = mbdsl.simulate(TOP, method=method, step=1e-3, stop=0.05, interval=1e-3)
    assert np.array_equal(found.q, run.q) and np.array_equal(found.v, run.v)
    for name in ("top.x", "top.wy"):
        assert np.array_equal(found[name], run[name])
        # numpy turns one vector and many with sums in another order
        assert steps[name] == pytest.approx(run[name][-1], rel=1e-15)
    # of methods without reactions of their own, these follow from the state, for many states at once or for one
    assert steps["ball.fz"] == pytest.approx(run["ball.fz"][-1], rel=1e-13)
    assert abs(steps["top.p2"]) == pytest.approx(abs(run["top.p2"][-1]), rel=1e-14)  # both signs are the same attitude


def test_saved_states_copies_and_pickles():
    steps = mbdsl.Simulation(TOP, step=1e-3)
    steps.step(20)
    state, copy, other = steps.state, steps.copy(), pickle.loads(pickle.dumps(steps))
    found = []
    for each in (steps, copy, other):
        each.step(30)
        found.append(each["top.x"])
    steps.state = state
    steps.step(30)
    assert len({*found, steps["top.x"]}) == 1


def test_angles_count_turns():
    """phi = w0/w sin(w t) with w = sqrt(k/J): 4.7 turns. HHT's error is (h w)^2/12, which is below rounding here."""
    steps = mbdsl.Simulation(mbdsl.parse(WOUND), step=1e-3, general=True)
    steps.step(3000)
    assert steps["hinge.phi"] == pytest.approx(100 * np.sin(0.3), rel=1e-7)
    blind = mbdsl.Simulation(mbdsl.parse(WOUND), step=1e-3, record=False)
    blind.step(10)
    assert blind["hinge.w"] == pytest.approx(10 * np.cos(0.001), rel=1e-7)
    with pytest.raises(UsageError, match="angles in space that count turns follow from all states"):
        blind["hinge.phi"]
