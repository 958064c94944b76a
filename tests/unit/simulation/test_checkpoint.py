"""A run that is stopped and resumed gives the results of an uninterrupted run, bit for bit."""

import os
import shutil

import numpy as np
import pytest

from mbdsl import Builder, Interrupted, UsageError, results, simulate
from mbdsl.integrators import compiled
from mbdsl.simulation.checkpoint import Checkpoint, about
from mbdsl.simulation.resume import resume

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
  annotation(experiment(StopTime = 0.16 s, Interval = 1.3 ms));
end Stops;
"""


@pytest.fixture
def model(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr("mbdsl.simulation.simulate.SLICE", 7)
    (tmp_path / "stops.mbd").write_text(TEXT)
    return "stops.mbd"


class Until:
    """Let a run advance for some slices of steps, and copy its checkpoint files."""

    def __init__(self, count, copies=None):
        self.count, self.copies = count, copies

    def __call__(self, progress):
        if self.copies is not None and os.path.exists("run.cp"):
            self.copies.append(shutil.copy("run.cp", f"{len(self.copies)}.copy"))
        self.count -= 1
        if self.count == 0:
            raise KeyboardInterrupt


def written(run, path):
    """The bytes of all results of a run, except its time of computing."""
    stats = {key: value for key, value in run.stats.items() if key != "seconds"}
    names = (*run.default_names, "pin.fx") if "pin.fx" in run.names else run.default_names
    columns = {"time": run.t, **{name: run[name] for name in names}}
    results.write(path, columns, {}, {key: str(value) for key, value in stats.items()})
    with open(path, "rb") as stream:
        return stream.read()


def part(call, *args, **given):
    """The results of a run that is interrupted."""
    with pytest.raises(Interrupted) as caught:
        call(*args, **given)
    return caught.value.trajectory


SIZES = {"fixed": {"step": 1e-3}, "controlled": {"tol": 1e-4}}


@pytest.mark.parametrize(("method", "steps"), [(name, kind) for name in compiled() for kind in compiled()[name].steps])
def test_stopped_and_resumed(model, method, steps):
    size = SIZES[steps]
    whole = simulate(model, method=method, **size)
    copies = []
    first = part(simulate, model, method=method, **size, progress=Until(2), checkpoint=Checkpoint("run.cp", every=0.0))
    assert first.status == "interrupted" and first.t[-1] < 0.16
    second = part(resume, "run.cp", progress=Until(2, copies))
    assert second.status == "interrupted" and (second.t[-1] > first.t[-1] or "tol" in size)
    third = resume("run.cp", progress=Until(0, copies))
    expected = written(whole, "whole.npz")
    assert written(third, "resumed.npz") == expected
    # a process that was killed after any of its checkpoints
    for copy in {copies[0], copies[-1]}:
        assert written(resume(copy), "resumed.npz") == expected


@pytest.mark.parametrize(
    ("method", "size"), [("hht-si2", {"step": 1e-3}), ("nstiff", {"tol": 1e-4}), ("radau5", {"tol": 1e-4})]
)
def test_states(model, method, size):
    """A pressure, whose size is that of the first run of a calibration, and a steady state."""
    states = "  Pressure p(start = 1 bar); Real z;\n  Force push2(ball.c, fy = 1e-5 m2*p + 1 N*z);\n"
    rates = "  der(p) = (3 bar - 1e5 Pa/m*ball.x - p)/(0.02 s);\n  der(z) = (ball.vx/(1 m/s) - z)/(0.01 s);\n"
    text = TEXT.replace("initial equation\n", f"{states}initial equation\n  der(z) = 0;\n")
    with open(model, "w") as stream:
        stream.write(text.replace("  annotation(", f"equation\n{rates}  annotation("))
    whole = simulate(model, method=method, **size)
    assert whole["p"].max() > 1e5
    part(simulate, model, method=method, **size, progress=Until(2), checkpoint=Checkpoint("run.cp", every=0.0))
    part(resume, "run.cp", progress=Until(2))
    assert written(resume("run.cp"), "resumed.npz") == written(whole, "whole.npz")


FEET = """
model Feet "a block lands on two feet, and friction of both holds it"
  Ground ground(g = 10 m/s2);
  Body block(m = 1 kg, I = 0.1 kg.m2, frames(left = {-0.5 m, -0.1 m}, right = {0.5 m, -0.1 m}));
  Contact a(gap = block.left.y, slip = block.left.vx, mu = 0.5, e = 0);
  Contact b(gap = block.right.y, slip = block.right.vx, mu = 0.5, e = 0);
  Force push(block.c, fx = 1 N);
  Real work(start = 0 J);
