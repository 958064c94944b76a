"""Models and results as texts, pictures and pages: what the commands of these names show."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from functools import cached_property
from os import PathLike
from typing import TYPE_CHECKING, Any

from mbdsl.errors import IntegrationError, ModelWarning, UsageError
from mbdsl.lang.display_units import asked
from mbdsl.lang.mistakes import unused
from mbdsl.lang.model_argument import as_scene, blame_model
from mbdsl.mechanism.assembly_need import has_to_be_assembled
from mbdsl.mechanism.graph import MechanismGraph, build
from mbdsl.mechanism.scene import Scene
from mbdsl.reporting.shown_runs import (
    Changes,
    Model,
    Shown,
    changes_of,
    check_ghost,
    check_plotted,
    computed,
    listed,
    motion_of,
    motion_or_file,
    needs_no_run,
    pale,
    simulated,
    source,
)
from mbdsl.storage import output_files

if TYPE_CHECKING:
    from mbdsl.plotting.signal_plots import Plot
    from mbdsl.reporting.report import Report
    from mbdsl.simulation.trajectory import Trajectory
    from mbdsl.viewing.animation import Animation
    from mbdsl.viewing.structure import Structure

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
    from mbdsl.viewing.structure_files import SUFFIXES

    output_files.suffix_of(out, SUFFIXES)
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
    from mbdsl.plotting.signal_plots import SUFFIXES, plot
    from mbdsl.simulation.trajectory import Trajectory

    given = [results] if isinstance(results, (str, Trajectory)) or not isinstance(results, Iterable) else [*results]
    if not given:
        raise UsageError("a plot needs a result or a model")
    output_files.suffix_of(out, SUFFIXES)
    output_files.check([out])
    asked(units)  # raises its errors before a run
    changes, patterns = changes_of(run), listed(signals)
    opened = [source(item, patterns, **changes) for item in given]
    if (changes or run) and not any(isinstance(item, Scene) for item in opened):
        raise needs_no_run(changes | run)
    labels = [str(x) if isinstance(x, (str, PathLike)) else o.name if isinstance(o, Scene) else o.label
              for x, o in zip(given, opened, strict=True)]  # fmt: skip
    check_plotted(opened, labels, patterns, against, spectrum)
    shown, failure = computed(opened, labels, patterns, units, lambda scene: simulated(scene, run))
    return _saved(plot(shown, patterns, against=against, difference=difference, spectrum=spectrum), out, failure)


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
    patterns = listed(signals)
    asked(units)
    trajectory, failure = motion_of(model, Shown(out, patterns), {"announce": announce, **run})
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
    from mbdsl.viewing.saved_page import SavedPage

    output_files.suffix_of(out, SavedPage.suffixes)
    check_ghost(ghost)
    asked(units)
    asked_for = Shown(out, listed(signals), listed(traces) or ())
    trajectory, patterns, failure = motion_or_file(model, result, asked_for, run)
    found = animate(trajectory.in_units(units), patterns, traces, pale(ghost, trajectory.scene), arrows, view)
    return _saved(found, out, failure, size)


def _saved(found: Any, out: str | PathLike | None, failure: IntegrationError | None = None, *more: Any) -> Any:
    """What was found, written to a file if one is given; then the failure of its run is raised."""
    if out is not None:
        found.save(out, *more)
    if failure is not None:
        raise failure
    return found
