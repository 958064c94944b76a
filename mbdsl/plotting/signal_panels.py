"""The panels of a plot: one figure a unit, several for angles that turn and others; axis and looks."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from mbdsl.messages import OWN, DisplayUnit, UnitsOfSignals
from mbdsl.plotting.curves import SignalCurve, is_held
from mbdsl.plotting.figures import Figure, Series
from mbdsl.plotting.series_styles import DASHES, NEUTRAL, OTHERS, Look
from mbdsl.results.stored import Result

QUANTITIES = {
    "m": "length",
    "rad": "angle",
    "m/s": "velocity",
    "rad/s": "angular velocity",
    "m/s2": "acceleration",
    "rad/s2": "angular acceleration",
    "N": "force",
    "N.m": "torque",
    "J": "energy",
    "W": "power",
    "s": "duration",
}
ASPECTS = {1: 0.5, 2: 0.34}  #: number of panels -> height of a panel over its width
FLAT = 0.26  #: the same for more panels
MARGIN = 0.04  #: space beside a phase plot, over its range
#: angles whose range is above a turn [rad], and this many times that of others, have a panel of their own
TURN, WIDER = 2.0 * np.pi, 5.0
NAMED = 3  #: lines of a model that the legend names for the events of a kind
LINES = 12  #: events up to which their lines cross the panel
BETWEEN = "peak between outputs"  #: name of the marks of peaks that outputs cut
FLOOR = 1e-4  #: lowest amplitude of a spectrum that is shown, over the largest of its panel


@dataclass(frozen=True)
class Horizontal:
    """The horizontal axis: its label and unit, and whether it is that of a signal."""

    label: str
    unit: str
    signal: bool = False

    def shown(self, display: UnitsOfSignals) -> DisplayUnit:
        """The unit in which it is displayed."""
        return display.of(self.unit, self.label)


def panels(
    curves: Sequence[SignalCurve], units: Mapping[str, str], x: Horizontal, several: bool, display: UnitsOfSignals = OWN
) -> tuple[tuple[Figure, ...], dict[str, Look]]:
    """The panels from the top, and the looks by the names of their series.

    Parameters
    ----------
    curves : sequence of SignalCurve
        The curves of all panels.
    units : mapping
        Signal -> unit.
    x : Horizontal
        The horizontal axis.
    several : bool
        Whether there are several results; names then contain that of the result.
    display : UnitsOfSignals, optional
        The units in which values are displayed; those of the curves are in ``units``.

    Returns
    -------
    panels : tuple of Figure
    looks : dict
    """
    level = _levels(curves, units)
    along = x.shown(display)
    by_unit: dict[tuple[str, DisplayUnit, int], list[SignalCurve]] = {}
    for curve in curves:
        unit = units[curve.name]
        by_unit.setdefault((unit, display.of(unit, curve.name), level.get(curve.name, 0)), []).append(curve)
    equal = x.signal and x.unit == "m" and set(by_unit) == {("m", along, 0)}
    ends = None if equal else _ends(curves, x, along.factor)
    aspect = None if equal else ASPECTS.get(len(by_unit), FLAT)
    looks: dict[str, Look] = {}
    found = []
    for k, ((unit, own, _), shown) in enumerate(by_unit.items()):
        order = {name: j for j, name in enumerate(dict.fromkeys(curve.name for curve in shown))}
        series = []
        for curve in shown:
            name = f"{curve.name}, {curve.label}" if several else curve.name
            looks[name] = look(order[curve.name], curve.result)
            style = "line" if len(curve.x) > 1 else "marks"
            points = curve.x / along.factor, curve.y / own.factor
            series.append(Series(name, points[0].tolist(), points[1].tolist(), style=style))
        highest = max((curve.largest / own.factor for curve in shown if curve.frequency), default=0.0)
        figure = Figure(
            f"panel-{k}",
            "",
            labelled(x.label, along.symbol),
            labelled(_quantity(list(order), unit), own.symbol),
            series,
            x_log=False,
            y_log=highest > 0.0,
            equal=equal,
            x_ends=ends,
            y_ends=(FLOOR * highest, 2.0 * highest) if highest > 0.0 else None,
            aspect=aspect,
        )
        found.append(figure)
    return tuple(found), looks


def with_peaks(
    figures: Sequence[Figure],
    results: Sequence[Result],
    labels: Sequence[str],
    chosen: Sequence[str],
    display: UnitsOfSignals = OWN,
) -> tuple[tuple[Figure, ...], dict[str, Look]]:
    """The panels with marks at the peaks that the rows of results cut, and the looks of these marks."""
    peaks: dict[str, list] = {}
    for result, label in zip(results, labels, strict=True):
        for peak in result.cut_peaks([name for name in chosen if name in result.names]):
            name = f"{peak.signal}, {label}" if len(results) > 1 else peak.signal
            peaks.setdefault(name, []).append(peak)
    found = []
    for figure in figures:
        own = [peak for series in figure.series for peak in peaks.get(series.name, ())]
        if own:
            second = display.of("s", "time").factor
            x, texts = [p.time / second for p in own], [p.text(display) for p in own]
            y = [p.value / display.of(p.unit, p.signal).factor for p in own]
            marks = Series(BETWEEN, x, y, hover=texts, style="marks")
            figure = replace(figure, series=[*figure.series, marks])
        found.append(figure)
    return tuple(found), {BETWEEN: NEUTRAL} if peaks else {}


def with_events(
    figures: Sequence[Figure], results: Sequence[Result], labels: Sequence[str], display: UnitsOfSignals = OWN
) -> tuple[tuple[Figure, ...], int]:
    """The panels with lines at the times of events, and the number of ticks of clocks that have none."""
    second, found, ticks = display.of("s", "time").factor, dict[str, list[float]](), 0
    ends = [x * second for x in figures[0].x_ends or (0.0, 0.0)] if figures else [0.0, 0.0]
    for result, label in zip(results, labels, strict=True):
        marks, unmarked = result.events(*ends)
        ticks += unmarked
        for kind in dict.fromkeys(mark.kind for mark in marks):
            own = [mark for mark in marks if mark.kind == kind]
            lines = dict.fromkeys(mark.line for mark in own)
            name = f"{kind} ({'lines' if len(lines) > 1 else 'line'} {', '.join(lines)})"
            name = name if all(lines) and len(lines) <= NAMED else kind
            name = f"{name}, {label}" if len(results) > 1 else name
            found.setdefault(name, []).extend(mark.t / second for mark in own)
    return tuple(replace(x, series=[*x.series, *_lines(x, found)]) for x in figures), ticks


def _lines(figure: Figure, times: Mapping[str, Sequence[float]]) -> Iterator[Series]:
    """Vertical lines across a panel; short ones at its foot if there are many."""
    y = np.concatenate([np.asarray(series.y, float) for series in figure.series] or [np.zeros(1)])
    y = y[np.isfinite(y)]
    low, high = (float(y.min()), float(y.max())) if len(y) else (0.0, 1.0)
    size = (high - low) or abs(high) or 1.0
    few = sum(map(len, times.values())) <= LINES
    top = high + size if few else low
    for name, own in times.items():
        x = [a for t in own for a in (t, t, np.nan)]
        yield Series(name, x, [low - size, top, np.nan] * len(own), style="guide")


def _levels(curves: Sequence[SignalCurve], units: Mapping[str, str]) -> dict[str, int]:
    """The panels of angles by their ranges, from 0: beside one that turns many times, others would be flat lines; and
    those of flags and counters, which are separate from other values without a unit."""
    ranges: dict[str, float] = {}
    flags = {curve.name: 1 for curve in curves if not units[curve.name] and not curve.frequency and is_held(curve.y)}
    for curve in curves:
        if units[curve.name] == "rad" and not curve.frequency:
            ranges[curve.name] = max(ranges.get(curve.name, 0.0), curve.spread)
    found, level, widest = flags, 0, 0.0
    for name, width in sorted(ranges.items(), key=lambda item: -item[1]):
        if widest > TURN and WIDER * width < widest:
            level, widest = level + 1, width
        found[name], widest = level, max(widest, width)
    return found


def look(signal: int, result: int) -> Look:
    """Colour and mark of the ``signal``-th signal of a panel, and the dashes of the ``result``-th result."""
    turn, place = divmod(signal, len(OTHERS))
    return replace(OTHERS[place], dash=DASHES[(result + turn) % len(DASHES)])


def labelled(text: str, unit: str) -> str:
    """A label with its unit."""
    return f"{text} [{unit}]".strip() if unit else text


def _ends(curves: Sequence[SignalCurve], x: Horizontal, factor: float) -> tuple[float, float]:
    """The range of the horizontal axis of all panels."""
    if any(curve.frequency for curve in curves):
        return 0.0, max(curve.frequency for curve in curves)
    finite = [values[np.isfinite(values)] / factor for values in (curve.x for curve in curves)]
    finite = [values for values in finite if len(values)] or [np.array([0.0, 1.0])]
    low, high = float(min(v.min() for v in finite)), float(max(v.max() for v in finite))
    space = MARGIN * (high - low) if x.signal else 0.0
    return low - space, high + space


def _quantity(names: Sequence[str], unit: str) -> str:
    """A label for several signals: their name, the last part of their names if it is common, or the quantity."""
    if len(names) == 1:
        return names[0]
    keys = {name.rpartition(".")[2] for name in names}
    if keys <= {"p0", "p1", "p2", "p3"}:
        return "quaternion"
    return keys.pop() if len(keys) == 1 else QUANTITIES.get(unit, "value" if not unit else "")
