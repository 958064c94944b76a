"""Integrators in Python files: `--method file.py`, its errors, other processes, checkpoints."""

import os
import re
import subprocess
import sys
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

import mbdsl
from mbdsl import cli, integrators
from mbdsl.compilation import code_cache
from mbdsl.integrators import method_files
from mbdsl.studies import workers
from mbdsl.studies.cases import Case, setting
from mbdsl.studies.store import Store, method_code

ROOT = Path(__file__).parents[3]
CRANK = ROOT / "models" / "slider_crank.mbd"
RK4 = re.search(r'```python\n("""rk4\.py""".*?)```', (ROOT / "docs" / "backends.md").read_text("utf-8"), re.DOTALL)[1]
EULER = """from mbdsl.kernels import buffer_layout as L
from mbdsl.kernels.marks import kernel
from mbdsl.integrators.method import Method
from mbdsl.integrators.methods.newmark import METHOD as newmark
from mbdsl.integrators.methods.nstiff import correct, matrix, residual

METHOD = Method(
    "euler", doc="the implicit Euler formula on the index-3 equations", order=1, index=3, enforces=("Phi",),
    source="", memory=lambda c, start: (1.0, 1.0), begin=newmark.begin, own_reactions=False,
)


@kernel
def motion(h, run):
    y = run.vectors
    for i in range(run.layout[L.N_Q]):
        y[L.VELOCITY, i] = y[L.VELOCITY0, i] + h * y[L.UNKNOWN, i]
        y[L.POSITION, i] = y[L.POSITION0, i] + h * y[L.VELOCITY, i]


@kernel
def finish(h, run):
    pass
"""


@pytest.fixture(autouse=True)
def files(monkeypatch, tmp_path):
    """Methods of files are forgotten after a test; the files are in the present folder."""
    monkeypatch.setattr(integrators, "_given", {})
    monkeypatch.setattr(method_files, "_modules", {})
    monkeypatch.chdir(tmp_path)
    known = dict(integrators.modules())
    yield lambda name, text: Path(name).write_text(text, encoding="utf-8")
    integrators.modules().clear()
    integrators.modules().update(known)


def run(capsys, *words):
    return (cli.main([str(word) for word in words]), *capsys.readouterr())


# -- runs ---------------------------------------------------------------------------------------------------------
def test_a_file_with_solve(files, capsys):
    """Compared with SciPy's DOP853 at a tolerance of 1e-10; the error of RK4 at 1 ms is 1e-9 or less."""
    files("rk4.py", RK4)
    given = [CRANK, "--stop", "0.2s", "--interval", "20ms", "--quiet"]
    assert run(capsys, "simulate", *given, "--method", "rk4.py", "--step", "1ms", "--output", "a.csv") == (0, "", "")
    assert run(capsys, "simulate", *given, "--method", "scipy-dop853", "--tol", "1e-10", "--output", "b.csv")[0] == 0
    ours, theirs = (mbdsl.results.read(name)[0] for name in ("a.csv", "b.csv"))
    assert max(np.abs(ours[name] - theirs[name]).max() for name in ours) < 1e-7


def test_a_file_with_kernels():
    """Uncompiled, in a process of its own: a body in free fall, for which the formula gives y = -g h^2 k (k + 1)/2."""
    Path("euler.py").write_text(EULER, encoding="utf-8")
    Path("fall.mbd").write_text(
        "model Fall\n  Ground g(g = 10 m/s2);\n  PointMass ball(m = 1 kg);\n  FreeMotion free(g, ball);\nend Fall;\n",
        encoding="utf-8",
    )
    words = ["simulate", "fall.mbd", "--method", "euler.py", "--step", "0.1", "--interval", "0", "--stop", "1s"]
    environment = {**os.environ, "MBDSL_NO_COMPILE": "1", "PYTHONPATH": str(ROOT)}
    done = subprocess.run(
        [sys.executable, "-m", "mbdsl", *words], env=environment, capture_output=True, text=True, check=False
    )
    assert (done.returncode, done.stderr) == (0, "") and "10 steps of euler" in done.stdout
    k = np.arange(11)
    assert mbdsl.results.read("fall.csv")[0]["ball.y"] == pytest.approx(-10.0 * 0.1**2 * k * (k + 1) / 2, abs=1e-12)


def test_methods_lists_it(files, capsys):
    files("rk4.py", RK4)
    code, out, _ = run(capsys, "methods", "rk4.py", "newmark")
    assert code == 0
    assert [line.split()[0] for line in out.splitlines() if not line.startswith(" ")] == ["rk4", "newmark"]


