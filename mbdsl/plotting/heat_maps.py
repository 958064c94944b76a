"""Maps: a quantity over two parameters as coloured cells, laid out once and drawn to SVG, PNG and PDF."""

from __future__ import annotations

import math
import os
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

from mbdsl.plotting.axes import Axis, axis, coordinate
from mbdsl.plotting.escaping import escape
from mbdsl.plotting.figures import HeatMap
from mbdsl.plotting.picture_files import written

WIDTH, HEIGHT = 860.0, 430.0  #: of one map [px]
LEFT, RIGHT, TOP, BOTTOM = 84.0, 150.0, 30.0, 50.0  #: around the frame
BAR = 18.0  #: width of the colour bar
LEVELS = 128  #: number of colours
MISSING = "#c9ced6"  #: cells without a value
INK, PALE = "#1f2328", "#57606a"
DPI = 150.0
#: the colour map "viridis" of Smith, van der Walt and Firing (CC0), at equal distances
VIRIDIS = (
    *("#440154", "#481a6c", "#472f7d", "#414487", "#39568c", "#31688e", "#2a788e", "#23888e", "#1f988b", "#22a884"),
    *("#35b779", "#54c568", "#7ad151", "#a5db36", "#d2e21b", "#fde725"),
)


@dataclass(frozen=True)
class Area:
    """Rectangles (x, y, width, height) of one colour [px]."""

    colour: str
    cells: tuple[tuple[float, float, float, float], ...]


@dataclass(frozen=True)
class Lines:
    """Straight lines (x1, y1, x2, y2) [px]."""

    lines: tuple[tuple[float, float, float, float], ...]


@dataclass(frozen=True)
class Label:
    """A text at a place [px]; ``kind`` is "label", "tick" or "title", ``anchor`` that of SVG."""

    x: float
    y: float
    text: str
    kind: str = "label"
    anchor: str = "start"


Item = Area | Lines | Label


def lay_out(shown: HeatMap, top: float = 0.0) -> Iterator[Item]:
    """The items of a map whose upper edge is at ``top`` [px]."""
    x, y = (_axis(v, log, n) for v, log, n in ((shown.x, shown.x_log, 7), (shown.y, shown.y_log, 6)))
    width, height = WIDTH - LEFT - RIGHT, HEIGHT - TOP - BOTTOM
    foot = top + TOP + height
    xs = [LEFT + width * p for p in _edges(shown.x, x)]
    ys = [foot - height * p for p in _edges(shown.y, y)]
    values = [v for row in shown.z for v in row if math.isfinite(v)]
    bar = _bar(values)
    cells: dict[str, list[tuple[float, float, float, float]]] = {}
    for row, (y0, y1) in zip(shown.z, pairwise(ys), strict=True):
        for v, (x0, x1) in zip(row, pairwise(xs), strict=True):
            box = (min(x0, x1), min(y0, y1), abs(x1 - x0), abs(y1 - y0))
            cells.setdefault(colour(bar.place(v)), []).append(box)
    yield from (Area(c, tuple(boxes)) for c, boxes in cells.items())
    yield Label(2.0, top + 15.0, y.titled(shown.y_label))
    ticks = [(LEFT + width * p, foot, LEFT + width * p, foot + 5.0) for p, _ in x.ticks]
    ticks += [(LEFT - 5.0, foot - height * p, LEFT, foot - height * p) for p, _ in y.ticks]
    frame = [(LEFT, top + TOP, LEFT, foot), (LEFT, foot, LEFT + width, foot)]
    yield from (Label(LEFT + width * p, foot + 19.0, text, "tick", "middle") for p, text in x.ticks)
    yield from (Label(LEFT - 8.0, foot - height * p + 4.5, text, "tick", "end") for p, text in y.ticks)
    yield Label(LEFT + width / 2, foot + 42.0, x.titled(shown.x_label), "label", "middle")
    at = WIDTH - RIGHT + 26.0
    if values:
        yield Label(WIDTH - 4.0, top + 15.0, bar.titled(shown.z_label), "label", "end")
        part = height / LEVELS
        for k in range(LEVELS):
            yield Area(_level(k), ((at, foot - part * (k + 1), BAR, part),))
        ticks += [(at + BAR, foot - height * p, at + BAR + 5.0, foot - height * p) for p, _ in bar.ticks]
        yield from (Label(at + BAR + 9.0, foot - height * p + 4.5, text, "tick") for p, text in bar.ticks)
    if MISSING in cells:
        yield Area(MISSING, ((at, foot + 30.0, BAR, 12.0),))
        yield Label(at + BAR + 9.0, foot + 40.0, "no value", "tick")
    yield Lines((*frame, *ticks))


def _axis(values: Sequence[float], log: bool, wanted: int) -> Axis:
    edges = _cell_edges(values, log)
    return axis(min(edges), max(edges), log, wanted)


def _cell_edges(values: Sequence[float], log: bool) -> list[float]:
    """Coordinates of the edges of the cells: the middles between values, and as far outside."""
    c = [coordinate(v, log) for v in values]
    if len(c) == 1:
        return [c[0] - 0.5, c[0] + 0.5]
    middles = [0.5 * (a + b) for a, b in pairwise(c)]
    return [2.0 * c[0] - middles[0], *middles, 2.0 * c[-1] - middles[-1]]


