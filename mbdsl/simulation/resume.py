"""Continuing a run from its checkpoint."""

from __future__ import annotations

import os
from collections.abc import Callable
from typing import TYPE_CHECKING, TypeAlias

from mbdsl.errors import UsageError
from mbdsl.mechanism.scene import Scene
from mbdsl.simulation.checkpoint import Checkpoint, about, damaged
from mbdsl.simulation.progress import Progress
from mbdsl.simulation.run_options import REPEATED
from mbdsl.simulation.simulate import simulate
from mbdsl.simulation.trajectory import Trajectory

if TYPE_CHECKING:
    from mbdsl.lang.builder import Builder

    Model: TypeAlias = Scene | Builder | str | os.PathLike


def resume(
    path: str | os.PathLike,
    model: Model | None = None,
    *,
    progress: Callable[[Progress], None] | None = None,
    announce: Callable[[str], None] | None = None,
) -> Trajectory:
    """Continue a run from its checkpoint.

    Parameters
    ----------
    path : path
        The checkpoint file; further checkpoints are written to it.
    model : Scene, Builder or path, optional
        The model of the run; required unless ``mbdsl.simulate`` was called with a path.
    progress, announce : callable, optional
        As for ``mbdsl.simulate``.

    Returns
    -------
    Trajectory
        Equal to that of an uninterrupted run, bit for bit.

    Raises
    ------
    UsageError
        If the file is not a checkpoint, is damaged, or was made with a different model, settings, versions or machine.
    MbdslError
        As ``mbdsl.simulate`` does.
    """
    said = about(path)
    try:
        given, every, known = dict(said["given"]), float(said["every"]), said["model"]
    except (KeyError, TypeError, ValueError) as problem:
        raise damaged(path, str(problem)) from problem
    if not given.keys() <= {*REPEATED, "initial"} or not isinstance(known, str | None):
        raise damaged(path, "it has arguments that a run does not have")
    model = known if model is None else model
    if model is None:
        raise UsageError(f"`{path!s}` does not name the file of its model", hint="give the model to resume")
    if isinstance(model, Scene) and model.origin is None:  # it can only be used as it is
        del given["parameters"], given["without"]
    on = Checkpoint(path, every, said, resumed=True)
    return simulate(model, **given, progress=progress, announce=announce, checkpoint=on)
