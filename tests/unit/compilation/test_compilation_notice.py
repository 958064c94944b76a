"""A compilation is announced in terminals and notebooks, on standard error, and nowhere else."""

import io
import multiprocessing
import sys
from pathlib import Path

import pytest

import mbdsl
from mbdsl.cli import main
from mbdsl.compilation import code_cache
from mbdsl.system import System

MODEL = Path(__file__).parents[3] / "models" / "slider_crank.mbd"
SHORT = {"stop": 0.01, "step": 1e-3}
CALLS = {
    "simulate": lambda **given: mbdsl.simulate(MODEL, **SHORT, **given),
    "static": lambda **given: mbdsl.static(MODEL, **given),
    "explain": lambda **given: mbdsl.explain(MODEL, measured=False, **given),
    "Simulation": lambda: mbdsl.Simulation(MODEL, step=1e-3),
}


class Terminal(io.StringIO):
    def isatty(self):
        return True


#: the class of standard error in a kernel of IPython, which is not a terminal
Kernel = type("OutStream", (io.StringIO,), {"__module__": "ipykernel.iostream"})


@pytest.fixture
def uncompiled(monkeypatch):
    """As if no code were in the cache."""
    monkeypatch.setattr(code_cache, "is_compiled", lambda name: False)
    monkeypatch.setattr(System, "compile_beside", lambda system, sets: None)  # it starts a process


def said(monkeypatch, stream, call):
    monkeypatch.setattr(sys, "stderr", stream)
    call()
    return stream.getvalue()


@pytest.mark.parametrize("stream", [Terminal, Kernel])
@pytest.mark.parametrize("call", CALLS.values(), ids=CALLS)
def test_one_line_in_a_terminal_and_in_a_notebook(uncompiled, monkeypatch, capsys, stream, call):
    text = said(monkeypatch, stream(), call)
    assert text.startswith("mbdsl: compiling for the first time: a new combination of elements (rigid body, ")
    assert text.count("\n") == 1
    assert capsys.readouterr().out == ""


@pytest.mark.parametrize("call", CALLS.values(), ids=CALLS)
def test_nothing_if_the_code_is_compiled(monkeypatch, call):
    monkeypatch.setattr(code_cache, "is_compiled", lambda name: True)
    assert said(monkeypatch, Terminal(), call) == ""


def test_nothing_into_files_and_pipes(uncompiled, monkeypatch):
    assert said(monkeypatch, io.StringIO(), CALLS["simulate"]) == ""


def test_nothing_in_worker_processes(uncompiled, monkeypatch):
    monkeypatch.setattr(multiprocessing, "parent_process", lambda: "parent")
    assert said(monkeypatch, Terminal(), CALLS["simulate"]) == ""


def test_a_given_function_replaces_the_line(uncompiled, monkeypatch):
    lines = []
    assert said(monkeypatch, Terminal(), lambda: CALLS["simulate"](announce=lines.append)) == ""
    assert len(lines) == 1
    assert lines[0].startswith("compiling for the first time: a new combination of elements (")
    assert " and method hht-si2; the code " in lines[0]


def test_the_command_line_says_it_once_or_not_at_all(uncompiled, monkeypatch, tmp_path):
    given = ["simulate", str(MODEL), "--stop", "10ms", "--step", "1ms", "--output", str(tmp_path / "a.csv")]
    assert said(monkeypatch, Terminal(), lambda: main([*given, "--quiet"])) == ""
    assert said(monkeypatch, Terminal(), lambda: main(given)).count("compiling") == 1
