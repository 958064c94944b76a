"""mbdsl animate: models, results with and without their model, and what it refuses."""

import json

import numpy as np
import pytest

from mbdsl import load, results
from mbdsl.errors import IntegrationError, UsageError
from mbdsl.lang.stored_model import from_text, to_text
from mbdsl.viewing.stored_result import stored_trajectory

PENDULUM = """model Pendulum
  parameter Length L = 1 m;
  Ground ground; PointMass mass(m = 1 kg); Distance rod(ground, mass, length = L);
initial equation
  mass.x = L; mass.vx = 0; guess mass.y = 0;
  annotation(experiment(StopTime = 0.5 s, Step = 10 ms)); end Pendulum;
"""


@pytest.fixture
def folder(tmp_path):
    (tmp_path / "pendulum.mbd").write_text(PENDULUM)
    return tmp_path


def test_a_model_and_its_result(say, folder):
    """The page of a stored result has the same poses as that of the run."""
    code, out, _ = say("animate", "pendulum.mbd", "--set", "L=2 m", "--quiet")
    assert (code, out) == (0, "")
    assert say("simulate", "pendulum.mbd", "--set", "L=2 m", "--output", "p.npz", "--quiet")[0] == 0
    (folder / "pendulum.mbd").unlink()  # the result contains it
    code, out, _ = say("animate", "p.npz")
    assert code == 0
    assert out.startswith("p.html: ") and out.endswith("frames of 0.5 s\n")
    one, other = ((folder / name).read_text() for name in ("pendulum.html", "p.html"))
    poses = [json.loads(text.partition('id="data">')[2].partition("</script>")[0])["poses"] for text in (one, other)]
    assert poses[0] == poses[1] and len(poses[0]["data"]) > 100


def test_results_without_a_model(say, folder):
    assert say("simulate", "pendulum.mbd", "--output", "p.csv", "--quiet")[0] == 0
    code, _, err = say("animate", "p.csv")
    assert code == 2 and "`p.csv` contains signals, but not the model" in err
    assert "mbdsl animate MODEL.mbd --result p.csv" in err
    assert say("animate", "pendulum.mbd", "--result", "p.csv", "--out", "q.html", "--quiet")[0] == 0
    assert (folder / "q.html").stat().st_size > 10_000


def test_a_ghost_of_another_parameter(say, folder):
    for length in (1, 2):
        arguments = ("--set", f"L={length} m", "--output", f"{length}.npz", "--quiet")
        assert say("simulate", "pendulum.mbd", *arguments)[0] == 0
    assert say("animate", "1.npz", "--ghost", "2.npz", "--out", "p.html", "--quiet")[0] == 0
    text = (folder / "p.html").read_text()
    data = json.loads(text.partition('id="data">')[2].partition("</script>")[0])
    assert data["bounds"][1][0] == pytest.approx(2.0)
    assert data["ghost"]["tracks"] == ["mass"] and data["ghost"]["poses"] != data["poses"]
    code, _, err = say("animate", "1.npz", "--ghost", "pendulum.mbd")
    assert code == 2 and "the ghost `pendulum.mbd` is not a result" in err


def test_results_without_coordinates(say, folder):
    assert say("simulate", "pendulum.mbd", "--signals", "mass.x", "--output", "p.npz", "--quiet")[0] == 0
    code, _, err = say("animate", "p.npz")
    assert code == 2 and "`p.npz` lacks coordinates of bodies: mass.y" in err
    assert "without --signals writes all of them" in err


def test_results_without_velocities_show_their_signals(say, folder):
    assert say("simulate", "pendulum.mbd", "--signals", "mass.x,mass.y,rod.s", "--output", "p.npz", "--quiet")[0] == 0
    trajectory, names = stored_trajectory(folder / "p.npz")
    assert names == ["mass.x", "mass.y", "rod.s"]
    assert trajectory["mass.x"][0] == 1.0
    assert say("animate", "p.npz", "--quiet")[0] == 0


def test_beams_of_results(say, folder, model_file):
    """The elastic coordinates are in an archive, though not among the default signals of other formats."""
    arguments = ("simulate", model_file("flexible_slider_crank"), "--stop", "10 ms", "--quiet", "--output")
    assert say(*arguments, "f.npz")[0] == 0 and say(*arguments, "f.csv")[0] == 0
    columns, meta = results.read(folder / "f.npz")
    assert {"rod.q[7]", "rod.dq[7]"} <= set(columns)
    assert "rod.q[7]" not in results.read(folder / "f.csv")[0]
    trajectory, _ = stored_trajectory(folder / "f.npz")
    assert np.abs(trajectory["rod.q[4]"]).max() > 0.0
    for name in ("rod.x", "rod.b.y"):
        assert trajectory[name] == pytest.approx(columns[name] if name in columns else 0.0 * trajectory.t, abs=1e-9)
    assert meta["complete"]