def _edges(values: Sequence[float], along: Axis) -> list[float]:
    return [(c - along.low) / (along.high - along.low) for c in _cell_edges(values, along.log)]


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


# -- files -------------------------------------------------------------------------------------------------------------

STYLE = f"""\
text {{ fill: {INK}; font: 13px system-ui, "Segoe UI", "DejaVu Sans", sans-serif; }}
.title {{ font-size: 16px; font-weight: 700; }}
.tick {{ font-size: 12.5px; font-variant-numeric: tabular-nums; }}
.axis {{ stroke: {PALE}; fill: none; }}
"""
HEAD, NOTE = 34.0, 17.0  #: height of the title and of a line of the notes


def sheet(maps: Sequence[HeatMap], title: str, notes: Sequence[str]) -> tuple[list[Item], float]:
    """The items of maps one below the other, with a title and notes, and the height [px]."""
    items: list[Item] = [Label(2.0, 20.0, title, "title")]
    top = HEAD
    for shown in maps:
        if shown.title:
            items.append(Label(2.0, top + 13.0, shown.title, "label"))
            top += 20.0
        items += lay_out(shown, top)
        top += HEIGHT
    for line in notes:
        top += NOTE
        items.append(Label(2.0, top, line, "tick"))
    return items, top + 12.0


def svg(maps: Sequence[HeatMap], title: str, notes: Sequence[str] = ()) -> str:
    """Maps as the text of one SVG file, on white paper."""
    items, height = sheet(maps, title, notes)
    size = f'viewBox="0 0 {WIDTH:g} {height:.0f}" width="{WIDTH:g}" height="{height:.0f}"'
    paper = '<rect width="100%" height="100%" fill="#ffffff"/>'
    head = f'<svg xmlns="http://www.w3.org/2000/svg" {size}>\n<title>{escape(title)}</title>\n<style>\n{STYLE}</style>'
    return "\n".join((head, paper, *map(_element, items), "</svg>\n"))


def figure(shown: HeatMap) -> str:
    """A map as an element of a page with the style ``page.css``."""
    said = f"{shown.z_label} against {shown.x_label} and {shown.y_label}."
    head = f'<svg viewBox="0 0 {WIDTH:g} {HEIGHT:g}" role="img" aria-label="{escape(said)}">'
    heading = f"<h2>{escape(shown.title)}</h2>" if shown.title else ""
    inside = "\n".join(map(_element, lay_out(shown)))
    caption = f"<figcaption>{heading}</figcaption>"
    return f'<figure>\n{caption}\n<div class="scroll">\n{head}\n{inside}\n</svg>\n</div>\n</figure>'


def _element(item: Item) -> str:
    if isinstance(item, Area):
        cells = "".join(f"M{x:.1f} {y:.1f}h{w:.1f}v{h:.1f}h{-w:.1f}z" for x, y, w, h in item.cells)
        return f'<path fill="{item.colour}" stroke="{item.colour}" stroke-width=".6" d="{cells}"/>'
    if isinstance(item, Lines):
        lines = "".join(f"M{a:.1f} {b:.1f}L{c:.1f} {d:.1f}" for a, b, c, d in item.lines)
        return f'<path class="axis" d="{lines}"/>'
    place = f'x="{item.x:.1f}" y="{item.y:.1f}" text-anchor="{item.anchor}"'
    return f'<text class="{item.kind}" {place}>{escape(item.text)}</text>'


def draw(maps: Sequence[HeatMap], path: str | os.PathLike, title: str, notes: Sequence[str] = ()) -> None:
    """Draw maps to a PNG or PDF file by matplotlib.

    Raises
    ------
    UsageError
        If the file cannot be written, or matplotlib is not installed.
    """
    items, height = sheet(maps, title, notes)
    look = {"font.family": ["DejaVu Sans"], "text.color": INK}
    with written(path, (WIDTH / 96, height / 96), DPI, look, ".svg and .html") as picture:
        ax = picture.add_axes((0.0, 0.0, 1.0, 1.0))
        ax.set(xlim=(0.0, WIDTH), ylim=(height, 0.0))
        ax.set_axis_off()
        for item in items:
            _shape(ax, item)


def _shape(ax: Any, item: Item) -> None:
    from matplotlib.collections import LineCollection, PolyCollection

    if isinstance(item, Area):
        corners = [[(x, y), (x + w, y), (x + w, y + h), (x, y + h)] for x, y, w, h in item.cells]
        ax.add_collection(PolyCollection(corners, facecolors=item.colour, edgecolors=item.colour, linewidths=0.5))
    elif isinstance(item, Lines):
        ax.add_collection(LineCollection([[(a, b), (c, d)] for a, b, c, d in item.lines], colors=PALE, linewidths=0.75))
    else:
        size = {"title": 11.5, "tick": 9.2}.get(item.kind, 9.75)
        side = {"start": "left", "middle": "center", "end": "right"}[item.anchor]
        weight = "bold" if item.kind == "title" else "normal"
        ax.text(item.x, item.y, item.text, fontsize=size, ha=side, va="baseline", weight=weight)
