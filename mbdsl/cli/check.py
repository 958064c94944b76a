"""mbdsl check: parse, build the graph, report mobility, redundancy and problems. Loads no numerics."""

from __future__ import annotations

import argparse

from mbdsl.cli._streams import print_problem
from mbdsl.cli._values import add_model, load_model


def register(subparsers) -> argparse.ArgumentParser:
    parser = subparsers.add_parser(
        "check",
        help="parse a model and report its mobility and problems",
        description="Parse a model, check names, units and structure, and count its degrees of freedom.",
    )
    add_model(parser)
    return parser


def run(args: argparse.Namespace) -> int:
    from mbdsl.mechanism.graph import build

    graph = build(load_model(args))
    for warning in graph.warnings:
        print_problem(warning)
    print(graph.summary())
    return 0
