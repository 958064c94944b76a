"""mbdsl plot: files, terminals and pipes, models, lists of signals, errors and exit codes."""

import os
import pty
import subprocess
import sys
import types

import numpy as np
import pytest

from mbdsl import cli, results
from mbdsl.errors import IntegrationError
from mbdsl.mechanism.scene import Scene
from mbdsl.messages import OWN

T = np.linspace(0.0, 2.0, 201)
COLUMNS = {"time": T, "crank.x": np.cos(T), "crank.phi": 2.0 * T, "pin.fx": 10.0 * T}
UNITS = {"time": "s", "crank.x": "m", "crank.phi": "rad", "pin.fx": "N"}


@pytest.fixture(autouse=True)
def _files(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    for name, factor in (("a.npz", 1.0), ("b.npz", 1.5)):
        columns = {key: x if key == "time" else factor * x for key, x in COLUMNS.items()}
        results.write(name, columns, UNITS, {"complete": True})


def run(capsys, *words):
    code = cli.main(["plot", *words])
    out, err = capsys.readouterr()
    return code, out, err


def test_a_pipe_gets_characters_without_colour(capsys):
    code, out, err = run(capsys, "a.npz")
    assert (code, err) == (0, "")
    assert "\x1b" not in out
    lines = out.splitlines()
    assert lines[0] == "a.npz"
    assert max(map(len, lines)) <= 80
    assert "crank.x [m]" in lines
    assert "crank.phi [rad]" in lines
    assert any("⠁" <= c <= "⣿" for c in out)
    assert "2 signals of 3; --signals chooses others, --list lists them." in lines


@pytest.mark.parametrize("suffix", ["svg", "html", "png", "pdf"])
def test_files(capsys, suffix):
    code, out, err = run(capsys, "a.npz", "--signals", "crank.x,pin.*", "--out", f"plot.{suffix}")
    assert (code, out, err) == (0, f"plot.{suffix}: crank.x [m], pin.fx [N]\n", "")
    assert os.path.getsize(f"plot.{suffix}") > 1500
    assert sorted(os.listdir()) == ["a.npz", "b.npz", f"plot.{suffix}"]


def test_options(capsys):
    code, out, _ = run(capsys, "a.npz", "b.npz", "--difference", "--signals", "pin.fx")
    assert code == 0
    assert out.startswith("b.npz − a.npz\n")
    assert " 10┤" in out  # the difference at the end is 0.5 · 10 · 2
    code, out, _ = run(capsys, "a.npz", "b.npz", "--signals", "crank.x", "--against", "crank.phi")
    assert code == 0
    assert "crank.phi [rad]" in out
    assert "b crank.x, b.npz" in out
    code, out, _ = run(capsys, "a.npz", "--signals", "crank.x", "--spectrum")
    assert code == 0
    assert "frequency [Hz]" in out
    assert "Hann window" in out


def test_list(capsys):
    assert run(capsys, "a.npz", "--list") == (0, "crank.x [m]\ncrank.phi [rad]\npin.fx [N]\n", "")


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["none.csv"], "cannot read `none.csv`: No such file"),
        (["a.npz", "--signals", "crnk.x"], "did you mean `crank.x` or"),
        (["a.npz", "--signals", "zzz*"], "no signal that matches `zzz*` in a.npz\n  = signals: crank.x"),
        (["a.npz", "--against", "time"], ""),
        (
            ["a.npz", "--against", "crank.*"],
            "one signal, and `crank.*` is a pattern\n  = it matches crank.x, crank.phi",
        ),
        (["a.npz", "--difference"], "a difference needs two results"),
        (["a.npz", "--out", "plot.gif"], "unknown suffix `.gif`"),
        (["a.npz", "--out", "no"], "no suffix on `no`"),
        (["a.npz", "--out", "no/plot.svg"], "there is no folder `no`"),
        (["a.npz", "--out", "a.svg", "--list"], "not allowed with"),
        (["a.txt"], "neither a result file nor a model\n  = known suffixes are .csv, .mat, .mbd, .nc, .npz"),
        (["bad.npz"], "`bad.npz` is not a .npz result file, or is damaged"),
        ([], "required: RESULT"),
    ],
)
def test_errors(capsys, words, message):
    with open("bad.npz", "w") as stream:
        stream.write("text")
    before = set(os.listdir())
    code, _, err = run(capsys, *words)
    assert code == (2 if message else 0)
    assert message in err
    assert "Traceback" not in err
    assert set(os.listdir()) == before