def test_a_worker_loads_the_file(files, tmp_path):
    """Its result is that of this process, bit for bit."""
    files("rk4.py", RK4)
    assert method_files.load("rk4.py") == "rk4"
    of, case, done = setting(CRANK, 0.05), Case("rk4", step=1e-3), {}
    workers.side_by_side(of, Store(tmp_path / "store"), [case], 1, lambda _: (60.0, 60.0, 0.0), done.__setitem__)
    from mbdsl.studies.compute import compute

    assert done[case].problem == ""
    assert np.array_equal(done[case].q, compute(of, case).q)


def test_commands_that_repeat_a_run_name_the_file(files):
    files("my rk4.py", RK4)
    name = method_files.load("my rk4.py")
    assert Case(name, step=0.5).arguments == "--method 'my rk4.py' --step 0.5"
    assert Case("newmark", step=0.5).arguments == "--method newmark --step 0.5"


def test_a_changed_file_replaces_the_method(files):
    files("rk4.py", RK4)
    method_files.load("rk4.py")
    first = method_files.digest("rk4")
    files("rk4.py", RK4.replace("the classical", "a classical"))
    method_files.load("rk4.py")
    assert integrators.declared("rk4").doc.startswith("a classical")
    assert method_files.digest("rk4") != first and method_files.digest("newmark") is None


def test_a_changed_file_that_it_imports_is_part_of_its_digest(files, tmp_path, monkeypatch):
    """Checkpoints and stored runs are then those of another method."""
    monkeypatch.syspath_prepend(tmp_path)
    files("helper_of_rk4.py", "HALF = 0.5")
    files("rk4.py", RK4 + "import helper_of_rk4\n")
    method_files.load("rk4.py")
    digest, key = method_files.digest("rk4"), method_code("rk4")
    assert (method_files.digest("rk4"), method_code("rk4")) == (digest, key)
    files("helper_of_rk4.py", "HALF = 0.25")
    assert method_files.digest("rk4") != digest and method_code("rk4") != key


# -- errors -------------------------------------------------------------------------------------------------------
@pytest.mark.parametrize(
    ("text", "message"),
    [
        (
            RK4.replace("def solve(problem):", "def solve(problem)"),
            "m.py:21:19: error: expected ':'\n    def solve(problem)\n                      ^\n"
            "  = it is not valid Python\n",
        ),
        (
            "import no_such_package\n" + RK4,
            "m.py:1:1: error: ModuleNotFoundError: No module named 'no_such_package'\n"
            "    import no_such_package\n    ^^^^^^^^^^^^^^^^^^^^^^\n",
        ),
        (
            RK4.replace("steps=", "stepz="),
            "m.py:7:10: error: TypeError: Method.__init__() got an unexpected keyword argument 'stepz'\n"
            "    METHOD = Method(\n             ^^^^^^^\n",
        ),
        ("raise SystemExit(3)\n", "m.py:1:1: error: SystemExit: 3\n    raise SystemExit(3)\n    ^^^^^^^^^^^^^^^^^^^\n"),
        (
            "x = 1\n",
            "error: `m.py` has no METHOD, expected `METHOD = mbdsl.integrators.Method(...)`\n"
            "  = docs/backends.md describes both kinds of files\n",
        ),
        (
            RK4.replace('"rk4"', '"newmark"'),
            "m.py:7:1: error: there is already a method called `newmark`\n    METHOD = Method(\n    ^^^^^^\n"
            "  = give METHOD another name\n",
        ),
        (
            RK4.replace("def solve", "def resolve"),
            "error: method `rk4` of `m.py` has neither a function solve(problem) nor kernels\n"
            "  = docs/backends.md describes both kinds of files\n",
        ),
        (
            EULER.replace("= y[L.POSITION0, i]", "= positions[i]"),
            "m.py:18:28: error: the kernel motion uses `positions`, which is not defined\n"
            "            y[L.POSITION, i] = positions[i] + h * y[L.VELOCITY, i]\n"
            "                               ^^^^^^^^^\n",
        ),
    ],
)
def test_errors_in_a_file_are_shown_with_their_line(files, capsys, text, message):
    files("m.py", text)
    code, out, err = run(capsys, "simulate", CRANK, "--method", "m.py")
    if sys.version_info < (3, 11):  # columns are known since then
        message, err = (re.sub(r"(?m)^(m\.py:\d+):\d+|^ +\^+\n", r"\1", x) for x in (message, err))
    assert (code, out, err) == (2, "", message)


def test_a_missing_kernel(files, capsys):
    files("m.py", EULER.replace("def finish", "def end"))
    code, _, err = run(capsys, "simulate", CRANK, "--method", "m.py")
    assert code == 2 and err.startswith("error: method euler has no kernel finish(h, run)\n  = add it to ")


def test_no_file(capsys):
    code, _, err = run(capsys, "simulate", CRANK, "--method", "no.py")
    assert (code, err) == (2, "error: cannot read the method `no.py`: No such file or directory\n")


