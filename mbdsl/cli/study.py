"""mbdsl study: many runs of one model, to learn what no single run tells."""

from __future__ import annotations

import argparse
import sys

from mbdsl.cli import _values as values


def register(subparsers) -> argparse.ArgumentParser:
    parser = subparsers.add_parser(
        "study",
        help="run a model many times to learn about it",
        description="Many runs of one model, and what they say.",
    )
    kinds = parser.add_subparsers(title="studies", metavar="KIND", dest="kind", required=True)
    effects = kinds.add_parser(
        "effects",
        help="which effects the model calls for, to an accuracy",
        description="Run the model without each effect in turn (friction, damping, flexibility, gravity), and tell how "
        "much a signal changes and how much time the effect costs.",
    )
    values.add_model(effects)
    effects.add_argument("--signal", metavar="NAME", required=True, help="what is looked at, such as crank.phi or O.fx")
    effects.add_argument("--tol", metavar="E", help="how much it may change: 1mm, or as a part of its range, 1%%")
    effects.add_argument("--method", metavar="NAME", help="integrator; default: the model's, else hht-si2")
    effects.add_argument("--step", metavar="H", type=values.positive_seconds, help="step size; default: the model's")
    effects.add_argument("--stop", metavar="T", type=values.seconds, help="stop time; default: the model's")
    effects.add_argument("--repeats", metavar="K", type=int, default=5, help="timed runs of each; default 5")
    return parser


def run(args: argparse.Namespace) -> int:
    return {"effects": _effects}[args.kind](args)


def _effects(args: argparse.Namespace) -> int:
    from mbdsl.studies.effects import effects

    say = (lambda text: print(text, file=sys.stderr)) if sys.stderr.isatty() else None
    study = effects(
        args.model,
        args.signal,
        tol=args.tol,
        method=args.method,
        step=args.step,
        stop=args.stop,
        parameters=dict(args.set),
        without=args.without,
        repeats=args.repeats,
        announce=say,
    )
    print(study)
    return 0