def terminal(words, **environment):
    """The output on a terminal of 60 columns and 30 lines."""
    code = (
        "import fcntl, struct, sys, termios\n"
        "fcntl.ioctl(1, termios.TIOCSWINSZ, struct.pack('4H', 30, 60, 0, 0))\n"
        "from mbdsl import cli\nraise SystemExit(cli.main(sys.argv[1:]))"
    )
    variables = {k: v for k, v in os.environ.items() if k not in ("NO_COLOR", "COLUMNS", "LINES", "TERM")}
    ours, theirs = pty.openpty()
    command = [sys.executable, "-c", code, "plot", *words]
    environment = {"TERM": "xterm", "PYTHONIOENCODING": "utf-8", **environment}
    with subprocess.Popen(command, stdout=theirs, stdin=subprocess.DEVNULL, env=variables | environment) as process:
        os.close(theirs)
        found = b""
        try:
            while part := os.read(ours, 65536):
                found += part
        except OSError:  # Linux: the other end was closed
            pass
    os.close(ours)
    assert process.returncode == 0
    return found.decode().replace("\r\n", "\n")


def test_a_terminal_gets_colours_and_its_width():
    found = terminal(["a.npz", "--signals", "*"])
    assert "\x1b[36m" in found
    lines = found.splitlines()
    assert len(lines) <= 30
    frames = [len(line) for line in lines if "└" in line]
    assert set(frames) == {59}
    for variable, value in (("NO_COLOR", "1"), ("TERM", "dumb")):
        assert "\x1b" not in terminal(["a.npz"], **{variable: value})
    plain = terminal(["a.npz"], PYTHONIOENCODING="ascii")
    assert plain.isascii()
    assert "*" in plain


class Trajectory:
    names = ("time", "crank.x", "crank.phi", "pin.fx")
    shown_names = (("crank.x", "crank.phi"),)
    system = types.SimpleNamespace(tables=types.SimpleNamespace(size=1.0))
    scene, t = Scene("Crank", {}, {}), T
    status, message = "done", "the tolerance was not reached"
    undetermined = ()
    display = OWN
    descriptions = {}  # noqa: RUF012
    stats = {"warnings": ["a pulse may be passed over"]}  # noqa: RUF012
    unit = staticmethod(UNITS.__getitem__)

    def select(self, patterns):
        return self.names

    def __getitem__(self, name):
        return COLUMNS[name]

    def cut_peaks(self, names):
        return []

    def find_events(self):
        return []

    def _event_times(self, impulses):
        return []

    def event_marks(self, start, stop):
        return (), 0


@pytest.fixture
def simulation(monkeypatch):
    """Replaces loading and simulating; ``act`` determines the result."""
    double = types.SimpleNamespace(act=Trajectory)
    monkeypatch.setitem(
        sys.modules, "mbdsl.api", types.SimpleNamespace(simulated=lambda scene, asked, stream: double.act())
    )
    monkeypatch.setattr("mbdsl.lang.load.load", lambda path, *given, **named: Scene("Crank", {}, {}))
    return double


def test_a_model_is_simulated(capsys, simulation):
    code, out, err = run(capsys, "crank.mbd")
    assert (code, err) == (0, "warning: a pulse may be passed over\n")
    assert out.splitlines()[:2] == ["crank.mbd", "crank.x [m]"]
    code, out, _ = run(capsys, "crank.mbd", "b.npz", "--signals", "pin.fx", "--difference")
    assert out.startswith("b.npz − crank.mbd")


def test_a_failed_run_is_plotted_and_is_an_error(capsys, simulation):
    def fail():
        problem = IntegrationError("the step became too small")
        problem.trajectory = Trajectory()
        problem.trajectory.status = "failed"
        raise problem

    simulation.act = fail
    code, out, err = run(capsys, "crank.mbd")
    assert code == 4
    assert "crank.mbd is marked: its run was not completed." in out
    assert "the step became too small" in err


def test_an_interrupted_run_is_not_plotted(capsys, simulation):
    def interrupt():
        found = Trajectory()
        found.status = "interrupted"
        return found

    simulation.act = interrupt
    code, out, err = run(capsys, "crank.mbd")
    assert (code, out) == (130, "")
    assert "interrupted" in err


def test_an_inaccurate_run_is_plotted_with_a_warning(capsys, simulation):
    def inaccurate():
        found = Trajectory()
        found.status = "inaccurate"
        found.stats = {"warnings": [found.message]}
        return found

    simulation.act = inaccurate
    code, out, err = run(capsys, "crank.mbd")
    assert code == 0
    assert "crank.mbd is marked: its accuracy was not reached." in out
    assert "the tolerance was not reached" in err


@pytest.mark.parametrize("suffix", [".csv", ".npz", ".mat", ".nc"])
def test_marked_results(capsys, suffix):
    results.write(f"c{suffix}", COLUMNS, UNITS, {"complete": False, "status": "failed"})
    assert f"c{suffix} is marked: its run was not completed." in run(capsys, f"c{suffix}")[1]


def test_without_matplotlib(capsys, monkeypatch):
    monkeypatch.setitem(sys.modules, "matplotlib", None)
    monkeypatch.setitem(sys.modules, "matplotlib.figure", None)
    code, _, err = run(capsys, "a.npz", "--out", "a.png")
    assert code == 2
    assert "pip install '.[plot]'; .svg and .html need no further package" in err
    assert run(capsys, "a.npz", "--out", "a.svg")[0] == 0
    assert run(capsys, "a.npz")[0] == 0
