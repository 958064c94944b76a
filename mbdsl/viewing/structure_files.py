"""Files of a mechanism's graph: SVG, a page, or PNG and PDF by matplotlib."""

from __future__ import annotations

import os
from collections.abc import Iterator
from typing import Any

from mbdsl.plotting.escaping import escape
from mbdsl.plotting.picture_files import written
from mbdsl.storage.output_files import suffix_of, write_text
from mbdsl.viewing.documents import document, sheet
from mbdsl.viewing.structure import Structure
from mbdsl.viewing.structure_picture import Item, picture
from mbdsl.viewing.structure_svg import COLOURS, style, svg
from mbdsl.viewing.structure_text import text

SUFFIXES = (".svg", ".html", ".png", ".pdf")
DPI = 160.0
#: class of a line or area -> (colour of the area, of its line, width of the line [px], dashes)
LOOKS: dict[str, tuple[str, str, float, tuple[float, float] | None]] = {
    "line": ("", "wire", 1.6, None),
    "body": ("shade", "ink", 1.3, None),
    "moved": ("driven", "drive", 1.3, None),
    "follows": ("shade", "drive", 1.3, (5.0, 3.0)),
    "ground": ("paper", "", 0.0, None),
    "hatch": ("", "pale", 1.2, None),
    "hull": ("weld", "", 0.0, None),
    "band": ("", "weld", 26.0, None),
    "joint": ("paper", "ink", 1.6, None),
    "driver": ("drive", "drive", 1.6, None),
    "force": ("", "force", 1.7, None),
    "closing": ("paper", "loop", 2.0, None),
    "redundant": ("paper", "hot", 2.4, None),
}


def check_suffix(path: str | os.PathLike) -> str:
    """The suffix of a file of a graph.

    Raises
    ------
    UsageError
        If it is unknown.
    """
    return suffix_of(path, SUFFIXES)


def save(structure: Structure, path: str | os.PathLike) -> None:
    """Write the picture of a graph to a file.

    Parameters
    ----------
    structure : Structure
        The graph.
    path : path
        The file; its suffix selects the format.

    Raises
    ------
    UsageError
        If the suffix is unknown, the file cannot be written, or matplotlib is not installed (.png, .pdf).
    """
    suffix = check_suffix(path)
    if suffix == ".svg":
        write_text(path, svg(structure))
    elif suffix == ".html":
        write_text(path, page(structure))
    else:
        _draw(structure, path)


def page(structure: Structure) -> str:
    """The graph as one HTML page that loads nothing."""
    heading = [f"<h1>Graph of {escape(structure.name)}</h1>"]
    heading += [f"<p>{escape(structure.doc)}</p>"] if structure.doc else []
    return document(f"Graph of {structure.name}", [*heading, *section(structure)], [sheet(), style()])


def section(structure: Structure) -> Iterator[str]:
    """The picture with its lists, as part of a page."""
    yield "".join(f"<p>{escape(line)}</p>" for line in structure.summary.split("\n")[:3])
    yield f'<figure class="wide"><div class="scroll">{svg(structure, own=False)}</div></figure>'
    lines = [structure.loop_text(k + 1) for k in range(len(structure.loops))] + list(structure.remarks)
    if lines:
        yield f"<ul>{''.join(f'<li>{escape(line)}</li>' for line in lines)}</ul>"
    yield f"<details><summary>The graph as text</summary><pre>{escape(text(structure, 100))}</pre></details>"


def _draw(structure: Structure, path: str | os.PathLike) -> None:
    shown = picture(structure)
    size = shown.width / 96, shown.height / 96
    with written(path, size, DPI, {"font.family": "sans-serif"}, ".svg and .html") as figure:
        ax = figure.add_axes((0.0, 0.0, 1.0, 1.0))
        ax.set(xlim=(0.0, shown.width), ylim=(shown.height, 0.0))
        ax.set_axis_off()
        for item in shown.items:
            _shape(ax, item) if item.path else _label(ax, item)


def _shape(ax: Any, item: Item) -> None:
    from matplotlib.patches import PathPatch
    from matplotlib.path import Path as Outline

    codes, points = [], []
    for command, numbers in item.path:
        pairs = list(zip(numbers[::2], numbers[1::2], strict=True)) or [(0.0, 0.0)]
        kind = {"M": Outline.MOVETO, "L": Outline.LINETO, "C": Outline.CURVE4, "Z": Outline.CLOSEPOLY}[command]
        codes += [kind] * len(pairs)
        points += pairs
    classes = item.kind.split()
    fill, line, width, dash = LOOKS[classes[-1]]
    if classes[0] == "line":
        fill, dash = "", (4.0, 3.0) if classes[-1] == "force" else None
        line, width = (line, width) if classes[-1] != "joint" else ("wire", 1.6)
    if classes[-1] == "redundant" and "driver" in classes:
        fill = "drive"
    patch = PathPatch(
        Outline(points, codes),
        facecolor=COLOURS[fill][0] if fill else "none",
        edgecolor=COLOURS[line][0] if line else "none",
        linewidth=0.75 * width,
        capstyle="round" if classes[-1] == "band" else "butt",
        joinstyle="round",
    )
    if dash is not None:
        patch.set_linestyle((0, (dash[0] / width, dash[1] / width)))
    ax.add_patch(patch)


def _label(ax: Any, item: Item) -> None:
    classes = item.kind.split()
    colour = "hot" if "warn" in classes else "loop" if "number" in classes else "ink"
    colour = "pale" if classes in (["small"], ["part"]) else colour
    size = {"name": 9.75, "part": 9.75, "legend": 9.4}.get(classes[0], 8.6)
    bold = classes[0] in ("name", "part", "number") or "warn" in classes
    anchor = {"start": "left", "middle": "center"}[item.anchor]
    ax.text(
        item.x,
        item.y,
        item.text,
        ha=anchor,
        va="baseline",
        fontsize=0.92 * size,
        color=COLOURS[colour][0],
        weight="bold" if bold else "normal",
    )
