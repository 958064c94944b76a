"""Titles, sentences and tables as fragments of HTML, and whole pages in a frame: the displays of a notebook.

All styles are inline, as a front end may remove style sheets. Colours are those of the front end, light or dark. All
texts are escaped.
"""

from __future__ import annotations

import html
import re
from collections.abc import Iterator, Sequence

from mbdsl.plotting.escaping import escape
from mbdsl.plotting.figures import Table

MOST = 40  #: rows of a table that are shown without scrolling
LIMIT = 400  #: rows of a table that are shown at all
NUMBER = re.compile(r"[-+−]?(\d[\d,]*\.?\d*|\.\d+)([eE][-+]?\d+)?$|nan$|-?inf$")
SMALL = "margin: 2px 0"
GREY = "opacity: .75"


def fragment(
    title: str, paragraphs: Sequence[str] = (), tables: Sequence[Table] = (), notes: Sequence[str] = ()
) -> str:
    """A title, sentences below it, tables, and notes at the end.

    Parameters
    ----------
    title : str
        The first line; a text after a colon is not bold.
    paragraphs, notes : sequence of str, optional
        Sentences before and after the tables.
    tables : sequence of Table, optional
        Tables without rows are omitted.

    Returns
    -------
    str
        One element of HTML.
    """
    name, colon, rest = title.partition(": ")
    parts = [f'<p style="{SMALL}"><b>{escape(name)}</b>{escape(colon + rest)}</p>']
    parts += [f'<p style="{SMALL}">{escape(text)}</p>' for text in paragraphs]
    parts += [table(t) for t in tables if t.rows]
    parts += [f'<p style="{SMALL}; {GREY}">{escape(text)}</p>' for text in notes]
    return f'<div class="mbdsl">{"".join(parts)}</div>'


def preformatted(text: str) -> str:
    """A text with its line ends and columns."""
    return f'<pre style="margin: 2px 0; white-space: pre">{escape(text)}</pre>'


def table(t: Table) -> str:
    """A table without its empty columns; numbers are aligned to the right, and a long table scrolls.

    Parameters
    ----------
    t : Table
        The table; if it has more than ``LIMIT`` rows, the first ones and the number of rows are shown.

    Returns
    -------
    str
        HTML.
    """
    rows = [[*map(str, row), *[""] * (len(t.columns) - len(row))] for row in t.rows[:LIMIT]]
    kept = [k for k in range(len(t.columns)) if any(row[k] for row in rows)]
    rows = [[row[k] for k in kept] for row in rows]
    right = [_numeric([row[k] for row in rows]) for k in range(len(kept))]
    found = "".join(_table([t.columns[k] for k in kept], rows, right))
    if len(rows) > MOST:
        found = f'<div style="max-height: 32em; overflow: auto">{found}</div>'
    title = f'<p style="margin: 8px 0 2px"><b>{escape(t.title)}</b></p>' if t.title else ""
    said = [f"{len(rows)} of {len(t.rows)} rows"] if len(t.rows) > len(rows) else []
    said += [t.note] if t.note else []
    notes = "".join(f'<p style="{SMALL}; {GREY}">{escape(text)}</p>' for text in said)
    return f'<div style="overflow-x: auto">{title}{found}{notes}</div>'


def _table(columns: Sequence[str], rows: Sequence[Sequence[str]], right: Sequence[bool]) -> Iterator[str]:
    # Each cell states its alignment, because front ends align all cells to the right.
    sides = [f'style="text-align:{"right" if r else "left"}"' for r in right]
    head = "".join(f'<th scope="col" {side}>{escape(c)}</th>' for c, side in zip(columns, sides, strict=True))
    yield f'<table style="margin: 0; font-variant-numeric: tabular-nums"><thead><tr>{head}</tr></thead><tbody>'
    for row in rows:
        yield f"<tr>{''.join(f'<td {side}>{escape(cell)}</td>' for cell, side in zip(row, sides, strict=True))}</tr>"
    yield "</tbody></table>"


def _numeric(cells: Sequence[str]) -> bool:
    """Whether all cells that are not blank are numbers, and there are some."""
    texts = [cell.strip() for cell in cells if cell.strip()]
    return bool(texts) and all(NUMBER.match(text) for text in texts)


def frame(page: str, height: int, width: int | None = None) -> str:
    """A page in a frame of its own.

    Its script runs with an origin of its own, so that it reaches neither the notebook nor the network.

    Parameters
    ----------
    page : str
        The text of an HTML file that loads nothing.
    height : int [px]
        Height of the frame.
    width : int, optional [px]
        Largest width of the frame. Default: that of the notebook.

    Returns
    -------
    str
        HTML.
    """
    most = "" if width is None else f"; max-width: {width}px"
    style = f"display: block; box-sizing: border-box; border: 1px solid #8888; border-radius: 6px{most}"
    return (
        f'<iframe srcdoc="{html.escape(page)}" sandbox="allow-scripts allow-modals" width="100%" height="{height}" '
        f'style="{style}" loading="lazy"></iframe>'
    )
