"""A laid-out figure as the SVG of a page, and as the data that the page's script shows on hovering."""

from __future__ import annotations

import math
from collections.abc import Iterator
from html import escape
from typing import Any

from mbdsl.plotting.axes import number
from mbdsl.plotting.frames import Drawn, Frame
from mbdsl.plotting.looks import MARKS

WIDTH = 860.0  #: of the picture [px]; the page may scale it
RIGHT, BOTTOM, ROW, HEAD = 22.0, 46.0, 19.0, 26.0
TALLEST = 560.0  #: frame of equal axes
LETTER = 6.7  #: width of a letter of the small text
RADIUS = 4.2  #: of a mark
MANY = 150  #: marks; beyond them they are dots
NEAR = 0.4  #: points of a line closer than this to the one before are left out [px]


class Canvas:
    """Where the frame of the axes is on the picture."""

    def __init__(self, frame: Frame) -> None:
        self.left = 16.0 + 7.5 * max((len(label) for _, label in frame.y.ticks), default=1)
        self.width = WIDTH - self.left - RIGHT
        self.height = self.width * frame.aspect
        if self.height > TALLEST:
            self.width, self.height = TALLEST / frame.aspect, TALLEST
        self.top = HEAD + ROW * len(frame.rows)
        self.total = self.top + self.height + BOTTOM

    def x(self, place: float) -> float:
        return self.left + self.width * place

    def y(self, place: float) -> float:
        return self.top + self.height * (1.0 - place)


def letter() -> float:
    """A letter's width over that of a usual frame, for the layout of texts."""
    return LETTER / (WIDTH - RIGHT - 50.0)


def picture(frame: Frame, key: str, classes: dict[str, str]) -> str:
    """``<svg>`` with title and description; ``classes`` are those of the page's style for each series' name."""
    canvas = Canvas(frame)
    figure = frame.figure
    parts = [
        f'<svg viewBox="0 0 {WIDTH:g} {canvas.total:.0f}" role="img" aria-labelledby="{key}-title {key}-desc">',
        f'<title id="{key}-title">{escape(figure.title)}</title>',
        f'<desc id="{key}-desc">{escape(description(frame))}</desc>',
        f'<clipPath id="{key}-clip"><rect x="{canvas.left:.1f}" y="{canvas.top - 1:.1f}" '
        f'width="{canvas.width:.1f}" height="{canvas.height + 2:.1f}"/></clipPath>',
        *_axes(frame, canvas),
    ]
    order = sorted(range(len(frame.drawn)), key=lambda k: BEHIND.get(frame.drawn[k].series.style, 2))
    for k in order:
        drawn = frame.drawn[k]
        parts.append(f'<g class="series {colour(drawn, classes)}" data-series="{k}">')
        parts += _series(drawn, canvas, f"{key}-clip")
        parts.append("</g>")
    parts += _outcomes(frame, canvas, classes)
    parts.append('<circle class="ring" r="8" visibility="hidden"/></svg>')
    return "\n".join(parts)


#: style -> depth of what lies behind all other series
BEHIND = {"front": 0, "guide": 1}


def colour(drawn: Drawn, classes: dict[str, str]) -> str:
    """The class of the page's style that gives a series its colour."""
    return "neutral" if drawn.series.style in BEHIND else classes[drawn.series.name]


def description(frame: Frame) -> str:
    """The figure in words."""
    figure = frame.figure
    kinds = {(True, True): "Both axes are logarithmic.", (True, False): "The horizontal axis is logarithmic."}
    kinds[False, True] = "The vertical axis is logarithmic."
    told = [f"{figure.y_label} against {figure.x_label}.", kinds.get((figure.x_log, figure.y_log), "")]
    told.append("Series: " + ", ".join(s.name for s in figure.series if s.name) + "." if figure.series else "Empty.")
    told += [f"Without a point: {o.name}: {o.text}." for o in figure.outcomes[:20]]
    return " ".join(filter(None, (*told, figure.note)))


def swatch(drawn: Drawn) -> str:
    """The piece of line, with its mark, that stands in the legend."""
    style = drawn.series.style
    inside = []
    if style != "marks":
        kind = style if style in ("front", "guide") else "line"
        inside.append(f'<path class="{kind}"{_dash(drawn)} d="M1 8H33"/>')
    if style in ("both", "marks"):
        inside.append(_mark(drawn, 17.0, 8.0))
    return f'<svg class="swatch" viewBox="0 0 34 16" aria-hidden="true">{"".join(inside)}</svg>'


def hover(frame: Frame) -> dict[str, Any]:
    """What the script shows: labels, and for each series the points (px, py, x, y, spread, text)."""
    canvas = Canvas(frame)
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
    for k in _kept(drawn, canvas):
        if math.isnan(drawn.x[k]):
            continue
        spread = ""
        if s.low is not None and s.high is not None and math.isfinite(s.low[k]) and math.isfinite(s.high[k]):
            spread = f"{number(s.low[k])} … {number(s.high[k])}"
        text = s.hover[k] if s.hover is not None else ""
        place = [round(canvas.x(drawn.x[k]), 1), round(canvas.y(drawn.y[k]), 1)]
        yield [*place, number(s.x[k]), number(s.y[k]), spread, str(text)]


