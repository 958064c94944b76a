"""mbdsl study: several runs of a model, to measure errors, run times and effects."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

from mbdsl.cli import _values as values
from mbdsl.cli._options import Command
from mbdsl.cli._streams import print_problem, say
from mbdsl.cli._studies import counted, save_table
from mbdsl.errors import UsageError
from mbdsl.messages import install

SIGNALS = "--signals PATTERN,...  further signals (globs)"
REPEATS = "--repeats K  timed runs of each; default 5"


def _of_methods(kind: str, help: str, description: str, *further: str) -> Command:
    """A study of methods, with ``further`` options."""
    table = """
    @model methods
    --steps H,...  fixed steps: 4ms,2ms,1ms
    --tols TOL,...  tolerances of error-controlled steps
    {}
    --stop T  stop time; default: the model's
    --budget S  time budget of all runs, compilation included; default 120 s
    --output DIR  output folder; default: MODEL-{}
    --pictures SUFFIX,...  formats of pictures: png, svg, pdf; default png,svg; none: the page alone
    @table fresh
    --quiet  print nothing
    | --verbose  print long tables, too
    """.format("\n    ".join(further), kind)
    more: dict[str, Any] = {"repeats": {"type": int, "default": 5}} if REPEATS in further else {}
    more |= {"steps": values.list_of(values.positive_seconds), "tols": values.list_of(values.tolerance)}
    return Command(help, description, table, budget={"default": 120.0}, pictures=values.names, **more)


KINDS = {
    "convergence": _of_methods(
        "convergence",
        "errors as functions of the step or the tolerance",
        "Errors of positions, velocities, reactions, energy and constraints as functions of the step or the "
        "tolerance, with slopes and the orders of the methods.",
        SIGNALS,
        "@reference",
    ),
    "energy": _of_methods(
        "energy",
        "energy errors of the methods",
        "The energy error as a function of time, and its mean as a function of the step.",
        "@reference",
    ),
    "drift": _of_methods(
        "drift",
        "constraint violations of the methods",
        "Violation of the constraints of positions and velocities, as a function of time and of the step.",
    ),
    "runtime": _of_methods(
        "runtime",
        "time of a step with every method",
        "Time of a step and of a simulated second with every method, absolute and relative to hht-i3.",
        REPEATS,
    ),
    "work-precision": _of_methods(
        "work-precision",
        "error against run time",
        "Errors of every method as functions of the run time, and the least time for each error.",
        SIGNALS,
        "@reference",
        REPEATS,
    ),
    "effects": Command(
        "the effects that a result depends on",
        "Run the model without each effect in turn (friction, damping, flexibility, gravity, contact), and print the"
        " change of a signal and the run time of the effect.",
        f"""
        @model
        --signal NAME  name of a signal, such as crank.phi or O.fx
        --tol E  allowed change: 1mm, or relative to its range, 1%%
        @method
        --step H  step size; default: the model's
        --stop T  stop time; default: the model's
        {REPEATS}
        @table
        """,
        signal={"required": True},
        tol={"type": None},
        repeats={"type": int, "default": 5},
    ),
}
COMMAND = Command(
    "measure errors, run times and effects by several runs", "Studies of a model by several runs.", kinds=KINDS
)


def run(args: argparse.Namespace) -> int:
    return _effects(args) if args.kind == "effects" else _methods(args)


def _methods(args: argparse.Namespace) -> int:
    output = Path(args.output or f"{values.stem(args)}-{args.kind}")
    values.check_table(args)
    pictures = _checked(args.pictures)
    values.check_folder(output)

    study = _function(args.kind)
    given = {name: getattr(args, name) for name in ("methods", "steps", "tols", "stop", "budget", "fresh", "without")}
    given |= {name: getattr(args, name) for name in ("reference", "repeats") if hasattr(args, name)}
    if getattr(args, "signals", None):
        given["signals"] = values.patterns(args.signals)
    with counted(args.fresh) as counter:
        found = study(args.model, parameters=dict(args.set), tell=counter, announce=counter.say, **given)
    if not args.quiet:
        print(found.text(10**9) if args.verbose else found)
    paths = found.write(output, pictures)
    if not args.quiet:
        print(f"\n{output}: {', '.join(path.name for path in paths if path.suffix in ('.csv', '.json', '.html'))}"
              f"{_pictures(paths)}")  # fmt: skip
    save_table(found, args)
    return 0


def _checked(pictures: list[str] | None) -> list[str]:
    """Suffixes of the pictures to draw; none by default if matplotlib is not installed.

    Raises
    ------
    UsageError
        If a requested suffix is unknown, or requested pictures cannot be drawn.
    """
    if pictures == ["none"]:
        return []
    from importlib.util import find_spec

    from mbdsl.plotting.pictures import SUFFIXES
    from mbdsl.studies.report import PICTURES

    wanted = list(PICTURES) if pictures is None else list(dict.fromkeys(pictures))
    for suffix in wanted:
        if f".{suffix}" not in SUFFIXES:
            listed = ", ".join(known[1:] for known in SUFFIXES)
            hint = f"known suffixes are {listed}; none, by itself, is the page alone"
            raise UsageError(f"argument --pictures: unknown suffix `{suffix}`", hint=hint)
    if wanted and find_spec("matplotlib") is None:
        hint = f"{install('plot')}; or take --pictures none"
        problem = UsageError("matplotlib, which draws pictures, is not installed", hint=hint)
        if pictures is not None:
            raise problem
        print_problem(problem)
        return []
    return wanted


def _pictures(paths: list[Path]) -> str:
    count = sum(path.suffix not in (".csv", ".json", ".html") for path in paths)
    return f" and {count} pictures" if count else ""


def _function(kind: str) -> Callable:
    """The function of a study: ``work_precision`` of ``mbdsl.studies.work_precision``."""
    from importlib import import_module

    name = kind.replace("-", "_")
    return getattr(import_module(f"mbdsl.studies.{name}"), name)


def _effects(args: argparse.Namespace) -> int:
    values.check_table(args)

    from mbdsl.studies.effects import effects

    study = effects(
        args.model,
        args.signal,
        tol=args.tol,
        method=args.method,
        step=args.step,
        stop=args.stop,
        parameters=dict(args.set),
        without=args.without,
        repeats=args.repeats,
        announce=say if sys.stderr.isatty() else None,
    )
    print(study)
    save_table(study, args)
    return 0
