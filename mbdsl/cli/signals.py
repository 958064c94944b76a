"""mbdsl signals: the signals of a model with units and meanings. Loads no numerics."""

from __future__ import annotations

import argparse
import csv
import json
import sys

from mbdsl.cli import _values as values
from mbdsl.messages import cell, count


def register(subparsers) -> argparse.ArgumentParser:
    parser = subparsers.add_parser(
        "signals",
        help="list the signals of a model with units and meanings",
        description="List the signals of a model, which --signals selects in other commands, with units and meanings. "
        "Without a PATTERN, bodies, joints and frames with the same signals are listed together.",
    )
    values.add_model(parser)
    parser.add_argument(
        "patterns",
        metavar="PATTERN",
        nargs="*",
        help="list full names that match: a name, or a glob such as 'crank.*'; '*' lists all",
    )
    parser.add_argument(
        "--format",
        choices=("text", "csv", "json"),
        default="text",
        help="text (default); csv or json: full names for other programs",
    )
    return parser


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
