"""A laid-out figure as the SVG of a page, and as the data that the page's script shows on hovering.

Pages are not drawn by matplotlib, as pictures are: they work without it, use the reader's light or dark colour scheme
by classes of the style sheet, and their series and points can be hovered and hidden. docs/decisions/svg.md has the
measurements.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from itertools import pairwise
from typing import Any

from mbdsl.plotting.axes import number
from mbdsl.plotting.cells import LEVELS, MISSING, edges, level, scale
from mbdsl.plotting.cells import colour as cell_colour
from mbdsl.plotting.escaping import escape
from mbdsl.plotting.figure_layout import Drawn, PlotArea
from mbdsl.plotting.series_styles import MARKS

WIDTH = 860.0  #: size of the picture [px]; the page may scale it
NARROW = 400.0  #: the same of the picture for narrow windows
RIGHT, BOTTOM, ROW, HEAD = 22.0, 46.0, 19.0, 26.0
SCALE = 112.0  #: in place of RIGHT: the colour bar of cells with its labels
FIRST, SECOND = 15.0, 34.0  #: base lines of labels above the frame
TICK = 20.0  #: space below a frame that labels of ticks need
TALLEST = 560.0  #: frame of equal axes
BAR, BESIDE = 18.0, 26.0  #: width of the colour bar of cells, and its distance from the frame
LETTER = 6.7  #: width of a letter of the small text
LABEL = 7.2  #: width of a letter of the labels of axes
RADIUS = 4.2  #: radius of a mark
MANY = 150  #: number of marks above which they are dots
LONG, PART = 4096, 512  #: number of points of a line above which it is simplified in parts, of so many points
FLAT = 0.25  #: points of a line within this distance of the line without them are left out [px]
NEAR = 5.0  #: of many points, hovering shows those that are further than this from the previous one [px]


class Canvas:
    """The place of the frame on the picture; ``left`` is its least left margin, ``bottom`` is below the frame.

    ``full`` is the width of the picture.
    """

    def __init__(self, frame: PlotArea, left: float = 0.0, bottom: float = BOTTOM, full: float = WIDTH) -> None:
        self.full = full
        self.left = max(left, 16.0 + 7.5 * max((len(label) for _, label in frame.y.ticks), default=1))
        self.bottom = bottom
        cells = frame.figure.cells
        self.width = full - self.left - (RIGHT if cells is None else SCALE)
        self.height = self.width * frame.aspect
        if self.height > TALLEST:
            self.width, self.height = TALLEST / frame.aspect, TALLEST
        #: base line of the label of the cells, in a line of its own if it would meet that of the vertical axis
        self.label = FIRST if cells is None or LABEL * len(cells.label + frame.figure.y_label) < full - 24.0 else SECOND
        self.top = HEAD + ROW * len(frame.rows) + self.label - FIRST
        self.total = self.top + self.height + bottom

    def x(self, place: float) -> float:
        return self.left + self.width * place

    def y(self, place: float) -> float:
        return self.top + self.height * (1.0 - place)


def letter(full: float = WIDTH) -> float:
    """A letter's width relative to that of a usual frame, for the layout of texts."""
    return LETTER / (full - RIGHT - 50.0)


