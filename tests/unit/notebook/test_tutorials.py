"""The notebooks of docs/notebooks run, and their results agree with their texts."""

import json
from pathlib import Path

import numpy as np
import pytest

ROOT = Path(__file__).parents[3]
NOTEBOOKS = sorted((ROOT / "docs" / "notebooks").glob("*.ipynb"))


def cells(path, kind):
    return [c for c in json.loads(path.read_text(encoding="utf-8"))["cells"] if c["cell_type"] == kind]


def test_they_are_stored_without_outputs():
    assert len(NOTEBOOKS) >= 2
    for path in NOTEBOOKS:
        stored = json.loads(path.read_text(encoding="utf-8"))
        assert (stored["nbformat"], stored["nbformat_minor"]) == (4, 5)
        ids = [cell["id"] for cell in stored["cells"]]
        assert len(ids) == len(set(ids))
        assert all(c["outputs"] == [] and c["execution_count"] is None for c in cells(path, "code"))


@pytest.fixture
def executed(shell):
    """``executed(name)``: values of the cells of a notebook, and its variables."""

    def run(name):
        values = []
        for cell in cells(ROOT / "docs" / "notebooks" / name, "code"):
            done = shell.run("".join(cell["source"]))
            assert done.success, done.text
            values.append(done.value)
        return values, shell.names

    return run


def test_slider_crank(executed):
    values, names = executed("slider_crank.ipynb")
    assert all(hasattr(value, "_repr_html_") for value in values if type(value).__module__.startswith("mbdsl"))
    # Newton iterations end at residuals of 1e-10 of the size of the mechanism.
    assert np.abs(names["residual"]).max() < 1e-9
    assert names["soft"].parameters["k"].value == 40.0
    # At 4 s the amplitude is below 1 % of the first one; it changes the frequency by its square.
    frequency = 1 / np.diff(names["crossings"])[-1]
    assert frequency == pytest.approx(names["modes"][0].damped_frequency, rel=1e-3)


def test_pendulum(executed):
    values, names = executed("pendulum.ipynb")
    assert [type(value).__name__ for value in values[1:5]] == ["Builder", "Scene", "Animation", "Plot"]
    # Runs to 1e-6 of the largest speed, and a linear interpolation where the speed has no curvature.
    assert len(names["error"]) == 6 and np.abs(names["error"]).max() < 1e-5
    assert np.ptp(names["large"]["energy.total"]) < 1e-5 * np.ptp(names["large"]["energy.kinetic"])
