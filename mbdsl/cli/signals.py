"""mbdsl signals: the signals of a model with units and meanings. Loads no numerics."""

from __future__ import annotations

import argparse
import csv
import json
import sys

from mbdsl.cli import _values as values
from mbdsl.cli._options import Command
from mbdsl.messages import cell, count

COMMAND = Command(
    "list the signals of a model with units and meanings",
    "List the signals of a model, which --signals selects in other commands, with units and meanings. Without a "
    "PATTERN, bodies, joints and frames with the same signals are listed together.",
    """
    @model
    patterns PATTERN ...  list full names that match: a name, or a glob such as 'crank.*'; '*' lists all
    --format {text,csv,json}  text (default); csv or json: full names for other programs
    """,
    format={"default": "text"},
)


def run(args: argparse.Namespace) -> int:
    from mbdsl.cli._signal_text import grouped, rows_of, table
    from mbdsl.mechanism.signal_names import SignalNames

    scene = values.load_model(args)
    names = SignalNames(scene)
    patterns = [part for text in args.patterns for part in values.patterns(text)]
    rows = rows_of(names, names.select(patterns) if patterns else names.names)
    if args.format == "csv":
        writer = csv.writer(sys.stdout, lineterminator="\n")
        writer.writerow(("signal", "unit", "meaning"))
        writer.writerows(map(cell, row) for row in rows)
    elif args.format == "json":
        print(json.dumps([row._asdict() for row in rows], indent=2, ensure_ascii=False))
    else:
        print(f"{scene.name}: {count(len(rows), 'signal')}")
        print(table(rows) if patterns else grouped(scene, rows, rows_of(names, names.unlisted)))
    return 0
