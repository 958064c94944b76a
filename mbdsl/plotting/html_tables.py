"""Titles, sentences and tables as fragments of HTML, and whole pages in a frame: the displays of a notebook.

All styles are inline, as a front end may remove style sheets. Colours are those of the front end, light or dark. All
texts are escaped.
"""

from __future__ import annotations

import html
import re
from collections.abc import Iterator, Sequence
from dataclasses import replace

from mbdsl.plotting.escaping import escape
from mbdsl.plotting.figures import TextTable

MOST = 40  #: rows of a table that are shown without scrolling
LIMIT = 400  #: rows of a table that are shown at all
_NUMERIC = re.compile(
    r"-?(nan|inf)$|[(]?[<>≤≥~≈±]?\s*[-+−]?"
    r"(\d[\d,]*\.?\d*|\.\d+)([eE][-+]?\d+|·10[⁻⁰¹²³⁴⁵⁶⁷⁸⁹]+)?[)]?"  # digits and exponent
    r"(\s*[±%…].*|\s?\D{0,12})?$"  # a spread or a unit
)
SMALL = "margin: 2px 0"
GREY = "opacity: .75"


def fragment(
    title: str, paragraphs: Sequence[str] = (), tables: Sequence[TextTable] = (), notes: Sequence[str] = ()
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


def table(t: TextTable) -> str:
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
    shown = without_empty(replace(t, rows=t.rows[:LIMIT]))
    # Each cell states its alignment, because front ends align all cells to the right.
    rows = "".join(as_html(shown, ' style="text-align:right"', ' style="text-align:left"'))
    found = f'<table style="margin: 0; font-variant-numeric: tabular-nums">{rows}</table>'
    if len(shown.rows) > MOST:
        found = f'<div style="max-height: 32em; overflow: auto">{found}</div>'
    title = f'<p style="margin: 8px 0 2px"><b>{escape(t.title)}</b></p>' if t.title else ""
    said = [f"{LIMIT} of {len(t.rows)} rows"] if len(t.rows) > LIMIT else []
    said += [t.note] if t.note else []
    notes = "".join(f'<p style="{SMALL}; {GREY}">{escape(text)}</p>' for text in said)
    return f'<div style="overflow-x: auto">{title}{found}{notes}</div>'


def as_html(table: TextTable, right: str, left: str = "", named: bool = False) -> Iterator[str]:
    """The head and the rows of a table in HTML.

    Parameters
    ----------
    table : Table
        The table.
    right, left : str
        Attributes of cells that are aligned to these sides.
    named : bool, optional
        Whether the first cell of a row is its name.

    Yields
    ------
    str
        The head, and each row.
    """
    sides = [right if r else left for r in numeric_columns(table)]
    cells = (f'<th scope="col"{side}>{escape(str(c))}</th>' for c, side in zip(table.columns, sides, strict=True))
    yield f"<thead><tr>{''.join(cells)}</tr></thead>\n<tbody>"
    for row in table.rows:
        kinds = (("th", ' scope="row"') if named and k == 0 else ("td", "") for k in range(len(sides)))
        texts = [*map(str, row), *[""] * (len(sides) - len(row))]
        found = zip(texts, kinds, sides, strict=True)
        yield f"<tr>{''.join(f'<{tag}{more}{side}>{escape(text)}</{tag}>' for text, (tag, more), side in found)}</tr>"
    yield "</tbody>"


def without_empty(table: TextTable) -> TextTable:
    """The table with rows of the same length, without columns whose cells are all empty."""
    n = len(table.columns)
    rows = [[*map(str, row), *[""] * (n - len(row))] for row in table.rows]
    kept = [k for k in range(n) if any(row[k] for row in rows)]
    return replace(table, columns=[str(table.columns[k]) for k in kept], rows=[[row[k] for k in kept] for row in rows])


def numeric_columns(table: TextTable) -> list[bool]:
    """Which columns contain more numbers than words: their cells are aligned to the right."""
    found = []
    for k in range(len(table.columns)):
        cells = [str(row[k]).strip() for row in table.rows if k < len(row)]
        cells = [cell for cell in cells if cell.strip("-–— ")]
        found.append(2 * sum(bool(_NUMERIC.match(cell)) for cell in cells) > len(cells) > 0)
    return found


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