@pytest.mark.parametrize(
    ("good", "bad", "message"),
    [
        (
            "f(t + h, y + h * k3)",
            "g(t + h, y + h * k3)",
            "rk4.py:31:18: error: rk4 stopped at t = 0 s: NameError: name 'g' is not defined\n"
            "                k4 = g(t + h, y + h * k3)\n                     ^\n"
            "  = the file of the method raised this error; --debug shows the traceback\n",
        ),
        (
            "yield t, *f.split(y)",
            "yield t, y",
            "error: rk4 stopped at t = 0 s: TypeError: it yielded a tuple of 2, expected (t, q, v) or (t, q, v, lam)\n"
            "  = a larger tolerance may pass, or another method; see `mbdsl methods`\n",
        ),
    ],
)
def test_errors_during_the_run(files, capsys, good, bad, message):
    files("rk4.py", RK4.replace(good, bad))
    given = ["simulate", CRANK, "--method", "rk4.py", "--step", "1ms", "--stop", "0.1s", "--quiet"]
    code, _, err = run(capsys, *given)
    if sys.version_info < (3, 11):
        message, err = (re.sub(r"(?m)^(rk4\.py:\d+):\d+|^ +\^+\n", r"\1", x) for x in (message, err))
    assert (code, err) == (4, message)
    assert "Traceback" in run(capsys, *given, "--debug")[2]


@pytest.mark.skipif(not code_cache.enabled(), reason="MBDSL_NO_COMPILE=1: nothing is compiled")
def test_a_kernel_that_is_not_translated_has_a_line(files, capsys):
    files("euler.py", EULER.replace("    y = run.vectors\n", "    y = run.vectors\n    z = [1.0, h]\n"))
    words = ["simulate", ROOT / "models" / "pendulum.mbd", "--method", "euler.py", "--step", "1ms", "--stop", "0.1s"]
    code, _, err = run(capsys, *words, "--quiet", "--output", "o.csv")
    assert (code, err) == (
        2,
        "euler.py:16:5: error: cannot compile the kernel motion: `[1.0, h]`\n"
        "        z = [1.0, h]\n"
        "        ^^^^^^^^^^^^\n"
        "  = write a tuple, or fill the entries of an array that is an argument; "
        "MBDSL_NO_COMPILE=1 runs kernels as Python\n",
    )


@pytest.mark.skipif(not code_cache.enabled(), reason="MBDSL_NO_COMPILE=1: nothing is compiled")
def test_a_wrong_call_in_a_kernel_has_a_line(files, capsys):
    files("euler.py", EULER + "\n\n@kernel\ndef correct(k, h, run):\n    finish(h)\n    return 0.0\n")
    words = ["simulate", ROOT / "models" / "pendulum.mbd", "--method", "euler.py", "--step", "1ms", "--stop", "0.1s"]
    code, _, err = run(capsys, *words, "--quiet", "--output", "o.csv")
    assert code == 2 and err.startswith(
        "euler.py:28:5: error: cannot compile the kernel correct: TypeError: missing a required argument: 'run'\n"
    )


# -- no file is executed that the user has not named --------------------------------------------------------------
def test_a_model_never_loads_a_file(files, capsys):
    files("evil.py", "open('executed', 'w')\n")
    model = CRANK.read_text(encoding="utf-8").replace("experiment(", 'experiment(Method = "evil.py", ')
    Path("m.mbd").write_text(model, encoding="utf-8")
    code, _, err = run(capsys, "simulate", "m.mbd", "--quiet")
    assert code == 2 and not Path("executed").exists()
    assert err == (
        "error: there is no method `evil.py`\n"
        "  = a model cannot load a Python file: mbdsl simulate MODEL --method evil.py\n"
    )


def test_a_checkpoint_never_loads_a_file(files, capsys, monkeypatch):
    from mbdsl.cli import simulate

    files("euler.py", EULER)
    name = method_files.load("euler.py")
    args = SimpleNamespace(checkpoint="c", checkpoint_every=60.0, model="m.mbd", stats=None, method=name)
    command = simulate.kept(args, "m.csv", False).about["command"]
    assert command["method_file"] == str(Path("euler.py").absolute())
    command = {"set": [], "option": [], "without": [], **command}
    monkeypatch.setattr("mbdsl.simulation.checkpoint.about", lambda path: {"command": command})
    monkeypatch.setattr("mbdsl.cli.simulate.run", lambda former, resumed: 0)
    code, _, err = run(capsys, "resume", "c")
    assert (code, err) == (
        2,
        "error: the run was started with the method `euler` of a Python file\n"
        f"  = mbdsl resume c --method {command['method_file']}\n",
    )
    assert run(capsys, "resume", "c", "--method", "euler.py") == (0, "", "")
    code, _, err = run(capsys, "resume", "c", "--method", "newmark")
    assert code == 2 and err.startswith("error: the run was started with another method than `newmark`\n")