@pytest.mark.parametrize(
    ("arguments", "expected"),
    [
        (("--out", "p.png"), "unknown suffix `.png` of `p.png`"),
        (("--out", "p.gif", "--size", "641x480"), "`641x480`: expected even numbers"),
        (("--out", "p.gif", "--size", "640"), "expected WIDTHxHEIGHT"),
        (("--out", "p.html", "--size", "640x480"), "--size is for films and pictures"),
        (("--arrows", "forces,none"), "`forces,none`: expected forces, reactions"),
        (("--trace", "masss"), "there is no frame or joint `masss` in Pendulum"),
        (("--signals", "masss"), "there is no signal `masss`"),
        (("--out", "pendulum.mbd.html/x.html"), "there is no folder"),
        (("--result", "missing.csv"), "cannot read `missing.csv`"),
        (("--result", "missing.csv", "--stop", "1"), "--stop belongs to a simulation"),
    ],
)
def test_refusals(say, folder, arguments, expected):
    code, out, err = say("animate", "pendulum.mbd", "--quiet", *arguments)
    assert code == 2 and expected in err and out == ""
    assert not [path for path in folder.iterdir() if path.suffix in (".html", ".gif")]


def test_a_model_is_stored_with_its_imports(tmp_path, monkeypatch):
    """The stored text gives an equal scene when the files are gone."""
    (tmp_path / "parts").mkdir()
    (tmp_path / "parts" / "arm.mbd").write_text(
        "model Arm Frame tip; Rod rod(m = 1 kg, length = 1 m); Revolute pin(tip, rod.a); end Arm;"
    )
    (tmp_path / "a.mbd").write_text(
        'import "parts/arm.mbd"; model A parameter Mass m = 1 kg; Ground ground; Arm arm(ground, rod(m = m)); end A;'
    )
    monkeypatch.chdir(tmp_path)
    scene = load("a.mbd", {"m": "3 kg"}, without=["gravity"])
    text = to_text(scene, {"m": "3 kg"})
    (tmp_path / "a.mbd").unlink(), (tmp_path / "parts" / "arm.mbd").unlink()
    assert from_text(text) == scene
    assert from_text(text).components["arm.rod"].values["m"] == 3.0


@pytest.mark.parametrize("text", ["", "[]", "{}", '{"model": "A", "set": {}, "without": [], "files": {}}'])
def test_damaged_models_are_refused(text):
    with pytest.raises(UsageError, match="the stored model is damaged"):
        from_text(text)


@pytest.mark.parametrize(("failed", "expected"), [(True, 4), (False, 130)])
def test_a_run_that_ends_early_is_shown_up_to_there(say, folder, monkeypatch, slider_crank, failed, expected):
    """The page is written, and the exit code is that of the run."""

    def simulated(scene, asked, stream):
        monkeypatch.setitem(slider_crank.stats, "status", "failed" if failed else "interrupted")
        if not failed:
            return slider_crank
        problem = IntegrationError("Newton's iteration fails at t = 3 s")
        problem.trajectory = slider_crank
        raise problem

    monkeypatch.setattr("mbdsl.api.simulated", simulated)
    code, out, err = say("animate", "pendulum.mbd")
    assert code == expected
    assert out.endswith("301 frames of 3 s\n") and (folder / "pendulum.html").stat().st_size > 10_000
    assert '"mark": "The run ' in (folder / "pendulum.html").read_text(encoding="utf-8").replace('":"', '": "')
    assert ("Newton's iteration fails" in err) if failed else err.endswith("interrupted\n")


def test_a_run_without_any_state_has_no_page(say, folder, monkeypatch):
    def simulated(scene, asked, stream):
        raise IntegrationError("the first step fails")

    monkeypatch.setattr("mbdsl.api.simulated", simulated)
    code, _, err = say("animate", "pendulum.mbd")
    assert (code, err) == (4, "error: the first step fails\n")
    assert not list(folder.glob("*.html"))


@pytest.mark.parametrize(
    ("columns", "expected"),
    [
        ({"x": [1.0]}, "has no column `time`"),
        ({"time": [0.0, 2.0, 1.0], "mass.x": [0.0, 1.0, 2.0], "mass.y": [0.0, 1.0, 2.0]}, "do not ascend"),
        ({"time": [0.0, np.nan], "mass.x": [0.0, 1.0], "mass.y": [0.0, 1.0]}, "do not ascend"),
        ({"time": [0.0, 1.0], "mass.x": [0.0, 1.0, 2.0]}, "lacks coordinates of bodies: mass.x"),
        ({"time": [], "mass.x": [], "mass.y": []}, "the trajectory of Pendulum is empty"),
    ],
)
def test_columns_that_are_no_motion(say, folder, columns, expected):
    results.write(folder / "x.npz", {name: np.array(x) for name, x in columns.items()})
    code, _, err = say("animate", "pendulum.mbd", "--result", "x.npz")
    assert code == 2 and expected in err