equation
  der(work) = a.friction*0.1 m/s;
initial equation
  block.x = 0 m; block.vx = 0 m/s; block.y = 0.101 m; block.phi = 0; block.vy = 0 m/s; block.w = 0 rad/s;
end Feet;
"""


def test_what_is_not_unique_is_said_of_a_run_that_continues(tmp_path, monkeypatch):
    """The block lands at t = 14 ms; what a run noted before its checkpoint is part of its warnings."""
    monkeypatch.chdir(tmp_path)
    path = tmp_path / "feet.mbd"
    path.write_text(FEET)
    monkeypatch.setattr("mbdsl.simulation.simulate.SLICE", 20)
    given = {"stop": 0.2, "step": 1e-3, "method": "hht-si2"}
    whole = simulate(path, **given)
    part(simulate, path, **given, progress=Until(4), checkpoint=Checkpoint("run.cp", every=0.0))
    said = resume("run.cp").stats["warnings"]
    assert said == whole.stats["warnings"] and len(said) == 2
    assert all("not unique from t = 0.0141" in x for x in said)


def test_every_step_and_a_body_that_deforms(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    b = Builder("Strip")
    ground = b.Ground("ground")
    strip = b.FlexibleBeam("strip", length=1.0, mass=0.3, E=1e7, S=1e-3, I=1e-8, formulation="ancf", elements=3)
    pin = b.Revolute("pin", ground, strip.a)
    b.initial(pin.phi, 0.3)
    scene = b.scene()
    given = {"method": "hht-si2", "tol": 1e-3, "interval": 0.0, "stop": 0.1}
    whole = simulate(scene, **given)
    part(simulate, scene, **given, checkpoint="run.cp", progress=Until(1))
    with pytest.raises(UsageError, match=r"`run.cp` does not name the file of its model"):
        resume("run.cp")
    assert written(resume("run.cp", b), "a.npz") == written(whole, "b.npz")


def test_interrupted_before_the_first_output(model):
    """The last step that was reached is in the results, behind the start."""
    found = part(simulate, model, method="hht-si2", step=1e-3, interval=0.16, progress=Until(1))
    assert found.t == pytest.approx([0.0, 7e-3]) and found["rod.phi"][1] != found["rod.phi"][0]


def test_a_start_that_is_not_zero(model):
    """Pulses that a run looks out for are those of an uninterrupted run."""
    with open(model, "w") as stream:
        stream.write(
            TEXT.replace("push(time)", "20 N*exp(-((time - 0.4 s)/(0.1 ms))^2)")
            .replace("Interval", "StartTime = 0.3 s, Interval")
            .replace("StopTime = 0.16 s", "StopTime = 0.46 s")
        )
    whole = simulate(model, method="radau5", tol=1e-4)
    assert whole.t[0] == 0.3 and whole.t[-1] == 0.46
    part(simulate, model, method="radau5", tol=1e-4, progress=Until(1), checkpoint=Checkpoint("run.cp", every=0.0))
    assert written(resume("run.cp"), "resumed.npz") == written(whole, "whole.npz")


def test_where_pivots_are_searched_for(model, monkeypatch):
    """The other solver has other buffers."""
    from mbdsl.integrators.loop import linear_solve
    from mbdsl.integrators.run import MethodRun

    begin = MethodRun.begin

    def pivoting(self, *given, **named):
        if named.get("t") is None:
            self.use_solver(linear_solve.DENSE)
        begin(self, *given, **named)

    with monkeypatch.context() as other:
        other.setattr(MethodRun, "begin", pivoting)
        whole = simulate(model, step=1e-3)
        part(simulate, model, step=1e-3, checkpoint="run.cp", progress=Until(2))
    assert written(resume("run.cp"), "a.npz") == written(whole, "b.npz")


# -- the command --------------------------------------------------------------------------------------------------
def test_the_commands(model, say, monkeypatch):
    class Impatient(Until):
        def __init__(self, stream):
            super().__init__(3)

        say = close = lambda self, *line: None

    asked = ("simulate", model, "--step", "1ms", "--set", "M=2 kg", "--signals", "rod.*,ball.x", "--quiet")
    assert say(*asked, "--output", "whole.csv") == (0, "", "")
    with monkeypatch.context() as other:
        other.setattr("mbdsl.cli._runs.Display", Impatient)
        code, _, err = say(*asked[:-1], "--output", "part.csv", "--checkpoint", "run.cp", "--stats", "s.json")
    assert code == 130
    assert err == (
        f"part.csv ends at t = {results.read('part.csv')[0]['time'][-1]:g} s and is marked incomplete\n"
        "to continue:  mbdsl resume run.cp\ninterrupted\n"
    )
    folder = os.path.basename(os.getcwd())
    monkeypatch.chdir("..")  # the command writes to the same file as the first one
    assert say("resume", f"{folder}/run.cp", "--quiet") == (0, "", "")
    assert not os.path.exists(f"{folder}/run.cp") and os.path.exists(f"{folder}/s.json")
    with open(f"{folder}/part.csv", "rb") as part, open(f"{folder}/whole.csv", "rb") as whole:
        assert part.read() == whole.read()


# -- refused checkpoints -----------------------------------------------------------------------------------------------
@pytest.fixture
def kept(model):
    part(simulate, model, step=1e-3, checkpoint="run.cp", progress=Until(2))
    with open("run.cp", "rb") as stream:
        return stream.read()


def test_damaged_and_foreign_files(kept, say):
    np.savez("other.npz", a=np.zeros(3))
    np.savez("objects.npz", about=np.array([{}], dtype=object))
    for name in ("stops.mbd", "other.npz", "objects.npz"):
        with open(name, "rb") as stream:
            foreign = stream.read()
        code, out, err = say("resume", name)
        assert (code, out, err.count("\n")) == (2, "", 1)
        assert err.startswith(f"error: `{name}` is not a checkpoint of mbdsl, or is damaged: ")
        with pytest.raises(UsageError, match="is not a checkpoint"):  # and it is not overwritten
            simulate("stops.mbd", checkpoint=name)
        with open(name, "rb") as stream:
            assert stream.read() == foreign
    rng = np.random.default_rng(5)
    for cut in (0, 1, 100, len(kept) // 2, len(kept) - 1):
        with open("cut.cp", "wb") as stream:
            stream.write(kept[:cut])
        assert say("resume", "cut.cp")[0] == 2
    for at in rng.integers(0, len(kept), 40):  # any bit: the change is detected, or the bit has no effect
        with open("bit.cp", "wb") as stream:
            stream.write(kept[:at] + bytes([kept[at] ^ 4]) + kept[at + 1 :])
        try:
            said = about("bit.cp")
        except UsageError:
            continue
        assert said == about("run.cp")


def test_a_model_that_has_changed(kept):
    with open("stops.mbd", "w") as stream:
        stream.write(TEXT.replace("k = 50 N/m", "k = 50.000000001 N/m"))
    with pytest.raises(UsageError, match=r"cannot resume from .*: the model is a different one, or has changed"):
        resume("run.cp")
    with open("stops.mbd", "w") as stream:
        stream.write("// the same\n" + TEXT)
    assert resume("run.cp").status == "done"


def test_what_has_no_checkpoints(model):
    with pytest.raises(UsageError, match="there are no checkpoints of scipy-dop853"):
        simulate(model, method="scipy-dop853", checkpoint="run.cp")
    with pytest.raises(UsageError, match="runs with an accuracy have no checkpoints"):
        simulate(model, accuracy=1e-3, checkpoint="run.cp")
    with pytest.raises(UsageError, match=r"cannot write `no/run\.cp`"):
        simulate(model, step=1e-3, checkpoint=Checkpoint("no/run.cp", every=0.0))
    assert os.listdir() == ["stops.mbd"]


def test_a_full_disk_ends_no_run(model, monkeypatch, capsys):
    whole = simulate(model, step=0.01)

    def full(path):
        raise UsageError(f"cannot write `{path}`: No space left on device")

    monkeypatch.setattr("mbdsl.simulation.checkpoint.writing", full)
    found = simulate(model, step=0.01, checkpoint=Checkpoint("run.cp", 0.0))
    assert found.status == "done" and np.array_equal(found.q, whole.q)
    warning = "the last checkpoint is missing: cannot write `run.cp`: No space left on device"
    assert warning in found.stats["warnings"] and warning not in whole.stats["warnings"]
    with pytest.raises(Interrupted) as caught:
        simulate(model, step=0.01, checkpoint=Checkpoint("run.cp", 0.0), progress=Until(1))
    assert len(caught.value.trajectory.t) > 1 and warning in caught.value.trajectory.stats["warnings"]


def test_a_file_that_cannot_be_written_is_refused_before_the_run(model):
    with pytest.raises(UsageError, match="there is no folder `nowhere`"):
        simulate(model, step=0.01, checkpoint="nowhere/run.cp")
