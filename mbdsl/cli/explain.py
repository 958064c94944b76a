"""mbdsl explain: the effects of a model, their causes and costs, and the reductions before the first step."""

from __future__ import annotations

import argparse
import sys

from mbdsl.cli import _values as values
from mbdsl.cli._options import Command
from mbdsl.cli._streams import say

COMMAND = Command(
    "list the effects of a model and their costs",
    "Print a receipt: every effect, whether the model contains it and why, the unknowns and code that it adds, its "
    "measured share of a step, and the bodies that were merged, split off or eliminated.",
    """
    @model method
    --step H  step size; default: the model's, else 1 ms
    --signals PATTERN,...  output signals to include
    --no-time  measure nothing
    """,
)


def run(args: argparse.Namespace) -> int:
    scene = values.load_model(args)

    from mbdsl.explanation.receipt import explain

    given = {"method": args.method, "step": args.step, "signals": values.signals(args), "measured": not args.no_time}
    print(explain(scene, **given, announce=say if sys.stderr.isatty() else None))
    return 0
