"""Rows that are taken from a run while it goes on: the same results, bounded memory, nothing lost."""

import os
import shutil
import tracemalloc
from dataclasses import replace

import numpy as np
import pytest

from mbdsl import UsageError, results, simulate
from mbdsl.integrators.output_times import OutputTimes
from mbdsl.results.rows_file import RowsFile
from mbdsl.simulation import streaming, tolerance_calibration
from mbdsl.simulation.ladder_constants import LADDER
from mbdsl.simulation.simulate import simulated
from mbdsl.simulation.streaming import Stream

# A switch in the state, corners in time, friction, a part that is a function of time, and an independent part.
TEXT = """model Stops
  Ground g0;
  Table push(table = [0 s, 0 N; 0.03 s, 5 N; 0.05 s, 0 N], extrapolation = "periodic");
  parameter Mass M = 1 kg;
  Rod rod(m = M, length = 1 m);
  Revolute pin(g0, rod.a, mu = 0.1, radius = 10 mm, w_s = 0.1 rad/s);
  Torque stop(g0, rod.a, tau = if rod.phi < -1.2 then -400 N.m*(rod.phi + 1.2) else 0 N.m);
  Force side(rod.b, fx = push(time));
  Body cam(m = 1 kg, I = 0.01 kg.m2);
  Revolute axle(g0, cam.c);
  RotationalDriver turn(axle, phi = 3 rad/s*time);
  PointMass ball(m = 1 kg);
  SpringDamper spring(g0, ball.c, k = 50 N/m, c = 0.1 N.s/m, s0 = 1 m);
initial equation
  pin.phi = -60 deg; ball.x = 1.1 m; ball.y = 0 m; ball.vy = 1 m/s;
  annotation(experiment(StopTime = 0.16 s));
end Stops;
"""


