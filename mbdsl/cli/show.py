"""mbdsl show: any stage of the pipeline as text."""

from __future__ import annotations

import argparse
from typing import TYPE_CHECKING

from mbdsl.cli._values import add_model, load_model
from mbdsl.errors import UsageError

if TYPE_CHECKING:
    from mbdsl.system import System

STAGES = ("syntax", "scene", "graph", "system", "code")


def register(subparsers) -> argparse.ArgumentParser:
    parser = subparsers.add_parser(
        "show",
        help="print any stage between text and trajectory",
        description="Print a stage of the pipeline: the syntax tree, the scene (components with all numbers in SI), "
        "the mechanism's graph, the system of equations, or the code made for it.",
    )
    parser.add_argument("--stage", choices=STAGES, required=True, help="what to print")
    add_model(parser)
    return parser


def run(args: argparse.Namespace) -> int:
    print({"syntax": _syntax, "scene": _scene, "graph": _graph, "system": _system, "code": _code}[args.stage](args))
    return 0


def _syntax(args: argparse.Namespace) -> str:
    from mbdsl.lang.library import read
    from mbdsl.lang.parser import parse
    from mbdsl.lang.write import dump

    if args.set:
        raise UsageError("--set changes no syntax", hint="the stages from scene on show what it does")
    return dump(parse(read(args.model), args.model))


def _scene(args: argparse.Namespace) -> str:
    from mbdsl.cli._scene_text import describe

    return describe(load_model(args))


def _graph(args: argparse.Namespace) -> str:
    from mbdsl.graph import build

    return build(load_model(args)).describe()


def _system(args: argparse.Namespace) -> str:
    return _build_system(args).describe()


def _code(args: argparse.Namespace) -> str:
    return _build_system(args).code


def _build_system(args: argparse.Namespace) -> System:
    from mbdsl import graph, system

    scene = load_model(args)
    return system.build(scene, graph.build(scene))
