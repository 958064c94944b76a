"""The command line: arguments, exit codes, messages, progress, files. The simulation is replaced by a double."""

import io
import json
import os
import re
import signal
import subprocess
import sys
import types

import numpy as np
import pytest

import mbdsl
from mbdsl import cli, results
from mbdsl.cli import _progress, _values, simulate
from mbdsl.errors import InitialisationError, IntegrationError, ModelError, Span
from mbdsl.initial.consistent import Moved
from mbdsl.mechanism.scene import Scene
from mbdsl.messages import OWN, DisplayUnit
from mbdsl.simulation.code_preparation import PreparationProgress as Prepared
from mbdsl.simulation.extremes import Extreme, Extremes
from mbdsl.simulation.progress import Progress, Purpose


class Trajectory:
    """As :class:`mbdsl.simulation.trajectory.Trajectory`, of a crank that turns once."""

    default_names = ("crank.x", "crank.phi")
    names = (*default_names, "energy.total")
    elastic_names = ()
    moved = (Moved("crank.phi", np.pi / 6, np.pi / 12, DisplayUnit("deg", np.pi / 180)),)
    undetermined = ()
    display = OWN

    def __init__(self, status="done"):
        self.t, self.status, self.scene = np.linspace(0.0, 1.0, 5), status, Scene("Crank", {}, {})
        counts = dict(n=3, m=2, p=0, steps=10, rejected=0, iterations=21)
        counts.update(evaluations=0, matrix_evaluations=2, factorisations=2)
        counts["pivoting_from"] = None
        seconds = {"build": 0.1, "compile": 0.0, "initialise": 0.0, "integrate": 0.25}
        self.stats = {"method": "hht-si2", "h": 0.1, "tol": None, "status": status, **counts, "seconds": seconds}

    def __getitem__(self, name):
        return self.t * (self.names.index(name) + 1)

    def select(self, patterns):
        return [name for name in self.names if name in patterns]

    def unit(self, name):
        return "rad" if name.endswith("phi") else "m"

    def extremes(self, names):
        return Extremes(Extreme(name, self.unit(name), 0.0, 0.0, 2.0, 1.0, 1.0, 1.2) for name in names)

    def cut_peaks(self, names):
        return []

    def find_events(self):
        return []


@pytest.fixture
def simulation(monkeypatch, tmp_path):
    """Replaces loading and simulating; ``given`` collects the arguments, ``act`` determines the result."""
    double = types.SimpleNamespace(given={}, act=lambda **given: Trajectory())

    def simulated(scene, asked, stream):
        double.given = vars(asked)
        return double.act(**double.given)

    monkeypatch.setitem(sys.modules, "mbdsl.api", types.SimpleNamespace(simulated=simulated))
    monkeypatch.setattr(_values, "load_model", lambda args: Scene("Crank", {}, {}))
    monkeypatch.chdir(tmp_path)
    return double


@pytest.fixture
def say(capsys):
    """Run a command; exit code, standard output, standard error."""

    def run(*argv):
        return (cli.main(argv), *capsys.readouterr())

    return run


# -- commands and help ------------------------------------------------------------------------------------------
def test_help_names_every_command(say):
    code, out, err = say("--help")
    assert (code, err) == (0, "")
    assert {"check", "simulate", "methods", "show"} <= set(cli.commands())
    assert all(f"\n    {name} " in out for name in cli.commands())


def test_no_arguments_are_a_call_for_help(say):
    assert say() == say("--help")


@pytest.mark.parametrize("command", cli.commands())
def test_every_command_has_help(say, command):
    code, out, _ = say(command, "--help")
    assert code == 0
    assert out.startswith(f"usage: mbdsl {command}")


def test_version(say):
    assert say("--version") == (0, f"mbdsl {mbdsl.__version__}\n", "")


def test_module_runs_as_the_program():
    done = subprocess.run([sys.executable, "-m", "mbdsl", "--version"], capture_output=True, text=True, check=True)
    assert done.stdout == f"mbdsl {mbdsl.__version__}\n"


