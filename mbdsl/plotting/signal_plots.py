"""Plots of the signals of results: over the time, against a signal, as differences and as spectra."""

from __future__ import annotations

import os
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import NamedTuple

from mbdsl.errors import UsageError
from mbdsl.messages import DisplayUnit, UnitsOfSignals, count, few
from mbdsl.plotting import curves
from mbdsl.plotting.curves import SignalCurve
from mbdsl.plotting.default_signals import MOST, default_groups, left_out
from mbdsl.plotting.differences import Difference
from mbdsl.plotting.figures import Figure, Page
from mbdsl.plotting.plot_notes import of_choice, of_curves, of_results, of_variables, short_labels
from mbdsl.plotting.series_styles import Look
from mbdsl.plotting.signal_panels import Horizontal, panels, with_events, with_peaks
from mbdsl.results.selection import matching, select, unknown
from mbdsl.results.stored import Result
from mbdsl.storage import output_files

SUFFIXES = (".png", ".svg", ".pdf", ".html")
WIDE, TALLEST = 780, 900  #: largest size of the page in a notebook, which scrolls further [px]


@dataclass(frozen=True)
class Plot:
    """A plot: panels with a shared axis, one below the other.

    ``print(plot)`` shows it in characters, and a notebook as a page with the values under the cursor.

    Attributes
    ----------
    title : str
    panels : tuple of Figure
        One for each unit, from the top.
    looks : mapping
        Name of a series -> its look.
    notes : tuple of str
        Sentences on what is shown: decimation, interpolation, omitted signals.
    """

    title: str
    panels: tuple[Figure, ...]
    looks: Mapping[str, Look] = field(default_factory=dict)
    notes: tuple[str, ...] = ()

    def save(self, path: str | os.PathLike) -> None:
        """Write the plot to a file.

        Parameters
        ----------
        path : path
            The file. Its suffix selects the format: .svg, .html, or .png and .pdf, which require matplotlib.

        Raises
        ------
        UsageError
            If the suffix is unknown, the file cannot be written, or matplotlib is not installed.
        """
        if output_files.suffix_of(path, SUFFIXES) == ".html":
            from mbdsl.plotting.pages import write

            write(self.page(), path)
        else:
            from mbdsl.plotting.pictures import draw

            draw(self._repr_svg_(), path)

    def page(self) -> Page:
        """Return the plot as a page.

        Returns
        -------
        Page
        """
        return Page(self.title, self.notes, self.panels, looks=self.looks)

    def __repr__(self) -> str:
        names = dict.fromkeys(series.name for panel in self.panels for series in panel.series)
        names |= dict.fromkeys(panel.cells.label for panel in self.panels if panel.cells is not None)
        return f"<Plot of {self.title}: {few(names)}>"

    def __str__(self) -> str:
        from mbdsl.plotting.characters import text

        return text(self.page())

    def _repr_html_(self) -> str:
        from mbdsl.plotting import html_tables, pages

        page = self.page()
        return html_tables.frame(pages.html(page), min(pages.height(page, WIDE), TALLEST), WIDE)

    def _repr_svg_(self) -> str:
        from mbdsl.plotting.sheets import sheet

        return sheet(self.title, self.panels, self.looks, self.notes)


def plot(
    results: Sequence[Result],
    patterns: Sequence[str] | None = None,
    *,
    against: str | None = None,
    difference: bool = False,
    spectrum: bool = False,
    units: UnitsOfSignals | None = None,
) -> Plot:
    """Plot signals of one or more results.

    Parameters
    ----------
    results : sequence of Result
        The results.
    patterns : sequence of str, optional
        Names and glob patterns of signals; the results have the expressions among them as columns. Default: up to nine
        coordinates of joints, drivers and free bodies, without those that are constant or equal to others; those of the
        first three bodies if these move alone or no joint is known; if no signal is named as a coordinate, the first
        six signals.
    against : str, optional
        Name of the signal on the horizontal axis. Default: the time.
    difference : bool, optional
        Plot the second and further results minus the first one.
    spectrum : bool, optional
        Plot amplitude spectra.
    units : UnitsOfSignals, optional
        The units in which values are displayed. Default: those of each signal in the first result that has it.

    Returns
    -------
    Plot

    Raises
    ------
    UsageError
        If a pattern matches no signal, a result is empty or damaged, results do not fit together, or a signal has no
        spectrum.
    """
    display = units or display_of(results)
    results = _compared(results) if difference else list(results)
    labels = short_labels([result.label for result in results])
    known = list(dict.fromkeys(name for result in results for name in result.names))
    if against is not None and against.lower() == "time":
        against = None
    files = all(r.is_file for r in results)
    asked = check_names([r.names for r in results], labels, patterns, against, spectrum, files)
    choice = _chosen(results, labels, asked if patterns else None, against, spectrum)
    chosen, found = choice.signals, choice.curves
    x = Horizontal("frequency", "Hz") if spectrum else Horizontal("time", "s")
    if against is not None:
        x = Horizontal(against, _unit(against, results), signal=True)
    units_of = {name: _unit(name, results) for name in chosen}
    figures, looks = panels(found, units_of, x, len(results) > 1, display)
    ticks = 0
    if against is None and not spectrum:
        figures, marked = with_peaks(figures, results, labels, chosen, display)
        looks |= marked
        figures, ticks = with_events(figures, results, labels, display)
    notes = [f"{count(ticks, 'tick')} of clocks are not marked."] if ticks else []
    notes += [] if patterns else list(of_choice(chosen, choice.constant, choice.same, known))
    notes += [*of_variables(results, chosen), *of_results(results, labels, chosen, display), *of_curves(found)]
    return Plot(", ".join(labels), figures, looks, tuple(dict.fromkeys(notes)))


