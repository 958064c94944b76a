"""Every shipped model with every method: the run ends, the joints stay closed, and energy is conserved where it should
be."""

import json
from pathlib import Path

import numpy as np
import pytest

import mbdsl
from mbdsl.errors import IntegrationError
from mbdsl.integrators import compiled

MODELS = Path(__file__).parents[2] / "models"
#: model -> (stop, step, parameters); a hundred steps or more
EVERY = json.loads((Path(__file__).parents[1] / "data" / "runs.json").read_text(encoding="utf-8"))
RUNS = {name: run for name, run in EVERY.items() if "/" not in name}
#: models whose springs and dampers make these steps unstable with explicit methods
STIFF = {"double_pendulum", "flexible_pendulum", "spin_up_beam"}
#: models without drivers, damping or friction
CONSERVED = {"chain", "chaplygin_sleigh", "four_bar", "pendulum", "rolling_disc"}


def test_all_are_here():
    """A new model needs a line in tests/data/runs.json: its stop time, step and parameters."""
    assert set(EVERY) == {path.relative_to(MODELS).with_suffix("").as_posix() for path in MODELS.rglob("*.mbd")}


@pytest.mark.parametrize("method", compiled())
@pytest.mark.parametrize("name", RUNS)
def test_run(name, method):
    stop, step, parameters = RUNS[name]
    given = {"method": method, "step": step, "stop": stop, "interval": stop / 50, "parameters": parameters}
    if name in STIFF and compiled()[method].stable < np.inf:
        with pytest.raises(IntegrationError, match="the model is stiff"):
            mbdsl.simulate(MODELS / f"{name}.mbd", **given)
        return
    found = mbdsl.simulate(MODELS / f"{name}.mbd", **given)
    assert found.status == "done" and found.t[-1] == stop
    assert np.isfinite(found.q).all() and np.isfinite(found.v).all() and np.isfinite(found.lam).all()
    assert np.ptp(found.q, axis=0).max() > 1e-3  # it moves
    closed = found.select(["*.Phi[*]"]) if name != "chaplygin_sleigh" else []
    assert all(np.abs(found[row]).max() < 1e-10 for row in closed)
    if name in CONSERVED:
        energy, kinetic = found["energy.total"], found["energy.kinetic"]
        # of first order with newmark, and 1e-4 with methods of second order
        assert np.abs(energy - energy[0]).max() < (1e-2 if compiled()[method].order == 1 else 1e-4) * kinetic.max()
