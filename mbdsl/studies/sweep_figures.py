"""The pictures of a sweep, a measure over a parameter as curves or over two long ones as a map, and its files."""

from __future__ import annotations

import math
import os
from collections.abc import Iterator, Sequence
from itertools import product
from typing import TYPE_CHECKING

from mbdsl.errors import UsageError
from mbdsl.messages import count
from mbdsl.plotting import table_files
from mbdsl.plotting.figures import Cells, Figure, Outcome, Page, Series, TextTable
from mbdsl.plotting.series_styles import looks
from mbdsl.plotting.signal_panels import ASPECTS, FLAT, labelled
from mbdsl.plotting.signal_plots import SUFFIXES as PICTURES
from mbdsl.plotting.signal_plots import Plot
from mbdsl.storage.output_files import suffix_of
from mbdsl.studies.sweep_values import Varied

if TYPE_CHECKING:
    from mbdsl.studies.measures import Measure
    from mbdsl.studies.sweep_results import Sweep

SUFFIXES = tuple(dict.fromkeys((*table_files.SUFFIXES, *PICTURES)))
CURVES = 8  #: largest number of curves in a frame; of more values a map is drawn
PANELS = 12  #: largest number of frames
MANY = 60  #: number of points above which curves have no marks
MARGIN = 0.03  #: space between the ends of a curve and the frame, relative to its width
ROWS = 500  #: largest number of rows of the table of a page


def plot(sweep: Sweep) -> Plot:
    """The picture of a sweep: see :meth:`mbdsl.studies.sweep_results.Sweep.plot`."""
    if not sweep.measures:
        raise UsageError("a sweep without measures has no picture")
    title, *_ = sweep.summary()
    layout = _Layout(sweep)
    frames = list(product(sweep.measures, layout.panels()))
    notes = list(layout.notes(len(frames)))
    of = layout.curves if layout.second is None else layout.cells
    figures = tuple(of(measure, fixed, k) for k, (measure, fixed) in enumerate(frames[:PANELS]))
    return Plot(title, figures, looks(dict.fromkeys(s.name for figure in figures for s in figure.series)), tuple(notes))


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

    def curves(self, measure: Measure, fixed: dict[int, int], k: int) -> Figure:
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

    def cells(self, measure: Measure, fixed: dict[int, int], k: int) -> Figure:
        """A measure over two parameters."""
        assert self.second is not None
        p, q = self.sweep.varied[self.x], self.sweep.varied[self.second]
        x, y, (column, unit) = _places(p), _places(q), self.sweep.shown(measure)
        along, up = sorted(range(len(p)), key=x.__getitem__), sorted(range(len(q)), key=y.__getitem__)
        z = [[column[self._row({**fixed, self.x: i, self.second: j})] for i in along] for j in up]
        cells = Cells(labelled(str(measure), unit), [x[i] for i in along], [y[j] for j in up], z)
        return Figure(f"map-{k}", self._said(fixed), _label(p), _label(q), (), _log(p), _log(q), cells=cells)

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


def save(sweep: Sweep, path: str | os.PathLike) -> None:
    """Write the table, the picture or the page of a sweep, as the suffix selects."""
    suffix = suffix_of(path, SUFFIXES)
    if suffix in table_files.SUFFIXES:
        title, *notes = sweep.summary()
        table_files.write(path, [sweep.table()], sweep.records(), title, [note.strip() for note in notes])
    elif suffix == ".html":
        _write_page(sweep, path)
    else:
        plot(sweep).save(path)


def _write_page(sweep: Sweep, path: str | os.PathLike) -> None:
    """A page with the table and the pictures."""
    from mbdsl.plotting import pages

    title, *notes = sweep.summary()
    shown, table = plot(sweep), sweep.table()
    note = f"The first {ROWS} of {len(table.rows)} rows; a .csv file contains all." if len(table.rows) > ROWS else ""
    items = [*shown.page().items, TextTable("Runs", table.columns, table.rows[:ROWS], note)]
    pages.write(Page(title, [*notes, *shown.notes], items, looks=shown.looks), path)