class _Choice(NamedTuple):
    """Signals that are plotted with their curves, and those that are left out: constant, or equal to others."""

    signals: list[str]
    curves: list[SignalCurve]
    constant: Sequence[str] = ()
    same: Sequence[str] = ()


def _chosen(
    results: Sequence[Result], labels: Sequence[str], asked: list[str] | None, against: str | None, spectrum: bool
) -> _Choice:
    """The signals that were asked for, or the first of the default groups in which some are not constant.

    Raises
    ------
    UsageError
        If there is no signal, or if the results have no rows.
    """
    sizes = {unit: size for result in results for unit, size in result.sizes.items()}
    choice = _Choice([], [])
    for group in default_groups(results) if asked is None else [asked]:
        names = [name for name in group if name != against]
        own = {name: _unit(name, results) for name in names}
        choice = _Choice(names, list(_curves(results, labels, names, against, spectrum)))
        if asked is not None:
            break
        constant, same = left_out(choice.curves, own, sizes)
        choice = choice._replace(constant=constant, same=same)
        if len(constant) < len(names):
            break
    if not choice.signals:
        raise UsageError("there is no signal to plot", hint="`--signals '*'` chooses all; `--list` lists them")
    if not any(len(curve.x) for curve in choice.curves):
        raise UsageError(f"{few(labels)} {'has' if len(results) == 1 else 'have'} no rows")
    if asked is not None:
        return choice
    moving = [name for name in choice.signals if name not in {*choice.constant, *choice.same}]
    shown = (moving or choice.signals)[:MOST]
    curves = [curve for curve in choice.curves if curve.name in shown]
    return choice._replace(signals=shown, curves=curves, constant=choice.constant if moving else ())


class _OfResults(UnitsOfSignals):
    """The units of each signal in the first of several results that has it."""

    def __init__(self, results: Sequence[Result]) -> None:
        self._results = [(set(result.names), result.display) for result in results]

    def of(self, unit: str, name: str = "") -> DisplayUnit:
        found = next((display for names, display in self._results if name in names), self._results[0][1])
        return found.of(unit, name)


def display_of(results: Sequence[Result]) -> UnitsOfSignals:
    """The units in which the signals of several results are displayed."""
    return results[0].display if len(results) == 1 else _OfResults(results)


def check_names(
    names: Sequence[Sequence[str]],
    labels: Sequence[str],
    patterns: Sequence[str] | None,
    against: str | None,
    spectrum: bool,
    of_files: bool = False,
) -> list[str]:
    """The signals that patterns select from the ``names`` of several results, or of result files.

    Raises
    ------
    UsageError
        If a pattern matches none of them, or a result lacks the signal on the horizontal axis.
    """
    known = list(dict.fromkeys(name for own in names for name in own))
    chosen = select(patterns, known, few(labels), of_files) if patterns else []
    if against is None or against.lower() == "time":
        return chosen
    if spectrum:
        raise UsageError("a spectrum is plotted against the frequency", hint="omit --against or --spectrum")
    lacking = [label for label, own in zip(labels, names, strict=True) if against not in own]
    if lacking:
        if found := matching(against, known):
            raise UsageError(
                f"the horizontal axis needs the name of one signal, and `{against}` is a pattern",
                hint=f"it matches {few(found)}",
            )
        raise unknown(against, known, few(lacking), of_files)
    return chosen


def _compared(results: Sequence[Result]) -> list[Result]:
    if len(results) < 2:
        raise UsageError("a difference needs two results", hint="give both: mbdsl plot a.csv b.csv --difference")
    return [Difference(result, results[0]) for result in results[1:]]


def _unit(name: str, results: Sequence[Result]) -> str:
    units = {result.unit(name): result for result in results if name in result.names}
    units.pop("", None)
    if len(units) > 1:
        pairs = [f"{unit} in {result.label}" for unit, result in units.items()]
        raise UsageError(f"`{name}` has the unit {' and '.join(pairs)}", hint="plot the results one by one")
    return next(iter(units), "")


def _curves(
    results: Sequence[Result], labels: Sequence[str], chosen: Sequence[str], against: str | None, spectrum: bool
) -> Iterator[SignalCurve]:
    for k, (result, label) in enumerate(zip(results, labels, strict=True)):
        have = set(result.names)
        names = [name for name in chosen if name in have]
        if spectrum:
            found = curves.of_frequency(result, names)
        elif against is None:
            found = curves.over_time(result, names)
        else:
            found = curves.in_plane(result, against, names)
        yield from (replace(curve, result=k, label=label) for curve in found)
