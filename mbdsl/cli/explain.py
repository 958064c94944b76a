"""mbdsl explain: the effects of a model, their causes and costs, and the reductions before the first step."""

from __future__ import annotations

import argparse
import sys

from mbdsl.cli import _values as values


def register(subparsers) -> argparse.ArgumentParser:
    parser = subparsers.add_parser(
        "explain",
        help="list the effects of a model and their costs",
        description="Print a receipt: every effect, whether the model contains it and why, the unknowns and code that "
        "it adds, its measured share of a step, and the bodies that were merged, split off or eliminated.",
    )
    values.add_model(parser)
    values.add_method_name(parser)
    parser.add_argument(
        "--step", metavar="H", type=values.positive_seconds, help="step size; default: the model's, else 1 ms"
    )
    parser.add_argument("--signals", metavar="PATTERN,...", help="output signals to include")
    parser.add_argument("--no-time", action="store_true", help="measure nothing")
    return parser


def run(args: argparse.Namespace) -> int:
    scene = values.load_model(args)

    from mbdsl.explanation.receipt import explain

    say = (lambda text: print(text, file=sys.stderr)) if sys.stderr.isatty() else None
    signals = values.patterns(args.signals) if args.signals else None
    print(explain(scene, method=args.method, step=args.step, signals=signals, measured=not args.no_time, announce=say))
    return 0
