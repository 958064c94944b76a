"""mbdsl show: any stage of the pipeline as text."""

from __future__ import annotations

import argparse
from collections.abc import Iterator
from typing import TYPE_CHECKING

from mbdsl.cli._options import Command
from mbdsl.cli._streams import verbatim
from mbdsl.cli._values import load_model
from mbdsl.errors import UsageError

if TYPE_CHECKING:
    from mbdsl.mechanism.reduction import Reduction
    from mbdsl.system import System

COMMAND = Command(
    "print any stage between text and trajectory",
    "Print a stage of the pipeline: the syntax tree, the scene (components with all numbers in SI), the mechanism's "
    "graph, the system of equations, or the generated code. The last two are shown after the reductions, which are "
    "listed.",
    """
    --stage {syntax,scene,graph,system,code}  what to print
    @model
    """,
    stage={"required": True},
)


def run(args: argparse.Namespace) -> int:
    verbatim()
    print({"syntax": _syntax, "scene": _scene, "graph": _graph, "system": _system, "code": _code}[args.stage](args))
    return 0


def _syntax(args: argparse.Namespace) -> str:
    from mbdsl.lang.library import read
    from mbdsl.lang.parser import parse
    from mbdsl.lang.unparse import dump

    for option in ("model_name", "set", "without"):
        if getattr(args, option):
            name = option.partition("_")[0]
            raise UsageError(f"--{name} changes no syntax", hint="the stages from scene on show its effect")
    return dump(parse(read(args.model), args.model))


def _scene(args: argparse.Namespace) -> str:
    from mbdsl.cli._scene_text import describe

    return describe(load_model(args))


def _graph(args: argparse.Namespace) -> str:
    from mbdsl.mechanism.graph import build

    return build(load_model(args)).describe()


def _system(args: argparse.Namespace) -> str:
    found = _reduction(args)
    lines = [str(note) for note in found.notes]
    for title, system in _systems(found):
        lines += [*([""] if lines else []), *([title] if title else []), system.describe()]
    return "\n".join(lines)


def _code(args: argparse.Namespace) -> str:
    from mbdsl.system.row_kernels import texts_of

    systems = list(_systems(_reduction(args)))
    texts = [f"# {title}\n{system.code}" if title else system.code for title, system in systems]
    made = dict.fromkeys(text for _, system in systems for text in texts_of(system.tables.blocks))
    return "\n\n".join([*texts, *made]) or "# nothing is left to be solved"


def _reduction(args: argparse.Namespace) -> Reduction:
    from mbdsl.mechanism import graph
    from mbdsl.mechanism.reduction import reduce

    return reduce(graph.build(load_model(args)))


def _systems(reduction: Reduction) -> Iterator[tuple[str, System]]:
    """(Title, System) of each part; the title is empty if there is only one."""
    from mbdsl import system

    number = len(reduction.parts)
    for k, part in enumerate(reduction.parts, 1):
        yield f"part {k} of {number}" if number > 1 else "", system.build(part.scene, part.graph)
