"""Files of a mechanism's graph: SVG, a page, or PNG and PDF by matplotlib."""

from __future__ import annotations

import os
from collections.abc import Iterator

from mbdsl.plotting.documents import document, sheet
from mbdsl.plotting.escaping import escape
from mbdsl.plotting.pictures import draw
from mbdsl.storage.output_files import suffix_of, write_text
from mbdsl.viewing.structure import Structure
from mbdsl.viewing.structure_svg import style, svg
from mbdsl.viewing.structure_text import text

SUFFIXES = (".svg", ".html", ".png", ".pdf")
DPI = 160.0


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
    if suffix_of(path, SUFFIXES) == ".html":
        write_text(path, page(structure))
    else:
        draw(svg(structure), path, DPI)


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
