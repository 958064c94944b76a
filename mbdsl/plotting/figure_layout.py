"""The layout of a figure: the places of all points, marks and texts in the frame of the axes, for all renderers.

Places run from 0 to 1, from the left and from the bottom; nan is a gap.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import chain

from mbdsl.plotting.axes import Axis, axis, coordinate, limits, number
from mbdsl.plotting.cells import edges
from mbdsl.plotting.figures import Bars, Figure, Outcome, Series
from mbdsl.plotting.series_styles import DASHES, NEUTRAL, Look, looks

FLATTEST = 0.4  #: least ratio of height to width of the frame of equal axes
USUAL = 0.56  #: ratio of height to width of all other frames
TALL = 0.9  #: least ratio of narrow frames
PANEL = 0.45  #: the same of panels with a shared axis
ROWS = 6  #: largest number of rows of outcomes
LONGEST = 60  #: largest number of letters of an outcome's text
FAR = 0.3  #: part of the range, or decades: a floor that is further below is described in words instead of drawn
BELOW = 0.08  #: space for the text below the lowest floor, relative to the height of the frame
GAP = 0.012  #: space between marks and texts, relative to the width of the frame


@dataclass(frozen=True)
class Drawn:
    """A series with its look and its places; ``low`` and ``high`` are empty without a range."""

    series: Series
    look: Look
    x: list[float]
    y: list[float]
    low: list[float]
    high: list[float]


@dataclass
class Failures:
    """Outcomes of a series with the same text: their marks and the text, in one row above the frame."""

    outcomes: list[Outcome]
    look: Look
    x: list[float]
    text: str
    text_x: float = 0.0
    to_left: bool = False  #: the text ends at ``text_x``


@dataclass(frozen=True)
class PlotArea:
    """The result of ``lay_out``. ``rows`` of outcomes are ordered from the bottom; ``aspect`` is height over width."""

    figure: Figure
    x: Axis
    y: Axis
    drawn: list[Drawn]
    rows: list[list[Failures]] = field(default_factory=list)
    unplaced: int = 0  #: number of groups of outcomes that do not fit
    floors: list[tuple[float, str]] = field(default_factory=list)
    aspect: float = USUAL
    left_out: str = ""  #: sentences on values without a place on logarithmic axes, and on floors far below


def names(figures: Sequence[Figure | Bars]) -> list[str]:
    """The names that need a look, in the order of their first use."""
    return list(dict.fromkeys(chain.from_iterable(map(_names, figures))))


def looks_of(figures: Sequence[Figure | Bars], methods: Mapping[str, Look] | None = None) -> dict[str, Look]:
    """The looks of all series of figures on one page; ``methods`` as for :func:`looks`."""
    return looks(names(figures), methods, [_names(figure) for figure in figures])


def _names(figure: Figure | Bars) -> list[str]:
    if isinstance(figure, Bars):
        return [bar.name for bar in figure.bars]
    return [*(s.name for s in figure.series if _plain(s)), *(o.name for o in figure.outcomes)]


def lay_out(
    figure: Figure, known: Mapping[str, Look] | None = None, letter: float = 0.0085, narrow: bool = False
) -> PlotArea:
    """The layout of a figure.

    ``known`` are looks by name; ``letter`` is a letter's width relative to the frame's. A ``narrow`` frame has fewer
    ticks and is higher.
    """
    known = dict(known if known is not None else looks_of([figure]))
    guides = [s.name for s in figure.series if s.style == "guide"]
    thin = {name: replace(NEUTRAL, dash=DASHES[1 + k % (len(DASHES) - 1)]) for k, name in enumerate(guides)}
    special = {"guide": thin, "front": {s.name: NEUTRAL for s in figure.series}}
    x, y, aspect = _axes(figure, narrow)
    drawn = [_place(s, x, y, special.get(s.style, known)[s.name]) for s in figure.series]
    groups = _groups(figure.outcomes, x, known)
    rows, unplaced = _pack(groups, letter)
    floors, below = [], []
    for value, text in figure.floors:
        place = y.place(value)
        if place >= 0.0:
            floors.append((place, text))
        elif place < 0.0:
            below.append(f"Further below: {text} ({number(value, 2)}).")
    left_out = " ".join(filter(None, (_left_out(figure), *below)))
    return PlotArea(figure, x, y, drawn, rows, unplaced, sorted(floors), aspect, left_out)


def _plain(series: Series) -> bool:
    return series.style not in ("guide", "front")


def _axes(figure: Figure, narrow: bool = False) -> tuple[Axis, Axis, float]:
    if figure.like is not None:
        return _axes(figure.like, narrow)
    if figure.cells is not None:
        ends = [edges(values, log) for values, log in ((figure.cells.x, figure.x_log), (figure.cells.y, figure.y_log))]
        x, y = ((min(e), max(e)) for e in ends)
        return axis(*x, figure.x_log, 4 if narrow else 7), axis(*y, figure.y_log, 6), figure.aspect or USUAL
    counted = [s for s in figure.series if s.style != "guide"] or list(figure.series)
    shown = [
        (a, b)
        for s in counted
        for a, b in zip(s.x, s.y, strict=True)
        if not (math.isnan(coordinate(a, figure.x_log)) or math.isnan(coordinate(b, figure.y_log)))
    ]
    spreads = chain.from_iterable(edge for s in counted for edge in (s.low, s.high) if edge is not None and _plain(s))
    failed = [o.x for o in figure.outcomes if o.x is not None]
    lines_only = bool(counted) and all(s.style == "line" for s in counted) and not figure.equal
    x = limits(chain((a for a, _ in shown), failed), figure.x_log, pad=0.0 if lines_only else 0.04)
    y = _with_floors(figure, limits(chain((b for _, b in shown), spreads), figure.y_log, pad=0.06))
    x = x if figure.x_ends is None else limits(figure.x_ends, figure.x_log, pad=0.0)
    y = y if figure.y_ends is None else limits(figure.y_ends, figure.y_log, pad=0.0)
    least = 0.0 if not narrow else TALL if figure.x_ends is None else PANEL
    aspect = max(figure.aspect or USUAL, least)
    if figure.equal:
        dx, dy = x[1] - x[0], y[1] - y[0]
        aspect = min(1.0, max(FLATTEST, dy / dx))
        x, y = _widened(x, max(dx, dy / aspect)), _widened(y, max(dy, dx * aspect))
    x_axis = axis(*x, figure.x_log, 6 if narrow and figure.x_log else 9 if figure.x_log else 4 if narrow else 7)
    return x_axis, axis(*y, figure.y_log, 8 if figure.y_log else 6), aspect


def _widened(ends: tuple[float, float], size: float) -> tuple[float, float]:
    middle = 0.5 * (ends[0] + ends[1])
    return middle - 0.5 * size, middle + 0.5 * size


def _with_floors(figure: Figure, ends: tuple[float, float]) -> tuple[float, float]:
    """The range extended to floors that are not far, with space for the text below the lowest one."""
    far = ends[0] - max(FAR * (ends[1] - ends[0]), 1.0 if figure.y_log else 0.0)
    floors = [c for c in (coordinate(v, figure.y_log) for v, _ in figure.floors) if c >= far]
    if not floors:
        return ends
    low, high = min(ends[0], *floors), max(ends[1], *floors)
    return min(low, min(floors) - BELOW * (high - low)), high + (0.03 * (high - low) if high > ends[1] else 0.0)


def _place(series: Series, x: Axis, y: Axis, look: Look) -> Drawn:
    xs, ys = [x.place(v) for v in series.x], [y.place(v) for v in series.y]
    for k, (a, b) in enumerate(zip(xs, ys, strict=True)):
        if math.isnan(a) or math.isnan(b):
            xs[k] = ys[k] = math.nan
    low: list[float] = []
    high: list[float] = []
    if series.low is not None and series.high is not None:
        low = [_edge(y, v, p) for v, p in zip(series.low, ys, strict=True)]
        high = [_edge(y, v, p) for v, p in zip(series.high, ys, strict=True)]
    return Drawn(series, look, xs, ys, low, high)


def _edge(y: Axis, value: float, place: float) -> float:
    """Place of one end of a range: the point itself if the end is not given, the foot of the axis if it is zero."""
    value = float(value)
    if math.isnan(place):
        return math.nan
    if y.log and value <= 0.0:
        return 0.0
    found = y.place(value)
    return place if math.isnan(found) else found


def _groups(outcomes: Sequence[Outcome], x: Axis, known: Mapping[str, Look]) -> list[Failures]:
    """Groups of outcomes with the same name and text. Outcomes without x are marked at the right of the frame."""
    found: dict[tuple[str, str], Failures] = {}
    for outcome in outcomes:
        text = outcome.text if outcome.text.startswith(outcome.name) else f"{outcome.name}: {outcome.text}"
        group = found.setdefault((outcome.name, outcome.text), Failures([], known[outcome.name], [], text))
        place = math.nan if outcome.x is None else x.place(outcome.x)
        group.outcomes.append(outcome)
        group.x.append(1.0 + GAP if math.isnan(place) else place)
    return list(found.values())


def _pack(groups: Sequence[Failures], letter: float) -> tuple[list[list[Failures]], int]:
    """The groups in as few rows as possible without overlaps; texts are shortened to the available space."""
    rows: list[list[Failures]] = []
    taken: list[list[tuple[float, float]]] = []
    unplaced = 0
    for group in groups:
        first, last = min(group.x), max(group.x)
        right, left = 1.0 - last - GAP, first - GAP
        wanted = min(len(group.text), LONGEST) * letter
        group.to_left = wanted > right and left > right
        group.text = _shortened(group.text, int(min(wanted, max(left, right)) / letter + 0.5))
        group.text_x = first - GAP if group.to_left else last + GAP
        ends = (first, group.text_x + len(group.text) * letter)
        if group.to_left:
            ends = (group.text_x - len(group.text) * letter, last)
        fits = (k for k, others in enumerate(taken) if all(ends[1] + GAP < a or b + GAP < ends[0] for a, b in others))
        row = next(fits, len(rows))
        if row == ROWS:
            unplaced += 1
            continue
        if row == len(rows):
            rows.append([])
            taken.append([])
        rows[row].append(group)
        taken[row].append(ends)
    return rows, unplaced


def _shortened(text: str, length: int) -> str:
    text = " ".join(text.split())
    return text if len(text) <= length else text[: max(length - 1, 1)].rstrip() + "…"


def _left_out(figure: Figure) -> str:
    counts = {
        s.name: sum(
            math.isfinite(a) and math.isfinite(b) and ((figure.x_log and a <= 0) or (figure.y_log and b <= 0))
            for a, b in zip(s.x, s.y, strict=True)
        )
        for s in figure.series
        if _plain(s)
    }
    names = ", ".join(f"{name} ({count})" for name, count in counts.items() if count)
    return f"Zero or negative, so without a place on a logarithmic axis: {names}." if names else ""
