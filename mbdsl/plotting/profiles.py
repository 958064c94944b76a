"""Profiles: a signal along the elements of an array, or along a rod or beam, at one or more times.

``joint[:].tau`` are the signals ``joint[1].tau``, ``joint[2].tau``, ... over the index; ``joint[2:5].tau`` are those of
some elements.
"""

from __future__ import annotations

import os
import re
from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING

import numpy as np

from mbdsl.errors import UsageError
from mbdsl.messages import OWN, UnitsOfSignals, did_you_mean, few
from mbdsl.plotting import signal_plots, table_files
from mbdsl.plotting.curves import SignalCurve
from mbdsl.plotting.figures import TextTable
from mbdsl.plotting.signal_panels import Horizontal, labelled, panels
from mbdsl.plotting.signal_plots import Plot
from mbdsl.storage import output_files

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from mbdsl.results.stored import Result

    Array = NDArray[np.float64]

SUFFIXES = (*table_files.SUFFIXES, *signal_plots.SUFFIXES)
SLICE = re.compile(r"\[([^\[\]]*:[^\[\]]*)\]")
INDEX = re.compile(r"\[\d+\]")
#: interpolation between two rows; at a row, rounding of the times counts as equal
ROUNDING = 1e-9
HOW = (
    "write `[:]` for the index of an array, `joint[:].tau`; profiles of rods and beams (`rod.M`) need the model or the "
    "run: a result file has only those of arrays"
)
LINEAR = "Between the outputs, values are interpolated linearly."


@dataclass(frozen=True)
class Line:
    """A signal along an array, rod or beam.

    Attributes
    ----------
    axis : Horizontal
        Label and unit of the positions.
    x : (K,)
        Positions: an index from 1, or a distance [m].
    y : (T, K)
        Values at T times, in SI units.
    unit : str
        Unit of the values.
    """

    axis: Horizontal
    x: Array
    y: Array
    unit: str


@dataclass(frozen=True, repr=False)
class Profile(Plot):
    """Signals along arrays or beams at one or more times; ``print`` shows a table, and ``save`` writes a picture.

    ``profile["joint[:].tau"]`` are the values (T, K) at T times.

    Attributes
    ----------
    title, panels, looks, notes
        As of a Plot.
    at : tuple of float [s]
        The times.
    lines : mapping of str to Line
        Signal -> its positions and values.
    display : UnitsOfSignals
        The units in which values are displayed.
    """

    at: tuple[float, ...] = ()
    lines: Mapping[str, Line] = field(default_factory=dict)
    display: UnitsOfSignals = OWN

    def __getitem__(self, signal: str) -> Array:
        """The values (T, K) of a signal in SI units."""
        if signal not in self.lines:
            raise UsageError(f"the profile has no `{signal}`", hint=f"it has {few(self.lines)}")
        return self.lines[signal].y

    def __repr__(self) -> str:
        return f"<Profile of {self.title}: {few(self.lines)}>"

    def __str__(self) -> str:
        columns = [[head, *(f"{x:.6g}" for x in values)] for head, values in self._columns().items()]
        wide = [max(map(len, column)) for column in columns]
        rows = zip(*columns, strict=True)
        text = ["  ".join(f"{cell:>{w}}" for cell, w in zip(row, wide, strict=True)) for row in rows]
        return "\n".join([self._head(), *text, *self.notes])

    def save(self, path: str | os.PathLike) -> None:
        """Write the profile to a file.

        Parameters
        ----------
        path : path
            The file. Its suffix selects the content: .csv (all digits), .md or .tex (a table), .svg, .html, .png or
            .pdf (the plot; the last two require matplotlib).

        Raises
        ------
        UsageError
            If the suffix is unknown, the file cannot be written, or matplotlib is not installed.
        """
        if output_files.suffix_of(path, SUFFIXES) not in table_files.SUFFIXES:
            super().save(path)
            return
        columns = self._columns()
        rows = list(zip(*(values.tolist() for values in columns.values()), strict=True))
        table = TextTable("", list(columns), [[f"{x:.6g}" for x in row] for row in rows])
        records = [dict(zip(columns, row, strict=True)) for row in rows]
        table_files.write(path, [table], records, self._head(), self.notes)

    def _head(self) -> str:
        second = self.display.of("s", "time")
        return f"{self.title}, t = {', '.join(f'{t / second.factor:.6g}' for t in self.at)} {second.symbol}"

    def _columns(self) -> dict[str, Array]:
        """The table as it is displayed: heading -> positions (K,), and values (K,) of each signal at each time."""
        line = next(iter(self.lines.values()))
        unit, second = line.axis.shown(self.display), self.display.of("s", "time")
        columns = {labelled(line.axis.label, unit.symbol): line.x / unit.factor}
        for name, own in self.lines.items():
            unit = self.display.of(own.unit, name)
            for t, values in zip(self.at, own.y, strict=True):
                head = name if len(self.at) == 1 else f"{name} at {second.text(t)}"
                columns[labelled(head, unit.symbol)] = values / unit.factor
        return columns


