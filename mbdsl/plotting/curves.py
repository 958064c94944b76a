"""The points of the curves of a plot, read from results part by part, and decimated if they are many."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from mbdsl.plotting.decimation import POINTS, ThinnedRows, Visited
from mbdsl.plotting.spectra import spectrum
from mbdsl.results.stored import Result

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Array = NDArray[np.float64]

WEAK = 1e-3  #: frequencies above the last one with this part of the largest amplitude are left out
HELD = 0.25  #: least part of the values of a flag or counter that are equal to those before
COLUMN_NOTE = "of each column of pixels the first, least, largest and last value are drawn."
CELL_NOTE = "each segment between cells of a fine grid is drawn once."


@dataclass(frozen=True)
class SignalCurve:
    """A curve of a signal."""

    name: str  #: the signal
    #: (K,): points; nan is a gap
    x: Array
    y: Array
    #: largest size, and range, of all finite values
    largest: float
    spread: float
    count: int  #: number of rows
    reduced: str = ""  #: how the points were decimated; "" if they are all rows
    remark: str = ""  #: details of a spectrum
    frequency: float = 0.0  #: [Hz] highest frequency of a spectrum that is shown
    result: int = 0  #: number of the result
    label: str = ""  #: the result's name


def _curve(name: str, points: Iterable[Array], count: int, reduced: str, **more) -> SignalCurve:
    x, y = points
    finite = y[np.isfinite(y)]
    low, high = (float(finite.min()), float(finite.max())) if len(finite) else (0.0, 0.0)
    return SignalCurve(name, x, y, max(abs(low), abs(high)), high - low, count, reduced, **more)


def over_time(result: Result, names: Sequence[str]) -> list[SignalCurve]:
    """Signals over the time, from one pass through the result."""
    found = {name: ThinnedRows([result.time, name], result.time, POINTS, even=True) for name in names}
    last = -np.inf
    for t, columns in result.chunks(names):
        if len(t) and (t[0] < last or (np.diff(t) < 0.0).any()):  # of another program: not ascending
            return in_plane(result, result.time, names)
        last = t[-1] if len(t) else last
        for name in names:
            found[name].add({result.time: t, name: columns[name]})
    jumps = result.jumps(False)
    drawn = []
    for name, rows in found.items():
        x, y = rows.columns().values()
        points = (x, y) if rows.reduced else stepped(x, y, jumps)
        drawn.append(_curve(name, points, rows.count, COLUMN_NOTE if rows.reduced else ""))
    return drawn


def is_held(y: Array) -> bool:
    """Whether values (N,) are those of a flag or a counter: whole numbers, which are often equal to those before."""
    return len(y) > 1 and float((y[1:] == y[:-1]).mean()) >= HELD and bool((np.rint(y) == y).all())


def stepped(t: Array, y: Array, events: Array) -> tuple[Array, Array]:
    """A curve with vertical lines where its value jumps: at every change of a flag or counter, and at a change between
    rows before and after which the value is constant.

    A line is at the last event between the two rows, or at the second row if there is none.
    """
    flat = y[1:] == y[:-1]
    alone = np.ones(len(flat), bool) if is_held(y) else np.r_[False, flat[:-1]] & np.r_[flat[1:], False]
    k = np.flatnonzero(~flat & alone)
    if not len(k):
        return t, y
    at, last = t[k + 1], np.searchsorted(events, t[k + 1], "right") - 1
    if len(events):
        at = np.where((last >= 0) & (events[last] > t[k]), events[last], at)
    places = np.repeat(k + 1, 2)
    return np.insert(t, places, np.repeat(at, 2)), np.insert(y, places, np.stack([y[k], y[k + 1]], axis=1).ravel())


def in_plane(result: Result, against: str, names: Sequence[str]) -> list[SignalCurve]:
    """Signals against a signal: one pass for the ranges, and for long results a second one for the points."""
    asked, limit = [against, *names], POINTS
    ends = dict.fromkeys(asked, (np.inf, -np.inf))
    rows: dict[str, list[Array]] = {name: [] for name in asked}
    count = 0
    for t, columns in result.chunks(asked):
        count += len(t)
        for name in asked:
            finite = columns[name][np.isfinite(columns[name])]
            if len(finite):
                ends[name] = min(ends[name][0], float(finite.min())), max(ends[name][1], float(finite.max()))
            if count <= limit:
                rows[name].append(columns[name])
    if count <= limit:
        whole = {name: np.concatenate([np.empty(0), *parts]) for name, parts in rows.items()}
        return [_curve(name, (whole[against], whole[name]), count, "") for name in names]
    drawn = {name: Visited(ends[against], ends[name]) for name in names if np.isfinite(ends[name][0])}
    for _, columns in result.chunks(asked):
        for name, visited in drawn.items():
            visited.add(columns[against], np.where(np.isfinite(columns[name]), columns[name], np.nan))
    return [_curve(name, (v.x, v.y), count, CELL_NOTE) for name, v in drawn.items()]


def of_frequency(result: Result, names: Sequence[str]) -> list[SignalCurve]:
    """Amplitude spectra; one signal is in memory at a time."""
    found: list[SignalCurve] = []
    for name in names:
        s = spectrum(result, name)
        highest = s.amplitude.max()
        above = np.flatnonzero(s.amplitude > WEAK * highest) if highest > 0.0 else np.array([], int)
        end = s.frequency[-1] if not len(above) else min(1.25 * s.frequency[above[-1]], s.frequency[-1])
        kept = ThinnedRows(["frequency", name], "frequency", POINTS, even=True)
        kept.add({"frequency": s.frequency[s.frequency <= end], name: s.amplitude[s.frequency <= end]})
        remarks = []
        if s.resampled:
            remarks.append(f"The times of {result.label} are not uniform: {name} is resampled {s.resampled}.")
        if s.segments > 1:
            remarks.append(f"Mean of {s.segments} segments that overlap by half.")
        found.append(_curve(name, kept.columns().values(), 0, "", remark=" ".join(remarks), frequency=float(end)))
    return found
