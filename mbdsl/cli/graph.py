"""mbdsl graph: bodies and joints of a model as a picture or in characters."""

from __future__ import annotations

import argparse
import shutil
import sys

from mbdsl.cli import _values as values
from mbdsl.cli._options import Command
from mbdsl.cli._streams import can_write, print_problem, say, verbatim
from mbdsl.storage.output_files import suffix_of

COMMAND = Command(
    "show which joints connect which bodies",
    "Show the bodies of a model and the joints, drivers and forces between them: loops, redundant joints, bodies that"
    " are solved as one, and the bodies that drivers move. Without --out, print a tree.",
    """
    @model
    --out FILE  picture or page: .svg, .html, .png, .pdf (the last two with the extra `plot`)
    --quick  do not search for redundant constraints; the search may compile code
    """,
)


def run(args: argparse.Namespace) -> int:
    if args.out:
        from mbdsl.viewing.structure_files import SUFFIXES

        suffix_of(args.out, SUFFIXES)
    scene = values.load_for(args, [args.out])

    from mbdsl.mechanism.graph import build
    from mbdsl.viewing.structure import structure

    graph = build(scene)
    for warning in graph.warnings:
        print_problem(warning)
    found = structure(graph, not args.quick, say)
    if args.out:
        from mbdsl.viewing.structure_files import save

        save(found, args.out)
        print(values.written(args.out, found.summary.partition(": ")[2].splitlines()[0]))
        return 0
    from mbdsl.viewing.structure_text import COLUMNS, RESERVED, text

    columns = shutil.get_terminal_size((COLUMNS, 24)).columns if sys.stdout.isatty() else COLUMNS
    verbatim()
    print(text(found, columns, not can_write(RESERVED)))
    return 0
