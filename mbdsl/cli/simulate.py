"""mbdsl simulate: integrate a model and write a result file."""

from __future__ import annotations

import argparse
import csv
import io
import json
import shlex
import shutil
import sys
from dataclasses import replace
from pathlib import Path
from time import perf_counter
from typing import TYPE_CHECKING

from mbdsl import results
from mbdsl.cli import _values as values
from mbdsl.cli._arguments import Parser
from mbdsl.cli._options import Command
from mbdsl.cli._runs import displayed, ended
from mbdsl.cli._summary import extreme_lines, print_warnings, summary
from mbdsl.errors import IntegrationError, UsageError
from mbdsl.messages import cell
from mbdsl.simulation import result_file, result_units
from mbdsl.simulation.interrupts import deferred
from mbdsl.storage import output_files
from mbdsl.storage.output_files import write_text

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping, Sequence

    import numpy as np

    from mbdsl.mechanism.scene import Scene
    from mbdsl.results.rows_file import StoredColumn
    from mbdsl.simulation.checkpoint import Checkpoint
    from mbdsl.simulation.run_options import RunOptions
    from mbdsl.simulation.streaming import Stream
    from mbdsl.simulation.trajectory import Trajectory
    from mbdsl.studies.verify import Verification


STANDARD_OUTPUT = "-"
#: options of a run that are words of the command
NAMES = ("method", "step", "tol", "accuracy", "start", "stop", "interval", "force", "general", "initial")


COMMAND = Command(
    "integrate a model and write its trajectory",
    "Integrate a model in time and write signals to a file. Times take units: 2, 2s, 1ms.",
    """
    @model method_and_option
    @force general step tol accuracy
    --verify  repeat the run with another method and print the digits that agree
    @budget start stop interval
    --from {static}  start at rest at the equilibrium that `mbdsl static` finds; default: the initial values of the
        model
    --input NAME=FILE ...  values of an input over time: the columns `time` and NAME (or the only other one) of a result
        file or CSV, in SI units or those of its row of units; linear between the rows
    --signals PATTERN,...  signals to write (globs, expressions); default: coordinates and velocities of all bodies,
        states and discrete variables
    --output FILE  result file ({results}); default: the model's name + .csv
    @units_of_file
    --checkpoint FILE  write checkpoints of the run to this file, for `mbdsl resume FILE`; it is removed when the run is
        done
    --checkpoint-every T  time between checkpoints, wall clock; default 60 s. An interrupted run always writes one
    --events FILE.csv  write the time, the kind and the line of each event, and the name of its contact or joint;
        -: to standard output
    --stats FILE.json  write counts and phase times
    @talk
    """,
    from_={"dest": "initial"},
    checkpoint_every={"type": values.interval_seconds, "default": 60.0},
)


def add_options(parser: argparse.ArgumentParser, words: Sequence[str] | None = None) -> None:
    """The parameters of mbdsl's own methods, as options of the same name.

    They are left out if the words of the command contain no other options than those that the parser has: the files of
    all methods are imported for them.
    """
    parser.set_defaults(option=[])
    if words is not None and isinstance(parser, Parser) and parser.has_options(words):
        return
    from mbdsl.integrators import own

    for name in sorted({name for method in own().values() for name in method.parameters}):
        parser.add_argument(
            f"--{name}", metavar="X", dest="option", action="append", type=values.named_number(name), default=[]
        )


def _with_inputs(args: argparse.Namespace, scene: Scene) -> Scene:
    """The model with the inputs of ``--input``."""
    from mbdsl.simulation.prescribed_inputs import with_inputs

    if args.checkpoint:
        raise UsageError("runs with --input have no checkpoints", hint="write the input as a `Table` of the model")
    given = {}
    for word in args.input:
        name, equals, path = word.partition("=")
        if not (equals and name and path):
            raise UsageError(f"--input {word}: expected NAME=FILE", hint="e.g. --input u=torque.csv")
        columns, _about = result_units.read(path)
        others = [key for key in columns if key != "time"]
        column = name if name in columns else others[0] if len(others) == 1 else None
        if "time" not in columns or column is None:
            has = ", ".join(list(columns)[:6])
            raise UsageError(f"`{path}` has no columns `time` and `{name}`", hint=f"its columns: {has}")
        given[name] = columns["time"], columns[column]
    begin = scene.experiment.start if args.start is None else args.start
    return with_inputs(scene, given, begin, args.stop)