def picture(frame: PlotArea, key: str, classes: dict[str, str], canvas: Canvas | None = None) -> str:
    """``<svg>`` with title and description; ``classes`` are those of the page's style for each series' name."""
    canvas = canvas or Canvas(frame)
    figure = frame.figure
    kind = ' class="narrow"' if canvas.full == NARROW else ""
    parts = [
        f'<svg viewBox="0 0 {canvas.full:g} {canvas.total:.0f}"{kind} role="img" '
        f'aria-labelledby="{key}-title {key}-desc">',
        f'<title id="{key}-title">{escape(figure.title or figure.y_label)}</title>',
        f'<desc id="{key}-desc">{escape(description(frame))}</desc>',
        f'<clipPath id="{key}-clip"><rect x="{canvas.left:.1f}" y="{canvas.top - 1:.1f}" '
        f'width="{canvas.width:.1f}" height="{canvas.height + 2:.1f}"/></clipPath>',
        *_axes(frame, canvas),
    ]
    for depth in (0, 1, 2):
        if depth == 2:
            parts += _floor_texts(frame, canvas)
        for k, drawn in enumerate(frame.drawn):
            if BEHIND.get(drawn.series.style, 2) == depth:
                parts.append(f'<g class="series {colour(drawn, classes)}" data-series="{k}">')
                parts += _series(drawn, canvas, f"{key}-clip")
                parts.append("</g>")
    parts += _outcomes(frame, canvas, classes)
    parts.append('<circle class="ring" r="8" visibility="hidden"/></svg>')
    return "\n".join(parts)


#: style -> depth, for styles behind all other series
BEHIND = {"front": 0, "guide": 1}


def colour(drawn: Drawn, classes: dict[str, str]) -> str:
    """The CSS class that gives a series its colour."""
    return "neutral" if drawn.series.style in BEHIND else classes[drawn.series.name]


def description(frame: PlotArea) -> str:
    """A description of the figure in words."""
    figure = frame.figure
    kinds = {(True, True): "Both axes are logarithmic.", (True, False): "The horizontal axis is logarithmic."}
    kinds[False, True] = "The vertical axis is logarithmic."
    texts = [f"{figure.y_label} against {figure.x_label}.", kinds.get((figure.x_log, figure.y_log), "")]
    if figure.cells is not None:
        texts[0] = f"{figure.cells.label} against {figure.x_label} and {figure.y_label}."
    else:
        names = ", ".join(s.name for s in figure.series if s.name)
        texts.append(f"Series: {names}." if figure.series else "Empty.")
    texts += [f"Without a point: {o.name}: {o.text}." for o in figure.outcomes[:20]]
    return " ".join(filter(None, (*texts, figure.note)))


def swatch(drawn: Drawn) -> str:
    """The sample of the line and its mark in the legend."""
    style = drawn.series.style
    inside = []
    if style != "marks":
        kind = style if style in BEHIND else "line"
        inside.append(f'<path class="{kind}"{_dash(drawn)} d="M1 8H33"/>')
    if style in ("both", "marks"):
        inside.append(_mark(drawn, 17.0, 8.0))
    return f'<svg class="swatch" viewBox="0 0 34 16" aria-hidden="true">{"".join(inside)}</svg>'


def hover(frame: PlotArea, canvas: Canvas | None = None) -> dict[str, Any]:
    """Data of the script: labels, and for each series the points (px, py, x, y, spread, text)."""
    canvas = canvas or Canvas(frame)
    failed = [
        [
            round(canvas.x(p), 1),
            round(_row(canvas, k), 1),
            number(o.x) if o.x is not None else "",
            "",
            "",
            o.text,
            o.name,
        ]
        for k, row in enumerate(frame.rows)
        for group in row
        for p, o in zip(group.x, group.outcomes, strict=True)
    ]
    points = [[] if d.series.style == "guide" else list(_points(d, canvas)) for d in frame.drawn]
    return {
        "x": frame.figure.x_label,
        "y": frame.figure.y_label,
        "names": [d.series.name for d in frame.drawn],
        "points": points,
        "failed": failed,
    }


def _points(drawn: Drawn, canvas: Canvas) -> Iterator[list[Any]]:
    s = drawn.series
    for k in _told(drawn, canvas):
        spread = ""
        if s.low is not None and s.high is not None and math.isfinite(s.low[k]) and math.isfinite(s.high[k]):
            spread = f"{number(s.low[k])} … {number(s.high[k])}"
        text = s.hover[k] if s.hover is not None else ""
        place = [round(canvas.x(drawn.x[k]), 1), round(canvas.y(drawn.y[k]), 1)]
        yield [*place, number(s.x[k]), number(s.y[k]), spread, str(text)]


