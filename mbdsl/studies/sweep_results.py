"""The results of a sweep: columns of parameters and measures, tables, files and pictures."""

from __future__ import annotations

import math
import os
import textwrap
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np

from mbdsl.errors import UsageError
from mbdsl.kernels.arrays import Array
from mbdsl.lang.display_units import asked, only_asked
from mbdsl.messages import OWN, UnitsOfSignals, count, did_you_mean, few
from mbdsl.plotting.figures import TextTable
from mbdsl.plotting.signal_panels import labelled
from mbdsl.studies.measures import Measure
from mbdsl.studies.report import LONG, WIDTH, as_text
from mbdsl.studies.store import Computed
from mbdsl.studies.sweep_values import Varied

if TYPE_CHECKING:
    import pandas

    from mbdsl.plotting.signal_plots import Plot

TROUBLES = 8  #: reasons of failures that are listed
DONE, FAILED, LATE = "done", "failed", "not finished"


@dataclass(eq=False, repr=False)
class Sweep:
    """The runs of a sweep. ``print(sweep)`` shows a table; notebooks show a page.

    ``sweep["max(pin.fx)"]`` is the column (N,) of a measure and ``sweep["L"]`` that of a parameter, in the units of
    ``sweep.unit(name)``; N is the number of runs.

    Attributes
    ----------
    name : str
        Name of the model.
    parameters : tuple of Varied
        Parameters and their values.
    measures : tuple of Measure
        Measures.
    indices : list of tuple of int
        For each row the index of the value of each parameter; the last parameter changes fastest.
    runs : tuple of Computed
        Runs in the order of the rows.
    paired : bool
        Whether row k has value k of each parameter; otherwise the rows are all combinations.
    limit : float [s]
        Time limit of a run.
    found : int
        Number of runs that were taken from the store.
    notes : list of str
        Remarks, such as where the order of modes by frequency changes.
    display : UnitsOfSignals
        The units of measures in tables and pictures.
    """

    name: str
    parameters: tuple[Varied, ...]
    measures: tuple[Measure, ...]
    indices: list[tuple[int, ...]]
    runs: tuple[Computed, ...]
    paired: bool = False
    limit: float = math.inf
    found: int = 0
    notes: list[str] = field(default_factory=list)
    display: UnitsOfSignals = OWN

    @property
    def varied(self) -> tuple[Varied, ...]:
        """The parameters in the units that were asked for, for tables and pictures."""
        display = only_asked(self.display)
        return tuple(p.displayed(display) for p in self.parameters)

    def shown(self, measure: Measure) -> tuple[Array, str]:
        """A measure (N,) in the unit in which it is displayed, and that unit.

        Parameters
        ----------
        measure : Measure

        Returns
        -------
        values : (N,) array
        unit : str
            "" if it has none.
        """
        return self._in(measure, self.display)

    def _in(self, measure: Measure, display: UnitsOfSignals) -> tuple[Array, str]:
        unit = display.of(measure.unit, measure.signal)
        return self[str(measure)] / unit.factor, unit.symbol

    def __len__(self) -> int:
        return len(self.runs)

    def __repr__(self) -> str:
        return f"<Sweep of {self.name} over {few([p.name for p in self.parameters])}: {count(len(self), 'run')}>"

    def __str__(self) -> str:
        return self.text()

    def _repr_html_(self) -> str:
        from mbdsl.plotting.html_tables import fragment

        title, *notes = self.summary()
        return fragment(title, (), [self.table()], notes)

    # -- values ------------------------------------------------------------------------------------------------
    @property
    def names(self) -> list[str]:
        """Names of the columns: parameters, then measures."""
        return [p.name for p in self.parameters] + [str(m) for m in self.measures]

    def unit(self, name: str) -> str:
        """Return the unit of a column.

        Parameters
        ----------
        name : str
            A parameter or a measure.

        Returns
        -------
        str
            "" if it has none. Parameters are in the unit in which they were given, measures in SI units.
        """
        self._known(name)
        units = {p.name: p.unit for p in self.parameters} | {str(m): m.unit for m in self.measures}
        return units[name]

    def __getitem__(self, name: str) -> Array:
        self._known(name)
        for k, p in enumerate(self.parameters):
            if p.name == name:
                if p.numbers is None:
                    raise UsageError(f"the values of {name} are not numbers", hint="sweep.table() has them as texts")
                return np.array([p.numbers[row[k]] for row in self.indices])
        return np.array([run.stats["values"][name] if run.done else math.nan for run in self.runs])

    def _known(self, name: str) -> None:
        if name not in self.names:
            hint = did_you_mean(name, self.names) or f"it has {few(self.names)}"
            raise UsageError(f"the sweep has no column `{name}`", hint=hint)

    def grid(self, measure: str) -> Array:
        """Return a measure over all combinations.

        Parameters
        ----------
        measure : str
            A measure.

        Returns
        -------
        (n1, n2, ...) array
            One axis per parameter; nan where a run failed.

        Raises
        ------
        UsageError
            If there is no such measure, or the parameters are paired.
        """
        if self.paired:
            raise UsageError("paired parameters have no grid", hint=f'use sweep["{measure}"]')
        return self[measure].reshape([len(p) for p in self.parameters])

    @property
    def failed(self) -> list[int]:
        """Rows without values, because their runs failed or were not finished."""
        return [k for k, run in enumerate(self.runs) if not run.done]

    def reason(self, k: int) -> str:
        """Why row ``k`` has no values; "" if it has.

        Parameters
        ----------
        k : int
            Number of the row, from 0.

        Returns
        -------
        str
        """
        run = self.runs[k]
        return f"not finished within {self.limit:g} s" if run.late else run.problem

    def point(self, k: int) -> str:
        """The values of the parameters of row ``k``: ``L = 1.2 m, k = 5 N/mm``.

        Parameters
        ----------
        k : int
            Number of the row, from 0.

        Returns
        -------
        str
        """
        return ", ".join(p.said(j) for p, j in zip(self.varied, self.indices[k], strict=True))

    def to_pandas(self, units: str | Iterable[str] | None = None) -> pandas.DataFrame:
        """Return parameters, measures and outcomes as a data frame; requires pandas.

        Parameters
        ----------
        units : str or iterable of str, optional
            As for ``records``.

        Returns
        -------
        pandas.DataFrame
            One row per run. The column "outcome" is "done" or the reason of the failure.
        """
        import pandas

        return pandas.DataFrame(self.records(units))

    # -- as text and files ---------------------------------------------------------------------------------------
    def table(self, digits: int = 6) -> TextTable:
        """Return the table of all runs.

        Parameters
        ----------
        digits : int, optional
            Significant digits.

        Returns
        -------
        Table
            With a column "outcome" if a run failed.
        """
        failed = bool(self.failed)
        columns = [self.shown(m) for m in self.measures]
        heads = [p.head for p in self.varied]
        heads += [labelled(str(m), unit) for m, (_, unit) in zip(self.measures, columns, strict=True)]
        heads += ["outcome"] if failed else []
        rows = []
        for k, run in enumerate(self.runs):
            row = [p.shown(j, digits) for p, j in zip(self.varied, self.indices[k], strict=True)]
            row += [number(column[k], digits) for column, _ in columns]
            rows.append([*row, *([DONE if run.done else LATE if run.late else FAILED] if failed else [])])
        return TextTable("", heads, rows)

    def summary(self) -> list[str]:
        """Return what was run, and which runs failed or have warnings.

        Returns
        -------
        list of str
            Sentences; the first one is a title.
        """
        how = "paired" if self.paired and len(self.parameters) > 1 else ""
        over = (" and " if how else " x ").join(f"{p.name} ({len(p)})" for p in self.parameters)
        lines = [f"{self.name}: {count(len(self), 'run')} over {over}{f', {how}' if how else ''}"]
        reasons: dict[str, list[int]] = {}
        for k in self.failed:
            reasons.setdefault(self.reason(k), []).append(k)
        if reasons:
            lines.append(f"{len(self.failed)} of {count(len(self), 'run')} failed:")
            lines += [f"  {self._where(rows)}: {reason}" for reason, rows in list(reasons.items())[:TROUBLES]]
            lines += [f"  and {len(reasons) - TROUBLES} other reasons"] if len(reasons) > TROUBLES else []
        for m in self.measures:
            column = self[str(m)]
            empty = [k for k, run in enumerate(self.runs) if run.done and math.isnan(column[k])]
            if empty and m.lacking:
                lines.append(f"{m} has no value at {self._where(empty)}: {m.lacking}")
        said: dict[str, list[int]] = {}
        for k, run in enumerate(self.runs):
            for line in run.stats.get("warnings", ()) if run.done else ():
                said.setdefault(line, []).append(k)
        warned = sorted({k for rows in said.values() for k in rows})
        if warned:
            line, rows = next(iter(said.items()))
            which = f"the first ({self._where(rows)}): {line}"
            lines.append(f"{count(len(warned), 'run has', 'runs have')} warnings, {which}")
        return lines + self.notes

    def _where(self, rows: Sequence[int]) -> str:
        first = self.point(rows[0])
        return first if len(rows) == 1 else f"{first} and {len(rows) - 1} more"

    def text(self, width: int = WIDTH, most: int = LONG) -> str:
        """Return the table for a terminal.

        Parameters
        ----------
        width : int, optional
            Largest number of characters of a line; further columns are continued below.
        most : int, optional
            Largest number of rows; of a longer table the first and the last rows are shown.

        Returns
        -------
        str
        """
        table = self.table()
        rows = list(table.rows)
        if len(rows) > most:
            half = most // 2
            left = f"... {len(rows) - 2 * half} rows"
            rows = [*rows[:half], [left, *[""] * (len(table.columns) - 1)], *rows[-half:]]
        shown = as_text(TextTable("", table.columns, rows), width, len(self.parameters))
        title, *notes = self.summary()
        title += f" ({self.found} of them stored before)" if self.found else ""
        return "\n".join([*wrapped([title], width), "", shown, *([""] if notes else []), *wrapped(notes, width)])

    def save(self, path: str | os.PathLike) -> None:
        """Write the table or the picture.

        Parameters
        ----------
        path : path
            The file. Its suffix selects the content: .csv (all digits), .md, .tex (tables), .html (a page with table
            and pictures), .svg, .png, .pdf (pictures; the last two require matplotlib).

        Raises
        ------
        UsageError
            If the suffix is unknown, the file cannot be written, or matplotlib is not installed.
        """
        from mbdsl.studies.sweep_figures import save

        save(self, path)

    def plot(self) -> Plot:
        """Return the measures as curves over the parameter with the most values, or as maps over two.

        Returns
        -------
        Plot
            ``plot.save(path)`` writes it.
        """
        from mbdsl.studies.sweep_figures import plot

        return plot(self)

    def records(self, units: str | Iterable[str] | None = None) -> list[dict]:
        """Return one record a run, with all digits.

        Parameters
        ----------
        units : str or iterable of str, optional
            Units of measures such as "deg, kN". Default: those that the sweep was asked for, else SI units.

        Returns
        -------
        list of dict
            Column with its unit -> number or text. The column "outcome" is "done" or the reason of the failure.
        """
        display = asked(units, only_asked(self.display))
        varied = [p.displayed(display) for p in self.parameters]
        found_of = [self._in(m, display) for m in self.measures]
        columns = {labelled(str(m), unit): x.tolist() for m, (x, unit) in zip(self.measures, found_of, strict=True)}
        found = []
        for k, row in enumerate(self.indices):
            record: dict = {
                p.head: p.texts[j] if p.numbers is None else p.numbers[j] for p, j in zip(varied, row, strict=True)
            }
            record |= {head: column[k] for head, column in columns.items()}
            found.append(record | {"outcome": self.reason(k) or DONE})
        return found


def number(x: float, digits: int = 6) -> str:
    """A value of a table; "-" if there is none."""
    return f"{x:.{digits}g}" if math.isfinite(x) else "-"


def wrapped(lines: Iterable[str], width: int) -> list[str]:
    """Lines of at most ``width`` characters; those that begin with spaces keep them."""
    found = []
    for line in lines:
        indent = " " * (len(line) - len(line.lstrip()))
        found += textwrap.wrap(line, width, subsequent_indent=indent, break_long_words=False) or [""]
    return found
