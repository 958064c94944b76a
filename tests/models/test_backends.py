"""Every shipped model with every backend: their motion agrees with that of our own method to the tolerance."""

import json
from pathlib import Path

import numpy as np
import pytest

import mbdsl
from mbdsl.integrators import available, external

MODELS = Path(__file__).parents[2] / "models"
BACKENDS = ("scipy-dop853", "scipy-radau", "scipy-lsoda", "ida")
TOL = 1e-5
#: model -> (stop, step of hht-si2, parameters): the first hundred steps of the table of runs, at a twentieth of
#: its step; the error is TOL/50 or less
RUNS = json.loads((Path(__file__).parents[1] / "data" / "runs.json").read_text(encoding="utf-8"))
RUNS = {name: (100 * step, step / 20, given) for name, (_, step, given) in RUNS.items() if "/" not in name}
#: stiff models, over a shorter time with shorter steps
RUNS["double_pendulum"] = (4e-3, 1e-5, {})
RUNS["flexible_pendulum"] = (4e-3, 1e-6, {})
RUNS["spin_up_beam"] = (0.05, 2.5e-5, {})
RUNS["stick_slip_belt"] = (2e-3, 1e-6, {})
#: models without stiffness that would make velocities matter more than positions
SMOOTH = set(RUNS) - {"crank_ivp", "double_pendulum", "flexible_pendulum", "flexible_slider_crank", "spin_up_beam"}
SMOOTH -= {"stick_slip_belt"}


@pytest.fixture(scope="module")
def own():
    """Motions by hht-si2, each computed once."""
    found = {}

    def of(name):
        if name not in found:
            stop, step, parameters = RUNS[name]
            model, given = MODELS / f"{name}.mbd", {"stop": stop, "interval": stop / 10, "parameters": parameters}
            reference = mbdsl.simulate(model, method="hht-si2", step=step, options={"alpha": 0.0}, **given)
            found[name] = model, given, reference
        return found[name]

    return of


def test_all_are_here():
    assert set(RUNS) == {path.stem for path in MODELS.glob("*.mbd")}
    folder = Path(external.__file__).parent
    assert {path.stem.replace("_", "-") for path in folder.glob("[a-z]*.py")} == set(BACKENDS) <= set(available())


@pytest.mark.parametrize("method", BACKENDS)
@pytest.mark.parametrize("name", RUNS)
def test_motion(name, method, own):
    model, given, reference = own(name)
    found = mbdsl.simulate(model, method=method, tol=TOL, **given)
    assert found.status == "done" and np.array_equal(found.t, reference.t)
    scale = reference.system.tables.scale
    assert np.abs((found.q - reference.q) * scale).max() < TOL
    if name in SMOOTH:
        speed = max(np.abs(reference.v * scale).max(), 1.0 / given["stop"])
        assert np.abs((found.v - reference.v) * scale).max() < TOL * speed
    system = found.system
    for t, q in zip(found.t, found.q, strict=True):
        assert np.abs(system.Phi(t, q)).max(initial=0.0) < 1e-12 * system.tables.size
