"""mbdsl recommend: the method and the step or tolerance that reach an error in the least time."""

from __future__ import annotations

import argparse
import sys

from mbdsl.cli import _values as values
from mbdsl.messages import visible


def register(subparsers) -> argparse.ArgumentParser:
    parser = subparsers.add_parser(
        "recommend",
        help="find the fastest method and step for an error",
        description="Measure the error and the cost of every method by a cheap run, refine the steps of those that "
        "may be the fastest, and print the fastest command on this machine. Runs are stored; the same command "
        "continues.",
    )
    values.add_model(parser)
    parser.add_argument(
        "--error",
        metavar="E",
        required=True,
        help="allowed error: of the signal (1e-6, 1mm, 1%%), or of positions and velocities, scaled",
    )
    parser.add_argument(
        "--signal", metavar="NAME", help="signal with this error; default: all positions and velocities"
    )
    values.add_methods(parser)
    parser.add_argument(
        "--reference", metavar="FILE", default="auto", help="a result file; default auto: methods of two families"
    )
    parser.add_argument("--stop", metavar="T", type=values.seconds, help="stop time; default: the model's")
    parser.add_argument("--repeats", metavar="K", type=int, default=3, help="timed runs of each; default 3")
    parser.add_argument(
        "--budget",
        metavar="S",
        type=values.positive_seconds,
        default=120.0,
        help="time budget, compilation included; default 120 s",
    )
    values.add_table(parser)
    parser.add_argument("--fresh", action="store_true", help="compute everything again")
    return parser


def run(args: argparse.Namespace) -> int:
    values.check_table(args)

    from mbdsl.cli._progress import Counter
    from mbdsl.studies.recommendation import recommend

    counter = Counter(sys.stderr)
    given = {name: getattr(args, name) for name in ("methods", "reference", "stop", "repeats", "budget", "fresh")}
    try:
        found = recommend(
            args.model,
            args.error,
            args.signal,
            parameters=dict(args.set),
            without=args.without,
            tell=counter,
            announce=counter.say,
            **given,
        )
    finally:
        counter.close()
    print(found)
    if args.table:
        from mbdsl.studies.tables import write

        write(found, args.table)
        print(f"{visible(args.table, line=True)}: table")
    return 0
