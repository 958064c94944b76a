"""A page as one HTML file without external resources: SVG figures, tables, and a script for hovering and the legend."""

from __future__ import annotations

import os
from collections.abc import Iterator, Mapping, Sequence

from mbdsl.plotting import bars, svg
from mbdsl.plotting.documents import asset, data_script, document
from mbdsl.plotting.escaping import escape
from mbdsl.plotting.figure_layout import PlotArea, lay_out, looks_of
from mbdsl.plotting.figures import Bars, Figure, Page, TextTable
from mbdsl.plotting.html_tables import as_html
from mbdsl.plotting.series_styles import NEUTRAL, Look
from mbdsl.storage.output_files import write_text

SHORT = 100  #: largest number of letters of a value of the fine print that is shown unfolded


def write(page: Page, path: str | os.PathLike) -> None:
    """Write a page as one HTML file without external resources.

    Parameters
    ----------
    page : Page
        The page.
    path : path
        The file.

    Raises
    ------
    UsageError
        If the file cannot be written.
    """
    write_text(path, html(page))


def html(page: Page) -> str:
    """The page as the text of one HTML file."""
    colours, parts = fragments(page.items, page.looks)
    body = [f"<h1>{escape(page.title)}</h1>", *(f"<p>{escape(text)}</p>" for text in page.paragraphs), *parts]
    body += fine_print(page.fine_print)
    return document(page.title, body, [asset("page.css") + colours], [asset("page.js")])


def height(page: Page, width: float) -> int:
    """The height of a page of figures at a width of at least 760 px [px], approximately."""
    known = {**looks_of([item for item in page.items if isinstance(item, Figure)]), **page.looks}
    pictures = [svg.Canvas(lay_out(item, known)).total for item in page.items if isinstance(item, Figure)]
    # Measured in a browser: the title and the margins, the legend of a figure, lines of text.
    return round(90 + (width - 40) / svg.WIDTH * sum(pictures) + 95 * len(pictures) + 30 * len(page.paragraphs))


def fragments(items: Sequence[Figure | Bars | TextTable], given: Mapping[str, Look]) -> tuple[str, list[str]]:
    """Figures and tables as parts of a page.

    Parameters
    ----------
    items : sequence of Figure, Bars or Table
        All figures and tables of the page.
    given : mapping
        Name of a series -> its look; the others get theirs in order.

    Returns
    -------
    style : str
        The colours of the series and the widths of bars, in addition to ``page.css``.
    parts : list of str
        HTML of each item.
    """
    drawn = [item for item in items if isinstance(item, Figure | Bars)]
    figures = [item for item in drawn if isinstance(item, Figure)]
    known = {**looks_of(drawn), **given}
    classes = {name: f"c{k}" for k, name in enumerate(known)}
    panels = [f for f in figures if f.x_ends is not None]
    left = max((svg.Canvas(lay_out(f, known)).left for f in panels), default=0.0)
    small = max((svg.Canvas(_narrow(f, known)).left for f in panels), default=0.0)
    parts = []
    for k, item in enumerate(items):
        if isinstance(item, Bars):
            parts.append("\n".join(bars.html(item, f"figure-{k}", classes, known)))
        else:
            part = _figure(item, f"figure-{k}", known, (left, small)) if isinstance(item, Figure) else _table(item)
            parts.append("\n".join(part))
    widths = (bars.widths(item, f"figure-{k}") for k, item in enumerate(items) if isinstance(item, Bars))
    return "".join((_colours(known), *widths)), parts


def _colours(known: dict[str, Look]) -> str:
    """Classes ``c0``, ``c1``, ... of the names in their order, and ``neutral``."""
    rules = {f"c{k}": look for k, look in enumerate(known.values())} | {"neutral": NEUTRAL}
    light = "".join(f".{name} {{ color: {look.light}; }}\n" for name, look in rules.items())
    dark = "".join(f".{name} {{ color: {look.dark}; }}\n" for name, look in rules.items())
    return f"{light}@media screen and (prefers-color-scheme: dark) {{\n{dark}}}\n"


