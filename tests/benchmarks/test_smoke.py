"""The benchmarks run and say what they should; no time is asserted."""

import importlib.util
import sys
from pathlib import Path

import pytest

from mbdsl.integrators import methods


def script(name):
    spec = importlib.util.spec_from_file_location(name, Path(__file__).with_name(f"{name}.py"))
    module = sys.modules[name] = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


@pytest.mark.filterwarnings("ignore")  # of the other program
def test_exudyn():
    pytest.importorskip("exudyn", reason="Exudyn is not installed: pip install 'mbdsl[bench]'")
    benchmark = script("exudyn_pendulum_chain")
    assert set(benchmark.METHODS) <= set(methods())
    text = benchmark.table(steps=40, repeats=1)
    assert text.count("mbdsl hht-") == 4
    assert text.count("Exudyn dense") == 4
    assert "VOID" not in text  # the models are the same


def test_startup():
    benchmark = script("startup")
    text = benchmark.table(1, {"mbdsl --help": ["--help"]})
    assert len(text.splitlines()) == 2
