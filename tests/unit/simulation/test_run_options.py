"""The table of the options of a run, and what shows it: signatures, types, the command line."""

import ast
import inspect
from dataclasses import fields
from pathlib import Path

import pytest

import mbdsl
from mbdsl.cli import make_parser
from mbdsl.simulation import run_options
from mbdsl.simulation.run_options import OPTIONS, RunOptions

NAMES = [x.name for x in fields(RunOptions)]


def test_type_checkers_see_the_options_of_the_table():
    tree = ast.parse(Path(run_options.__file__).read_text(encoding="utf-8"))
    (typed,) = (x for x in ast.walk(tree) if isinstance(x, ast.ClassDef) and x.name == "GivenOptions")
    given = {x.target.id: ast.unparse(x.annotation) for x in typed.body if isinstance(x, ast.AnnAssign)}
    assert list(given) == NAMES
    assert {name for name, kind in given.items() if "float | str" in kind} == {n for n, o in OPTIONS.items() if o.unit}


def test_signatures_show_the_options():
    assert [*inspect.signature(mbdsl.simulate).parameters] == ["model", *NAMES]
    stepwise = inspect.signature(mbdsl.Simulation).parameters
    assert {*stepwise} - {"model", "record"} < {*NAMES} and stepwise["step"].annotation == "float | str | None"


@pytest.mark.parametrize("function", [mbdsl.simulate, mbdsl.Simulation])
def test_an_unknown_option_is_refused_with_the_nearest_name(function):
    with pytest.raises(TypeError, match=r"unexpected keyword argument 'stepp'; did you mean `step`"):
        function("m.mbd", stepp=1e-3)


def test_simulate_takes_an_option_of_the_table_from_the_command_line():
    args = make_parser("simulate").parse_args(["simulate", "m.mbd", "--accuracy", "1e-4", "--budget", "2 min"])
    assert (args.accuracy, args.budget, args.step) == (1e-4, 120.0, None)
