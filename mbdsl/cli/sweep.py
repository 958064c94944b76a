"""mbdsl sweep: a run for each combination of values of parameters, as a table and as a picture."""

from __future__ import annotations

import argparse
import sys

from mbdsl.cli import _values as values
from mbdsl.cli._options import Command
from mbdsl.cli._studies import of_sweep, save, varied
from mbdsl.messages import count
from mbdsl.plotting.terminal_text import text_width

COLUMNS = 100  #: characters of a line where the output is not a terminal


COMMAND = Command(
    "run a model with many values of its parameters",
    "Run a model with each combination of values of parameters, on all cores, and print measures of each run as a "
    "table. Completed runs are stored: after Ctrl-C the same command continues. The exit code is 4 if a run failed.",
    """
    @model
    --vary NAME=VALUES  a parameter and its values, repeatable: L=1:2:11 (start:stop:count), L=1:1000:4:log, L=0.5,1,2;
        a unit comes last: "k=1:10:5 N/mm"
    --paired  first run: the first value of each parameter; second run: the second values, ...; default: all
        combinations
    --measure F(SIGNAL),... ...  measures of each run, repeatable: final, min, max, maxabs, mean, rms, amplitude,
        period, time_of_max, time_of_min of a signal or glob, time_when(CONDITION, first|last|count), at(SIGNAL,
        TIME|CONDITION), at_max(SIGNAL, OTHER), at_min, static(SIGNAL) at the equilibrium, frequency(N),
        damped_frequency(N), damping(N) of mode N, followed by its shape; default: min and max of the coordinates of the
        first body
    @runs
    --quiet  print errors only
    | --verbose  print all rows of a long table
    """,
    vary={"type": values.variation, "action": "append", "required": True},
)


def run(args: argparse.Namespace) -> int:
    vary = varied(args)

    from mbdsl.studies.measures import split
    from mbdsl.studies.sweep import sweep

    measures = [measure for text in args.measure for measure in split(text)] or None
    found = of_sweep(args, sweep, vary, measures, paired=args.paired)
    if not args.quiet:
        print(found.text(text_width(COLUMNS), len(found) if args.verbose else 40) + ("\n" if args.output else ""))
    save(found, args)
    if found.failed:
        if args.quiet:
            print(f"{len(found.failed)} of {count(len(found), 'run')} failed", file=sys.stderr)
        return 4
    return 0
