"""mbdsl resume: continue a simulation from its checkpoint."""

from __future__ import annotations

import argparse
import shlex
from pathlib import Path
from types import NoneType
from typing import Any

from mbdsl import results
from mbdsl.cli import simulate
from mbdsl.cli._options import Command
from mbdsl.errors import UsageError

COMMAND = Command(
    "continue a simulation from its checkpoint",
    "Continue a run from a checkpoint of `mbdsl simulate --checkpoint FILE`. The result equals that of an "
    "uninterrupted run, bit for bit. It is written to --output, by default to the file of that name beside the "
    "checkpoint. The model must not have changed.",
    """
    checkpoint FILE  the checkpoint; it is removed when the run is done
    --method FILE.py  the Python file of the method, if the run was started with one
    --output FILE  result file; default: its former name beside the checkpoint
    --stats FILE.json  write counts and phase times; default: as --output
    @units_of_file
    @talk
    """,
)


def run(args: argparse.Namespace) -> int:
    from mbdsl.simulation.checkpoint import about

    said = about(args.checkpoint).get("command")
    if not isinstance(said, dict):
        raise UsageError(
            f"`{args.checkpoint}` was not made by `mbdsl simulate`", hint=f'mbdsl.resume("{args.checkpoint}") in Python'
        )
    former = _command(args.checkpoint, said)
    former.output = args.output or _beside(args.checkpoint, former.output, tuple(results.formats()))
    former.stats = args.stats or (former.stats and _beside(args.checkpoint, former.stats, (".json",)))
    _check_method(former, args)
    former.checkpoint, former.quiet, former.verbose = args.checkpoint, args.quiet, args.verbose
    former.units = former.units if args.units in (None, False) else args.units
    return simulate.run(former, resumed=True)


#: words of the command: the types of their values
TYPES: dict[str, tuple[type, ...]] = {
    **dict.fromkeys(("model", "output"), (str,)),
    **dict.fromkeys(("method", "signals", "stats", "method_file", "model_name", "initial"), (str, NoneType)),
    **dict.fromkeys(("step", "tol", "accuracy", "budget", "start", "stop", "interval"), (int, float, NoneType)),
    **dict.fromkeys(("force", "general", "verify"), (bool,)),
    "units": (bool, str, NoneType),
    **dict.fromkeys(("set", "option", "without"), (list,)),
    "checkpoint_every": (int, float),
}


def _command(checkpoint: str, said: dict[str, Any]) -> argparse.Namespace:
    """The words of the command that has made a checkpoint."""
    former = {name: value for name, value in said.items() if name in TYPES}
    former = {"units": False, "initial": None} | former  # missing in checkpoints of earlier versions
    try:
        for name, types in TYPES.items():
            number = float in types and isinstance(former.get(name), bool)
            if name in former and (number or not isinstance(former[name], types)):
                raise ValueError(f"it has an impossible value of {name}")
        for name, types in (("set", (str,)), ("option", (int, float, NoneType))):
            former[name] = [(str(key), value) for key, value in former[name]]
            if not all(isinstance(value, types) for _, value in former[name]):
                raise ValueError(f"it has an impossible value of {name}")
        former["without"] = tuple(map(str, former["without"]))
        former["model"], former["output"] = str(Path(former["model"])), str(Path(former["output"]))
    except (KeyError, TypeError, ValueError) as problem:
        raise UsageError(f"`{checkpoint}` is damaged: {problem}") from problem
    return argparse.Namespace(**former)


def _beside(checkpoint: str, former: str, suffixes: tuple[str, ...]) -> str:
    """The file beside the checkpoint with the name of the former one.

    Others may have made the checkpoint: it does not choose the folder, and no file of another kind is overwritten.

    Raises
    ------
    UsageError
        If the name is hidden or has another suffix.
    """
    path = Path(checkpoint).parent / Path(former).name
    if path.name.startswith(".") or path.suffix.lower() not in suffixes:
        option = "--stats" if suffixes == (".json",) else "--output"
        raise UsageError(f"a checkpoint does not name the file `{path.name}`", hint=f"give its name with {option}")
    return str(path)


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