def _narrow(figure: Figure, known: dict[str, Look]) -> PlotArea:
    """A figure in a narrow window."""
    return lay_out(figure, known, svg.letter(svg.NARROW), narrow=True)


def _figure(figure: Figure, key: str, known: dict[str, Look], left: tuple[float, float]) -> Iterator[str]:
    """A figure; ``left`` are the common left margins of figures that share their axis, in wide and narrow windows."""
    frame = lay_out(figure, known, svg.letter())
    small = _narrow(figure, known)
    wide, tight = left if figure.x_ends is not None else (0.0, 0.0)
    canvas, place = svg.Canvas(frame, wide), svg.Canvas(small, tight, full=svg.NARROW)
    classes = {name: f"c{k}" for k, name in enumerate(known)}
    heading = f"<h2>{escape(figure.title)}</h2>" if figure.title else ""
    shared = " data-shared" if figure.x_ends is not None else ""
    yield f'<figure id="{key}"{shared}>\n<figcaption>{heading}'
    if figure.note:
        yield f'<p class="note">{escape(figure.note)}</p>'
    yield "</figcaption>"
    yield from _legend(frame, classes)
    data = svg.hover(frame, canvas)
    pictures = svg.picture(frame, key, classes, canvas), svg.picture(small, f"{key}-narrow", classes, place)
    yield f'<div class="scroll both">\n{pictures[0]}\n{pictures[1]}\n</div>'
    data["narrow"] = {name: what for name, what in svg.hover(small, place).items() if name in ("points", "failed")}
    yield from _outcomes(frame)
    yield f"{data_script(data)}\n</figure>"


def _legend(frame: PlotArea, classes: dict[str, str]) -> Iterator[str]:
    named = [(k, drawn) for k, drawn in enumerate(frame.drawn) if drawn.series.name]
    named.sort(key=lambda entry: entry[1].series.style in svg.BEHIND)
    if not named:
        return
    yield '<ul class="legend" aria-label="Series">'
    for k, drawn in named:
        kind = svg.colour(drawn, classes)
        yield (
            f'<li><span data-entry="{k}"><span class="{kind}">{svg.swatch(drawn)}</span>'
            f"{escape(drawn.series.name)}</span></li>"
        )
    yield "</ul>"


def _outcomes(frame: PlotArea) -> Iterator[str]:
    """All outcomes in full: in the picture they are shortened."""
    if frame.left_out:
        yield f'<p class="note">{escape(frame.left_out)}</p>'
    places: dict[str, list[str]] = {}
    for outcome in frame.figure.outcomes:
        places.setdefault(f"{outcome.name}: {outcome.text}", []).append(
            "" if outcome.x is None else svg.number(outcome.x)
        )
    if not places:
        return
    yield '<ul class="outcomes" aria-label="Without a point">'
    for text, where in places.items():
        at = ", ".join(filter(None, where))
        yield f"<li>{escape(text)}{f' ({escape(frame.figure.x_label)}: {at})' if at else ''}</li>"
    yield "</ul>"


def _table(table: TextTable) -> Iterator[str]:
    yield f'<div class="table">\n<div class="scroll"><table>\n<caption>{escape(table.title)}</caption>'
    yield from as_html(table, ' class="number"', named=True)
    yield "</table></div>"
    if table.note:
        yield f'<p class="note">{escape(table.note)}</p>'
    yield "</div>"


def fine_print(items: Sequence[tuple[str, str]]) -> Iterator[str]:
    """Names and values that describe a run, as required to repeat it."""
    if not items:
        return
    yield '<section class="fine">\n<h2>How to repeat it</h2>\n<dl>'
    for name, value in items:
        yield f"<dt>{escape(name)}</dt><dd>{_value(str(value))}</dd>"
    yield "</dl>\n</section>"


def _value(value: str) -> str:
    text = value.strip("\n")
    if "\n" not in text and len(text) <= SHORT:
        return escape(text)
    lines = text.count("\n") + 1
    summary = f"{lines} lines" if lines > 1 else f"{text[:60].rstrip()}…"
    return f"<details><summary>{escape(summary)}</summary><pre>{escape(text)}</pre></details>"
