"""mbdsl check: parse, build the graph, report mobility, redundancy and problems; assemble what is not a tree."""

from __future__ import annotations

import argparse
import sys

from mbdsl.cli._options import Command
from mbdsl.cli._streams import print_problem
from mbdsl.cli._values import load_model

COMMAND = Command(
    "parse a model, assemble it, report its mobility and problems",
    "Parse a model, check names, units and structure, count its degrees of freedom, and assemble it: loops that "
    "cannot close, initial values that contradict each other and masses that make the equations singular are errors. "
    "Nothing is compiled.",
    """
    @model
    --quick  do not assemble the model
    """,
)


def run(args: argparse.Namespace) -> int:
    from mbdsl.mechanism.graph import build
    from mbdsl.reporting.views import Check

    found = Check(build(load_model(args)), args.quick)
    for warning in found.doubts:
        print_problem(warning)
    print(found.graph.summary())
    sys.stdout.flush()  # the assembly may fail
    for line in found.assembly:
        print(line)
    return 0
