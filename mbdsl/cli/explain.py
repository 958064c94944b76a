"""mbdsl explain: which effects a scene calls for, why, what they cost, and what was left out or done beforehand."""

from __future__ import annotations

import argparse
import sys

from mbdsl.cli import _values as values


def register(subparsers) -> argparse.ArgumentParser:
    parser = subparsers.add_parser(
        "explain",
        help="tell which effects a model calls for, and what each costs",
        description="Print a receipt: every effect, whether it is in and why, what it brings of unknowns and code, and "
        "its measured share of a step; what was merged, split or eliminated before the first step.",
    )
    values.add_model(parser)
    parser.add_argument("--method", metavar="NAME", help="integrator; default: the model's, else hht-si2")
    parser.add_argument(
        "--step", metavar="H", type=values.positive_seconds, help="step size; default: the model's, else 1 ms"
    )
    parser.add_argument("--signals", metavar="PATTERN,...", help="outputs to account for as well")
    parser.add_argument("--no-time", action="store_true", help="measure nothing")
    return parser


def run(args: argparse.Namespace) -> int:
    scene = values.load_model(args)

    from mbdsl.explanation.receipt import explain

    say = (lambda text: print(text, file=sys.stderr)) if sys.stderr.isatty() else None
    signals = values.patterns(args.signals) if args.signals else None
    print(explain(scene, method=args.method, step=args.step, signals=signals, measured=not args.no_time, announce=say))
    return 0
