"""Runs for commands that show a motion: a model is simulated; the results of a run that ends early are kept."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any

from mbdsl.cli import _values as values
from mbdsl.cli._progress import Display
from mbdsl.cli._summary import print_warnings
from mbdsl.errors import IntegrationError, Interrupted, UsageError
from mbdsl.messages import once
from mbdsl.storage import output_files

if TYPE_CHECKING:
    from mbdsl.mechanism.scene import Scene
    from mbdsl.simulation.run_options import RunOptions
    from mbdsl.simulation.streaming import Stream
    from mbdsl.simulation.trajectory import Trajectory


def of_arguments(args: argparse.Namespace, out: str) -> tuple[Trajectory, BaseException | None]:
    """The trajectory of a model, and the error that ended the run early; ``out`` is the file that will be written."""
    from mbdsl.reporting.shown_runs import check_shown

    options = values.numbers(args.option)
    scene = values.load_model(args)
    output_files.check([out], scene.files)
    traces = getattr(args, "trace", None)
    check_shown(scene, values.signals(args), values.names(traces) if traces else ())
    given = {name: getattr(args, name) for name in ("method", "step", "tol", "start", "stop", "interval")}
    trajectory, failure = kept(scene, args.quiet, options=options, **given)
    print_warnings(trajectory, args.quiet)
    return trajectory, failure


def kept(scene: Scene, quiet: bool, **given: Any) -> tuple[Trajectory, BaseException | None]:
    """The results of a run with a display of its progress, also of one that ends early, and the error that ended it.

    Raises
    ------
    IntegrationError
        If there are no results.
    UsageError
        If neither the command nor the model has a stop time.
    """
    from mbdsl.simulation.plan import NO_STOP
    from mbdsl.simulation.run_options import RunOptions

    try:
        with displayed(quiet, set()) as shown:
            trajectory, failure = ended(scene, RunOptions(**given, **shown))
    except UsageError as problem:
        if problem.hint != NO_STOP or "stop" in given:
            raise
        hint = "write `annotation(experiment(StopTime = 2 s));` in the model, or plot a result of "
        raise UsageError(problem.message, hint=f"{hint}`mbdsl simulate --stop 2s`") from None
    if isinstance(failure, IntegrationError) and not len(trajectory.t):
        raise failure
    return trajectory, failure


def ended(scene: Scene, asked: RunOptions, stream: Stream | None = None) -> tuple[Trajectory, BaseException | None]:
    """The results of a run, also of one that ends early, and the error or interruption that ended it."""
    from mbdsl.api import simulated

    try:
        trajectory = simulated(scene, asked, stream)
    except IntegrationError as problem:
        if problem.trajectory is None:
            raise
        return problem.trajectory, problem
    except Interrupted as problem:  # after its last step: it is complete
        return problem.trajectory, KeyboardInterrupt()
    return trajectory, KeyboardInterrupt() if trajectory.status == "interrupted" else None


@contextmanager
def displayed(quiet: bool, said: set[str]) -> Iterator[dict[str, Any]]:
    """The options of a run that show its progress, and announce each text once, unless it is ``said`` already."""
    display = None if quiet else Display(sys.stderr)
    try:
        yield {"progress": display, "announce": once(display.say, said) if display else None}
    finally:
        if display:
            display.close()
