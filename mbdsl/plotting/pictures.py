"""Figures drawn to PNG, SVG and PDF files by matplotlib, the same bytes for the same figure."""

from __future__ import annotations

import math
import os
import textwrap
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from mbdsl.errors import UsageError
from mbdsl.plotting import bars
from mbdsl.plotting.figure_layout import Drawn, Frame, lay_out, looks_of
from mbdsl.plotting.figures import Bars, Figure
from mbdsl.plotting.picture_files import written
from mbdsl.plotting.series_styles import LIGHT_PAPER, MARKS, Look

if TYPE_CHECKING:
    from matplotlib.axes import Axes

SUFFIXES = (".png", ".svg", ".pdf")
SIZE = (9.0, 5.4)  #: [inch]
INK, PALE, GRID, SHADE = "#1f2328", "#57606a", "#e4e7eb", "#f1f2f4"
STYLE: dict[str, Any] = {
    "font.family": ["DejaVu Sans"],  # a dependency of matplotlib
    "font.size": 10.0,
    "axes.edgecolor": PALE,
    "axes.linewidth": 0.8,
    "text.color": INK,
    "axes.labelcolor": INK,
    "xtick.color": PALE,
    "ytick.color": PALE,
    "xtick.labelcolor": INK,
    "ytick.labelcolor": INK,
    "lines.solid_capstyle": "round",
}
FIRST = 3.0  #: depth of the first series; guides and fronts lie behind
ROW = 0.055  #: height of a row of outcomes over that of the frame
MANY = 150  #: marks; beyond them they are dots
LONG_NAME = 28  #: number of letters above which the legend is below the frame


def draw(
    figure: Figure | Bars,
    path: str | os.PathLike,
    *,
    size: tuple[float, float] = SIZE,
    dpi: float = 150.0,
    known: Mapping[str, Look] | None = None,
) -> None:
    """Draw a figure to a PNG, SVG or PDF file.

    Parameters
    ----------
    figure : Figure or Bars
        The figure.
    path : path
        The file; its suffix chooses the format.
    size : (float, float), optional [inch]
        Width and height.
    dpi : float, optional
        Pixels per inch of a PNG.
    known : mapping, optional
        Name of a series -> its look; the others get theirs in order.

    Raises
    ------
    UsageError
        If the suffix is unknown, the file cannot be written, or matplotlib is not installed.
    """
    path = Path(path)
    if path.suffix.lower() not in SUFFIXES:
        hint = f"known suffixes are {', '.join(SUFFIXES)}"
        raise UsageError(f"unknown suffix `{path.suffix}` of picture `{path}`", hint=hint)
    looks = {**looks_of([figure]), **(known or {})}
    if isinstance(figure, Bars):
        size = size[0], max(2.0, 1.1 + bars.ROW * len(figure.bars))
    with written(path, size, dpi, STYLE, layout="constrained") as picture:
        ax = picture.add_subplot()
        picture.suptitle(_wrapped(figure.title, 90), fontsize=12, fontweight="bold", x=0.01, ha="left")
        if isinstance(figure, Bars):
            bars.fill(ax, figure, looks)
        else:
            frame = lay_out(figure, looks, letter=0.009 * SIZE[0] / size[0])
            fill(ax, frame)
            more = f"{frame.unplaced} more outcomes are not shown." if frame.unplaced else ""
            if frame.left_out or more:
                picture.supxlabel(_wrapped(f"{frame.left_out} {more}", 130), fontsize=8, color=PALE)
            _legend(picture, ax)


def fill(ax: Axes, frame: Frame) -> None:
    """Draw a figure into axes of matplotlib."""
    _axes(ax, frame)
    for zorder, drawn in enumerate(frame.drawn):
        _SHOW.get(drawn.series.style, _series)(ax, drawn, FIRST + 0.01 * zorder)
    _outcomes(ax, frame)


def _axes(ax: Axes, frame: Frame) -> None:
    """Frame, ticks, grid and floors, in the coordinates of the layout, so that all renderers have the same ticks."""
    top = 1.0 + ROW * len(frame.rows)
    ax.set(xlim=(0.0, 1.0), ylim=(0.0, top))
    if frame.figure.equal:
        ax.set_box_aspect(frame.aspect * top)
        ax.set_anchor("N")
    for axis, ticks, side in ((ax.xaxis, frame.x, "bottom"), (ax.yaxis, frame.y, "left")):
        axis.set_ticks([p for p, _ in ticks.ticks], [label for _, label in ticks.ticks])
        axis.set_ticks(list(ticks.minor), minor=True)
        ax.spines[side].set_bounds(0.0, 1.0)
    grid: dict[str, Any] = dict(color=GRID, linewidth=0.8, zorder=1.0)
    ax.vlines([p for p, _ in frame.x.ticks], 0.0, 1.0, **grid)
    ax.hlines([p for p, _ in frame.y.ticks], 0.0, 1.0, **grid)
    ax.spines[["top", "right"]].set_visible(False)
    ax.set_xlabel(frame.x.titled(frame.figure.x_label))
    ax.set_title(frame.y.titled(frame.figure.y_label), loc="left", fontsize=10)
    for place, _ in frame.floors[-1:]:
        ax.axhspan(0.0, place, color=SHADE, zorder=0.5)
    for k, (place, text) in enumerate(frame.floors):
        ax.axhline(place, color=PALE, linewidth=1.0, dashes=(5, 3), zorder=1.5)
        at, side = (0.995, "right") if k % 2 == 0 else (0.005, "left")
        box = dict(facecolor=SHADE, linewidth=0.0, pad=1.0)
        ax.text(at, place - 0.015, text, ha=side, va="top", fontsize=8.5, color=PALE, bbox=box, zorder=2.9)


