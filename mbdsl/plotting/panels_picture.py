"""A plot drawn to PNG and PDF files by matplotlib, the same bytes for the same plot."""

from __future__ import annotations

import os
from typing import TYPE_CHECKING, Any

from mbdsl.plotting import panels_svg
from mbdsl.plotting.figure_layout import Frame, lay_out
from mbdsl.plotting.figures import Panels
from mbdsl.plotting.picture_files import written
from mbdsl.plotting.pictures import PALE, STYLE, fill

if TYPE_CHECKING:
    from matplotlib.axes import Axes


WIDTH = 9.0  #: [inch]
LETTERS = 108  #: letters of a legend or of the notes that fit into the width
DPI = 150.0


def draw(plot: Panels, path: str | os.PathLike) -> None:
    """Draw a plot to a PNG or PDF file.

    Raises
    ------
    UsageError
        If the file cannot be written, or matplotlib is not installed.
    """
    frames = [lay_out(panel, plot.looks) for panel in plot.panels]
    heights = [(WIDTH - 1.0) * frame.aspect + 0.25 * len(_rows(frame)) for frame in frames]
    lines = panels_svg.notes(plot, LETTERS + 20)
    size = WIDTH, sum(heights) + 0.25 * len(frames) + 0.9 + 0.16 * len(lines)
    with written(path, size, DPI, STYLE, ".svg and .html", layout="constrained") as picture:
        grid = picture.subplots(len(frames), 1, squeeze=False, height_ratios=heights)[:, 0]
        for k, (ax, frame) in enumerate(zip(grid, frames, strict=True)):
            fill(ax, frame)
            if k < len(frames) - 1:
                ax.set_xlabel("")
                ax.tick_params(labelbottom=False)
            _legend(ax, frame)
        picture.suptitle(plot.title, fontsize=12, fontweight="bold", x=0.01, ha="left")
        if lines:
            picture.supxlabel("\n".join(lines), fontsize=8, color=PALE, x=0.01, ha="left")


def _rows(frame: Frame) -> list[list[int]]:
    return panels_svg.rows([len(drawn.series.name) + 6 for drawn in panels_svg.named(frame)], LETTERS, 3)


def _legend(ax: Axes, frame: Frame) -> None:
    """The legend above the frame, below the label of the vertical axis."""
    shown, rows = panels_svg.named(frame), _rows(frame)
    if not shown:
        return
    columns = min(len(row) for row in rows[:-1]) if len(rows) > 1 else len(shown)
    handles = {line.get_label(): line for line in ax.get_lines()}
    order = _by_rows(list(range(len(shown))), columns)
    names = [shown[k].series.name for k in order]
    options: dict[str, Any] = dict(loc="lower left", bbox_to_anchor=(0.0, 1.0), borderaxespad=0.0, borderpad=0.2)
    ax.legend(
        [handles[n] for n in names], names, ncols=columns, frameon=False, fontsize=9.0, handlelength=2.6, **options
    )
    ax.set_title(ax.get_title(loc="left"), loc="left", fontsize=10, pad=4.0 + 14.5 * -(-len(shown) // columns))


def _by_rows(entries: list[int], columns: int) -> list[int]:
    """The entries in the order in which matplotlib, which fills columns, shows them row by row."""
    count = -(-len(entries) // columns)
    full = len(entries) - (count - 1) * columns  # columns with an entry in the last row
    found = []
    for k in range(columns):
        found += [entries[k + columns * j] for j in range(count if k < full else count - 1)]
    return found
