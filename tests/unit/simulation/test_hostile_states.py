"""Checkpoints and saved states with impossible content: an error of one line, or the right result; never a signal.

Compiled code does not check its indices, so a number that is not checked ends the process or writes into foreign
memory.
"""

import io
import json
import os
import pickle
import subprocess
import sys
import zipfile
from importlib import import_module

import numpy as np
import pytest

import mbdsl
from mbdsl import Interrupted, UsageError
from mbdsl.simulation.checkpoint import Checkpoint
from mbdsl.simulation.resume import resume

#: a switch, friction, a table, peaks of a law, and an independent part
TEXT = """model Stop
  Ground g;
  Table push(table = [0 s, 0 N; 0.03 s, 5 N; 0.05 s, 0 N], extrapolation = "periodic");
  Rod rod(m = 1 kg, length = 1 m);
  Revolute pin(g, rod.a, mu = 0.1, radius = 10 mm, w_s = 0.1 rad/s);
  Torque stop(g, rod.a, tau = if rod.phi < -1.2 then -400 N.m*(rod.phi + 1.2) else 0 N.m);
  Force side(rod.b, fx = push(time));
  PointMass ball(m = 1 kg);
  SpringDamper spring(g, ball.c, k = 50 N/m, c = 0.1 N.s/m, s0 = 1 m);
initial equation
  pin.phi = -60 deg; ball.x = 1.1 m; ball.y = 0 m; ball.vy = 1 m/s;
  annotation(experiment(StopTime = 0.1 s, Interval = 5 ms));
end Stop;
"""
WRONG = (2**33, -1)
#: the run of a checkpoint with other values, in a child; it reports a signal by its return code
CHILD = """
import json, sys
from test_hostile_states import outcomes
print(json.dumps(outcomes(sys.argv[1])))
"""


def refusal(function, *arguments):
    """The message of the error that a call raises, or nothing."""
    try:
        function(*arguments)
    except UsageError as problem:
        return problem.message
    return ""


def stopped(**given):
    """The checkpoint of a run that was interrupted, as a description and its arrays."""

    class Once:
        count = 2

        def __call__(self, progress):
            self.count -= 1
            if self.count == 0:
                raise KeyboardInterrupt

    with pytest.raises(Interrupted):
        mbdsl.simulate("stop.mbd", **given, progress=Once(), checkpoint=Checkpoint("run.cp", every=0.0))
    with np.load("run.cp") as archive:
        return {name: archive[name] for name in archive.files}


def changed(arrays, path="changed.cp", **others):
    with zipfile.ZipFile(path, "w") as archive:
        for name, values in (arrays | others).items():
            stream = io.BytesIO()
            np.lib.format.write_array(stream, values)
            archive.writestr(f"{name}.npy", stream.getvalue())
    return path


def entries(arrays):
    """Entries of the arrays of integers of one part: all of the state, some of the layout and of the pivots."""
    rng = np.random.default_rng(1)
    for name in (f"0.parts.0.run.{key}" for key in ("integers", "layout", "pivots")):
        values = arrays[name]
        few = range(values.size) if values.size < 40 else rng.choice(min(values.size, 60), 12, replace=False).tolist()
        for k in few:
            for wrong in WRONG:
                other = values.copy()
                other.flat[k] = wrong
                yield f"{name}[{k}] = {wrong}", {name: other}


def outcomes(kind):
    """Resume with each wrong entry: the number of errors and of right results; a list of all else."""
    import_module("mbdsl.simulation.simulate").SLICE = 7
    given = {"fixed": {"step": 1e-3}, "controlled": {"tol": 1e-3}}[kind]
    with open("stop.mbd", "w") as stream:
        stream.write(TEXT)
    whole = mbdsl.simulate("stop.mbd", **given)
    arrays = stopped(**given)
    refused = right = 0
    wrong = []
    for what, other in entries(arrays):
        print(what, file=sys.stderr, flush=True)  # the last one before a signal
        try:
            found = resume(changed(arrays, **other))
        except mbdsl.MbdslError as problem:
            refused += 1
            if "\n" in problem.message:
                wrong.append(what)
        else:
            same = found.q.shape == whole.q.shape and bool(np.abs(found.q - whole.q).max() < 1e-3)
            right += same
            wrong += [] if same else [what]
    return [refused, right, wrong]


@pytest.mark.parametrize("kind", ["fixed", "controlled"])
def test_no_integer_of_a_checkpoint_harms(kind, tmp_path):
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join([os.path.dirname(__file__), *sys.path])}
    done = subprocess.run(
        [sys.executable, "-c", CHILD, kind], cwd=tmp_path, env=environment, capture_output=True, text=True
    )
    assert done.returncode == 0, done.stderr[-2000:]
    refused, right, wrong = json.loads(done.stdout.splitlines()[-1])
    assert not wrong and refused > 40 and right > 20