def _told(drawn: Drawn, c: Canvas) -> Iterator[int]:
    """The points that hovering shows: all if they are few, else those that are apart."""
    few = len(drawn.x) <= MANY
    last = (math.inf, math.inf)
    for k, (x, y) in enumerate(zip(drawn.x, drawn.y, strict=True)):
        at = c.width * x, c.height * y
        if not math.isnan(x) and (few or math.dist(at, last) >= NEAR):
            yield k
            last = at


def _pieces(drawn: Drawn) -> list[list[int]]:
    """The sequences of points between gaps."""
    pieces: list[list[int]] = [[]]
    for k, x in enumerate(drawn.x):
        if math.isnan(x):
            pieces.append([])
        else:
            pieces[-1].append(k)
    return [piece for piece in pieces if piece]


def _outline(drawn: Drawn, c: Canvas, piece: list[int]) -> list[int]:
    """The points of a sequence that its line needs: the others are within FLAT of it.

    Recursive division at the farthest point: Douglas and Peucker, Cartographica 10 (1973) 112.
    """
    import numpy as np

    if len(piece) <= MANY:
        return piece
    x = c.width * np.array([drawn.x[k] for k in piece])
    y = c.height * np.array([drawn.y[k] for k in piece])
    # the time grows with the square of the points if a curve goes up and down often: in parts if there are many
    ends = [*range(0, len(piece) - 1, PART if len(piece) > LONG else len(piece)), len(piece) - 1]
    keep, open_ = set(ends), list(pairwise(ends))
    while open_:
        a, b = open_.pop()
        if b - a < 2:
            continue
        dx, dy = x[a + 1 : b] - x[a], y[a + 1 : b] - y[a]
        ex, ey = x[b] - x[a], y[b] - y[a]
        size = ex * ex + ey * ey
        along = np.clip((dx * ex + dy * ey) / size, 0.0, 1.0) if size > 0.0 else 0.0
        off = np.hypot(dx - along * ex, dy - along * ey)
        farthest = int(off.argmax())
        if off[farthest] > FLAT:
            middle = a + 1 + farthest
            keep.add(middle)
            open_ += [(a, middle), (middle, b)]
    return [piece[k] for k in sorted(keep)]


def _text(x: float, y: float, text: str, kind: str, anchor: str = "start", most: float = math.inf) -> str:
    """A text; letters are narrower if it would be longer than ``most``."""
    fit = f' textLength="{most:.0f}" lengthAdjust="spacingAndGlyphs"' if len(text) * LABEL > most else ""
    return f'<text class="{kind}" x="{x:.1f}" y="{y:.1f}" text-anchor="{anchor}"{fit}>{escape(text)}</text>'


def _cells(frame: PlotArea, c: Canvas) -> Iterator[str]:
    """The cells of a figure, and the colour bar to the right of its frame, as SVG."""
    shown = frame.figure.cells
    assert shown is not None
    xs, ys = (
        [place((e - along.low) / (along.high - along.low)) for e in edges(values, along.log)]
        for values, along, place in ((shown.x, frame.x, c.x), (shown.y, frame.y, c.y))
    )
    values = [v for row in shown.z for v in row if math.isfinite(v)]
    bar = scale(values)
    cells: dict[str, list[str]] = {}
    for row, (y0, y1) in zip(shown.z, pairwise(ys), strict=True):
        for v, (x0, x1) in zip(row, pairwise(xs), strict=True):
            cell = f"M{min(x0, x1):.1f} {min(y0, y1):.1f}h{abs(x1 - x0):.1f}v{abs(y1 - y0):.1f}h{-abs(x1 - x0):.1f}z"
            cells.setdefault(cell_colour(bar.place(v)), []).append(cell)
    for fill, boxes in cells.items():
        yield f'<path fill="{fill}" stroke="{fill}" stroke-width=".6" d="{"".join(boxes)}"/>'
    bar_at, foot, part = c.x(1.0) + BESIDE, c.y(0.0), c.height / LEVELS
    if values:
        yield _text(c.full - 4.0, c.label, bar.titled(shown.label), "label", "end")
        for k in range(LEVELS):
            y = foot - part * (k + 1)
            yield f'<rect fill="{level(k)}" x="{bar_at:.1f}" y="{y:.2f}" width="{BAR}" height="{part + 0.5:.2f}"/>'
        yield f'<path class="axis" d="{"".join(f"M{bar_at + BAR:.1f} {c.y(p):.1f}h5" for p, _ in bar.ticks)}"/>'
        yield from (_text(bar_at + BAR + 9.0, c.y(p) + 4.5, label, "tick") for p, label in bar.ticks)
    if MISSING in cells:
        yield f'<rect fill="{MISSING}" x="{bar_at:.1f}" y="{foot + 30.0:.1f}" width="{BAR}" height="12"/>'
        yield _text(bar_at + BAR + 9.0, foot + 40.0, "no value", "tick")


