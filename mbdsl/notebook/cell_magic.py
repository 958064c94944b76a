"""The cell magic ``%%mbd``: a model as the text of a cell.

    %load_ext mbdsl

    %%mbd crank --simulate --stop 2s
    model SliderCrank
      ...
    end SliderCrank;

The first line names the variable that the scene is assigned to. An error is raised, so that a run of
all cells stops there; IPython shows its message with line and column in the cell, and no traceback.
"""

from __future__ import annotations

import argparse
import keyword
import shlex
import sys
from typing import TYPE_CHECKING, Any

from mbdsl.cli import Parser
from mbdsl.cli import _values as values
from mbdsl.cli._options import add
from mbdsl.cli.simulate import add_options
from mbdsl.errors import IntegrationError, Interrupted, UsageError
from mbdsl.lang.display_units import in_units
from mbdsl.lang.load import parse_text
from mbdsl.mechanism.graph import build

if TYPE_CHECKING:
    from IPython.core.interactiveshell import InteractiveShell

    from mbdsl.mechanism.scene import Scene
    from mbdsl.simulation.trajectory import Trajectory

FILE = "<cell>"  #: name of the text in messages
SUFFIX = "_run"  #: of the variable of the trajectory
#: options of a simulation
SETTINGS = ("method", "step", "tol", "accuracy", "start", "stop", "interval")


def register(shell: InteractiveShell) -> None:
    """Add the magic to a shell."""

    def mbd(line: str, cell: str | None = None) -> Scene | Trajectory | None:
        return _run(shell.user_ns, line, cell)

    mbd.__doc__ = _parser().format_help()
    shell.register_magic_function(mbd, "line_cell", "mbd")  # as a line: `%mbd --help`


def _parser(options: bool = False) -> Parser:
    """The parser of the first line, with ``options`` for the parameters of all methods, which load slowly."""
    parser = Parser(
        prog="%mbd",
        usage="%%%%mbd NAME [--simulate [RESULT] [--method NAME] [--step H] ...]",
        add_help=False,
        allow_abbrev=False,
        description="Read the model in the cell and assign it to a variable; simulate it if requested.",
    )
    add(
        parser,
        f"""
        name NAME  variable for the scene
        --simulate [RESULT]  simulate the model and assign the trajectory to this variable; default: NAME{SUFFIX}
        @method_and_option step tol accuracy start stop interval units changes
        """,
    )
    parser.add_argument("-h", "--help", action="store_true", help="show these options")
    if options:
        add_options(parser)
    return parser


def _run(variables: dict[str, Any], line: str, cell: str | None) -> Scene | Trajectory | None:
    """Read the model, simulate it, and return the value that the notebook shows."""
    try:
        words = shlex.split(line)
    except ValueError as problem:
        raise UsageError(f"cannot read the options `{line}`: {problem}") from None
    parser = _parser("--simulate" in words)
    if {"-h", "--help"} & {*words}:
        print(parser.format_help())
        return None
    if cell is None:
        raise UsageError(
            "%mbd has no cell", hint="write `%%mbd NAME` and the model below it; %mbd --help lists options"
        )
    if not words:
        raise UsageError("%%mbd needs the name of a variable", hint="write `%%mbd crank`; %mbd --help lists options")
    args = parser.parse_args(words)
    result = _variable(args.simulate or f"{args.name}{SUFFIX}") if args.simulate is not None else ""
    name = _variable(args.name)
    given = [f"--{key}" for key in (*SETTINGS, "option") if getattr(args, key) not in (None, [])]
    if given and not result:
        raise UsageError(f"{', '.join(given)} without --simulate", hint="add --simulate, or omit them")
    # The first line of the cell is that of the magic.
    scene = parse_text(
        f"\n{cell}", FILE, dict(args.set), args.model_name, without=args.without, allow_imports=args.allow_imports
    )
    scene = in_units(scene, args.units)
    for warning in (*scene.warnings, *build(scene).warnings):
        print(warning.render(), file=sys.stderr)
    variables[name] = scene
    return _simulated(variables, result, scene, args) if result else scene


def _variable(name: str) -> str:
    if not name.isidentifier() or keyword.iskeyword(name):
        raise UsageError(f"`{name}` is not the name of a variable", hint="write `%%mbd crank`")
    return name


def _simulated(variables: dict[str, Any], result: str, scene: Scene, args: argparse.Namespace) -> Trajectory:
    """The trajectory of a scene; an incomplete one is also assigned, before its error is raised."""
    from mbdsl.api import simulate

    settings: dict[str, Any] = {key: getattr(args, key) for key in SETTINGS}
    try:
        variables[result] = simulate(scene, options=values.numbers(args.option), announce=print, **settings)
    except (IntegrationError, Interrupted) as problem:
        if problem.trajectory is not None:
            variables[result] = problem.trajectory
        raise
    return variables[result]