@pytest.mark.parametrize(
    ("argv", "message"),
    [
        (["simulat", "x.mbd"], "error: there is no command `simulat`\n  = did you mean `simulate`?\n"),
        (["x.mbd"], "error: what to do with `x.mbd`?\n  = try:  mbdsl simulate x.mbd\n"),
        (["check"], "error: the following arguments are required: MODEL\n  = see mbdsl check --help\n"),
        (["check", "x.mbd", "--sep", "k"], "error: mbdsl check has no option `--sep`\n  = did you mean `--set`?\n"),
        (
            ["simulate", "x.mbd", "--stpe", "1ms"],
            "no option `--stpe`\n  = did you mean `--stop` or `--step`?\n",
        ),
        (["simulate", "--stpe", "1ms"], "error: mbdsl simulate has no option `--stpe`\n"),  # the model is missing, too
        (["simulate", "x.mbd", "--stp=1ms"], "error: mbdsl simulate has no option `--stp`\n"),
        (["simulate", "x.mbd", "--methd", "radau5"], "error: mbdsl simulate has no option `--methd`\n"),
        (["simulate", "x.mbd", "--alhpa", "0"], "no option `--alhpa`\n  = did you mean `--alpha`?\n"),
        (
            ["recommend", "x.mbd", "--eror", "1mm"],
            "mbdsl recommend has no option `--eror`\n  = did you mean `--error`?\n",
        ),
        (["study", "drift", "x.mbd", "--stpes", "1ms"], "error: mbdsl study drift has no option `--stpes`\n"),
        (["study", "drfit", "x.mbd"], "error: argument KIND: unknown value `drfit`\n  = did you mean `drift`?\n"),
        (["check", "x.mbd", "more"], "error: unrecognized arguments: more\n  = see mbdsl check --help\n"),
        (["simulate", "x.mbd", "-o", "x.csv"], "error: unrecognized arguments: -o x.csv\n  = write `--output`\n"),
        (["plot", "x.csv", "-o", "x.svg"], "error: unrecognized arguments: -o x.svg\n  = write `--out`\n"),
        (["--versoin"], "error: mbdsl has no option `--versoin`\n  = did you mean `--version`?\n"),
        (["sweep", "x.mbd", "--vary", "L"], "error: --vary: found `L`, expected NAME=VALUES\n  = write L=1:2:11 "),
        (
            ["simulate", "x.mbd", "--stop", "2", "s"],
            "error: `2 s` after --stop is two words: the value ends at the space\n"
            '  = write  --stop 2s  or  --stop "2 s"\n',
        ),
        (
            ["simulate", "--interval", "1.5e-3", "ms", "x.mbd"],
            '  = write  --interval 1.5e-3ms  or  --interval "1.5e-3 ms"\n',
        ),
        (["check", "x.mbd", "--set", "k=120", "N/mm"], '  = write  --set "k=120 N/mm"\n'),
        (["check", "x.mbd", "--set", "k"], "error: argument --set: expected NAME=VALUE, found `k`\n"),
        (["show", "x.mbd", "--stage", "cod"], "argument --stage: unknown value `cod`\n  = did you mean `code`?\n"),
        (
            ["simulate", "x.mbd", "--step", "1kg"],
            "error: argument --step: `1kg` has the wrong unit: expected s, found kg\n",
        ),
        (["simulate", "x.mbd", "--step", "1 parsec"], "error: argument --step: unknown unit `parsec` in `1 parsec`;"),
        (["simulate", "x.mbd", "--step", "fast"], "error: argument --step: `fast` is not a number"),
        (["simulate", "x.mbd", "--step", "0"], "error: argument --step: `0` is 0, expected a value above 0\n"),
        (["simulate", "x.mbd", "--interval=-1ms"], "`-1ms` is -0.001, expected a value of 0 or more\n"),
        (["simulate", "x.mbd", "--tol", "2"], "error: argument --tol: `2` is 2, expected a value between 0 and 1\n"),
        (["simulate", "x.mbd", "--tol", "1e-20"], "is less than the rounding errors of a run"),
        (["simulate", "x.mbd", "--accuracy", "1e-16"], "expected 2.5e-14 or more"),
        (["simulate", "x.mbd", "--step", "-1ms"], "argument --step: `-1ms` is -0.001, expected a value above 0\n"),
        (["simulate", "x.mbd", "--start", "-.5s", "--step", "-1ms"], "argument --step: `-1ms` is -0.001"),
        (["simulate", "x.mbd", "--quiet", "-1ms"], "error: argument --quiet: ignored explicit argument"),
        (["simulate", "x.mbd", "--step", "1", "--tol", "1e-3"], "--tol: not allowed with argument --step\n"),
        (["simulate", "x.mbd", "--output", "x.xls"], "  = known suffixes are .csv, .mat, .nc, .npz\n"),
        (["simulate", "x.mbd", "--output", "no/x.csv"], "error: cannot write `no/x.csv`: there is no folder `no`\n"),
        (["simulate", "x.mbd", "--stats", "no/x.json"], "error: cannot write `no/x.json`: there is no folder `no`\n"),
    ],
)
def test_wrong_arguments(say, simulation, argv, message):
    code, out, err = say(*argv)
    assert (code, out) == (2, "")
    assert message in err
    assert "Traceback" not in err


