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


def test_method_costs():
    benchmark = script("method_costs")
    text = benchmark.table(repeats=1, steps=20)
    assert set(benchmark.METHODS) == set(methods())
    cases = len(benchmark.CASES) + len(benchmark.LARGER)
    for name in methods():
        assert text.count(f"  {name} ") == cases + len(benchmark.CASES)  # its rows, and a bar for each case
    assert "VOID" not in text
    assert text.count("about 1.3\n") == 4  # two methods, two models


def test_ratios_of_method_costs():
    """Of the minima, and the median over rounds; a target is met by the median."""
    benchmark = script("method_costs")
    costs = {name: benchmark.Cost([1.0, 2.0, 4.0]) for name in benchmark.METHODS}
    costs["hht-si2"] = benchmark.Cost([2.0, 2.2, 4.4])
    assert benchmark.ratios(costs, "hht-si2") == (2.0, 1.1)
    case = benchmark.CASES[0]
    line = next(line for line in benchmark.rows(case, costs) if "hht-si2" in line and "nstiff" not in line)
    assert line.endswith("1.15 met")
    costs["hht-si2"] = benchmark.Cost([1.0, 2.4, 4.8])
    assert "1.15 MISSED" in "".join(benchmark.rows(case, costs))