def profile(
    title: str, lines: Mapping[str, Line], at: Sequence[float], notes: Sequence[str], display: UnitsOfSignals
) -> Profile:
    """The table and the plot of signals along arrays or beams, in the units in which they are displayed.

    Raises
    ------
    UsageError
        If the signals have different horizontal axes.
    """
    first, second = next(iter(lines.values())), display.of("s", "time")
    for name, line in lines.items():
        if line.axis.unit != first.axis.unit or not np.array_equal(line.x, first.x):
            first_name = next(iter(lines))
            slices = SLICE.search(first_name) or SLICE.search(name)
            what = "not along the same elements" if slices else "along different bodies"
            raise UsageError(
                f"{first_name} and {name} are {what}",
                hint="give them one by one",
            )
    curves = [
        SignalCurve(name, line.x, y, *_size(y), len(y), result=k, label=f"t = {second.text(at[k])}")
        for name, line in lines.items()
        for k, y in enumerate(line.y)
    ]
    axes = {line.axis for line in lines.values()}
    axis = first.axis if len(axes) == 1 else replace(first.axis, label=first.axis.label.partition(" ")[0])
    lines = {name: replace(line, axis=axis) for name, line in lines.items()}
    figures, looks = panels(curves, {name: line.unit for name, line in lines.items()}, axis, len(at) > 1, display)
    return Profile(title, figures, looks, tuple(notes), tuple(at), dict(lines), display)


def _size(y: Array) -> tuple[float, float]:
    finite = y[np.isfinite(y)]
    return (float(np.abs(finite).max()), float(np.ptp(finite))) if len(finite) else (0.0, 0.0)


def elements(pattern: str, names: Collection[str], where: str) -> tuple[str, list[int], list[str]]:
    """The array that a pattern with a slice names, and the indices and signals of its elements, in ascending order.

    Raises
    ------
    UsageError
        If the pattern has no slice or several ones, or matches no signal, or its limits are not those of elements.
    """
    found = SLICE.findall(pattern)
    known = list(dict.fromkeys(INDEX.sub("[:]", name) for name in names if INDEX.search(name)))
    if not found:
        hint = did_you_mean(pattern, known) or HOW
        raise UsageError(f"`{pattern}` is not a signal along an array", hint=hint)
    parts = [part.strip() for part in found[0].split(",")]
    if len(found) > 1 or sum(":" in part for part in parts) != 1:
        raise UsageError(f"`{pattern}` has more than one slice", hint="a profile is along one index: `p[1].q[:].x`")
    before, after = pattern.split(f"[{found[0]}]")
    inner = ",".join(r"(\d+)" if ":" in part else re.escape(part) for part in parts)
    form = re.compile(rf"{re.escape(before)}\[{inner}\]{re.escape(after)}")
    at = {int(m[1]): name for name in names if (m := form.fullmatch(name))}
    if not at:
        hint = did_you_mean(pattern, known) or (f"arrays: {few(known)}" if known else "it has no arrays")
        raise UsageError(f"there is no array of signals `{pattern}` in {where}", hint=hint)
    first, last = _limits(next(part for part in parts if ":" in part), pattern)
    outside = [k for k in (first, last) if k is not None and k not in at]
    if outside:
        raise UsageError(f"`{pattern}`: there is no element {outside[0]}", hint=f"they are {min(at)} to {max(at)}")
    chosen = [k for k in sorted(at) if (first or min(at)) <= k <= (last or max(at))]
    if not chosen:
        raise UsageError(f"`{pattern}` contains no element", hint=f"they are {min(at)} to {max(at)}")
    return before, chosen, [at[k] for k in chosen]