@pytest.fixture
def model(tmp_path, monkeypatch):
    """A model of several parts; runs are streamed in blocks of 16 rows, and windows of few more."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr("mbdsl.simulation.simulate.SLICE", 7)
    monkeypatch.setattr(streaming, "LEAST", 0)
    monkeypatch.setattr(streaming, "BLOCK", 16)
    monkeypatch.setattr(streaming, "FEWEST", 16)
    monkeypatch.setattr("mbdsl.system.batch_accelerations.MANY", 16)
    monkeypatch.setattr("mbdsl.results.rows_file.ROWS", 32)
    few(monkeypatch, 20)
    (tmp_path / "stops.mbd").write_text(TEXT)
    return "stops.mbd"


def few(monkeypatch, count):
    for module in (streaming, tolerance_calibration):
        monkeypatch.setattr(module, "LADDER", replace(LADDER, most_compared=count))


def columns(stream):
    return {name: x[:] for name, x in stream.file.columns().items()}


def streamed(model, names=lambda found: found.names, **given):
    stream = Stream("r.csv", names)
    try:
        last = simulated(model, **given, stream=stream)
        return columns(stream), last
    finally:
        stream.close()


@pytest.mark.parametrize(
    "given",
    [
        {"step": 1e-3, "interval": 0.0},
        {"step": 1e-3, "interval": 0.3e-3},
        {"step": 1e-3, "interval": 1.7e-3},
        {"tol": 1e-3, "interval": 1e-3},
        {"tol": 1e-3, "interval": 0.0},
    ],
)
def test_the_results_are_those_in_memory(model, given):
    found, last = streamed(model, **given)
    whole = simulate(model, **given)
    assert list(found) == whole.names
    assert len(found["time"]) == len(whole.t) > 60
    for name in whole.names:
        assert np.array_equal(found[name], whole[name], equal_nan=True), name
    assert len(last.t) < 40 < len(whole.t)
    counts = ("steps", "trial_steps", "iterations", "error", "warnings", "status")
    assert [last.stats[key] for key in counts] == [whole.stats[key] for key in counts]


def test_short_results_stay_in_memory(model, monkeypatch):
    few(monkeypatch, 1000)
    stream = Stream("r.csv", lambda found: found.names)
    assert len(simulated(model, step=1e-3, interval=0.0, stream=stream).t) == 161
    assert stream.file is None


def test_a_mechanism_without_equations(model):
    """A motion that is a function of time only has no steps, and its rows are computed in parts as well."""
    text = TEXT.split("  Body cam")[1].split("  PointMass")[0]
    with open("cam.mbd", "w") as file:
        file.write(f"model Cam\n  Ground g0;\n  Body cam{text}  annotation(experiment(StopTime = 1 s));\nend Cam;\n")
    found, _ = streamed("cam.mbd", step=1e-3, interval=1e-3)
    assert len(found["time"]) == 1001
    assert found["cam.phi"] == pytest.approx(3.0 * found["time"], abs=1e-14)


def test_a_warning_needs_all_rows(model):
    """A contact that the steps do not resolve."""
    with open("stiff.mbd", "w") as file:
        file.write(
            "model Stiff\n  Ground g0;\n  PointMass a(m = 1 kg);\n"
            "  Force f(a.c, fx = if a.x < 0 then -1e6 N/m*a.x else 0 N, fy = 0 N);\n"
            "initial equation\n  a.x = 0.3 m; a.y = 0 m; a.vx = -1 m/s; a.vy = 0 m/s;\n"
            "  annotation(experiment(StopTime = 1 s));\nend Stiff;\n"
        )
    given = {"step": 7e-3, "interval": 0.0}
    whole = simulate("stiff.mbd", **given)
    assert whole.stats["warnings"], "this step resolves the contact: the test needs another one"
    assert streamed("stiff.mbd", **given)[1].stats["warnings"] == whole.stats["warnings"]


# -- nothing is lost ----------------------------------------------------------------------------------------------
class Impatient:
    """A display that interrupts the run after some slices of steps."""

    slices = 3

    def __init__(self, stream):
        self.count = self.slices

    def __call__(self, progress):
        self.count -= 1
        if self.count == 0:
            raise KeyboardInterrupt

    say = close = lambda self, *line: None


@pytest.mark.parametrize("settings", [("--step", "1ms", "--interval", "0.3ms"), ("--tol", "1e-3", "--interval", "0s")])
def test_an_interrupted_run_keeps_its_rows_and_is_resumed(model, say, monkeypatch, settings):
    asked = ("simulate", model, *settings, "--signals", "rod.*,ball.x", "--quiet")
    assert say(*asked, "--output", "whole.csv")[::2] == (0, "")
    whole, resumed = results.read("whole.csv")[0], 0
    part = None
    for slices in (1, 5, 2, 30):
        with monkeypatch.context() as other:
            other.setattr(Impatient, "slices", slices)
            other.setattr("mbdsl.cli._runs.Display", Impatient)
            first = (*asked[:-1], "--output", "part.csv", "--checkpoint", "run.cp")
            code, _, err = say(*first) if part is None else say("resume", "run.cp")
        if code == 0:
            break
        part, meta = results.read("part.csv")
        assert (code, meta["complete"]) == (130, False)
        assert "to continue:  mbdsl resume run.cp" in err
        resumed += 1
        if settings[0] == "--step":  # the last row is that of the last step
            done = len(part["time"]) - 1
            for name in whole:
                assert np.array_equal(part[name][:done], whole[name][:done])
    assert resumed >= 2
    if code:
        assert say("resume", "run.cp", "--quiet")[0] == 0
    with open("part.csv", "rb") as one, open("whole.csv", "rb") as other:
        assert one.read() == other.read()
    assert [name for name in os.listdir() if name.startswith(("run.cp", ".mbdsl"))] == []


def test_resume_from_a_checkpoint_that_is_older_than_the_rows(model, say, monkeypatch):
    """After a power cut: the file of rows has more rows than the checkpoint counts."""

    class Cut(Impatient):
        def __call__(self, progress):
            if self.count == 4:
                shutil.copy("run.cp", "old.cp")
            super().__call__(progress)

    asked = ("simulate", model, "--step", "1ms", "--interval", "0.3ms", "--checkpoint-every", "1ns")
    with monkeypatch.context() as other:
        other.setattr(Impatient, "slices", 8)
        other.setattr("mbdsl.cli._runs.Display", Cut)
        assert say(*asked, "--output", "part.csv", "--checkpoint", "run.cp")[0] == 130
    os.replace("old.cp", "run.cp")
    assert say("resume", "run.cp", "--quiet")[0] == 0
    assert say(*asked, "--output", "whole.csv", "--quiet")[0] == 0
    with open("part.csv", "rb") as one, open("whole.csv", "rb") as other:
        assert one.read() == other.read()


def test_a_failed_run_keeps_its_rows(model, say):
    with open("fails.mbd", "w") as file:
        file.write(
            "model Fails\n  Ground g0;\n  PointMass a(m = 1 kg);\n"
            "  Force f(a.c, fx = 1 N*sqrt(1 - time/1.0), fy = 0 N);\n"
            "initial equation\n  a.x = 0 m; a.y = 0 m; a.vx = 0 m/s; a.vy = 0 m/s;\n"
            "  annotation(experiment(StopTime = 2 s));\nend Fails;\n"
        )
    code, _, err = say("simulate", "fails.mbd", "--step", "10ms", "--interval", "10ms")
    assert code not in (0, 130) and "not finite" in err
    found, meta = results.read("fails.csv")
    assert not meta["complete"]
    assert found["time"] == pytest.approx(0.01 * np.arange(len(found["time"])))
    assert 95 < len(found["time"]) <= 102


def test_a_full_disk_ends_the_run_and_keeps_the_rows(model, say, monkeypatch):
    append, written = RowsFile.append, []

    def full(self, columns):
        if self.count > 40:
            raise UsageError("cannot write the results: No space left on device")
        written.append(len(columns[0]))
        append(self, columns)

    monkeypatch.setattr(RowsFile, "append", full)
    code, _, err = say("simulate", model, "--step", "1ms", "--interval", "1ms", "--output", "r.csv")
    found, meta = results.read("r.csv")
    assert code == 2 and "No space left on device" in err and not meta["complete"]
    assert found["time"] == pytest.approx(1e-3 * np.arange(sum(written)), abs=1e-15)


# -- bounded memory ------------------------------------------------------------------------------------------------
def test_output_times_in_parts_are_those_of_the_whole():
    times = OutputTimes(0.1, 1.0, 0.7e-3, 1286)
    whole = 0.1 + 0.7e-3 * np.arange(1.0, 1287)
    whole[-1] = 1.0
    parts = [times.part(k, min(k + 100, 1286)) for k in range(0, 1286, 100)]
    assert np.array_equal(np.concatenate(parts), whole)
    assert np.array_equal(times.at([3, 1285]), whole[[3, 1285]])


def test_memory_does_not_grow_with_the_rows(model, monkeypatch):
    """NumPy's arrays, which tracemalloc counts: 60,000 rows of 18 numbers are 8.6 MB, 5,000 rows 0.7 MB."""
    monkeypatch.setattr(streaming, "BLOCK", 512)
    monkeypatch.setattr("mbdsl.simulation.simulate.SLICE", 1000)
    peaks = []
    for rows in (500, 5000, 60_000):  # the first run imports and compiles
        tracemalloc.start()
        found, _ = streamed(model, lambda found: ["rod.phi"], step=1e-4, interval=0.16 / rows)
        peaks.append(tracemalloc.get_traced_memory()[1] - found["time"].nbytes * 2)
        tracemalloc.stop()
        assert len(found["time"]) == rows + 1
    assert peaks[2] - peaks[1] < 2.0e6
