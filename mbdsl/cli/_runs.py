"""Runs for commands that show a motion: a model is simulated; the results of a run that ends early are kept."""

from __future__ import annotations

import argparse
import sys
from typing import TYPE_CHECKING

from mbdsl.cli import _values as values
from mbdsl.cli._progress import Display
from mbdsl.cli.simulate import check_signals, print_warnings
from mbdsl.errors import IntegrationError, Interrupted
from mbdsl.storage import output_files

if TYPE_CHECKING:
    from mbdsl.simulation.trajectory import Trajectory


def simulated(args: argparse.Namespace, out: str) -> tuple[Trajectory, BaseException | None]:
    """The trajectory of a model, and the error that ended the run early; ``out`` is the file that will be written."""
    options = values.numbers(args.option)
    scene = values.load_model(args)
    output_files.check([out], scene.files)
    if args.signals:
        check_signals(scene, values.patterns(args.signals))
    if getattr(args, "trace", None):
        from mbdsl.viewing.animation import traced_point

        for name in values.names(args.trace):
            traced_point(scene, name)

    from mbdsl import api

    display = None if args.quiet else Display(sys.stderr)
    failure: BaseException | None = None
    try:
        trajectory = api.simulated(
            scene,
            method=args.method,
            step=args.step,
            tol=args.tol,
            start=args.start,
            stop=args.stop,
            interval=args.interval,
            options=options,
            progress=display,
            announce=display.say if display else None,
        )
    except IntegrationError as problem:
        found = getattr(problem, "trajectory", None)
        if found is None or not len(found):
            raise
        trajectory, failure = found, problem
    except Interrupted as problem:
        trajectory = problem.trajectory
        failure = KeyboardInterrupt()
    finally:
        if display:
            display.close()
    if trajectory.status == "interrupted":
        failure = KeyboardInterrupt()
    print_warnings(trajectory, args.quiet)
    return trajectory, failure
