"""mbdsl warm: what it compiles, in which order, and what it prints. Compilation itself is replaced."""

import subprocess
import sys
from pathlib import Path

import pytest

from mbdsl.cli import main
from mbdsl.compilation import code_cache
from mbdsl.integrators import compiled
from mbdsl.integrators.loop.compiled_loop import loop_name
from mbdsl.lang.load import load
from mbdsl.simulation import code_preparation
from mbdsl.simulation.code_preparation import EmittedModule, codes, prepare
from mbdsl.simulation.mechanism_run import MechanismRun
from mbdsl.simulation.plan import plan
from mbdsl.simulation.run_options import RunOptions
from mbdsl.storage import cache_folder

MODELS = Path(__file__).parents[3] / "models"


class Bench:
    """Codes whose compilation starts a process that does nothing, and a log of the calls."""

    def __init__(self, monkeypatch, *ready):
        self.ready, self.log, self.running, self.most = set(ready), [], {}, 0
        monkeypatch.setattr(code_cache, "is_compiled", self.is_ready)

    def is_ready(self, name):
        if name in self.running and self.running[name].poll() == 0:
            self.ready.add(name)
        return name in self.ready

    def code(self, name, fails=False):
        def beside():
            self.running[name] = subprocess.Popen([sys.executable, "-I", "-c", f"raise SystemExit({int(fails)})"])
            others = [n for n, process in self.running.items() if process.poll() is None]
            self.most = max(self.most, len(others))
            self.log.append(("start", name))
            return self.running[name]

        def here():
            self.log.append(("here", name))
            self.ready.add(name)

        return EmittedModule(name, name, here, beside)


def test_each_code_is_compiled_once_and_two_at_a_time(monkeypatch):
    bench, done, seen = Bench(monkeypatch, "there"), [], []
    given = [bench.code(name) for name in ("there", "a", "b", "c")]
    prepare(given, 2, seen.append, lambda code, seconds: done.append(code.name))
    assert sorted(done) == ["a", "b", "c"] and bench.log == [("start", name) for name in "abc"]
    assert bench.most <= 2
    assert (seen[0].done, seen[0].total, seen[0].what) == (1, 4, "a, b")
    prepare(given, 2, seen.append, lambda code, seconds: pytest.fail("compiled again"))


def test_what_no_process_can_compile_is_compiled_here(monkeypatch):
    """So that its error is printed; a process alone would leave nothing but an exit code."""
    bench = Bench(monkeypatch)
    alone = EmittedModule("alone", "alone", lambda: bench.ready.add("alone"), lambda: None)
    prepare([bench.code("a", fails=True), alone], 2, lambda progress: None, lambda code, seconds: None)
    assert ("here", "a") in bench.log and {"a", "alone"} <= bench.ready


def test_an_interruption_ends_the_other_processes(monkeypatch):
    started = []

    def beside():
        started.append(subprocess.Popen([sys.executable, "-I", "-c", "import time; time.sleep(60)"]))
        return started[0]

    def interrupt(progress):
        raise KeyboardInterrupt

    monkeypatch.setattr(code_cache, "is_compiled", lambda name: False)
    with pytest.raises(KeyboardInterrupt):
        prepare([EmittedModule("a", "a", lambda: None, beside)], 1, interrupt, lambda code, seconds: None)
    assert started[0].returncode is not None


@pytest.mark.parametrize("model", ["slider_crank", "driven_crank", "pendulum"])
def test_a_run_of_a_prepared_model_needs_nothing_else(model):
    scene = load(MODELS / f"{model}.mbd")
    names = {code.name for code in codes([(model, scene)])}
    needed = set()
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(code_cache, "is_compiled", lambda name: needed.add(name) or True)
        for method in compiled():
            MechanismRun(scene, plan(scene, RunOptions(method=method, step=1e-3, stop=0.1))).uncompiled()
    assert needed and needed <= names


def test_the_loops_of_all_methods_without_a_model():
    """Methods may share a loop, as radau9 and radau13 do."""
    assert {loop_name(method) for method in compiled()} <= {code.name for code in codes([])}


def test_chosen_methods_only():
    found = codes([("pendulum", load(MODELS / "pendulum.mbd"))], ["hht-i3"])
    what = {code.what for code in found}
    assert what >= {
        "step loop of hht-i3",
        "step loop of models without degrees of freedom",
        "equations of pendulum, index 3",
    }
    assert not {text for text in what if "newmark" in text or "additive" in text}
    assert len({code.name for code in found}) == len(found)


def test_the_command(monkeypatch, capsys, tmp_path):
    monkeypatch.setenv("MBDSL_CACHE_DIR", str(tmp_path))
    bench = Bench(monkeypatch, "there")
    given = [bench.code("there"), bench.code("step loop of newmark")]
    monkeypatch.setattr(code_preparation, "codes", lambda scenes, methods: given)
    monkeypatch.setattr(code_cache, "enabled", lambda: True)
    assert main(["warm"]) == 0
    out = capsys.readouterr().out.splitlines()
    assert out[0].startswith("step loop of newmark: ") and out[0].endswith(" s")
    assert out[1].startswith("2 modules: 1 compiled in ") and out[1].endswith(" s, 1 already in the cache")
    assert out[2] == f"folder: {tmp_path}"
    assert main(["warm", "--jobs", "1"]) == 0
    assert capsys.readouterr().out.startswith("2 modules: nothing to compile, 2 already in the cache\n")
    assert main(["warm", "--quiet"]) == 0
    assert capsys.readouterr() == ("", "")


def test_without_a_folder_or_a_compiler_it_fails(monkeypatch, capsys, tmp_path):
    """An image must not be built without the code."""
    monkeypatch.setenv("MBDSL_CACHE_DIR", "relative")
    assert main(["warm"]) == 2
    error = capsys.readouterr().err
    assert "machine code cannot be stored: MBDSL_CACHE_DIR is `relative`" in error
    assert "  = set MBDSL_CACHE_DIR to the absolute path of a folder" in error
    monkeypatch.setenv("MBDSL_CACHE_DIR", str(tmp_path))
    cache_folder._chosen.cache_clear()
    monkeypatch.setattr(code_cache, "enabled", lambda: False)
    assert main(["warm"]) == 2
    assert "kernels are not compiled: MBDSL_NO_COMPILE is set" in capsys.readouterr().err


@pytest.mark.parametrize("number", ["0", "-1", "two", "9999"])
def test_a_wrong_number_of_processes(capsys, number):
    assert main(["warm", f"--jobs={number}"]) == 2
    assert "above 0" in capsys.readouterr().err
