"""Bar charts: one value for each name, as part of a page and as a picture."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING, Any

from mbdsl.plotting.escaping import escape
from mbdsl.plotting.figures import Bars
from mbdsl.plotting.series_styles import LIGHT_PAPER, Look

if TYPE_CHECKING:
    from matplotlib.axes import Axes

ROW = 0.34  #: height of a bar in a picture [inch]


def html(bars: Bars, key: str, classes: Mapping[str, str], known: Mapping[str, Look]) -> Iterator[str]:
    """The chart as rows of name, bar and text, which fit any width; ``classes`` give the colours."""
    most = max((bar.value for bar in bars.bars), default=1.0) or 1.0
    heading = f"<h2>{escape(bars.title)}</h2>" if bars.title else ""
    yield f'<figure id="{key}">\n<figcaption>{heading}'
    if bars.note:
        yield f'<p class="note">{escape(bars.note)}</p>'
    yield f'</figcaption>\n<table class="bars"><caption>{escape(bars.label)}</caption>\n<tbody>'
    for bar in bars.bars:
        kind = "" if known[bar.name].filled else " hollow-bar"
        width = f"{max(0.5, 100.0 * bar.value / most):.1f}%"
        yield (
            f'<tr><th scope="row">{escape(bar.name)}</th><td><span class="bar {classes[bar.name]}{kind}" '
            f'style="width: {width}"></span></td><td class="number">{escape(bar.text)}</td></tr>'
        )
    yield "</tbody></table>\n</figure>"


def fill(ax: Axes, bars: Bars, known: Mapping[str, Look]) -> None:
    """Draw the chart into axes of matplotlib, the first bar at the top."""
    for k, bar in enumerate(bars.bars):
        look = known[bar.name]
        style: dict[str, Any] = dict(facecolor=look.light)
        if not look.filled:
            style = dict(facecolor=LIGHT_PAPER, linestyle="--")
        ax.barh(-k, bar.value, height=0.68, edgecolor=look.light, linewidth=1.4, zorder=2.0, **style)
        if bar.low is not None and bar.high is not None:
            ax.hlines(-k, bar.low, bar.high, color="#1f2328", linewidth=1.2, zorder=3.0)
        ax.annotate(bar.text, (max(bar.value, bar.high or 0.0), -k), (5, 0), textcoords="offset points", va="center")
    ax.set_yticks([-k for k in range(len(bars.bars))], [bar.name for bar in bars.bars])
    ax.margins(x=0.16, y=0.02)
    ax.set_xlim(left=0.0)
    ax.set_xlabel(bars.label)
    ax.spines[["top", "right"]].set_visible(False)
    ax.tick_params(axis="y", length=0)
