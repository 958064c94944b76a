"""The whole path from a shell: from a model to a result file and an exit code."""

import json
import os
import signal
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import mbdsl
from mbdsl import results

#: the package under test, wherever it was imported from
ENVIRONMENT = {**os.environ, "PYTHONPATH": str(Path(mbdsl.__file__).parents[1])}
MODELS = Path(__file__).parents[2] / "models"
ENDING = """\
model Ending "its force has no value from t = 0.5 s on"
  Ground world;
  Rod rod(m = 1 kg, length = 1 m);
  Revolute pin(world, rod.a);
  Force pull(rod.b, fx = 1 N*sqrt(0.5 - time/1 s));
  annotation(experiment(StopTime = 1 s));
end Ending;
"""
TORN = """\
model Torn "two walls, farther apart than the rod is long"
  Ground world;
  Frame wall(world, r = {3 m, 0});
  Rod rod(m = 1 kg, length = 1 m);
  Revolute left(world, rod.a);
  Revolute right(wall, rod.b);
  annotation(experiment(StopTime = 1 s));
end Torn;
"""


def shell(*argv, cwd):
    command = [sys.executable, "-m", "mbdsl", *map(str, argv)]
    return subprocess.run(command, cwd=cwd, env=ENVIRONMENT, capture_output=True, text=True, check=False)


def test_slider_crank_from_a_shell(tmp_path):
    done = shell(
        "simulate",
        MODELS / "slider_crank.mbd",
        "--method",
        "hht-si2",
        "--stats",
        "s.json",
        "--step",
        "1ms",
        cwd=tmp_path,
    )
    assert done.returncode == 0, done.stderr
    columns, meta = results.read(tmp_path / "slider_crank.csv")
    assert meta["complete"]
    assert columns["time"][[0, -1]].tolist() == [0.0, 2.0]
    bodies = [f"{body}.{key}" for key in ("x", "y", "phi", "vx", "vy", "w") for body in ("crank", "rod")]
    assert set(columns) == {"time", *bodies}
    # The reference angle at 2 s is -0.758205624274767; the error of an order-2 method at h = 1 ms is some 1e-6.
    assert columns["crank.phi"][-1] == pytest.approx(-0.758205624274767, abs=1e-5)
    stats = json.loads((tmp_path / "s.json").read_text())
    assert (stats["method"], stats["h"], stats["status"], stats["n"], stats["m"]) == ("hht-si2", 1e-3, "done", 6, 5)


@pytest.mark.parametrize("suffix", sorted(results.formats()))
def test_every_format_holds_the_same(tmp_path, suffix):
    signals = "crank.phi,O.f?,energy.total"
    for name in ("a.csv", f"b{suffix}"):
        done = shell("simulate", MODELS / "slider_crank.mbd", "--signals", signals, "--output", name, cwd=tmp_path)
        assert done.returncode == 0, done.stderr
    one, other = (results.read(tmp_path / name)[0] for name in ("a.csv", f"b{suffix}"))
    assert list(one) == list(other) == ["time", "crank.phi", "O.fx", "O.fy", "energy.total"]
    assert all(np.array_equal(one[name], other[name]) for name in one)


def test_integration_that_cannot_go_on(tmp_path):
    (tmp_path / "ending.mbd").write_text(ENDING)
    done = shell("simulate", "ending.mbd", "--interval", "0", cwd=tmp_path)
    assert done.returncode == 4, done.stderr
    assert "error: " in done.stderr
    assert "t = 0.5" in done.stderr
    assert "Traceback" not in done.stderr
    columns, meta = results.read(tmp_path / "ending.csv")
    assert meta["complete"] is False
    assert columns["time"][-1] == pytest.approx(0.5, abs=2e-3)


def test_model_that_cannot_be_assembled(tmp_path):
    (tmp_path / "torn.mbd").write_text(TORN)
    done = shell("simulate", "torn.mbd", cwd=tmp_path)
    assert done.returncode == 3, done.stderr
    assert "torn.mbd:" in done.stderr
    assert "Traceback" not in done.stderr
    assert os.listdir(tmp_path) == ["torn.mbd"]


@pytest.mark.skipif(os.name == "nt", reason="sends a POSIX signal")
def test_interruption_keeps_what_there_is(tmp_path, default_signals):
    argv = [sys.executable, "-m", "mbdsl", "simulate", MODELS / "slider_crank.mbd", "--stop", "1e6", "--interval", "10"]
    argv += ["--step", "1ms"]
    pipes = {"stdout": subprocess.DEVNULL, "stderr": subprocess.PIPE, "text": True}
    with subprocess.Popen(argv, cwd=tmp_path, env=ENVIRONMENT, **pipes) as process:
        for line in process.stderr:  # progress is shown after a while
            if "iterations/step" in line:
                process.send_signal(signal.SIGINT)
                break
        rest = process.stderr.read()
    assert process.returncode == 130
    assert "is marked incomplete\ninterrupted\n" in rest
    columns, meta = results.read(tmp_path / "slider_crank.csv")
    assert meta["complete"] is False
    assert 0.0 <= columns["time"][-1] < 1e6