@pytest.mark.parametrize(
    ("text", "value"),
    [("1ms", 1e-3), ("2 s", 2.0), ("0.5", 0.5), (" 1e-3s ", 1e-3), ("2 min", 120.0), (".5", 0.5), ("5e2us", 5e-4)],
)
def test_seconds_take_units(text, value):
    assert _values.seconds(text) == pytest.approx(value, rel=1e-15)


# -- simulate ---------------------------------------------------------------------------------------------------
def test_simulate_passes_on_what_was_said_and_nothing_else(say, simulation):
    say("simulate", "m.mbd")
    loud = {"progress", "announce"}
    assert {name for name, value in simulation.given.items() if value} == loud
    said = "--method hht-i3 --alpha -0.1 --step 1ms --start 1 --stop 2s --interval 0".split()
    say("simulate", "m.mbd", *said)
    wanted = dict(method="hht-i3", options={"alpha": -0.1}, step=1e-3, tol=None, start=1.0, stop=2.0, interval=0.0)
    assert {name: simulation.given[name] for name in wanted} == wanted


def test_simulate_writes_bodies_beside_the_time(say, simulation):
    code, out, err = say("simulate", "models/m.mbd")
    assert (code, err) == (0, "")
    assert out == (
        "Crank: 10 steps of hht-si2 to t = 1 s, 21 iterations (2.10 a step), in 0.25 s; "
        "error not known (--tol controls it, --verify checks it)\n"
        "m.csv: 5 rows, time and 2 signals\n"
        "1 guess moved: crank.phi from 30 deg to 15 deg (--verbose lists all)\n"
    )
    columns, meta = results.read("m.csv")
    assert list(columns) == ["time", "crank.x", "crank.phi"]
    assert columns["crank.phi"].tolist() == (2 * Trajectory().t).tolist()
    assert meta["complete"]


def test_verbose_tells_sizes_phases_and_how_far_guesses_moved(say, simulation):
    out = say("simulate", "m.mbd", "--verbose")[1]
    assert "n = 3, m = 2, p = 0; 0 steps rejected, 2 matrices, 2 factorisations" in out
    assert "integrate 0.25" in out
    assert "initial value of crank.phi: guessed 30 deg, found 15 deg" in out


def test_of_many_guesses_the_one_that_moved_furthest_is_told(say, simulation, monkeypatch):
    moved = [Moved(f"p.{key}", 0.9, 0.9 + by) for key, by in (("x", 0.1), ("y", -0.2))]
    monkeypatch.setattr(Trajectory, "moved", moved)
    assert say("simulate", "m.mbd")[1].endswith("2 guesses moved: furthest p.y from 0.9 to 0.7 (--verbose lists all)\n")
    monkeypatch.setattr(Trajectory, "moved", ())
    assert "guess" not in say("simulate", "m.mbd")[1]


@pytest.mark.parametrize("option", ["--stats", "--output"])
def test_folders_are_refused_before_the_work(say, simulation, tmp_path, option):
    (tmp_path / "x.csv").mkdir()
    assert say("simulate", "m.mbd", option, "x.csv") == (2, "", "error: cannot write `x.csv`: it is a folder\n")
    assert simulation.given == {}


