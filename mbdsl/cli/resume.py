"""mbdsl resume: continue a simulation from its checkpoint."""

from __future__ import annotations

import argparse
import shlex
from pathlib import Path

from mbdsl.cli import _values as values
from mbdsl.cli import simulate
from mbdsl.errors import UsageError


def register(subparsers) -> argparse.ArgumentParser:
    parser = subparsers.add_parser(
        "resume",
        help="continue a simulation from its checkpoint",
        description="Continue a run from a checkpoint of `mbdsl simulate --checkpoint FILE` and write the result file "
        "that this command named. The result equals that of an uninterrupted run, bit for bit. The model must not have "
        "changed.",
    )
    parser.add_argument("checkpoint", metavar="FILE", help="the checkpoint; it is removed when the run is done")
    parser.add_argument(
        "--method", metavar="FILE.py", help="the Python file of the method, if the run was started with one"
    )
    values.add_units(parser)
    talk = parser.add_mutually_exclusive_group()
    talk.add_argument("--quiet", action="store_true", help="print errors and warnings only")
    talk.add_argument("--verbose", action="store_true", help="print more details")
    return parser


def run(args: argparse.Namespace) -> int:
    from mbdsl.simulation.checkpoint import about

    said = about(args.checkpoint).get("command")
    if not isinstance(said, dict):
        raise UsageError(
            f"`{args.checkpoint}` was not made by `mbdsl simulate`", hint=f'mbdsl.resume("{args.checkpoint}") in Python'
        )
    former = argparse.Namespace(**said)
    try:
        former.set, former.option = ([(name, value) for name, value in x] for x in (former.set, former.option))
        former.model, former.without = str(Path(former.model)), tuple(former.without)
    except (AttributeError, TypeError, ValueError) as problem:
        raise UsageError(f"`{args.checkpoint}` is damaged: {problem}") from problem
    _check_method(former, args)
    former.checkpoint, former.quiet, former.verbose = args.checkpoint, args.quiet, args.verbose
    former.units = args.units or getattr(former, "units", False)  # missing in checkpoints of earlier versions
    return simulate.run(former, resumed=True)


def _check_method(former: argparse.Namespace, args: argparse.Namespace) -> None:
    """Check that the user names the file of the method: a checkpoint does not make mbdsl execute a file.

    Raises
    ------
    UsageError
        If it is missing, or is that of another method.
    """
    file = getattr(former, "method_file", None)
    if args.method is None and file is not None:
        hint = shlex.join(["mbdsl", "resume", args.checkpoint, "--method", file])
        raise UsageError(f"the run was started with the method `{former.method}` of a Python file", hint=hint)
    if args.method is not None and (file is None or args.method != former.method):
        raise UsageError(
            f"the run was started with another method than `{args.method}`", hint="omit --method, or name its file"
        )