def _kept(drawn: Drawn, canvas: Canvas) -> list[int]:
    """The points that are drawn: without those that cannot be told from the one before. A gap is kept."""
    kept: list[int] = []
    last = (math.nan, math.nan)
    few = len(drawn.x) <= MANY
    for k, (x, y) in enumerate(zip(drawn.x, drawn.y, strict=True)):
        at = canvas.width * x, canvas.height * y
        if few or not (abs(at[0] - last[0]) < NEAR and abs(at[1] - last[1]) < NEAR) or k == len(drawn.x) - 1:
            if math.isnan(x) and kept and math.isnan(drawn.x[kept[-1]]):
                continue
            kept.append(k)
            last = at
    return kept


def _text(x: float, y: float, text: str, kind: str, anchor: str = "start") -> str:
    return f'<text class="{kind}" x="{x:.1f}" y="{y:.1f}" text-anchor="{anchor}">{escape(text)}</text>'


def _axes(frame: Frame, c: Canvas) -> Iterator[str]:
    left, right, top, bottom = c.x(0.0), c.x(1.0), c.y(1.0), c.y(0.0)
    figure = frame.figure
    for place, _ in frame.floors[-1:]:
        yield (
            f'<rect class="floor" x="{left:.1f}" y="{c.y(place):.1f}" width="{c.width:.1f}" '
            f'height="{bottom - c.y(place):.1f}"/>'
        )
    lines = [f"M{c.x(p):.1f} {top:.1f}V{bottom:.1f}" for p, _ in frame.x.ticks]
    lines += [f"M{left:.1f} {c.y(p):.1f}H{right:.1f}" for p, _ in frame.y.ticks]
    yield f'<path class="grid" d="{"".join(lines)}"/>'
    ticks = [f"M{c.x(p):.1f} {bottom:.1f}v5" for p, _ in frame.x.ticks]
    ticks += [f"M{left:.1f} {c.y(p):.1f}h-5" for p, _ in frame.y.ticks]
    ticks += [f"M{c.x(p):.1f} {bottom:.1f}v3" for p in frame.x.minor]
    ticks += [f"M{left:.1f} {c.y(p):.1f}h-3" for p in frame.y.minor]
    over = f"M{left:.1f} {top:.1f}H{right:.1f}" if frame.rows else ""
    yield f'<path class="axis" d="M{left:.1f} {top:.1f}V{bottom:.1f}H{right:.1f}{over}{"".join(ticks)}"/>'
    for place, label in frame.x.ticks:
        yield _text(c.x(place), bottom + 19.0, label, "tick", "middle")
    for place, label in frame.y.ticks:
        yield _text(left - 8.0, c.y(place) + 4.5, label, "tick", "end")
    yield _text(c.x(0.5), c.total - 6.0, " ".join(filter(None, (figure.x_label, frame.x.scale))), "label", "middle")
    yield _text(2.0, 15.0, " ".join(filter(None, (figure.y_label, frame.y.scale))), "label")
    for k, (place, text) in enumerate(frame.floors):
        yield f'<path class="floor-line" d="M{left:.1f} {c.y(place):.1f}H{right:.1f}"/>'
        at, anchor = (right - 5.0, "end") if k % 2 == 0 else (left + 6.0, "start")
        yield _text(at, c.y(place) + 14.0, text, "small", anchor)


def _series(drawn: Drawn, c: Canvas, clip: str) -> Iterator[str]:
    style = drawn.series.style
    kept = _kept(drawn, c)
    if drawn.high and style == "line":
        yield f'<path class="band" clip-path="url(#{clip})" d="{_band(drawn, kept, c)}"/>'
    elif drawn.high:
        bars = (k for k in kept if not math.isnan(drawn.x[k]))
        ends = "".join(f"M{c.x(drawn.x[k]):.1f} {c.y(drawn.low[k]):.1f}V{c.y(drawn.high[k]):.1f}" for k in bars)
        yield f'<path class="spread" clip-path="url(#{clip})" d="{ends}"/>'
    if style != "marks":
        kind = style if style in ("front", "guide") else "line"
        yield f'<path class="{kind}" clip-path="url(#{clip})"{_dash(drawn)} d="{_line(drawn, kept, c)}"/>'
    if style not in ("both", "marks"):
        return
    shown = [(c.x(drawn.x[k]), c.y(drawn.y[k])) for k in kept if not math.isnan(drawn.x[k])]
    if len(shown) > MANY:
        dots = dict.fromkeys(f"M{round(x * 2) / 2:g} {round(y * 2) / 2:g}h0" for x, y in shown)
        yield f'<path class="dots" d="{"".join(dots)}"/>'
    else:
        yield from (_mark(drawn, x, y) for x, y in shown)


def _line(drawn: Drawn, kept: list[int], c: Canvas) -> str:
    words, pen = [], "M"
    for k in kept:
        if math.isnan(drawn.x[k]):
            pen = "M"
            continue
        words.append(f"{pen}{c.x(drawn.x[k]):.1f} {c.y(drawn.y[k]):.1f}")
        pen = "L"
    return "".join(words)


def _band(drawn: Drawn, kept: list[int], c: Canvas) -> str:
    """One closed outline for each piece between gaps."""
    pieces: list[list[int]] = [[]]
    for k in kept:
        if math.isnan(drawn.x[k]):
            pieces.append([])
        else:
            pieces[-1].append(k)
    words = []
    for piece in filter(None, pieces):
        up = [f"{c.x(drawn.x[k]):.1f} {c.y(drawn.high[k]):.1f}" for k in piece]
        down = [f"{c.x(drawn.x[k]):.1f} {c.y(drawn.low[k]):.1f}" for k in reversed(piece)]
        words.append(f"M{'L'.join(up + down)}Z")
    return "".join(words)


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


def _outcomes(frame: Frame, c: Canvas, classes: dict[str, str]) -> Iterator[str]:
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
