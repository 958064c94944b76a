"""Trajectory: the results of a simulation, as named signals that are computed on first access."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from numbers import Real
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING, Any

from numpy.typing import NDArray

from mbdsl.errors import UsageError
from mbdsl.integrators.event_list import happened, times
from mbdsl.kernels.arrays import Array
from mbdsl.lang.display_units import asked
from mbdsl.lang.given_values import seconds
from mbdsl.messages import count, install
from mbdsl.simulation import result_file
from mbdsl.simulation.event_marks import Mark, marks
from mbdsl.simulation.named_signals import NamedSignals

if TYPE_CHECKING:
    import pandas
    import xarray

    from mbdsl.integrators.event_list import Happened
    from mbdsl.plotting.profiles import Profile
    from mbdsl.plotting.signal_plots import Plot
    from mbdsl.simulation.signal_table import Signals
    from mbdsl.viewing.animation import Animation


class Trajectory(NamedSignals):
    """States over time, and every signal of the model by name.

    ``trajectory["crank.phi"]`` is the (N,) array of a signal in SI units, ``trajectory["time"]`` that of the times;
    ``trajectory.names`` lists the signals. ``trajectory[["crank.phi", "crank.w"]]`` and ``trajectory["crank.*"]`` are
    selections: trajectories of the same states that list, show and write these signals. ``trajectory[0.5:1.0]`` is the
    part between two times, both included.

    Attributes
    ----------
    system : System
        The equations of motion of the model as written.
    t : (N,) [s]
        Times.
    q, v : (N, n) [m, rad; m/s, rad/s]
        Generalised coordinates and velocities, in the order of ``system.names()``.
    lam : (N, m + p)
        Multipliers.
    inputs : dict of (N,)
        Values of the model's inputs.
    message : str
        Reason for a ``status`` other than "done".
    stats : dict
        Settings, counts, times of the phases, and error estimates.
    undetermined : list of float [s]
        Times at which accelerations and reactions are not unique (singular poses); their values there are nan.
    moved : tuple of Moved
        Guesses of initial values, and the values after assembly.
    left_out : tuple of int
        Redundant constraint rows, whose multipliers are zero.
    """

    def __repr__(self) -> str:
        span = f"{self.t[0]:g} ... {self.t[-1]:g} s" if len(self.t) else "empty"
        chosen = "" if self._chosen is None else f"{count(len(self._chosen), 'signal')}, "
        return f"<Trajectory of {self.scene.name}: {chosen}{count(len(self.t), 'point')}, {span}, {self.status}>"

    def _repr_html_(self) -> str:
        from mbdsl.simulation.signal_table import of_trajectory

        return of_trajectory(self)

    @property
    def events(self) -> list[Happened]:
        """What when-equations, rigid contacts and joints that stick did in the run: times [s], kinds, and places in the
        text."""
        return happened(self.find_events())

    def event_marks(self, start: float, stop: float) -> tuple[list[Mark], int]:
        """Return the marks of plots for the events between two times.

        Parameters
        ----------
        start, stop : float [s]
            The ends of the axis of a plot.

        Returns
        -------
        marks : list of Mark
            Time, kind, number of events and text of each.
        ticks : int
            Number of ticks of clocks that are not marked, because there are many.
        """
        return marks(self.find_events(), start, stop)

    def _event_times(self, impulses: bool) -> Array:
        """The times (k,) of the events [s], ascending; of impulses only, if asked."""
        return times(self.find_events(), impulses)

    @property
    def signals(self) -> Signals:
        """The signals in ``names`` with units and meanings; ``print`` and notebooks show a table."""
        from mbdsl.simulation.signal_table import signals

        return signals(self)

    def __array__(self, dtype: Any = None, copy: bool | None = None) -> NDArray[Any]:
        if copy is False:
            raise ValueError("the columns of a trajectory are copied into an array")
        return self.to_numpy().astype(dtype or float, copy=False)

    def to_pandas(self, patterns: str | Iterable[str] | None = None) -> pandas.DataFrame:
        """Return signals as a data frame; requires pandas.

        Parameters
        ----------
        patterns : str or iterable of str, optional
            As for ``to_dict``.

        Returns
        -------
        pandas.DataFrame
            One column per signal, indexed by time.

        Raises
        ------
        UsageError
            If a pattern matches no name, or pandas is not installed.
        """
        try:
            import pandas
        except ImportError as problem:
            raise _not_installed("pandas") from problem

        data = self.to_dict(patterns)
        return pandas.DataFrame({k: v for k, v in data.items() if k != "time"}, index=pandas.Index(self.t, name="time"))

    def to_xarray(self, patterns: str | Iterable[str] | None = None) -> xarray.Dataset:
        """Return signals as a data set; requires xarray.

        Parameters
        ----------
        patterns : str or iterable of str, optional
            As for ``to_dict``.

        Returns
        -------
        xarray.Dataset
            One variable a signal over the dimension "time", with the attribute "units".

        Raises
        ------
        UsageError
            If a pattern matches no name, or xarray is not installed.
        """
        try:
            import xarray
        except ImportError as problem:
            raise _not_installed("xarray") from problem

        data = self.to_dict(patterns)
        variables = {k: ("time", v, {"units": self.unit(k)}) for k, v in data.items() if k != "time"}
        return xarray.Dataset(variables, coords={"time": ("time", self.t, {"units": "s"})})

    def save(
        self,
        path: str | PathLike,
        patterns: str | Iterable[str] | None = None,
        *,
        row_of_units: bool = False,
        units: str | Iterable[str] | None = None,
    ) -> None:
        """Write signals to a result file, as ``mbdsl simulate --output`` does.

        Parameters
        ----------
        path : path
            The file; its suffix (.csv, .npz, .mat, .nc) selects the format.
        patterns : str or iterable of str, optional
            As for ``to_dict``.
        row_of_units : bool, optional
            Write a second row with the units, in a format that contains none otherwise (.csv).
        units : str or iterable of str, optional
            Units of a .csv file, "deg, rpm", which its second row names. Default: SI units, as in all other formats.

        Raises
        ------
        UsageError
            If a pattern matches no name, the suffix is unknown, units are invalid or given for another format, or the
            file cannot be written.
        """
        result_file.save(self, path, patterns, row_of_units, units)

    def to_csv(
        self,
        path: str | PathLike,
        patterns: str | Iterable[str] | None = None,
        *,
        row_of_units: bool = False,
        units: str | Iterable[str] | None = None,
    ) -> None:
        """Write signals to a CSV file; see ``save``.

        Parameters
        ----------
        path : path
            The file, with the suffix .csv.
        patterns, row_of_units, units : optional
            As for ``save``.

        Raises
        ------
        UsageError
            If a pattern matches no name, the path has another suffix, or the file cannot be written.
        """
        if Path(path).suffix.lower() != ".csv":
            hint = "`save` selects the format by the suffix"
            raise UsageError(f"found `{path!s}` for a CSV file, expected the suffix .csv", hint=hint)
        self.save(path, patterns, row_of_units=row_of_units, units=units)

    def plot(
        self,
        patterns: str | Iterable[str] | None = None,
        others: Iterable[Trajectory | str | PathLike] = (),
        *,
        against: str | None = None,
        difference: bool = False,
        spectrum: bool = False,
        units: str | Iterable[str] | None = None,
        out: str | PathLike | None = None,
    ) -> Plot:
        """Plot signals.

        Parameters
        ----------
        patterns : str or iterable of str, optional
            As for ``select``. Default: up to nine of ``shown_names`` that change, or the signals of a selection.
        others : iterable of Trajectory or path, optional
            Further results and result files in the same plot.
        against : str, optional
            Name of the signal on the horizontal axis. Default: the time.
        difference : bool, optional
            Plot the ``others`` minus this result, interpolated to its times.
        spectrum : bool, optional
            Plot amplitude spectra: a sine of amplitude A shows A.
        units : str or iterable of str, optional
            Units of the axes such as "deg, rpm, kN, mm", as for ``in_units``.
        out : path, optional
            A file to write: .svg, .html, or .png and .pdf, which require matplotlib.

        Returns
        -------
        Plot
            The plot: ``print`` shows it in characters, a notebook below the cell, and ``save`` writes it.

        Raises
        ------
        UsageError
            If a pattern matches no signal, results do not fit together, a signal has no spectrum, units are invalid, or
            the file cannot be written.
        """
        from mbdsl.plotting.signal_plots import plot
        from mbdsl.results.stored import of_trajectory, open_result
        from mbdsl.simulation.result_expressions import with_expressions

        patterns = self._chosen if patterns is None else patterns
        chosen = [patterns] if isinstance(patterns, str) else None if patterns is None else list(patterns)
        results = [of_trajectory(self, self.scene.name, chosen or ())]
        for other in others:
            if isinstance(other, Trajectory):
                results.append(of_trajectory(other, other.scene.name, chosen or ()))
            else:
                results.append(with_expressions(open_result(other), chosen))
        for result in results:
            result.display = asked(units, result.display)
        found = plot(results, chosen, against=against, difference=difference, spectrum=spectrum)
        if out is not None:
            found.save(out)
        return found

    def along(
        self,
        patterns: str | Iterable[str],
        at: float | str | Iterable[float | str] | None = None,
        out: str | PathLike | None = None,
        units: str | Iterable[str] | None = None,
    ) -> Profile:
        """Show signals along an array, or along a rod or beam, at one or more times.

        Parameters
        ----------
        patterns : str or iterable of str
            Names of signals with a slice in the place of an index, such as "joint[:].tau" or "joint[2:5].tau"; or of
            signals in the sections of a rod or beam: "beam.M", "beam.y".
        at : float or str, or several of them, optional [s]
            Times; between two outputs, values are interpolated linearly. Default: the end of the run.
        out : path, optional
            A file to write: a table (.csv, .md, .tex) or a plot (.svg, .html, or .png and .pdf, which require
            matplotlib).
        units : str or iterable of str, optional
            Units of the table and the plot, as for ``in_units``; ``profile[name]`` is in SI units.

        Returns
        -------
        Profile
            Positions and values: ``print`` shows a table, a notebook a plot, and ``save`` writes it.

        Raises
        ------
        UsageError
            If there is no such array, rod or beam, a time is outside of the run, or the file cannot be written.
        """
        from mbdsl.plotting.profiles import check_out
        from mbdsl.simulation.profiles import along

        check_out(out)
        chosen = [patterns] if isinstance(patterns, str) else list(patterns)
        times = None if at is None else [at] if isinstance(at, (str, Real)) else list(at)  # type: ignore[arg-type]
        found = along(self.in_units(units), chosen, None if times is None else [seconds(t, "at") for t in times])
        if out is not None:
            found.save(out)
        return found

    def animate(
        self,
        path: str | PathLike | None = None,
        signals: str | Iterable[str] | None = None,
        traces: str | Sequence[str] = (),
        ghost: Trajectory | None = None,
        arrows: str | Sequence[str] = ("forces",),
        view: str | None = None,
        units: str | Iterable[str] | None = None,
    ) -> Animation:
        """Animate the mechanism, as one HTML page that loads nothing.

        Parameters
        ----------
        path : path, optional
            File that the page is written to, ``.html``.
        signals : str or iterable of str, optional
            Names and glob patterns of the signals that are plotted with the motion. Default: coordinates, velocities
            and signals of elements that change.
        traces : str or sequence of str, optional
            Names of frames and bodies whose path is drawn.
        ghost : Trajectory, optional
            Another motion, such as that of another parameter, which is drawn pale behind the first at the same time.
        arrows : str or sequence of str, optional
            Arrows in a film, or in a page when it opens: any of "forces" and "reactions".
        view : str, optional
            Of a model in space: "iso" (default), "front", "side" or "top".
        units : str or iterable of str, optional
            Units of the plots of the page, as for ``in_units``.

        Returns
        -------
        Animation
            The page; a notebook shows it below the cell, and its ``save`` writes it to a file.

        Raises
        ------
        UsageError
            If the trajectory is empty, a name is unknown, a view is given for a planar model, or the file cannot
            be written.
        """
        from mbdsl.viewing.animation import animate

        found = animate(self.in_units(units), signals, traces, ghost, arrows, view)
        if path is not None:
            found.save(path)
        return found


def _not_installed(package: str) -> UsageError:
    return UsageError(f"{package} is not installed", hint=install(package))