def test_quiet_says_nothing(say, simulation):
    assert say("simulate", "m.mbd", "--quiet") == (0, "", "")
    assert simulation.given["progress"] is None
    assert simulation.given["announce"] is None


def test_signals_are_split_at_commas_outside_brackets(say, simulation, monkeypatch):
    asked = []
    monkeypatch.setattr(Trajectory, "select", lambda self, patterns: asked.extend(patterns) or ["crank.x"])
    monkeypatch.setattr(simulate, "check_signals", lambda scene, patterns: None)
    say("simulate", "m.mbd", "--signals", "crank.*, a[1,2].x,O.f?")
    assert asked == ["crank.*", "a[1,2].x", "O.f?"]


def test_stats_have_the_promised_keys(say, simulation):
    say("simulate", "m.mbd", "--stats", "s.json")
    with open("s.json") as stream:
        stats = json.load(stream)
    keys = "method h tol status n m p steps rejected iterations matrix_evaluations factorisations seconds".split()
    assert set(keys) <= set(stats)
    assert set(stats["seconds"]) == {"parse", "build", "compile", "initialise", "integrate", "write"}


def test_result_files_know_what_they_are(say, simulation):
    say("simulate", "m.mbd", "--output", "m.npz")
    about = results.read("m.npz")[1]
    assert json.loads(about.pop("extremes"))[1] == ["crank.phi", "rad", 0.0, 0.0, 2.0, 1.0, 1.0, 1.2, "steps"]
    assert about == {
        "complete": True, "model": "Crank", "method": "hht-si2", "step": 0.1, "status": "done",
        "version": mbdsl.__version__, "steps": 10, "iterations": 21,
    }  # fmt: skip


def test_failed_integration_leaves_what_there_is_and_says_so(say, simulation):
    def act(**given):
        problem = IntegrationError("Newton's iteration fails at t = 1 s", hint="try a smaller step")
        problem.trajectory = Trajectory("failed")
        raise problem

    simulation.act = act
    code, _, err = say("simulate", "m.mbd")
    assert code == 4
    assert err == "error: Newton's iteration fails at t = 1 s\n  = try a smaller step\n"
    assert results.read("m.csv")[1]["complete"] is False


def test_interrupted_simulation_leaves_what_there_is(say, simulation):
    simulation.act = lambda **given: Trajectory("interrupted")
    code, _, err = say("simulate", "m.mbd")
    assert code == 130
    assert err == "m.csv ends at t = 1 s and is marked incomplete\ninterrupted\n"
    assert os.path.exists("m.csv.incomplete")
    simulation.act = lambda **given: Trajectory()
    assert say("simulate", "m.mbd")[0] == 0
    assert sorted(os.listdir()) == ["m.csv"]


# -- errors -----------------------------------------------------------------------------------------------------
def raiser(problem):
    def act(**given):
        raise problem

    return act


@pytest.mark.parametrize(
    ("problem", "code", "message"),
    [
        (ModelError("no", Span("m.mbd", 2, 3, 4, "  this")), 2, "m.mbd:2:3: error: no\n      this\n      ^^^^\n"),
        (InitialisationError("cannot be assembled"), 3, "error: cannot be assembled\n"),
        (KeyboardInterrupt(), 130, "interrupted\n"),
    ],
)
def test_problems_have_their_codes(say, simulation, problem, code, message):
    simulation.act = raiser(problem)
    assert say("simulate", "m.mbd") == (code, "", message)


@pytest.mark.skipif(os.name != "posix", reason="other systems have no signals to send to a process")
@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_what_an_interruption_turns_into_is_an_interruption(say, simulation, number):
    """Extensions that are imported while a signal comes raise ImportError."""

    def act(**given):
        try:
            os.kill(os.getpid(), number)
            signal.pause()
        except KeyboardInterrupt:
            raise ImportError("Importing the numpy C-extensions failed") from None

    before = signal.signal(number, signal.default_int_handler if number == signal.SIGINT else signal.SIG_DFL)
    try:
        simulation.act = act
        assert say("simulate", "m.mbd") == (130, "", "interrupted\n")
    finally:
        signal.signal(number, before)


