"""mbdsl convert: a result file in another format, or a part of it."""

from __future__ import annotations

import argparse
from typing import TYPE_CHECKING

from mbdsl import results
from mbdsl.cli import _values as values
from mbdsl.cli._options import Command
from mbdsl.errors import UsageError
from mbdsl.messages import count
from mbdsl.results.selection import select
from mbdsl.storage import output_files

if TYPE_CHECKING:
    from collections.abc import Iterator

    import numpy as np

    from mbdsl.results.stored import Result

    Columns = dict[str, np.ndarray]


WHOLE = values.whole("expected a whole number above 0, found `{}`")


COMMAND = Command(
    "write a result file in another format, or a part of it",
    "Write a result in the format of another suffix ({results}). Files of any length are read and written in parts.",
    """
    result RESULT  result file ({results})
    --out FILE  the file to write; its suffix is the format
    --signals PATTERN,...  signals to write (globs, expressions); default: all
    --start T0  leave out earlier rows
    --stop T1  leave out later rows
    --every N  write every N-th row, beginning with the first
    | --most N  write at most N rows, with the least and largest values of signals
    @units_of_file
    """,
    out={"required": True},
    every=WHOLE,
    most=WHOLE,
)


def run(args: argparse.Namespace) -> int:
    from mbdsl.lang.display_units import asked, declared_text
    from mbdsl.results.rows_file import RowsFile
    from mbdsl.results.stored import open_result
    from mbdsl.simulation.result_expressions import with_expressions
    from mbdsl.simulation.result_units import KEY as SHOWN
    from mbdsl.simulation.result_units import converted
    from mbdsl.simulation.stored_extremes import KEY

    results.format_of(args.out)
    output_files.check([args.out], [args.result])
    if args.start is not None and args.stop is not None and args.stop < args.start:
        raise UsageError(f"--stop {args.stop:g} s is before --start {args.start:g} s")
    patterns = values.signals(args) or []
    result = with_expressions(open_result(args.result), patterns)
    names = result.names
    if args.signals:
        names = [name for name in select(patterns, names, args.result, of_file=True) if name != result.time]
    units = {"time": "s", **{name: result.unit(name) for name in names}}
    about = dict(result.layout.meta)
    if not getattr(results.format_of(args.out), "KEEPS_MODEL", False):
        about.pop("source", None)
    if declared := declared_text(result.display, names):
        about[SHOWN] = declared
    if args.start is not None or args.stop is not None:
        about.pop(KEY, None)  # they are those of the whole run
    with RowsFile(["time", *names], args.out) as file:
        for columns in _rows(args, result, names):
            file.append([columns[result.time], *(columns[name] for name in names)])
        columns, units = converted(args.out, file.columns(), units, asked(args.units, result.display))
        results.write(args.out, columns, units, about, row_of_units=values.row_of_units(args))
        print(values.written(args.out, f"{count(file.count, 'row')}, time and {count(len(names), 'signal')}"))
    return 0


def _rows(args: argparse.Namespace, result: Result, names: list[str]) -> Iterator[Columns]:
    """The chosen rows, in parts."""
    if args.most is None:
        yield from _within(args, result, names)
        return
    from mbdsl.plotting.decimation import ThinnedRows

    rows = ThinnedRows([result.time, *names], result.time, args.most)
    for columns in _within(args, result, names):
        rows.add(columns)
    yield rows.columns()


def _within(args: argparse.Namespace, result: Result, names: list[str]) -> Iterator[Columns]:
    """The rows from ``--start`` to ``--stop``, each N-th of them with ``--every``."""
    import numpy as np

    seen = 0
    for times, columns in result.chunks(names):
        keep = np.ones(len(times), bool)
        if args.start is not None:
            keep &= times >= args.start
        if args.stop is not None:
            keep &= times <= args.stop
        chosen = np.flatnonzero(keep)
        if args.every:
            chosen, seen = chosen[-seen % args.every :: args.every], seen + len(chosen)
        yield {name: x[chosen] for name, x in columns.items()}
