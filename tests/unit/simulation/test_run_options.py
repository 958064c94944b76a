"""The table of the options of a run, and what shows it: signatures, types, the command line."""

import ast
import inspect
from dataclasses import fields
from pathlib import Path

import pytest

import mbdsl
from mbdsl.cli import make_parser
from mbdsl.simulation import run_options
from mbdsl.simulation.run_options import RunOptions
from mbdsl.studies import sweep_options
from mbdsl.studies.sweep_options import SweepOptions

NAMES = [x.name for x in fields(RunOptions)]


@pytest.mark.parametrize(
    ("module", "typed_as", "table"),
    [(run_options, "GivenOptions", RunOptions), (sweep_options, "GivenSweepOptions", SweepOptions)],
)
def test_type_checkers_see_the_options_of_the_table(module, typed_as, table):
    tree = ast.parse(Path(module.__file__).read_text(encoding="utf-8"))
    (typed,) = (x for x in ast.walk(tree) if isinstance(x, ast.ClassDef) and x.name == typed_as)
    given = {x.target.id: ast.unparse(x.annotation) for x in typed.body if isinstance(x, ast.AnnAssign)}
    assert list(given) == [x.name for x in fields(table)]
    numbers = {x.name for x in fields(table) if run_options.unit_of(x)}
    assert {name for name, kind in given.items() if "float | str" in kind} - {"at"} == numbers


def test_options_of_sweeps_that_are_options_of_runs_have_their_types():
    types = {x.name: x.type for x in fields(RunOptions)}
    shared = [x for x in fields(SweepOptions) if x.name in types]
    assert len(shared) == 11 and all(x.type == types[x.name] for x in shared)


def test_signatures_show_the_options():
    assert [*inspect.signature(mbdsl.simulate).parameters] == ["model", *NAMES]
    stepwise = inspect.signature(mbdsl.Simulation).parameters
    assert {*stepwise} - {"model", "record"} < {*NAMES} and stepwise["step"].annotation == "float | str | None"


@pytest.mark.parametrize("function", [mbdsl.simulate, mbdsl.Simulation, mbdsl.sweep, mbdsl.solve, mbdsl.study.effects])
def test_an_unknown_option_is_refused_with_the_nearest_name(function):
    with pytest.raises(TypeError, match=r"unexpected keyword argument 'stepp'; did you mean `step`"):
        function("m.mbd", stepp=1e-3)


def test_simulate_takes_an_option_of_the_table_from_the_command_line():
    args = make_parser("simulate").parse_args(["simulate", "m.mbd", "--accuracy", "1e-4", "--budget", "2 min"])
    assert (args.accuracy, args.budget, args.step) == (1e-4, 120.0, None)
