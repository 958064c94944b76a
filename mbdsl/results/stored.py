"""Results that are read in parts: names, units and columns of a result file of any format, with bounded memory.

A format may have ``layout(path)``, which returns a ``Layout``; the columns of other formats are read as a whole.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator, Mapping, Sequence
from copy import copy
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

from mbdsl import results
from mbdsl.errors import UsageError
from mbdsl.messages import OWN

if TYPE_CHECKING:
    import numpy as np

    Chunks = Iterator[Sequence[np.ndarray]]

ROWS = 131072  #: number of rows of a part
#: last part of a name -> unit, for files without units: the signals of frames and bodies
USUAL_UNITS = {
    "x": "m",
    "y": "m",
    "phi": "rad",
    "vx": "m/s",
    "vy": "m/s",
    "w": "rad/s",
    "ax": "m/s2",
    "ay": "m/s2",
    "alpha": "rad/s2",
    "kinetic": "J",
    "potential": "J",
    "total": "J",
}


@dataclass(frozen=True)
class Layout:
    """Columns of a file: ``chunks(names, rows)`` yields the values of these columns for at most ``rows`` rows."""

    names: list[str]
    units: Mapping[str, str]
    chunks: Callable[[Sequence[str], int], Chunks]
    meta: dict = field(default_factory=dict)

    def __post_init__(self) -> None:
        results.check_about(self.meta, {} if isinstance(self.units, _Units) else self.units)


class Result:
    """A result whose columns are read in parts.

    Parameters
    ----------
    label : str
        Its name in legends and messages.
    layout : Layout
        Its columns.

    Attributes
    ----------
    names : list of str
        Names of the signals, without the time.
    groups : list of list of str, or None
        Signals from which those of a plot are chosen by default; None: by their names.
    time : str
        Name of the column of the times.
    sizes : dict of str to float
        Unit -> usual size of signals, beside which others are rounding errors; empty if it is unknown.
    events : callable
        Returns the marks of events between two times [s], and the number of ticks of clocks that have none.
    jumps : callable
        Returns the times of its events (J,) [s], ascending; if it is called with True, only those of impulses.
    cut_peaks : callable
        Returns the peaks of signals, given by their names, that its rows cut.
    is_file : bool
        Whether it may lack signals of the model.
    display : UnitsOfSignals
        The units in which values are displayed.
    descriptions : mapping of str to str
        Variable of the model -> its description, if it has one; empty for files.
    """

    def __init__(self, label: str, layout: Layout) -> None:
        self.label, self.layout = label, layout
        times = [name for name in layout.names if name.lower() == "time"]
        if not times:
            raise UsageError(
                f"`{label}` has no column `time`", hint="the columns of a result are signals over the time"
            )
        self.time = times[0]
        self.names = [name for name in layout.names if name != self.time]
        self.groups: list[list[str]] | None = None
        self.sizes: dict[str, float] = {}
        self.cut_peaks: Callable[[Sequence[str]], Sequence[Any]] = lambda names: ()
        self.events: Callable[[float, float], tuple[Sequence[Any], int]] = lambda start, stop: ((), 0)
        self.jumps: Callable[[bool], np.ndarray] = lambda impulses: _nothing()
        self.is_file = True
        self.display = OWN
        self.descriptions: Mapping[str, str] = {}

    def unit(self, name: str) -> str:
        """Return the unit of a signal.

        Parameters
        ----------
        name : str
            Name of a signal.

        Returns
        -------
        str
            Its unit; in files without units, that of the signals of bodies with this name; "" if it is unknown.
        """
        if name == self.time:
            return "s"
        units = self.layout.units
        if not units:
            owner, dot, key = name.rpartition(".")
            return USUAL_UNITS.get(key, "") if dot and (owner == "energy") == (USUAL_UNITS.get(key) == "J") else ""
        unit = units.get(name, "")
        return "" if unit == "1" else unit

    def chunks(self, names: Sequence[str], rows: int = ROWS) -> Iterator[tuple[np.ndarray, dict[str, np.ndarray]]]:
        """Read columns in parts.

        Parameters
        ----------
        names : sequence of str
            Names of signals.
        rows : int, optional
            Largest number of rows of a part.

        Yields
        ------
        times : (k,) [s]
        columns : dict of (k,)
            Name -> values, of ``names`` and the time.

        Returns
        -------
        iterator
            Of these pairs.

        Raises
        ------
        UsageError
            If the file cannot be read or is damaged.
        """
        asked = [self.time, *(name for name in dict.fromkeys(names) if name != self.time)]
        with results.readable(self.label):
            for part in self.layout.chunks(asked, rows):
                found = dict(zip(asked, part, strict=True))
                yield found[self.time], found


def open_result(path: str | os.PathLike) -> Result:
    """Open a result file whose columns are read in parts.

    Parameters
    ----------
    path : path
        The file; its suffix selects the format.

    Returns
    -------
    Result
        Names and units of the signals, and their values.

    Raises
    ------
    UsageError
        If the suffix is unknown, the file cannot be read or has another format, or it has no column ``time``.
    """
    module = results.format_of(path)
    with results.readable(str(path)):
        if hasattr(module, "layout"):
            return Result(str(path), module.layout(Path(path)))
        columns, meta = results.read(path)
        return Result(str(path), Layout(list(columns), {}, _in_parts(columns.__getitem__), meta))


def of_trajectory(trajectory: Any, label: str, patterns: Sequence[str] = ()) -> Result:
    """The signals of a ``Trajectory``, which computes them on access, and the expressions among ``patterns``."""
    known = dict.fromkeys(trajectory.select(["*"]))
    known |= dict.fromkeys(x for text in patterns if text not in known for x in trajectory.asked(text))
    found = of_columns(label, [*known], trajectory.unit, trajectory.__getitem__)
    found.groups, found.is_file, found.display = trajectory.shown_names, False, trajectory.display
    found.sizes = {"m": trajectory.system.tables.size, "rad": 1.0}
    found.cut_peaks, found.events = trajectory.cut_peaks, trajectory.event_marks
    found.jumps = trajectory._event_times
    found.descriptions = trajectory.descriptions
    found.layout.meta.update(complete=trajectory.status == "done", status=trajectory.status)
    return found


def of_columns(label: str, names: Sequence[str], unit: Callable[[str], str], column: Callable) -> Result:
    """A result in memory: ``unit(name)`` and ``column(name)`` give the unit and the values (N,) of a name."""

    return Result(label, Layout(list(names), _Units(names, unit), _in_parts(column)))


def _nothing() -> np.ndarray:
    import numpy as np

    return np.empty(0)


def _in_parts(column: Callable) -> Callable[[Sequence[str], int], Chunks]:
    """The ``chunks`` of a Layout whose columns are in memory."""

    def chunks(asked: Sequence[str], rows: int) -> Chunks:
        columns = [column(name) for name in asked]
        for k in range(0, len(columns[0]), rows):
            yield [values[k : k + rows] for values in columns]

    return chunks


class Made(NamedTuple):
    """A column that is computed from others: ``values`` takes these by name, and the number of rows."""

    unit: str
    operands: Sequence[str]
    values: Callable[[Mapping[str, np.ndarray], int], np.ndarray]


def with_columns(result: Result, made: Mapping[str, Made]) -> Result:
    """A result with additional columns, which are computed part by part."""

    def unit(name: str) -> str:
        return made[name].unit if name in made else result.unit(name)

    def chunks(asked: Sequence[str], rows: int) -> Chunks:
        read = dict.fromkeys(x for name in asked for x in (made[name].operands if name in made else (name,)))
        for part in result.layout.chunks([*read], rows):
            columns = dict(zip(read, part, strict=True))
            count = len(part[0])
            yield [made[name].values(columns, count) if name in made else columns[name] for name in asked]

    names = [*result.layout.names, *made]
    found = of_layout(result, Layout(names, _Units(names, unit), chunks, result.layout.meta))
    found.names = [*result.names, *made]
    found.cut_peaks = lambda names: result.cut_peaks([name for name in names if name not in made])
    return found


def of_layout(result: Result, layout: Layout) -> Result:
    """A result with the same names and other columns."""
    found = copy(result)
    found.layout = layout
    return found


class _Units(Mapping):
    """Units by name, computed on access."""

    def __init__(self, names: Sequence[str], unit: Callable[[str], str]) -> None:
        self._names, self._unit = dict.fromkeys(names), unit

    def __getitem__(self, name: str) -> str:
        if name not in self._names:
            raise KeyError(name)
        return self._unit(name)

    def __iter__(self) -> Iterator[str]:
        return iter(self._names)

    def __len__(self) -> int:
        return len(self._names)
