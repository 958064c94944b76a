"""The pictures of a sweep: a measure over a parameter as curves, or over two long ones as a map."""

from __future__ import annotations

import math
import os
import textwrap
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import product
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from mbdsl.errors import UsageError
from mbdsl.messages import count
from mbdsl.plotting import heat_maps
from mbdsl.plotting.figures import Figure, HeatMap, Outcome, Page, Series, Table
from mbdsl.plotting.series_styles import looks
from mbdsl.plotting.signal_panels import ASPECTS, FLAT, labelled
from mbdsl.plotting.signal_plots import Plot, suffix_of
from mbdsl.storage.output_files import write_text
from mbdsl.studies.sweep_values import Varied

if TYPE_CHECKING:
    from mbdsl.studies.measures import Measure
    from mbdsl.studies.sweep_results import Sweep

Array = NDArray[np.float64]
CURVES = 8  #: largest number of curves in a frame; of more values a map is drawn
PANELS = 12  #: largest number of frames
MANY = 60  #: number of points above which curves have no marks
MARGIN = 0.03  #: space between the ends of a curve and the frame, relative to its width
ROWS = 500  #: largest number of rows of the table of a page
NOTE = 120  #: letters of a line of the notes


@dataclass(frozen=True, repr=False)
class SweepPlot(Plot):
    """The picture of a sweep. ``print(plot)`` shows curves in characters.

    Attributes
    ----------
    title : str
    panels : tuple of Figure
        One for each measure, from the top; empty if maps are drawn.
    looks : mapping
        Name of a series -> its look.
    notes : tuple of str
        Sentences on what is shown.
    maps : tuple of HeatMap
        Measures over two parameters; empty if curves are drawn.
    """

    maps: tuple[HeatMap, ...] = ()

    def save(self, path: str | os.PathLike) -> None:
        """Write the picture.

        Parameters
        ----------
        path : path
            The file. Its suffix selects the format: .svg, .html, or .png and .pdf, which require matplotlib.

        Raises
        ------
        UsageError
            If the suffix is unknown, the file cannot be written, or matplotlib is not installed.
        """
        suffix = suffix_of(path)
        if not self.maps or suffix == ".html":
            return super().save(path)
        if suffix == ".svg":
            return write_text(path, self._repr_svg_())
        return heat_maps.draw(self.maps, path, self.title, self._lines())

    def page(self) -> Page:
        """Return the picture as a page.

        Returns
        -------
        Page
        """
        return Page(self.title, self.notes, self.maps or self.panels, looks=self.looks)

    def __repr__(self) -> str:
        return f"<SweepPlot of {self.title}: {count(len(self.maps), 'map')}>" if self.maps else super().__repr__()

    def __str__(self) -> str:
        if not self.maps:
            return super().__str__()
        shown = [(m, f", {m.title}" if m.title else "") for m in self.maps]
        each = (f"map of {m.z_label} over {m.x_label} and {m.y_label}{where}" for m, where in shown)
        return "\n".join([self.title, *each, *self.notes])

    def _repr_svg_(self) -> str:
        return heat_maps.svg(self.maps, self.title, self._lines()) if self.maps else super()._repr_svg_()

    def _lines(self) -> list[str]:
        return [line for note in self.notes for line in textwrap.wrap(note, NOTE)]


def plot(sweep: Sweep) -> SweepPlot:
    """The picture of a sweep: see :meth:`mbdsl.studies.sweep_results.Sweep.plot`."""
    if not sweep.measures:
        raise UsageError("a sweep without measures has no picture")
    title, *_ = sweep.summary()
    layout = _Layout(sweep)
    frames = list(product(sweep.measures, layout.panels()))
    notes = list(layout.notes(len(frames)))
    if layout.second is None:
        figures = tuple(layout.figure(measure, fixed, k) for k, (measure, fixed) in enumerate(frames[:PANELS]))
        names = dict.fromkeys(s.name for figure in figures for s in figure.series)
        return SweepPlot(title, figures, looks(names), tuple(notes))
    return SweepPlot(title, (), {}, tuple(notes), tuple(layout.map(*frame) for frame in frames[:PANELS]))


