"""Models and results as texts, pictures and pages: what the commands of these names show."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeAlias

from mbdsl import results as files
from mbdsl.errors import IntegrationError, ModelWarning, UsageError
from mbdsl.lang.asked_signals import AskedSignals
from mbdsl.lang.display_units import asked
from mbdsl.lang.mistakes import unused
from mbdsl.lang.model_argument import as_scene, blame_model
from mbdsl.mechanism.assembly_need import has_to_be_assembled
from mbdsl.mechanism.graph import MechanismGraph, build
from mbdsl.mechanism.scene import Scene
from mbdsl.results.selection import matching
from mbdsl.storage import output_files

if TYPE_CHECKING:
    from mbdsl.lang.builder import Builder
    from mbdsl.plotting.signal_plots import Plot
    from mbdsl.reporting.report import Report
    from mbdsl.results.stored import Result
    from mbdsl.simulation.trajectory import Trajectory
    from mbdsl.viewing.animation import Animation
    from mbdsl.viewing.structure import Structure

Model: TypeAlias = "Scene | Builder | str | PathLike"
Changes: TypeAlias = "Mapping[str, str | float] | None"
SUFFIX = ".mbd"  #: of models
SEARCHED = 200  #: largest number of unknowns with which `check` searches for the equilibrium, without compilation


@dataclass(frozen=True)
class Check:
    """What ``mbdsl.check`` found; ``print`` shows it as the command does.

    Attributes
    ----------
    graph : MechanismGraph
        Bodies, joints, forces and the count of degrees of freedom (``graph.mobility``).
    quick : bool
        Whether the model is not assembled.
    """

    graph: MechanismGraph
    quick: bool = False

    @property
    def warnings(self) -> tuple[ModelWarning, ...]:
        """Values and connections that are probably not as intended."""
        return (*self.graph.scene.warnings, *self.doubts)

    @cached_property
    def doubts(self) -> tuple[ModelWarning, ...]:
        """Those that are not found while the text is read."""
        return (*self.graph.warnings, *unused.find(self.graph.scene))

    @cached_property
    def assembly(self) -> tuple[str, ...]:
        """Lines about the initial state: guesses that were changed, redundant constraints, rates that were not given.

        There are none if the structure shows that the initial state is consistent. A model that starts at its
        equilibrium says so; its initial values are where the search for it begins.
        """
        steady = self._equilibrium() if self.graph.scene.steady else ()
        if self.quick or not has_to_be_assembled(self.graph):
            return steady
        from mbdsl.initial.start_check import check_start  # numerics take longer to load than everything before

        return (*check_start(self.graph), *steady)

    def _equilibrium(self) -> tuple[str, ...]:
        """Lines about the equilibrium at which the model starts."""
        from mbdsl.simulation.steady_start import found_at_start

        start = "starts at the static equilibrium that it reaches from here"
        if self.quick or self.graph.coordinates + self.graph.rows > SEARCHED:
            return (f"{start} (not searched)",)
        stability = found_at_start(self.graph.scene)
        return (f"{start}{', which is unstable' if stability == 'unstable' else ''}",)

    def __repr__(self) -> str:
        return f"<Check of {self.graph.scene.name}: mobility {self.graph.mobility}>"

    def __str__(self) -> str:
        return "\n".join([*(w.render() for w in self.warnings), self.graph.summary(), *self.assembly])

    def _repr_html_(self) -> str:
        from mbdsl.plotting.html_tables import preformatted

        return preformatted(str(self))


@blame_model
def check(model: Model, quick: bool = False, *, parameters: Changes = None, without: Sequence[str] = ()) -> Check:
    """Check a model, and assemble it unless its structure shows that its initial state is consistent.

    Parameters
    ----------
    model : Scene, Builder or path
        The mechanism.
    quick : bool, optional
        Do not assemble it.
    parameters, without : optional
        As for ``mbdsl.simulate``.

    Returns
    -------
    Check
        The graph with its mobility, warnings, and what the assembly found.

    Raises
    ------
    ModelError
        If the model is invalid.
    InitialisationError
        If there is no consistent initial state, or the mass matrix is singular.
    """
    found = Check(build(as_scene(model, parameters, without)), quick)
    found.assembly  # noqa: B018 - computed now, so that its errors are raised here
    return found


@blame_model
def graph(
    model: Model,
    out: str | PathLike | None = None,
    quick: bool = False,
    *,
    parameters: Changes = None,
    without: Sequence[str] = (),
    announce: Callable[[str], None] | None = None,
) -> Structure:
    """Find which joints connect which bodies: loops, redundant joints, welded and driven bodies.

    Parameters
    ----------
    model : Scene, Builder or path
        The mechanism.
    out : path, optional
        A file to write: .svg, .html, or .png and .pdf, which require matplotlib.
    quick : bool, optional
        Do not search for redundant constraints; the search may compile code.
    parameters, without, announce : optional
        As for ``mbdsl.simulate``.

    Returns
    -------
    Structure
        ``print`` shows it as a tree, a notebook as a picture, and its ``save`` writes it.

    Raises
    ------
    ModelError, UsageError
        If the model is invalid, or the file cannot be written.
    """
    from mbdsl.viewing.structure import structure
    from mbdsl.viewing.structure_files import check_suffix

    if out is not None:
        check_suffix(out)
    scene = as_scene(model, parameters, without)
    output_files.check([out], scene.files)
    return _saved(structure(build(scene), not quick, announce), out)


def plot(
    results: Model | Trajectory | Iterable[Model | Trajectory],
    signals: str | Iterable[str] | None = None,
    *,
    against: str | None = None,
    difference: bool = False,
    spectrum: bool = False,
    units: str | Iterable[str] | None = None,
    out: str | PathLike | None = None,
    **run: Any,
) -> Plot:
    """Plot signals of results; models are simulated first.

    Parameters
    ----------
    results : path, Trajectory, Scene or Builder, or several of them
        Result files, trajectories, and models.
    signals, against, difference, spectrum, units, out : optional
        As ``patterns`` and the others of ``Trajectory.plot``.
    **run
        Arguments of ``mbdsl.simulate`` for the models. Default: their own settings.

    Returns
    -------
    Plot
        ``print`` shows it in characters, a notebook below the cell, and its ``save`` writes it.

    Raises
    ------
    ModelError, UsageError
        If an argument is invalid. Names of signals are checked before models are simulated.
    IntegrationError
        If the integration fails; the file shows the results until then.
    """
    from mbdsl.plotting.signal_plots import plot, suffix_of
    from mbdsl.results.stored import of_trajectory
    from mbdsl.simulation.trajectory import Trajectory

    several = isinstance(results, Iterable) and not isinstance(results, (str, Trajectory))
    given: list[Any] = [*results] if several else [results]  # type: ignore[misc]
    if not given:
        raise UsageError("a plot needs a result or a model")
    if out is not None:
        suffix_of(out)
        output_files.check([out])
    asked(units)  # raises its errors before a run
    changes = _changes(run)
    patterns = _listed(signals)
    opened = [source(item, patterns, **changes) for item in given]
    if (changes or run) and not any(isinstance(item, Scene) for item in opened):
        raise _needs_no_run(changes | run)
    labels = [str(x) if isinstance(x, (str, PathLike)) else o.name if isinstance(o, Scene) else o.label
              for x, o in zip(given, opened, strict=True)]  # fmt: skip
    check_plotted(opened, labels, patterns, against, spectrum)
    shown, failure = list[Any](), None
    for item, label in zip(opened, labels, strict=True):
        if isinstance(item, Scene):
            trajectory, failed = _simulated(item, run)
            item, failure = of_trajectory(trajectory, label, patterns or ()), failure or failed
        item.display = asked(units, item.display)
        shown.append(item)
    return _saved(plot(shown, patterns, against=against, difference=difference, spectrum=spectrum), out, failure)


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
    suffix = Path(given).suffix.lower() if isinstance(given, (str, PathLike)) else SUFFIX
    if suffix == SUFFIX:
        return as_scene(given, parameters, without)
    known = {SUFFIX, *files.formats()}
    if suffix not in known:
        raise UsageError(
            f"`{given}` is neither a result file nor a model", hint=f"known suffixes are {', '.join(sorted(known))}"
        )
    return with_expressions(open_result(given), patterns)  # type: ignore[arg-type]


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


def report(
    model: Model | Trajectory,
    signals: str | Sequence[str] | None = None,
    eigen: str | float | None = None,
    *,
    units: str | Iterable[str] | None = None,
    out: str | PathLike | None = None,
    announce: Callable[[str], None] | None = None,
    **run: Any,
) -> Report:
    """Write a page about a model and its run: text, picture, graph, effects, motion, signals, energy, how to repeat it.

    Parameters
    ----------
    model : Scene, Builder, path or Trajectory
        The mechanism, which is simulated, or a run of it.
    signals : str or sequence of str, optional
        Names and glob patterns of signals to plot. Default: those of ``Trajectory.plot``.
    eigen : str or float, optional
        State about which eigenmodes are computed: "static", "start" or a time [s]. Default: no eigenmodes.
    units : str or iterable of str, optional
        Units of figures and tables such as "deg, rpm, kN, mm", each for all values of its quantity.
    out : path, optional
        A file to write, ``.html``.
    announce : callable, optional
        As for ``mbdsl.simulate``.
    **run
        Further arguments of ``mbdsl.simulate``.

    Returns
    -------
    Report
        The page; a notebook shows it below the cell, and its ``save`` writes it.

    Raises
    ------
    ModelError, UsageError
        If an argument is invalid. Names of signals are checked before the run.
    IntegrationError
        If the integration fails; the file shows the results until then.
    """
    from mbdsl.reporting.report import check_suffix
    from mbdsl.reporting.report import report as page

    if out is not None:
        check_suffix(out)
    patterns = _listed(signals)
    asked(units)
    trajectory, failure = _motion(model, out, patterns, (), {"announce": announce, **run})
    return _saved(page(trajectory.in_units(units), patterns, eigen, announce=announce), out, failure)


def animate(
    model: Model | Trajectory,
    out: str | PathLike | None = None,
    signals: str | Iterable[str] | None = None,
    traces: str | Sequence[str] = (),
    ghost: Trajectory | str | PathLike | None = None,
    arrows: str | Sequence[str] = ("forces",),
    view: str | None = None,
    *,
    result: str | PathLike | None = None,
    size: tuple[int, int] = (640, 400),
    units: str | Iterable[str] | None = None,
    **run: Any,
) -> Animation:
    """Animate a model, a run of it, or a result file, as one HTML page that loads nothing or as a film.

    Parameters
    ----------
    model : Scene, Builder, path or Trajectory
        The mechanism, which is simulated, or a run of it; or the path of a result that contains its model (.npz).
    out : path, optional
        A file to write: .html, or a film, .gif or .mp4.
    signals, traces, arrows, view : optional
        As for ``Trajectory.animate``.
    ghost : Trajectory or path, optional
        Another motion, or its result file, which is drawn pale behind the first at the same time.
    result : path, optional
        A result of the model, in a format that does not contain the model.
    size : (int, int), optional [px]
        Width and height of a film.
    units : str or iterable of str, optional
        As for ``Trajectory.animate``.
    **run
        Arguments of ``mbdsl.simulate``.

    Returns
    -------
    Animation
        The page; a notebook shows it below the cell, and its ``save`` writes it.

    Raises
    ------
    ModelError, UsageError
        If an argument is invalid. Names of signals and frames are checked before the run.
    IntegrationError
        If the integration fails; the file shows the results until then.
    """
    from mbdsl.viewing.animation import animate
    from mbdsl.viewing.saved_page import check_suffix
    from mbdsl.viewing.stored_result import is_result, stored_trajectory

    if out is not None:
        check_suffix(out)
    check_ghost(ghost)
    asked(units)
    patterns = _listed(signals)
    stored = isinstance(model, (str, PathLike)) and is_result(model)
    failure = None
    if stored or result is not None:
        if stored and result is not None:
            raise UsageError(f"`{model}` and `{result}` are both results", hint="give the model and one result")
        changes = {} if stored else _changes(run)
        if run:
            raise _needs_no_run(run)
        path = model if stored else result
        trajectory, names = stored_trajectory(path, None if stored else as_scene(model, **changes))  # type: ignore[arg-type]
        patterns = names if patterns is None else patterns
        output_files.check([out], [os.fspath(path)])  # type: ignore[arg-type]
    else:
        trajectory, failure = _motion(model, out, patterns, [traces] if isinstance(traces, str) else traces, run)
    found = animate(trajectory.in_units(units), patterns, traces, pale(ghost, trajectory.scene), arrows, view)
    return _saved(found, out, failure, size)


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


def _motion(
    model: Model | Trajectory,
    out: str | PathLike | None,
    patterns: Iterable[str] | None,
    traces: Sequence[str],
    run: dict[str, Any],
) -> tuple[Trajectory, IntegrationError | None]:
    """The trajectory of a model, which is simulated after a check of all names, and the error that ended it early."""
    from mbdsl.simulation.trajectory import Trajectory

    if isinstance(model, Trajectory):
        if given := {name: x for name, x in run.items() if name != "announce"}:
            raise _needs_no_run(given)
        return model, None
    scene = as_scene(model, **_changes(run))
    output_files.check([out], scene.files)
    check_shown(scene, patterns, traces)
    return _simulated(scene, run)


def _simulated(scene: Scene, run: dict[str, Any]) -> tuple[Trajectory, IntegrationError | None]:
    """The results of a run, also if the integration failed, and the failure."""
    from mbdsl.api import simulate

    try:
        return simulate(scene, **run), None
    except IntegrationError as problem:
        if problem.trajectory is None or not len(problem.trajectory):
            raise
        return problem.trajectory, problem


def _saved(found: Any, out: str | PathLike | None, failure: IntegrationError | None = None, *more: Any) -> Any:
    """What was found, written to a file if one is given; then the failure of its run is raised."""
    if out is not None:
        found.save(out, *more)
    if failure is not None:
        raise failure
    return found


def _listed(signals: str | Iterable[str] | None) -> list[str] | None:
    return None if signals is None else [signals] if isinstance(signals, str) else list(signals)


def _changes(run: dict[str, Any]) -> dict[str, Any]:
    """Take what changes a model out of the arguments of a run."""
    return {name: run.pop(name) for name in ("parameters", "without") if name in run}


def _needs_no_run(run: Mapping[str, Any]) -> UsageError:
    what = f"`{next(iter(run))}` belongs to a simulation, and the result is computed already"
    return UsageError(what, hint="give the model alone to simulate it")
