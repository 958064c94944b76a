"""The row of units that `simulate`, `resume` and `static` write into a .csv file, read by commands and by pandas."""

import argparse

import numpy as np
import pandas
import pytest

from mbdsl import results
from mbdsl.cli import resume
from mbdsl.results.stored import open_result

MODEL = """model M
  Ground g;
  PointMass ball(m = 1 kg);
  FreeMotion free(g, ball);
  SpringDamper spring(g.c, ball.c, k = 100 N/m, s0 = 0.1 m);
initial equation
  ball.y = -0.2 m;
  annotation(experiment(StopTime = 0.1 s, Step = 1 ms));
end M;
"""


@pytest.fixture
def model(say, tmp_path):
    (tmp_path / "m.mbd").write_text(MODEL, encoding="utf-8")
    return tmp_path


def test_a_run_writes_units_that_others_read(model, say):
    signals = ["--signals", "ball.y,ball.vy,spring.force", "--quiet"]
    assert say("simulate", "m.mbd", *signals, "--output", "plain.csv")[0] == 0
    assert say("simulate", "m.mbd", *signals, "--output", "units.csv", "--units")[0] == 0
    lines = (model / "units.csv").read_bytes().split(b"\n")
    assert lines[1] == b"s,m,m/s,N"
    assert lines[0:1] + lines[2:] == (model / "plain.csv").read_bytes().split(b"\n")
    frame = pandas.read_csv("units.csv", header=[0, 1])  # two header rows: names and units
    assert frame.columns.tolist() == [("time", "s"), ("ball.y", "m"), ("ball.vy", "m/s"), ("spring.force", "N")]
    columns, _ = results.read("units.csv")
    assert np.array_equal(frame[("spring.force", "N")], columns["spring.force"])
    assert open_result("units.csv").unit("spring.force") == "N"
    assert open_result("plain.csv").unit("spring.force") == ""


def test_commands_read_them_back(model, say):
    say("simulate", "m.mbd", "--signals", "ball.*,spring.force", "--output", "u.csv", "--units", "--quiet")
    assert "spring.force  N " in say("info", "u.csv", "--signals", "spring.force")[1]
    assert say("plot", "u.csv", "--list")[1].splitlines()[-1] == "spring.force [N]"
    assert "spring.force [N]" in say("plot", "u.csv", "--signals", "spring.force")[1]
    code, out, _ = say("animate", "m.mbd", "--result", "u.csv", "--out", "u.html")
    assert code == 0 and out.endswith("501 frames of 0.1 s\n")


def test_an_equilibrium_with_units(model, say):
    assert say("static", "m.mbd", "--signals", "ball.y,spring.force", "--output", "e.csv", "--units")[0] == 0
    header, units, row = (model / "e.csv").read_text(encoding="utf-8").splitlines()
    assert (header, units) == ("time,ball.y,spring.force", "s,m,N")
    assert float(row.split(",")[2]) == pytest.approx(9.81, rel=1e-9)  # the weight


@pytest.mark.parametrize(
    ("stored", "asked", "expected"),
    [({}, None, False), ({"units": True}, None, True), ({"units": "deg"}, None, "deg"), ({"units": False}, "", "")],
)
def test_a_resumed_run_writes_them_as_the_first_one_or_as_asked(monkeypatch, stored, asked, expected):
    command = {"model": "m.mbd", "output": "m.csv", "set": [], "option": [], "without": [], **stored}
    monkeypatch.setattr("mbdsl.simulation.checkpoint.about", lambda path: {"command": command})
    monkeypatch.setattr("mbdsl.cli.simulate.run", lambda former, resumed: former.units)
    args = argparse.Namespace(
        checkpoint="c", method=None, output=None, stats="c.json", quiet=False, verbose=False, units=asked
    )
    assert resume.run(args) == expected