class _Layout:
    """Which parameter is on the horizontal axis, and what the others become."""

    def __init__(self, sweep: Sweep) -> None:
        self.sweep = sweep
        order = list(range(len(sweep.varied)))
        sizes = [len(p) for p in sweep.varied]
        if sweep.paired:
            self.x, rest = 0, []
        else:
            # a parameter of numbers, the one with the most values, the first of them
            self.x = min(order, key=lambda j: (sweep.varied[j].numbers is None, -sizes[j], j))
            rest = sorted((j for j in order if j != self.x and sizes[j] > 1), key=lambda j: (-sizes[j], j))
        self.second: int | None = None
        self.family, self.others = rest, []
        if math.prod(sizes[j] for j in rest) > CURVES:
            self.family, self.others = rest[:1], rest[1:]
            if sizes[rest[0]] > CURVES:
                self.x, self.second = sorted((self.x, rest[0]))  # of a map, the first one is horizontal
                self.family = []
        self.rows = {index: k for k, index in enumerate(sweep.indices)}

    def panels(self) -> list[dict[int, int]]:
        """Indices of the values of the other parameters, one entry per frame."""
        return self._combinations(self.others)

    def _combinations(self, which: Sequence[int]) -> list[dict[int, int]]:
        sizes = [range(len(self.sweep.varied[j])) for j in which]
        return [dict(zip(which, values, strict=True)) for values in product(*sizes)]

    def _row(self, at: dict[int, int]) -> int:
        if self.sweep.paired:
            return at[0]
        return self.rows[tuple(at.get(j, 0) for j in range(len(self.sweep.varied)))]

    def _said(self, at: dict[int, int]) -> str:
        return ", ".join(self.sweep.varied[j].said(k) for j, k in at.items())

    def figure(self, measure: Measure, fixed: dict[int, int], k: int) -> Figure:
        """Curves of a measure."""
        p = self.sweep.varied[self.x]
        x, (column, unit) = _places(p), self.sweep.shown(measure)
        order = sorted(range(len(p)), key=x.__getitem__)
        style = "both" if len(p) <= MANY else "line"
        series, outcomes = [], []
        for at in self._combinations(self.family):
            rows = [self._row({**fixed, **at, self.x: j}) for j in order]
            name = self._said(at) or str(measure)
            values = [column[row] for row in rows]
            hover = [self.sweep.point(row) for row in rows]
            series.append(Series(name, [x[j] for j in order], values, hover=hover, style=style))
            if k == 0:
                failed = ((x[j], self.sweep.reason(row)) for j, row in zip(order, rows, strict=True))
                outcomes += [Outcome(name, at_x, reason) for at_x, reason in failed if reason]
        where = f", {self._said(fixed)}" if fixed else ""
        frames = len(self.sweep.measures) * len(self.panels())
        return Figure(
            f"panel-{k}",
            "",
            _label(p),
            labelled(f"{measure}{where}", unit),
            series,
            x_log=_log(p),
            y_log=False,
            outcomes=outcomes,
            x_ends=_ends(x, _log(p)),
            aspect=ASPECTS.get(min(frames, PANELS), FLAT),
        )

    def map(self, measure: Measure, fixed: dict[int, int]) -> HeatMap:
        """A measure over two parameters."""
        assert self.second is not None
        p, q = self.sweep.varied[self.x], self.sweep.varied[self.second]
        x, y, (column, unit) = _places(p), _places(q), self.sweep.shown(measure)
        along, up = sorted(range(len(p)), key=x.__getitem__), sorted(range(len(q)), key=y.__getitem__)
        z = [[column[self._row({**fixed, self.x: i, self.second: j})] for i in along] for j in up]
        title = self._said(fixed)
        head = labelled(str(measure), unit)
        return HeatMap(
            title, _label(p), _label(q), head, [x[i] for i in along], [y[j] for j in up], z, _log(p), _log(q)
        )

    def notes(self, frames: int) -> Iterator[str]:
        """Sentences on what is shown."""
        if self.sweep.paired and len(self.sweep.varied) > 1:
            others = ", ".join(p.name for p in self.sweep.varied[1:])
            yield f"{others}: changed together with {self.sweep.varied[0].name}."
        single = [j for j, p in enumerate(self.sweep.varied) if len(p) == 1 and j != self.x]
        if single and not self.sweep.paired:
            yield f"{self._said(dict.fromkeys(single, 0))}."
        if frames > PANELS:
            yield f"{frames - PANELS} of {frames} frames are not shown; the table contains all values."
        if self.sweep.failed:
            yield f"{count(len(self.sweep.failed), 'run')} of {len(self.sweep)} failed."


def _places(p: Varied) -> list[float]:
    """The numbers of a parameter; other values are counted from 1."""
    return list(p.numbers) if p.numbers is not None else [1.0 + k for k in range(len(p))]


def _log(p: Varied) -> bool:
    return p.log and min(_places(p)) > 0.0


def _label(p: Varied) -> str:
    if p.numbers is not None:
        return p.head
    return f"{p.name} ({', '.join(f'{k}: {text}' for k, text in enumerate(p.texts, 1))})"


def _ends(x: Sequence[float], log: bool) -> tuple[float, float]:
    low, high = min(x), max(x)
    if log:
        space = (high / low) ** MARGIN if high > low else 2.0
        return low / space, high * space
    space = MARGIN * (high - low) or 0.5 * abs(low) or 1.0
    return low - space, high + space


def write_page(sweep: Sweep, path: str | os.PathLike) -> None:
    """A page with the table and the pictures."""
    from mbdsl.plotting import pages

    title, *notes = sweep.summary()
    shown, table = plot(sweep), sweep.table()
    note = f"The first {ROWS} of {len(table.rows)} rows; a .csv file contains all." if len(table.rows) > ROWS else ""
    items = [*shown.page().items, Table("Runs", table.columns, table.rows[:ROWS], note)]
    pages.write(Page(title, [*notes, *shown.notes], items, looks=shown.looks), path)
