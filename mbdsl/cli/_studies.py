"""What commands that make many runs have in common: a count of the runs, tables, and files of sweeps."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any

from mbdsl.cli import _values as values
from mbdsl.cli._progress import Counter
from mbdsl.errors import UsageError
from mbdsl.messages import count
from mbdsl.storage import output_files

if TYPE_CHECKING:
    from mbdsl.studies.sweep_results import Sweep

#: arguments of the runs of a sweep that are words of the command
OF_RUNS = tuple("after method step tol start stop interval at without limit fresh units".split())


@contextmanager
def counted(fresh: bool) -> Iterator[Counter]:
    """A display of the number of runs; after Ctrl-C it says how many are stored."""
    counter = Counter(sys.stderr)
    try:
        yield counter
    except KeyboardInterrupt:
        counter.close()
        print(_kept(counter.kept, fresh), file=sys.stderr)
        raise
    finally:
        counter.close()


def _kept(runs: int, fresh: bool) -> str:
    """Message about the stored runs of an interrupted study."""
    if not runs:
        return "no run was completed: nothing is stored"
    command = "the same command without --fresh" if fresh else "the same command"
    return f"{count(runs, 'run is', 'runs are')} stored; {command} continues from there"


def of_sweep(args: argparse.Namespace, function: Callable[..., Any], *given: object, **further: object) -> Any:
    """The result of ``sweep`` or ``solve`` for the words of a command."""
    with counted(args.fresh) as counter:
        return function(
            args.model,
            *given,
            options=values.numbers(args.option),
            parameters=dict(args.set),
            tell=None if args.quiet else counter,
            announce=None if args.quiet else counter.say,
            **{name: getattr(args, name) for name in OF_RUNS},
            **further,
        )


def varied(args: argparse.Namespace) -> dict[str, str]:
    """Values by the name of their parameter, each of which is given once; the files of the command are checked, too.

    Raises
    ------
    UsageError
        If a parameter is given twice, or a file cannot be written.
    """
    for k, (name, _) in enumerate(args.vary):
        if name in (other for other, _ in args.vary[:k]):
            raise UsageError(f"`{name}` is varied twice", hint="give all of its values in one --vary")
    if args.output:
        from mbdsl.studies.sweep_figures import SUFFIXES

        for path in args.output:
            output_files.suffix_of(path, SUFFIXES)
        output_files.check(args.output, [args.model])
    return dict(args.vary)


def save(found: Sweep, args: argparse.Namespace) -> None:
    """Write the files of a sweep."""
    for path in args.output:
        found.save(path)
        if not args.quiet:
            print(values.written(path, count(len(found), "run")))


def save_table(found: Any, args: argparse.Namespace, what: str = "tables") -> None:
    """Write the tables of a study, if the command asks for them."""
    if args.table:
        from mbdsl.studies.tables import write

        write(found, args.table)
        if not getattr(args, "quiet", False):
            print(values.written(args.table, what))