def _limits(part: str, pattern: str) -> tuple[int | None, int | None]:
    words = [word.strip() for word in part.split(":")]
    if len(words) != 2 or not all(word in ("", "end") or word.isdecimal() for word in words):
        raise UsageError(f"`{pattern}`: `{part}` is not a slice", hint="write `[:]`, or `[2:5]` for some elements")
    first, last = (int(word) if word.isdecimal() else None for word in words)
    return first, last


def times_inside(at: Sequence[float] | None, first: float, last: float) -> list[float]:
    """The times, by default the end of the run.

    Raises
    ------
    UsageError
        If a time is outside of the run.
    """
    if at is None:
        return [last]
    if not at:
        raise UsageError("a profile needs at least one time")
    rounding = ROUNDING * max(abs(first), abs(last))
    for t in at:
        if not first - rounding <= t <= last + rounding:
            raise UsageError(f"t = {t:g} s is outside of the run, which is from {first:g} to {last:g} s")
    return [min(max(t, first), last) for t in at]


def weights(t: Array, time: float) -> tuple[int, int, float]:
    """Two rows of ascending times, and the weight of the second one; the same row twice at a row."""
    k = int(np.searchsorted(t, time))
    for row in (k - 1, k):
        if 0 <= row < len(t) and abs(t[row] - time) <= ROUNDING * max(abs(t[0]), abs(t[-1])):
            return row, row, 0.0
    return k - 1, k, float((time - t[k - 1]) / (t[k] - t[k - 1]))


def of_arrays(
    patterns: Sequence[str],
    names: Collection[str],
    where: str,
    unit: Callable[[str], str],
    columns: Callable[[Sequence[str]], Mapping[str, Array]],
) -> dict[str, Line]:
    """The lines of patterns with slices; ``columns`` gives the values (T,) of signals at the times."""
    found = {pattern: elements(pattern, names, where) for pattern in patterns}
    values = columns([name for _, _, own in found.values() for name in own])
    lines = {}
    for pattern, (array, indices, own) in found.items():
        axis = Horizontal(f"index of {array}", "")
        y = np.column_stack([values[name] for name in own])
        lines[pattern] = Line(axis, np.array(indices, float), y, unit(own[0]))
    return lines


def of_result(result: Result, patterns: Sequence[str], at: Sequence[float] | None = None) -> Profile:
    """Signals of a result file along arrays.

    Parameters
    ----------
    result : Result
        The result.
    patterns : sequence of str
        Names of signals with a slice in the place of an index.
    at : sequence of float, optional [s]
        Times. Default: the last one.

    Raises
    ------
    UsageError
        If a pattern is no array of signals, or a time is outside of the run.
    """
    t = np.concatenate([np.empty(0), *(part for part, _ in result.chunks([]))])
    if not len(t) or (np.diff(t) < 0.0).any():
        raise UsageError(f"{result.label} has {'no rows' if not len(t) else 'times that do not ascend'}")
    times = times_inside(at, float(t[0]), float(t[-1]))
    rows = [weights(t, time) for time in times]

    def columns(names: Sequence[str]) -> dict[str, Array]:
        needed = sorted({k for i, j, _ in rows for k in (i, j)})
        kept: dict[str, dict[int, float]] = {name: {} for name in names}
        start = 0
        for part, found in result.chunks(names):
            for k in needed:
                if start <= k < start + len(part):
                    for name in names:
                        kept[name][k] = float(found[name][k - start])
            start += len(part)
        return {name: np.array([_between(own[i], own[j], w) for i, j, w in rows]) for name, own in kept.items()}

    lines = of_arrays(patterns, result.names, result.label, result.unit, columns)
    return profile(result.label, lines, times, [LINEAR] if any(w for _, _, w in rows) else [], result.display)


def _between(a: float, b: float, weight: float) -> float:
    return a if weight == 0.0 else (1.0 - weight) * a + weight * b


def check_out(out: str | os.PathLike | None) -> None:
    """Check the suffix and the folder of an output file."""
    output_files.suffix_of(out, SUFFIXES)
    output_files.check([out])