def test_a_defect_is_one_line_and_a_request(say, simulation):
    simulation.act = raiser(ZeroDivisionError("float division\nby zero"))
    code, out, err = say("simulate", "m.mbd")
    assert (code, out) == (1, "")
    assert err.startswith("internal error: ZeroDivisionError: float division by zero\n")
    assert "please report it" in err
    for argv in (["simulate", "m.mbd", "--debug"], ["--debug", "simulate", "m.mbd"]):
        code, _, message = say(*argv)
        assert code == 1
        assert message.startswith("Traceback")
        assert message.endswith(err)


def test_debug_keeps_the_exit_code(say, simulation):
    simulation.act = raiser(InitialisationError("cannot be assembled"))
    code, _, err = say("simulate", "m.mbd", "--debug")
    assert code == 3
    assert err.startswith("Traceback")
    assert err.endswith("\nerror: cannot be assembled\n")


def test_reader_that_leaves_is_no_error():
    code = "import sys; from mbdsl import cli; cli._run = lambda argv: print('a line') or 0; sys.exit(cli.main([]))"
    read, write = os.pipe()
    os.close(read)
    done = subprocess.run([sys.executable, "-c", code], stdout=write, stderr=subprocess.PIPE, check=False)
    os.close(write)
    assert (done.returncode, done.stderr) == (cli.BROKEN_PIPE, b"")


# -- progress ---------------------------------------------------------------------------------------------------
class Terminal(io.StringIO):
    encoding = "utf-8"

    def isatty(self):
        return True


def progress(seconds, t=0.5, **given):
    usual = {"t": t, "start": 0.0, "stop": 2.0, "h": 1e-3, "steps": 500, "iterations": 1000, "seconds": seconds}
    return Progress(**{**usual, **given})


def test_short_work_shows_nothing():
    for stream in (Terminal(), io.StringIO()):
        display = _progress.Display(stream)
        display(progress(0.9))
        display.close()
        assert stream.getvalue() == ""


def test_terminal_gets_one_line_that_goes_away(monkeypatch):
    monkeypatch.setenv("COLUMNS", "100")
    display = _progress.Display(Terminal())
    display(progress(1.5))
    shown = display.stream.getvalue()
    assert shown.startswith("\r█████...............  25%  t = 0.5 of 2 s  h = 0.001 s  2.0 iterations/step")
    display(progress(1.55))
    assert display.stream.getvalue() == shown
    display.close()
    assert "\n" not in display.stream.getvalue()
    assert display.stream.getvalue().endswith(" \r")


def test_other_outputs_get_a_line_every_few_seconds():
    display = _progress.Display(io.StringIO())
    for k in range(1, 121):
        display(progress(k / 10, t=k / 60))
    lines = display.stream.getvalue().splitlines()
    assert lines[0] == "  8%  t = 0.1667 of 2 s  h = 0.001 s  2.0 iterations/step  11 s left"
    assert len(lines) == 3


def test_a_line_in_between_does_not_tear_the_bar():
    display = _progress.Display(Terminal())
    display(progress(2.0))
    display.say("compiling ...")
    assert display.stream.getvalue().endswith(" \rcompiling ...\n")


@pytest.mark.parametrize(("seconds", "text"), [(4.4, "4 s"), (75, "1:15 min"), (90061, "25:01:01")])
def test_durations(seconds, text):
    assert _progress.clock(seconds) == text


def test_progress_before_the_first_step():
    assert "just begun" in _progress.text(progress(3.0, t=0.0, steps=0))


@pytest.mark.parametrize(
    ("columns", "line"),
    [
        (80, "█████...............  25%  t = 0.5 of 2 s  h = 0.001 s  4 s left"),
        (60, "███............  25%  t = 0.5 of 2 s  h = 0.001 s  4 s left"),
        (50, "█....  25%  t = 0.5 of 2 s  h = 0.001 s  4 s left"),
    ],
)
def test_the_time_left_is_never_cut_off(columns, line, monkeypatch):
    monkeypatch.setenv("COLUMNS", str(columns))
    display = _progress.Display(Terminal())
    display(progress(1.5))
    assert display.stream.getvalue() == "\r" + line.ljust(columns - 1)


