"""mbdsl solve: the value of a parameter for which a measure has a given value."""

from __future__ import annotations

import argparse
import sys

from mbdsl.cli import _values as values
from mbdsl.cli._options import Command
from mbdsl.cli._studies import of_sweep, save, varied

COMMAND = Command(
    "find the value of a parameter that gives a result",
    "Find the value of a parameter, within a range, for which a measure of the model has a given value; or the values"
    " of two parameters for two measures. Print the value with its error, or what was reached over the range; the "
    "exit code is then 4. Runs are stored: after Ctrl-C the same command continues.",
    """
    @model
    --vary NAME=START:STOP  a parameter and the range in which it is sought: m=100:1000kg, "k=1:1000:log N/mm"; twice
        for two
    --for F(SIGNAL)=VALUE  a measure and its value, "max(shaft.w) = 160 rpm"; final, min, max, maxabs, mean, rms,
        amplitude, period, time_of_max, time_of_min of a signal in a run, time_when(CONDITION, first|last|count),
        at(SIGNAL, TIME|CONDITION), at_max(SIGNAL, OTHER), at_min, static(SIGNAL) at the equilibrium, or frequency(N),
        damped_frequency(N), damping(N) of mode N; twice for two parameters
    @runs
    --quiet  print errors only
    """,
    vary={"type": values.sought, "action": "append", "required": True},
    for_={"dest": "conditions", "action": "append", "required": True},
)


def run(args: argparse.Namespace) -> int:
    vary = varied(args)

    from mbdsl.studies.solve import solve

    found = of_sweep(args, solve, vary, args.conditions)
    if found and not args.quiet:
        print(found)
    save(found.sweep, args)
    if not found:
        print(found, file=sys.stderr)
        return 4
    return 0
