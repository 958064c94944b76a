"""mbdsl report: one page about a model and its run."""

from __future__ import annotations

import argparse
import shlex
import sys

from mbdsl.cli import _values as values
from mbdsl.cli._options import Command
from mbdsl.cli._streams import say
from mbdsl.cli.simulate import add_options as add_options
from mbdsl.errors import UsageError
from mbdsl.storage import output_files

COMMAND = Command(
    "write a page about a model and its run",
    "Simulate a model and write one HTML page: its text, picture, graph and effects, the motion, main signals, energy"
    " and constraint drift, the run's statistics, and the data that are required to repeat it. The page loads nothing"
    " and can be mailed or printed.",
    """
    @model method_and_option step tol start stop interval
    --signals PATTERN,...  signals to plot (globs, expressions); default: changing coordinates of joints, drivers,
        bodies
    @units
    --eigen  include the eigenmodes and their shapes
    --at STATE  with --eigen: the state, static (default), start, a time such as 1.5s, or values such as "pin.phi=80
        deg"; see `mbdsl eigen`
    --out FILE  the page (.html); default: NAME-report.html
    @quiet
    """,
    at={"default": None},
)


def run(args: argparse.Namespace) -> int:
    from mbdsl.cli._runs import of_arguments
    from mbdsl.reporting.report import check_suffix, report

    out = args.out or f"{values.stem(args)}-report.html"
    check_suffix(out)
    output_files.check([out], [args.model])
    if args.at is not None and not args.eigen:
        raise UsageError("--at belongs to --eigen", hint="add --eigen")
    trajectory, failure = of_arguments(args, out)
    eigen = (args.at if args.at is not None else "static") if args.eigen else None
    found = report(
        trajectory, values.signals(args), eigen, command=repeated(args), announce=None if args.quiet else say
    )
    found.save(out)
    for problem in found.problems:
        print(f"warning: {problem}", file=sys.stderr)
    if not args.quiet:
        print(values.written(out, values.file_size(out)))
    if failure is not None:
        raise failure
    return 0


def repeated(args: argparse.Namespace) -> str:
    """The command with these arguments, for a shell."""
    words = ["mbdsl", "report", args.model]
    words += ["--model", args.model_name] if args.model_name else []
    for option in ("set", "option"):
        for name, value in getattr(args, option):
            words += [f"--{option}", f"{name}={value}"]
    words += ["--without", ",".join(args.without)] if args.without else []
    if args.method:
        from mbdsl.integrators.method_files import spelled

        words.append(f"--method={spelled(args.method)}")
    for name in ("step", "tol", "start", "stop", "interval", "signals", "units", "at", "out"):
        if (value := getattr(args, name)) is not None:
            words.append(f"--{name}={value if isinstance(value, str) else repr(value)}")
    words += [f"--{name.replace('_', '-')}" for name in ("eigen", "allow_imports") if getattr(args, name)]
    return shlex.join(words)