def run(args: argparse.Namespace, resumed: bool = False) -> int:
    output = args.output or f"{values.stem(args)}.csv"
    rows = f"{args.checkpoint}.rows" if args.checkpoint else None
    events = getattr(args, "events", None)
    outputs = [output, args.stats, args.checkpoint, rows, None if events == STANDARD_OUTPUT else events]
    output_files.check(outputs, [args.model])
    results.format_of(output)

    options, begun = values.numbers(args.option), perf_counter()
    scene = values.load_model(args)
    if getattr(args, "input", None):
        scene = _with_inputs(args, scene)
    output_files.check(outputs, scene.files)
    parse = perf_counter() - begun
    if args.signals:
        check_signals(scene, values.patterns(args.signals))
    from mbdsl.simulation.run_options import RunOptions

    asked = RunOptions(
        **{name: getattr(args, name) for name in NAMES},
        options=options,
        budget=args.budget if args.accuracy is not None else None,
        signals=values.signals(args),
        checkpoint=kept(args, output, resumed) if args.checkpoint else None,
    )
    if args.accuracy is not None or args.verify:  # these compare whole trajectories
        return _run(args, scene, asked, parse, output, None)
    from mbdsl.simulation.streaming import Stream

    stream = Stream(rows or output, lambda found: chosen_names(found, output, args.signals), bool(rows))
    try:
        return _run(args, scene, asked, parse, output, stream)
    finally:
        stream.close(keep=bool(args.checkpoint) and Path(args.checkpoint).exists())


def _run(
    args: argparse.Namespace, scene: Scene, asked: RunOptions, parse: float, output: str, stream: Stream | None
) -> int:
    said: set[str] = set()
    with displayed(args.quiet, said) as shown:
        trajectory, failure = ended(scene, replace(asked, **shown), stream)
    begun = perf_counter()
    with deferred(1, f"writing {output}; Ctrl-C again to end without it") as heard:
        names = write(trajectory, output, args.signals, dict(args.set), stream, values.row_of_units(args))
    trajectory.stats["seconds"].update(parse=parse, write=perf_counter() - begun)
    over = bool(heard) or isinstance(failure, KeyboardInterrupt)
    args.verify = args.verify and not over
    verified = second_opinion(trajectory, names, args, said) if args.verify and not failure else None
    if getattr(args, "events", None):
        write_events(trajectory, args.events)
    if args.stats:
        write_text(args.stats, json.dumps(trajectory.stats, indent=2) + "\n")
    print_warnings(trajectory, args.quiet)
    if not args.quiet:
        print(summary(trajectory, output, names, args.verbose, stream))
        if args.signals:
            print("\n".join(extreme_lines(trajectory, names, args.verbose)))
        if verified:
            print(verified)
    if isinstance(failure, IntegrationError):
        raise failure
    if stream and stream.problem:
        raise UsageError(stream.problem, hint=f"{output} has the results until t = {stream.reached:g} s")
    return end(args, trajectory, output, over)


def write_events(trajectory: Trajectory, path: str) -> None:
    """Write the table of events to a file, or to standard output."""
    text = io.StringIO()
    table = csv.writer(text, lineterminator="\n")
    table.writerow(("time", "kind", "line", "name"))
    table.writerows((repr(x.t), x.kind, cell(x.line), cell(x.name)) for x in trajectory.events)
    if path == STANDARD_OUTPUT:
        print(text.getvalue(), end="")
    else:
        write_text(path, text.getvalue())


def check_signals(scene: Scene, patterns: list[str]) -> None:
    """Check before the run that every pattern matches a signal.

    Raises
    ------
    UsageError
        If one matches none.
    """
    from mbdsl.lang.asked_signals import AskedSignals

    AskedSignals(scene).select(patterns)


def end(args: argparse.Namespace, trajectory: Trajectory, output: str, over: bool) -> int:
    """Remove the checkpoint of a completed run, and return the exit code.

    Raises
    ------
    KeyboardInterrupt
        If the run, its verification or the writing of its results was interrupted.
    """
    if over and trajectory.status != "interrupted":
        raise KeyboardInterrupt
    if trajectory.stats.get("verify", {}).get("problem") == "interrupted":
        raise KeyboardInterrupt
    if trajectory.status == "interrupted":
        print(f"{output} ends at t = {trajectory.t[-1]:g} s and is marked incomplete", file=sys.stderr)
        if args.checkpoint and Path(args.checkpoint).exists():
            print(f"to continue:  {resuming(args, output)}", file=sys.stderr)
        raise KeyboardInterrupt
    if args.checkpoint:
        Path(args.checkpoint).unlink(missing_ok=True)
    return 0