@pytest.fixture
def kept(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr("mbdsl.simulation.simulate.SLICE", 7)
    (tmp_path / "stop.mbd").write_text(TEXT)
    return stopped(tol=1e-3)


def test_wrong_shapes_types_and_numbers(kept):
    """Also of the buffers of real numbers, and of the texts and numbers that describe the run."""
    for name, values in kept.items():
        if name == "about" or not values.size or name.startswith("0.parts.1"):
            continue
        for other in (values.ravel()[:-1], values.astype("U8")):
            with pytest.raises(UsageError, match="is not a checkpoint of mbdsl, or is damaged"):
                resume(changed(kept, **{name: other}))
    about = json.loads(kept["about"].item())
    run = about["runs"][-1]["values"]["parts"]["list"][0]["values"]["run"]["values"]
    for key in run:
        for value in ("text", -7):
            before, run[key] = run[key], value
            refused = refusal(resume, changed(kept, about=np.array(json.dumps(about))))
            assert "\n" not in refused
            run[key] = before
    reals = kept[run["reals"]["array"]]
    for value in (np.nan, np.inf, -1e300):
        other = reals.copy()
        other[10] = value  # the time reached
        with pytest.raises(UsageError, match="damaged"):
            resume(changed(kept, **{run["reals"]["array"]: other}))


def test_arguments_of_the_run(kept):
    about = json.loads(kept["about"].item())
    about["about"]["given"]["checkpoint"] = "victim"
    with pytest.raises(UsageError, match="arguments that a run does not have"):
        resume(changed(kept, about=np.array(json.dumps(about))))


def test_settings_and_layout_are_those_of_the_model(kept):
    """What follows from the model is not read: the result is the right one, to the last bit."""
    whole = resume(changed(kept))
    name = next(name for name in kept if name.endswith("layout"))
    flags = kept[name].copy()
    other = np.full_like(flags, 5)
    other[[26, 33]] = flags[[26, 33]]
    found = resume(changed(kept, **{name: other}))
    assert np.array_equal(found.q, whole.q)


@pytest.mark.parametrize("method", ["hht-si2", "radau5"])
def test_saved_states_of_a_simulation(method):
    simulation = mbdsl.Simulation(mbdsl.parse(TEXT), step=1e-3, method=method)
    simulation.step(20)
    state = simulation.state
    simulation.step(5)
    q = simulation["rod.phi"]
    run = state.runs[0]
    for name in ("layout", "integers", "pivots"):
        for k in [*range(36), run[name].size - 1]:
            other = pickle.loads(pickle.dumps(state))
            other.runs[0][name].flat[k] = 2**33
            refused = refusal(setattr, simulation, "state", other)
            assert refused.startswith("the state is damaged: ") or not refused
            if not refused:
                simulation.step(5)
                assert simulation["rod.phi"] == q
    other = pickle.loads(pickle.dumps(state))
    other.runs[0]["vectors"] = other.runs[0]["vectors"][:, :1]
    with pytest.raises(UsageError, match="the state is damaged"):
        simulation.state = other
    simulation.state = state
    simulation.step(5)
    assert simulation["rod.phi"] == q


# -- the files that a checkpoint names ---------------------------------------------------------------------------------
@pytest.fixture
def command(tmp_path, monkeypatch, say):
    """A checkpoint of the command line, in a folder of its own."""

    class Impatient:
        count = 2

        def __init__(self, stream):
            pass

        def __call__(self, progress):
            self.count -= 1
            if self.count == 0:
                raise KeyboardInterrupt

        say = close = lambda self, *line: None

    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr("mbdsl.simulation.simulate.SLICE", 7)
    (tmp_path / "work").mkdir()
    (tmp_path / "stop.mbd").write_text(TEXT)
    with monkeypatch.context() as patch:
        patch.setattr("mbdsl.cli._runs.Display", Impatient)
        more = ("--output", "other.csv", "--stats", "work/s.json", "--checkpoint", "work/run.cp")
        code, _, err = say("simulate", "stop.mbd", "--step", "1ms", *more)
    assert code == 130 and "to continue:  mbdsl resume work/run.cp --output other.csv\n" in err
    with np.load("work/run.cp") as archive:
        return {name: archive[name] for name in archive.files}


@pytest.mark.parametrize("key", ["output", "stats", "method_file", "checkpoint"])
def test_a_checkpoint_names_no_file_that_is_overwritten(key, command, say, tmp_path):
    victim = tmp_path / "victim.csv"
    victim.write_text("precious")
    about = json.loads(command["about"].item())
    about["about"]["command"][key] = str(victim)
    changed(command, "work/run.cp", about=np.array(json.dumps(about)))
    say("resume", "work/run.cp", "--quiet")
    assert victim.read_text() == "precious"


def test_results_go_beside_the_checkpoint_or_where_the_command_says(command, say, tmp_path):
    (tmp_path / "other.csv").write_text("time\n")
    changed(command, "work/again.cp")
    assert say("resume", "work/run.cp", "--quiet") == (0, "", "")
    assert sorted(os.listdir("work")) == ["again.cp", "other.csv", "s.json"]
    assert (tmp_path / "other.csv").read_text() == "time\n"
    code, _, err = say("resume", "work/again.cp", "--quiet", "--output", "here.npz", "--stats", "here.json")
    assert (code, err) == (0, "")
    assert {"here.npz", "here.json"} <= set(os.listdir())


@pytest.mark.parametrize("name", [".bashrc", "s.txt", ".s.json", "run.mbd"])
def test_no_hidden_file_beside_the_checkpoint(name, command, say, tmp_path):
    (tmp_path / "work" / name).write_text("precious")
    for key in ("output", "stats"):
        about = json.loads(command["about"].item())
        about["about"]["command"][key] = str(tmp_path / "work" / name)
        changed(command, "work/run.cp", about=np.array(json.dumps(about)))
        code, _, err = say("resume", "work/run.cp", "--quiet")
        assert code == 2 and err.startswith("error: ") and f"`{name}`" in err
        assert (tmp_path / "work" / name).read_text() == "precious"


@pytest.mark.parametrize("key", ["step", "signals", "set", "model", "without", "general", "start", "units", "output"])
@pytest.mark.parametrize("value", [7, [7], "text", {"a": 1}, [["a"]]])
def test_words_of_the_command_have_their_types(key, value, command, say):
    about = json.loads(command["about"].item())
    about["about"]["command"][key] = value
    changed(command, "work/run.cp", about=np.array(json.dumps(about)))
    code, _, err = say("resume", "work/run.cp", "--quiet")
    assert code in (0, 2) and "Traceback" not in err
