"""The signals that plots show by default: what moves, in the plane and in space, of models and of files."""

from pathlib import Path

import numpy as np
import pytest

import mbdsl

MODELS = Path(__file__).parents[3] / "models"
SHORT = {"stop": 0.02, "step": 1e-3}


def names(plot):
    return [[series.name for series in panel.series] for panel in plot.panels]


@pytest.mark.parametrize(
    ("model", "shown", "left_out"),
    [
        ("slider_crank", {"O.phi", "A.phi", "B.s", "B.phi"}, []),  # one hinge, a second one, a slider in the guide
        ("driven_crank", {"O.phi", "A.phi", "P.phi", "B.s"}, ["Constant, and left out: B.phi", "left out: drive.phi"]),
        ("pendulum", {"mass.x", "mass.y"}, []),  # the distance of a rod is no coordinate
        ("chaplygin_sleigh", {"sleigh.x", "sleigh.y", "sleigh.phi"}, []),
        ("space/dzhanibekov", {"nut.p0", "nut.p1", "nut.p2", "nut.p3"}, ["nut.x, nut.y, nut.z"]),
        ("space/cardan_shaft", {"front.phi", "first.phi_a", "first.phi_b", "second.phi_a", "second.phi_b"}, ["rear.s"]),
        ("gallery/trebuchet", {"axle.phi", "hinge.phi", "stone.x", "stone.y"}, []),  # and the stone on its rope
    ],
)
def test_what_moves(model, shown, left_out):
    """Signals that equal others (the driver's angle), and rounding errors beside the size of the mechanism, are not."""
    plot = mbdsl.plot(MODELS / f"{model}.mbd", stop=0.05, step=5e-4)
    found = {name for panel in names(plot) for name in panel}
    assert found == shown
    for text in left_out:
        assert any(text in note for note in plot.notes), plot.notes


def test_a_vehicle_in_space_has_hinges_and_a_free_body():
    """A body that rolls is described by no joint: height and attitude are among its signals."""
    run = mbdsl.simulate(MODELS / "space" / "bicycle.mbd", **SHORT)
    first, others = run.shown_names
    assert first[:3] == ["axle.phi", "steer.phi", "axle2.phi"]
    assert first[3:] == [f"rear.{key}" for key in ("x", "y", "z", "p0", "p1", "p2", "p3")]
    assert "rider.z" in others and not {"rear.x", "track.s"} & set(others)
    assert all(name in run for name in (*first, *others))


def test_files_in_space_show_heights_and_attitudes(tmp_path):
    run = mbdsl.simulate(MODELS / "space" / "delta_robot.mbd", stop=0.1, step=1e-3)
    run.save(tmp_path / "some.csv")
    run.save(tmp_path / "all.npz", "*")
    shown = {name for panel in names(mbdsl.plot(tmp_path / "some.csv")) for name in panel}
    assert {"platform.z", "arm[1].p0"} <= shown
    assert not any(name.endswith(".phi") for name in shown)
    whole = [name for panel in names(mbdsl.plot(tmp_path / "all.npz")) for name in panel]
    assert whole[0] == "shoulder[1].phi"  # the file contains the residuals of joints


def test_a_selection_is_shown_as_it_is():
    run = mbdsl.simulate(MODELS / "slider_crank.mbd", **SHORT)
    assert names(mbdsl.plot(run[["O.fx", "crank.w"]])) == [["O.fx"], ["crank.w"]]
    assert run[["O.fx"]].shown_names == [["O.fx"]]


def test_angles_that_turn_have_an_axis_of_their_own(tmp_path):
    """Seven-body mechanism: the crank turns, the levers swing. Three panels if a third angle is small beside both."""
    t = np.linspace(0.0, 1.0, 101)
    columns = {"time": t, "a.phi": 900.0 * t, "b.phi": 7.0 * t, "c.phi": 0.3 * np.sin(t), "d.phi": 500.0 * t}
    path = tmp_path / "angles.npz"
    mbdsl.results.write(path, columns, {name: "rad" for name in columns if name != "time"})
    assert names(mbdsl.plot(path, "*")) == [["a.phi", "d.phi"], ["b.phi"], ["c.phi"]]
    assert len(names(mbdsl.plot(path, ["b.phi", "c.phi"]))) == 2
    mbdsl.results.write(path, {**columns, "a.phi": 2.0 * t, "b.phi": 6.0 * t, "d.phi": t})
    assert len(names(mbdsl.plot(path, "*"))) == 1  # none turns round
    assert len(names(mbdsl.plot(path, "*", spectrum=True))) == 1
