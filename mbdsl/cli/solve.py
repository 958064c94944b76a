"""mbdsl solve: the value of a parameter for which a measure has a given value."""

from __future__ import annotations

import argparse
import sys

from mbdsl.cli import _values as values
from mbdsl.cli._options import Command
from mbdsl.cli.sweep import once
from mbdsl.messages import count, visible
from mbdsl.storage import output_files

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
    vary = once(args.vary)
    if args.output:
        from mbdsl.studies.sweep_files import SUFFIXES

        for path in args.output:
            output_files.suffix_of(path, SUFFIXES)
        output_files.check(args.output, [args.model])

    from mbdsl.cli._progress import Counter
    from mbdsl.cli.study import kept
    from mbdsl.studies.solve import solve

    counter = Counter(sys.stderr)
    given = {
        name: getattr(args, name) for name in ("after", "method", "step", "tol", "start", "stop", "interval", "at")
    }
    given |= {name: getattr(args, name) for name in ("without", "limit", "fresh", "units")}
    try:
        found = solve(
            args.model,
            vary,
            args.conditions,
            options=values.numbers(args.option),
            parameters=dict(args.set),
            tell=None if args.quiet else counter,
            announce=None if args.quiet else counter.say,
            **given,
        )
    except KeyboardInterrupt:
        counter.close()
        print(kept(counter.kept, args.fresh), file=sys.stderr)
        raise
    finally:
        counter.close()
    if found and not args.quiet:
        print(found)
    for path in args.output:
        found.sweep.save(path)
        if not args.quiet:
            print(f"{visible(path, line=True)}: {count(len(found.sweep), 'run')}")
    if not found:
        print(found, file=sys.stderr)
        return 4
    return 0
