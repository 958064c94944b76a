"""The cells of a figure in colours: the edges of the cells, the colour of a value, and the bar that explains it."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from itertools import pairwise
from typing import TYPE_CHECKING

from mbdsl.plotting.axes import Axis, axis, coordinate
from mbdsl.plotting.escaping import escape

if TYPE_CHECKING:
    from mbdsl.plotting.figure_layout import Frame
    from mbdsl.plotting.svg import Canvas

BAR, BESIDE = 18.0, 26.0  #: width of the colour bar, and its distance from the frame [px]
LEVELS = 128  #: number of colours
MISSING = "#c9ced6"  #: cells without a value
#: the colour map "viridis" of Smith, van der Walt and Firing (CC0), at equal distances
VIRIDIS = (
    *("#440154", "#481a6c", "#472f7d", "#414487", "#39568c", "#31688e", "#2a788e", "#23888e", "#1f988b", "#22a884"),
    *("#35b779", "#54c568", "#7ad151", "#a5db36", "#d2e21b", "#fde725"),
)


def edges(values: Sequence[float], log: bool) -> list[float]:
    """Coordinates of the edges of the cells: the middles between values, and as far outside."""
    c = [coordinate(v, log) for v in values]
    if len(c) == 1:
        return [c[0] - 0.5, c[0] + 0.5]
    middles = [0.5 * (a + b) for a, b in pairwise(c)]
    return [2.0 * c[0] - middles[0], *middles, 2.0 * c[-1] - middles[-1]]


def _bar(values: Sequence[float]) -> Axis:
    low, high = (min(values), max(values)) if values else (0.0, 1.0)
    if high - low <= 1e-12 * max(abs(low), abs(high)):
        half = 0.5 * abs(low) or 1.0
        low, high = low - half, high + half
    return axis(low, high, False, 6)


def colour(place: float) -> str:
    """The colour of a place between 0 and 1; grey for nan."""
    return MISSING if not math.isfinite(place) else _level(min(LEVELS - 1, max(0, int(place * LEVELS))))


def _level(k: int) -> str:
    at = (k + 0.5) / LEVELS * (len(VIRIDIS) - 1)
    j = min(int(at), len(VIRIDIS) - 2)
    one, other = (bytes.fromhex(VIRIDIS[j + i][1:]) for i in (0, 1))
    return "#" + "".join(f"{round(a + (b - a) * (at - j)):02x}" for a, b in zip(one, other, strict=True))


def drawn(frame: Frame, c: Canvas) -> Iterator[str]:
    """The cells of a figure, and the colour bar to the right of its frame, as SVG."""
    shown = frame.figure.cells
    assert shown is not None
    xs, ys = (
        [place((e - along.low) / (along.high - along.low)) for e in edges(values, along.log)]
        for values, along, place in ((shown.x, frame.x, c.x), (shown.y, frame.y, c.y))
    )
    values = [v for row in shown.z for v in row if math.isfinite(v)]
    bar = _bar(values)
    cells: dict[str, list[str]] = {}
    for row, (y0, y1) in zip(shown.z, pairwise(ys), strict=True):
        for v, (x0, x1) in zip(row, pairwise(xs), strict=True):
            cell = f"M{min(x0, x1):.1f} {min(y0, y1):.1f}h{abs(x1 - x0):.1f}v{abs(y1 - y0):.1f}h{-abs(x1 - x0):.1f}z"
            cells.setdefault(colour(bar.place(v)), []).append(cell)
    for fill, boxes in cells.items():
        yield f'<path fill="{fill}" stroke="{fill}" stroke-width=".6" d="{"".join(boxes)}"/>'
    at, foot, part = c.x(1.0) + BESIDE, c.y(0.0), c.height / LEVELS
    if values:
        yield (
            f'<text class="label" x="{c.full - 4.0:.1f}" y="{c.label:.1f}" text-anchor="end">'
            f"{escape(bar.titled(shown.label))}</text>"
        )
        for k in range(LEVELS):
            yield f'<rect fill="{_level(k)}" x="{at:.1f}" y="{foot - part * (k + 1):.2f}" width="{BAR}" height="3.5"/>'
        ticks = "".join(f"M{at + BAR:.1f} {c.y(p):.1f}h5" for p, _ in bar.ticks)
        yield f'<path class="axis" d="{ticks}"/>'
        yield from (
            f'<text class="tick" x="{at + BAR + 9.0:.1f}" y="{c.y(p) + 4.5:.1f}" text-anchor="start">{label}</text>'
            for p, label in bar.ticks
        )
    if MISSING in cells:
        yield f'<rect fill="{MISSING}" x="{at:.1f}" y="{foot + 30.0:.1f}" width="{BAR}" height="12"/>'
        yield f'<text class="tick" x="{at + BAR + 9.0:.1f}" y="{foot + 40.0:.1f}" text-anchor="start">no value</text>'
