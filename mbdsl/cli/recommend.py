"""mbdsl recommend: the method and the step or tolerance that reach an error in the least time."""

from __future__ import annotations

import argparse

from mbdsl.cli import _values as values
from mbdsl.cli._options import Command
from mbdsl.cli._studies import counted, save_table

#: arguments of `recommend` that are words of the command
NAMES = ("methods", "reference", "stop", "repeats", "budget", "fresh", "without")

COMMAND = Command(
    "find the fastest method and step for an error",
    "Measure the error and the cost of every method by a cheap run, refine the steps of those that may be the "
    "fastest, and print the fastest command on this machine. Runs are stored; the same command continues.",
    """
    @model
    --error E  allowed error: of the signal (1e-6, 1mm, 1%%), or of positions and velocities, scaled
    --signal NAME  signal with this error; default: all positions and velocities
    @methods
    @reference
    --stop T  stop time; default: the model's
    --repeats K  timed runs of each; default 3
    --budget S  time budget, compilation included; default 120 s
    @table
    @fresh
    """,
    error={"required": True},
    repeats={"type": int, "default": 3},
    budget={"default": 120.0},
)


def run(args: argparse.Namespace) -> int:
    values.check_table(args)

    from mbdsl.studies.recommendation import recommend

    given = {name: getattr(args, name) for name in NAMES}
    with counted(args.fresh) as counter:
        found = recommend(
            args.model,
            args.error,
            args.signal,
            parameters=dict(args.set),
            tell=counter,
            announce=counter.say,
            **given,
        )
    print(found)
    save_table(found, args, "table")
    return 0