def test_a_run_that_is_one_of_several_has_its_purpose(monkeypatch):
    monkeypatch.setenv("COLUMNS", "80")
    display = _progress.Display(Terminal())
    display(progress(1.5, what="check 2: scipy-dop853, tol = 3e-05; calibration run 1"))
    line = " 25%  t = 0.5 of 2 s  h = 0.001 s  4 s left  check 2: scipy-dop853, tol = 3e..."
    assert display.stream.getvalue() == "\r" + line.ljust(79)
    assert _progress.text(progress(1.5, what="calibration run 2")).endswith("  4 s left  calibration run 2")


def test_a_line_that_is_cut_off_ends_with_dots(monkeypatch):
    monkeypatch.setenv("COLUMNS", "80")
    display = _progress.Preparation(Terminal())
    display(Prepared(2, 12, "step loop of dop853, step loop of generalized-alpha", 1.5))
    line = "███................. 2 of 12  compiling step loop of dop853, step loop of ge..."
    assert display.stream.getvalue() == "\r" + line.ljust(79)


def test_an_explicit_method_states_no_iterations():
    assert "iterations" not in _progress.text(progress(1.5, iterations=0))


def test_a_backend_states_no_steps():
    line = _progress.text(progress(1.5, h=2.0, iterations=0))
    assert line == " 25%  t = 0.5 of 2 s  4 s left"


def test_the_time_left_follows_the_recent_rate():
    """Half of the run in 1 s, then 1e-6 of it in each second."""
    display = _progress.Display(io.StringIO())
    for k in range(11):
        display(progress(k / 10, t=k / 10))
    for k in range(1, 601):
        display(progress(1.0 + k / 10, t=1.0 + 2e-7 * k, h=4.5e-14))
    last = display.stream.getvalue().splitlines()[-1]
    # (2 - 1) s at 2e-6 a second of computing take 500000 s, or 138:53 h
    assert re.search(r"h = 4.5e-14 s \(fallen from 0.001 s\)  .*  138:5\d:\d\d left at this rate$", last)
    for k in range(601, 1200):
        display(progress(1.0 + k / 10, t=1.0 + 1.2e-4, h=4.5e-14))
    assert display.stream.getvalue().splitlines()[-1].endswith("  stands still")


def test_the_second_of_several_runs_is_shown_at_once():
    """Its time begins at zero again."""
    display = _progress.Display(io.StringIO())
    for k in range(1, 301):
        display(progress(k / 10, t=k / 150, what="calibration run 1"))
    for k in range(1, 61):
        display(progress(k / 10, t=k / 600, what="calibration run 2"))
    lines = display.stream.getvalue().splitlines()
    first = next(line for line in lines if line.endswith("  calibration run 2"))
    assert "  1:59 min left  " in first  # of 2 min, after 1 s


def test_work_without_progress_is_named_after_a_second(monkeypatch):
    monkeypatch.setattr(_progress, "PATIENCE", 0.01)
    display = _progress.Display(Terminal())
    display.phase("assembling the initial state")
    display._waiting.join()
    assert display.stream.getvalue().startswith("\rassembling the initial state ...   ")
    display.phase("compiling")
    display.close()
    assert display._waiting is None and "compiling" not in display.stream.getvalue()


def test_runs_have_the_purpose_of_their_part():
    seen = []
    inner = Purpose(seen.append, "check 1: radau5")
    inner(progress(1.0, what="calibration run 2"))
    inner(progress(1.0))
    inner.phase("compiling")  # the callback does not show it
    assert [p.what for p in seen] == [
        "check 1: radau5; calibration run 2",
        "check 1: radau5",
    ]


# -- methods ----------------------------------------------------------------------------------------------------
def test_methods_are_listed_with_their_source(say):
    from mbdsl.integrators import available

    code, out, _ = say("methods")
    assert code == 0
    for method in available().values():
        lines = out.splitlines()
        (at,) = (k for k, line in enumerate(lines) if line.startswith(f"{method.name} "))
        first, rest = lines[at], lines[at + 1 :]
        facts = f"order {method.order}, index {method.index}, enforces {' and '.join(method.enforces)}"
        assert first.removeprefix(method.name).strip() == facts
        assert f"    {method.source}" in rest
        assert all(f"    --{name} " in out for name in method.parameters)
