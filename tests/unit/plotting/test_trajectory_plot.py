"""Trajectory.plot: the signals of a run, another run, and a file in one plot."""

from pathlib import Path

import pytest

import mbdsl
from mbdsl import results
from mbdsl.errors import UsageError

MODEL = Path(__file__).parents[3] / "models" / "pendulum.mbd"


@pytest.fixture(scope="module")
def runs():
    return [mbdsl.simulate(MODEL, method="hht-si2", step=h, stop=0.5, interval=0.01) for h in (0.01, 0.005)]


def test_signals_of_a_run(runs, tmp_path):
    run, _ = runs
    bodies = {name.split(".")[0] for name in run.default_names}
    shown = {s.name for panel in run.plot().panels for s in panel.series}
    assert shown <= {f"{body}.{key}" for body in bodies for key in ("x", "y", "phi")}
    plot = run.plot("*.fx", out=tmp_path / "plot.svg")
    for panel in plot.panels:
        for series in panel.series:
            assert series.x == run.t.tolist()
            assert series.y == run[series.name].tolist()
            assert panel.y_label.endswith(f"[{run.unit(series.name)}]")
    assert (tmp_path / "plot.svg").read_text(encoding="utf-8") == plot._repr_svg_()
    assert str(plot).startswith(run.scene.name)


def test_difference_to_a_run_and_to_a_file(runs, tmp_path):
    run, other = runs
    name = next(name for name in run.default_names if name.endswith(".x"))
    results.write(tmp_path / "other.npz", other.to_dict(), {}, {"complete": True})
    plot = run.plot([name], [other, tmp_path / "other.npz"], difference=True)
    expected = other[name] - run[name]
    assert abs(expected).max() > 1e-9
    assert [s.y for s in plot.panels[0].series] == [expected.tolist()] * 2


def test_unknown_signals(runs):
    with pytest.raises(UsageError, match="there is no signal named `none`"):
        runs[0].plot("none")