def resuming(args: argparse.Namespace, output: str) -> str:
    """The command that continues a run: it writes beside the checkpoint, unless it names other files."""
    words = ["mbdsl", "resume", args.checkpoint]
    for option, path in (("--output", output), ("--stats", args.stats)):
        beside = path and Path(path).absolute().parent == Path(args.checkpoint).absolute().parent
        if path and not (beside and (option == "--output" or Path(path).suffix.lower() == ".json")):
            words += [option, path]
    return shlex.join(words)


def kept(args: argparse.Namespace, output: str, resumed: bool) -> Checkpoint:
    """The checkpoint of a simulation, with the words of its command."""
    from mbdsl.simulation.checkpoint import Checkpoint

    apart = ("run", "command", "debug", "quiet", "verbose", "checkpoint")
    command = {name: value for name, value in vars(args).items() if name not in apart}
    from mbdsl.integrators.method_files import spelled

    file = spelled(args.method) if args.method else None
    file = file if file != args.method else None
    for name, path in (("model", args.model), ("output", output), ("stats", args.stats), ("method_file", file)):
        command[name] = str(Path(path).absolute()) if path else None
    return Checkpoint(args.checkpoint, args.checkpoint_every, {"command": command}, resumed)


def second_opinion(
    trajectory: Trajectory, names: list[str], args: argparse.Namespace, said: set[str]
) -> Verification | None:
    """Repeat the run with another method and print warnings about signals that differ."""
    from mbdsl.studies.verify import FEW, verify

    if trajectory.status != "done":
        return None
    try:
        with displayed(args.quiet, said) as shown:
            found = verify(trajectory, names, args.general, shown["progress"], shown["announce"], args.budget)
    except KeyboardInterrupt:  # the result itself is complete
        trajectory.stats["verify"] = {"problem": "interrupted"}
        print("not verified: interrupted", file=sys.stderr)
        return None
    trajectory.stats["verify"] = found.facts()
    if found.problem:
        since = f" from t = {found.until:.4g} s on" if found.agreements else ""
        print(f"warning: not verified{since}: {found.how}: {found.problem}", file=sys.stderr)
    if found.doubtful:
        least, some = found.doubtful[0], f"{len(found.doubtful)} of {len(names)} signals"
        text = f"{some} agree to fewer than {FEW:g} digits, {least.signal} to {least.digits:.1f}"
        print(f"warning: {text}", file=sys.stderr)
    return found


def chosen_names(trajectory: Trajectory, output: str, signals: str | None) -> list[str]:
    """The names of the signals that are written."""
    return result_file.names(trajectory, output, values.patterns(signals) if signals else None)


def write(
    trajectory: Trajectory,
    output: str,
    signals: str | None,
    overrides: Mapping[str, str] = {},
    stream: Stream | None = None,
    row_of_units: bool = False,
) -> list[str]:
    """Write the requested signals, or those of a stream, and return their names.

    In a format that keeps the model, the file also contains the model's text with its ``overrides``, and by default the
    coordinates of bodies that deform. If the file cannot be written, the results are written to a temporary folder.
    """
    from mbdsl.lang.stored_model import to_text

    columns: Mapping[str, StoredColumn] | dict[str, np.ndarray]
    if stream and stream.file:
        columns = stream.file.columns()
        names = [name for name in columns if name != "time"]
        trajectory.undetermined = stream.undetermined
    else:
        names = chosen_names(trajectory, output, signals)
        columns = {"time": trajectory.t, **{name: trajectory[name] for name in names}}
    columns, units = result_units.converted(output, columns, result_file.units(trajectory, names), trajectory.display)
    said = result_file.about(trajectory, output, names)
    if result_file.keeps_model(output):
        said |= {"source": text} if (text := to_text(trajectory.scene, overrides)) else {}
    try:
        results.write(output, columns, units, said, row_of_units)
    except UsageError as problem:
        if where := elsewhere(output, lambda path: results.write(path, columns, units, said, row_of_units)):
            raise UsageError(problem.message, hint=f"the results are in {where}") from problem
        raise
    return names


def elsewhere(output: str, write: Callable[[str], None]) -> str | None:
    """The name of a file that results could be written to in place of ``output``; None if there is none."""
    import tempfile

    for folder in (tempfile.gettempdir(), Path.home(), "."):
        try:
            path = Path(tempfile.mkdtemp(prefix="mbdsl-", dir=folder)) / Path(output).name
        except OSError:
            continue
        try:
            write(str(path))
        except UsageError:
            shutil.rmtree(path.parent, ignore_errors=True)
        else:
            return str(path)
    return None
