"""Bar charts: one value for each name, as part of a page and as a picture."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from mbdsl.plotting.escaping import escape
from mbdsl.plotting.figures import Bars
from mbdsl.plotting.series_styles import Look

ROW, LETTER, WIDTH = 32.0, 7.4, 860.0  #: height of a bar, width of a letter, and width of a picture [px]


def html(bars: Bars, key: str, classes: Mapping[str, str], known: Mapping[str, Look]) -> Iterator[str]:
    """The chart as rows of name, bar and text, which fit any width, with classes of colours and of :func:`widths`."""
    heading = f"<h2>{escape(bars.title)}</h2>" if bars.title else ""
    yield f'<figure id="{key}">\n<figcaption>{heading}'
    if bars.note:
        yield f'<p class="note">{escape(bars.note)}</p>'
    yield f'</figcaption>\n<table class="bars"><caption>{escape(bars.label)}</caption>\n<tbody>'
    for k, bar in enumerate(bars.bars):
        kind = f"bar {key}-{k} {classes[bar.name]}{'' if known[bar.name].filled else ' hollow-bar'}"
        yield (
            f'<tr><th scope="row">{escape(bar.name)}</th><td><span class="{kind}"></span></td>'
            f'<td class="number">{escape(bar.text)}</td></tr>'
        )
    yield "</tbody></table>\n</figure>"


def widths(bars: Bars, key: str) -> str:
    """Rules of a style sheet for the widths of the bars: the policy of a page allows no style of single elements."""
    most = max((bar.value for bar in bars.bars), default=1.0) or 1.0
    parts = (max(0.5, 100.0 * bar.value / most) for bar in bars.bars)
    return "".join(f".{key}-{k} {{ width: {part:.1f}%; }}\n" for k, part in enumerate(parts))


def height(bars: Bars) -> float:
    """The height of the chart in a picture [px]."""
    return ROW * len(bars.bars) + 30.0


def picture(bars: Bars, classes: Mapping[str, str], known: Mapping[str, Look], top: float) -> Iterator[str]:
    """The chart as elements of SVG, the first bar at ``top`` [px]."""
    names = LETTER * max((len(bar.name) for bar in bars.bars), default=1)
    texts = LETTER * max((len(bar.text) for bar in bars.bars), default=1)
    most = max((max(bar.value, bar.high or 0.0) for bar in bars.bars), default=1.0) or 1.0
    left = min(names, 0.4 * WIDTH) + 12.0
    scale = max(WIDTH - left - texts - 12.0, 0.3 * WIDTH) / most
    for k, bar in enumerate(bars.bars):
        y, end = top + ROW * k, left + scale * bar.value
        kind = "chart" if known[bar.name].filled else "chart hollow"
        yield f'<text x="{left - 8.0:.1f}" y="{y + 20.0:.1f}" text-anchor="end">{escape(bar.name)}</text>'
        yield f'<g class="{classes[bar.name]}"><rect class="{kind}" x="{left:.1f}" y="{y + 4.0:.1f}" '
        yield f'width="{scale * bar.value:.1f}" height="{ROW - 8.0}"/></g>'
        if bar.low is not None and bar.high is not None:
            spread = f"M{left + scale * bar.low:.1f} {y + ROW / 2:.1f}H{left + scale * bar.high:.1f}"
            yield f'<path stroke="#1f2328" stroke-width="1.6" d="{spread}"/>'
            end = max(end, left + scale * bar.high)
        yield f'<text x="{end + 7.0:.1f}" y="{y + 20.0:.1f}">{escape(bar.text)}</text>'
    yield f'<text class="note" x="{left:.1f}" y="{top + height(bars) - 10.0:.1f}">{escape(bars.label)}</text>'