def _series(ax: Axes, drawn: Drawn, zorder: float) -> None:
    look, style = drawn.look, drawn.series.style
    line = style in ("both", "line")
    if drawn.high and style == "line":
        ax.fill_between(drawn.x, drawn.low, drawn.high, color=look.light, alpha=0.18, linewidth=0, zorder=zorder - 1)
    elif drawn.high:
        ax.vlines(drawn.x, drawn.low, drawn.high, color=look.light, linewidth=1.2, zorder=zorder)
    ax.plot(
        drawn.x,
        drawn.y,
        color=look.light,
        linewidth=1.4 if line else 0.0,
        linestyle=(0, look.dash) if look.dash and line else "-",
        zorder=zorder,
        label=drawn.series.name,
        **(_mark(look, len(drawn.x)) if style != "line" else {}),
    )


def _behind(ax: Axes, drawn: Drawn, zorder: float) -> None:
    """A front or a guide, which may extend beyond the frame."""
    front = drawn.series.style == "front"
    look: dict[str, Any] = (
        dict(alpha=0.3, linewidth=9.0) if front else dict(linewidth=0.9, linestyle=(0, drawn.look.dash))
    )
    zorder -= 1.5 if front else 1.0
    (line,) = ax.plot(drawn.x, drawn.y, color=drawn.look.light, label=drawn.series.name, zorder=zorder, **look)
    from matplotlib.transforms import Bbox, TransformedBbox

    line.set_clip_box(TransformedBbox(Bbox.unit(), ax.transData))


_SHOW = {"front": _behind, "guide": _behind}


def _mark(look: Look, count: int, size: float = 7.0) -> dict[str, Any]:
    if count > MANY:
        return dict(marker=".", markersize=2.5, markeredgewidth=0.0)
    corners = MARKS[look.mark]
    # matplotlib scales the corners to its unit square; the size compensates this
    widest = max((max(abs(a), abs(b)) for a, b in corners), default=1.0)
    return dict(
        marker=[(a, -b) for a, b in (*corners, corners[0])] if corners else "o",
        markersize=size * widest,
        markerfacecolor=look.light if look.filled else LIGHT_PAPER,
        markeredgewidth=1.2,
    )


def _outcomes(ax: Axes, frame: Frame) -> None:
    for k, row in enumerate(frame.rows):
        height = 1.0 + ROW * (k + 0.6)
        for group in row:
            places = [p for p in group.x if not math.isnan(p)]
            ax.plot(
                places,
                [height] * len(places),
                linestyle="",
                marker="x",
                markersize=6,
                markeredgewidth=2.0,
                color=group.look.light,
                clip_on=False,
            )
            side = "right" if group.to_left else "left"
            ax.text(group.text_x, height, group.text, ha=side, va="center", fontsize=8.5, color=PALE)
    if frame.rows:
        ax.axhline(1.0, color=PALE, linewidth=0.8)


def _wrapped(text: str, width: int) -> str:
    return "\n".join(textwrap.wrap(text, width))


def _legend(picture: Any, ax: Axes) -> None:
    """The legend next to the frame, or below it if names are long; guides and fronts last."""
    shown = [line for line in ax.get_lines() if not str(line.get_label()).startswith("_") and line.get_label()]
    if not shown:
        return
    shown.sort(key=lambda line: line.get_zorder() < FIRST)
    labels = [_wrapped(str(line.get_label()), 60) for line in shown]
    longest = max(map(len, labels))
    place: dict[str, Any] = dict(loc="outside right center")
    if longest > LONG_NAME:
        place = dict(loc="outside lower center", ncols=max(1, min(len(labels), 110 // (longest + 6))))
    legend = picture.legend(shown, labels, frameon=False, fontsize=9.5, handlelength=2.6, **place)
    for handle in legend.legend_handles:
        if handle.get_marker() == ".":
            handle.set_markersize(9.0)