def _axes(frame: PlotArea, c: Canvas) -> Iterator[str]:
    left, right, top, bottom = c.x(0.0), c.x(1.0), c.y(1.0), c.y(0.0)
    figure = frame.figure
    for place, _ in frame.floors[-1:]:
        yield (
            f'<rect class="floor" x="{left:.1f}" y="{c.y(place):.1f}" width="{c.width:.1f}" '
            f'height="{bottom - c.y(place):.1f}"/>'
        )
    if figure.cells is not None:
        yield from _cells(frame, c)
    lines = [f"M{c.x(p):.1f} {top:.1f}V{bottom:.1f}" for p, _ in frame.x.ticks if figure.cells is None]
    lines += [f"M{left:.1f} {c.y(p):.1f}H{right:.1f}" for p, _ in frame.y.ticks if figure.cells is None]
    yield f'<path class="grid" d="{"".join(lines)}"/>'
    ticks = [f"M{c.x(p):.1f} {bottom:.1f}v5" for p, _ in frame.x.ticks]
    ticks += [f"M{left:.1f} {c.y(p):.1f}h-5" for p, _ in frame.y.ticks]
    ticks += [f"M{c.x(p):.1f} {bottom:.1f}v3" for p in frame.x.minor]
    ticks += [f"M{left:.1f} {c.y(p):.1f}h-3" for p in frame.y.minor]
    over = f"M{left:.1f} {top:.1f}H{right:.1f}" if frame.rows else ""
    yield f'<path class="axis" d="M{left:.1f} {top:.1f}V{bottom:.1f}H{right:.1f}{over}{"".join(ticks)}"/>'
    for place, label in frame.x.ticks if c.bottom > TICK else ():
        yield _text(c.x(place), bottom + 19.0, label, "tick", "middle")
    for place, label in frame.y.ticks:
        yield _text(left - 8.0, c.y(place) + 4.5, label, "tick", "end")
    if c.bottom >= BOTTOM:
        label = frame.x.titled(figure.x_label)
        half = 0.5 * LABEL * len(label)
        middle = min(c.x(0.5), c.full - 4.0 - half) if 2.0 * half < c.full - 8.0 else 0.5 * c.full
        yield _text(middle, c.total - 6.0, label, "label", "middle", c.full - 8.0)
    yield _text(2.0, FIRST, frame.y.titled(figure.y_label), "label", "start", c.full - 4.0)
    for place, _ in frame.floors:
        yield f'<path class="floor-line" d="M{left:.1f} {c.y(place):.1f}H{right:.1f}"/>'


def _floor_texts(frame: PlotArea, c: Canvas) -> Iterator[str]:
    """Labels below their lines, right and left in alternation; above guides, which may cross them."""
    for k, (place, text) in enumerate(frame.floors):
        at, anchor = (c.x(1.0) - 5.0, "end") if k % 2 == 0 else (c.x(0.0) + 6.0, "start")
        yield _text(at, c.y(place) + 14.0, text, "small on-floor", anchor, c.width - 12.0)


