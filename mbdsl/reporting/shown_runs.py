"""What views show: results, models and their runs, and the checks of names before a run."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable, Mapping, Sequence
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple, TypeAlias, TypeVar

from mbdsl import results as files
from mbdsl.errors import IntegrationError, UsageError
from mbdsl.lang.asked_signals import AskedSignals
from mbdsl.lang.display_units import asked
from mbdsl.lang.experiment import check_effects
from mbdsl.lang.model_argument import as_scene
from mbdsl.mechanism.scene import Scene
from mbdsl.results.selection import matching
from mbdsl.storage import output_files

if TYPE_CHECKING:
    from mbdsl.lang.builder import Builder
    from mbdsl.results.stored import Result
    from mbdsl.simulation.trajectory import Trajectory

Model: TypeAlias = "Scene | Builder | str | PathLike"
Changes: TypeAlias = "Mapping[str, str | float] | None"
Failure = TypeVar("Failure", bound=BaseException)
SUFFIX = ".mbd"  #: of models


def source(
    given: Model | Trajectory,
    patterns: Sequence[str] | None = None,
    parameters: Changes = None,
    without: Sequence[str] = (),
) -> Result | Scene:
    """The result of a trajectory or in a file, with the expressions among names of signals, or a model.

    Raises
    ------
    UsageError
        If a file is neither a result nor a model.
    """
    from mbdsl.results.stored import of_trajectory, open_result
    from mbdsl.simulation.result_expressions import with_expressions
    from mbdsl.simulation.trajectory import Trajectory

    if isinstance(given, Trajectory):
        return of_trajectory(given, given.scene.name, patterns or ())
    if not isinstance(given, (str, PathLike)) or (suffix := Path(given).suffix.lower()) == SUFFIX:
        return as_scene(given, parameters, without)
    known = {SUFFIX, *files.formats()}
    if suffix not in known:
        raise UsageError(
            f"`{given}` is neither a result file nor a model", hint=f"known suffixes are {', '.join(sorted(known))}"
        )
    return with_expressions(open_result(given), patterns)


def check_plotted(
    opened: Sequence[Result | Scene],
    labels: Sequence[str],
    patterns: Sequence[str] | None,
    against: str | None,
    spectrum: bool,
) -> None:
    """Check the names of signals before models are simulated."""
    from mbdsl.plotting.signal_plots import check_names

    if any(isinstance(item, Scene) for item in opened):
        known = [_known(AskedSignals(x), patterns) if isinstance(x, Scene) else x.names for x in opened]
        check_names(known, labels, patterns, against, spectrum)


def _known(names: AskedSignals, patterns: Sequence[str] | None) -> list[str]:
    """The signals of a model, and the expressions among the patterns."""
    return [
        *names.names[1:],
        *(x for text in patterns or () if not matching(text, names.names) for x in names.asked(text)),
    ]


def computed(
    opened: Iterable[Result | Scene],
    labels: Sequence[str],
    patterns: Sequence[str] | None,
    units: str | Iterable[str] | None,
    run: Callable[[Scene], tuple[Trajectory, Failure | None]],
) -> tuple[list[Result], Failure | None]:
    """The results in the units in which they are displayed, those of models by a run, and the first failure."""
    from mbdsl.results.stored import of_trajectory

    shown, failure = list[Any](), None
    for item, label in zip(opened, labels, strict=True):
        if isinstance(item, Scene):
            trajectory, failed = run(item)
            item, failure = of_trajectory(trajectory, label, patterns or ()), failure or failed
        item.display = asked(units, item.display)
        shown.append(item)
    return shown, failure


class Shown(NamedTuple):
    """What is shown of a motion: the file to write, patterns of signals, and names of frames whose path is drawn."""

    out: str | PathLike | None
    patterns: Sequence[str] | None = None
    traces: Sequence[str] = ()


def motion_or_file(
    model: Model | Trajectory, result: str | PathLike | None, shown: Shown, run: dict[str, Any]
) -> tuple[Trajectory, Sequence[str] | None, IntegrationError | None]:
    """The motion of :func:`motion_of`, or that of a result file, and the patterns of its signals.

    The file is ``result``, which belongs to ``model``, or ``model`` itself if it is a result, which contains its model.

    Raises
    ------
    UsageError
        If both are results, or if there are arguments of a run for a file.
    """
    from mbdsl.simulation.trajectory import Trajectory
    from mbdsl.viewing.stored_result import is_result, stored_trajectory

    stored = model if isinstance(model, (str, PathLike)) and is_result(model) else None
    if stored is not None and result is not None:
        raise UsageError(f"`{model}` and `{result}` are both results", hint="give the model and one result")
    path = result if stored is None else stored
    if path is None:
        trajectory, failure = motion_of(model, shown, run)
        return trajectory, shown.patterns, failure
    changes = {} if stored is not None else changes_of(run)
    if run:
        raise needs_no_run(run)
    if isinstance(model, Trajectory):
        raise UsageError("a trajectory is a run, and the result is another one", hint="give the model and one result")
    trajectory, names = stored_trajectory(path, None if stored is not None else as_scene(model, **changes))
    output_files.check([shown.out], [os.fspath(path)])
    return trajectory, names if shown.patterns is None else shown.patterns, None


def pale(ghost: Trajectory | str | PathLike | None, scene: Scene) -> Trajectory | None:
    """The other motion of an animation; a result that does not contain its model belongs to that of the first."""
    from mbdsl.viewing.stored_result import has_model, stored_trajectory

    if not isinstance(ghost, (str, PathLike)):
        return ghost
    return stored_trajectory(ghost, None if has_model(ghost) else scene)[0]


def check_ghost(ghost: Trajectory | str | PathLike | None) -> None:
    """Check before a run that the other motion of an animation is a trajectory or a result file.

    Raises
    ------
    UsageError
        If it is a file of another kind.
    """
    from mbdsl.viewing.stored_result import is_result

    if isinstance(ghost, (str, PathLike)) and not is_result(ghost):
        hint = "write one: mbdsl simulate MODEL --output X.npz"
        raise UsageError(f"the ghost `{ghost}` is not a result", hint=hint)


def check_shown(scene: Scene, patterns: Iterable[str] | None, traces: Sequence[str]) -> None:
    """Check the names of signals and traced frames before a model is simulated."""
    if patterns is not None:
        AskedSignals(scene).select(patterns)
    if traces:
        from mbdsl.viewing.animation import traced_point

        for name in traces:
            traced_point(scene, name)


def motion_of(
    model: Model | Trajectory, shown: Shown, run: dict[str, Any]
) -> tuple[Trajectory, IntegrationError | None]:
    """The trajectory of a model, which is simulated after a check of all names, and the error that ended it early."""
    from mbdsl.simulation.trajectory import Trajectory

    if isinstance(model, Trajectory):
        if given := {name: x for name, x in run.items() if name != "announce"}:
            raise needs_no_run(given)
        return model, None
    scene = as_scene(model, **changes_of(run))
    output_files.check([shown.out], scene.files)
    check_shown(scene, shown.patterns, shown.traces)
    return simulated(scene, run)


def simulated(scene: Scene, run: dict[str, Any]) -> tuple[Trajectory, IntegrationError | None]:
    """The results of a run, also if the integration failed, and the failure."""
    from mbdsl.api import simulate

    try:
        return simulate(scene, **run), None
    except IntegrationError as problem:
        if problem.trajectory is None or not len(problem.trajectory):
            raise
        return problem.trajectory, problem


def listed(signals: str | Iterable[str] | None) -> list[str] | None:
    """Names and patterns as a list; None for the default."""
    return None if signals is None else [signals] if isinstance(signals, str) else list(signals)


def changes_of(run: dict[str, Any]) -> dict[str, Any]:
    """Take what changes a model out of the arguments of a run."""
    found: dict[str, Any] = {name: run.pop(name) for name in ("parameters", "without") if name in run}
    if contacts := run.pop("contacts", None):
        found["without"] = check_effects(found.get("without", ()), contacts)
    return found


def needs_no_run(run: Mapping[str, Any]) -> UsageError:
    """The error of arguments of a run where there is none."""
    what = f"`{next(iter(run))}` belongs to a simulation, and the result is computed already"
    return UsageError(what, hint="give the model alone to simulate it")