def _series(drawn: Drawn, c: Canvas, clip: str) -> Iterator[str]:
    style = drawn.series.style
    pieces = _pieces(drawn)
    points = [k for piece in pieces for k in piece]
    if drawn.high and style == "line":
        yield f'<path class="band" clip-path="url(#{clip})" d="{"".join(_band(drawn, p, c) for p in pieces)}"/>'
    elif drawn.high:
        ends = "".join(f"M{c.x(drawn.x[k]):.1f} {c.y(drawn.low[k]):.1f}V{c.y(drawn.high[k]):.1f}" for k in points)
        yield f'<path class="spread" clip-path="url(#{clip})" d="{ends}"/>'
    if style != "marks":
        kind = style if style in BEHIND else "line"
        line = "".join(_line(drawn, _outline(drawn, c, piece), c) for piece in pieces)
        yield f'<path class="{kind}" clip-path="url(#{clip})"{_dash(drawn)} d="{line}"/>'
    if style not in ("both", "marks"):
        return
    if len(points) > MANY:
        dots = dict.fromkeys(
            f"M{round(c.x(drawn.x[k]) * 2) / 2:g} {round(c.y(drawn.y[k]) * 2) / 2:g}h0" for k in points
        )
        yield f'<path class="dots" d="{"".join(dots)}"/>'
    else:
        yield from (_mark(drawn, c.x(drawn.x[k]), c.y(drawn.y[k])) for k in points)


def _line(drawn: Drawn, points: list[int], c: Canvas) -> str:
    return "M" + "L".join(f"{c.x(drawn.x[k]):.1f} {c.y(drawn.y[k]):.1f}" for k in points)


def _band(drawn: Drawn, points: list[int], c: Canvas) -> str:
    """The outline: along the upper edge, and back along the lower one."""
    up = [f"{c.x(drawn.x[k]):.1f} {c.y(drawn.high[k]):.1f}" for k in points]
    down = [f"{c.x(drawn.x[k]):.1f} {c.y(drawn.low[k]):.1f}" for k in reversed(points)]
    return f"M{'L'.join(up + down)}Z"


def _dash(drawn: Drawn) -> str:
    dash = drawn.look.dash
    return f' stroke-dasharray="{" ".join(f"{d * 1.3:g}" for d in dash)}"' if dash else ""


def _mark(drawn: Drawn, x: float, y: float) -> str:
    kind = "mark" if drawn.look.filled else "mark hollow"
    corners = MARKS[drawn.look.mark]
    if not corners:
        return f'<circle class="{kind}" cx="{x:.1f}" cy="{y:.1f}" r="{RADIUS}"/>'
    ends = "L".join(f"{x + RADIUS * a:.1f} {y + RADIUS * b:.1f}" for a, b in corners)
    return f'<path class="{kind}" d="M{ends}Z"/>'


def _row(c: Canvas, k: int) -> float:
    return c.top - ROW * (k + 0.5)


def _outcomes(frame: PlotArea, c: Canvas, classes: dict[str, str]) -> Iterator[str]:
    for k, row in enumerate(frame.rows):
        y = _row(c, k)
        for group in row:
            name = group.outcomes[0].name
            where = [j for j, d in enumerate(frame.drawn) if d.series.name == name]
            yield f'<g class="outcome {classes[name]}"{f" data-series={chr(34)}{where[0]}{chr(34)}" if where else ""}>'
            crosses = "".join(f"M{c.x(p) - 4:.1f} {y - 4:.1f}l8 8m-8 0l8 -8" for p in group.x)
            yield f'<path class="cross" d="{crosses}"/>'
            yield _text(c.x(group.text_x), y + 4.0, group.text, "small", "end" if group.to_left else "start")
            yield "</g>"
