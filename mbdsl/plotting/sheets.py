"""Figures as one SVG picture on white paper: one below the other, with legends above the frames and notes below."""

from __future__ import annotations

import re
import textwrap
from collections.abc import Iterable, Mapping, Sequence
from functools import cache

from mbdsl.plotting import bars, svg
from mbdsl.plotting.documents import asset
from mbdsl.plotting.escaping import escape
from mbdsl.plotting.figure_layout import Drawn, PlotArea, lay_out, looks_of
from mbdsl.plotting.figures import Bars, Figure
from mbdsl.plotting.series_styles import NEUTRAL, Look
from mbdsl.plotting.svg import BEHIND, BOTTOM, WIDTH, Canvas

LETTER = 7.4  #: width of a letter of a legend, rather too large than too small [px]
LINE = 20.0  #: height of a line of a legend
SAMPLE, SPACE = 34.0, 18.0  #: width of the sample of a line, and the space between two entries
BETWEEN = 20.0  #: space below the frame of all panels with a shared axis but the last
NOTE = 120  #: number of letters of a line of the notes
STYLE = """\
text { fill: #1f2328; font: 13px system-ui, "Segoe UI", "DejaVu Sans", sans-serif; }
.title { font-size: 16px; font-weight: 700; }
.note { fill: #57606a; font-size: 12px; }
.chart { fill: currentColor; stroke: currentColor; stroke-width: 1.5; }
.chart.hollow { fill: #ffffff; stroke-dasharray: 5 3; }
"""


@cache
def _style() -> str:
    """The rules of pages for pictures, in the colours of light paper."""
    text = asset("page.css")
    rules = text[text.index("/* pictures */") : text.index("/* pages */")].partition("\n")[2]
    colours = dict(re.findall(r"--(\w+): (#\w+)", text.partition("@media")[0]))
    return STYLE + re.sub(r"var\(--(\w+)\)", lambda found: colours[found[1]], rules)


def sheet(
    title: str, figures: Sequence[Figure | Bars], given: Mapping[str, Look] | None = None, notes: Iterable[str] = ()
) -> str:
    """Figures as the text of one SVG file.

    Parameters
    ----------
    title : str
        Title of the picture.
    figures : sequence of Figure or Bars
        From the top. Those with ``x_ends`` that follow each other share their horizontal axis.
    given : mapping, optional
        Name of a series -> its look; the others get theirs in order.
    notes : iterable of str, optional
        Sentences below the figures.
    """
    known = {**looks_of(figures), **(given or {})}
    frames = {k: lay_out(figure, known, svg.letter()) for k, figure in enumerate(figures) if isinstance(figure, Figure)}
    shared = [frame for frame in frames.values() if frame.figure.x_ends is not None]
    left = max((Canvas(frame).left for frame in shared), default=0.0)
    classes = {name: f"c{k}" for k, name in enumerate(known)}
    colours = "".join(f".{classes[name]} {{ color: {look.light}; }}\n" for name, look in known.items())
    colours += f".neutral {{ color: {NEUTRAL.light}; }}\n"
    lines = textwrap.wrap(title, NOTE - 20)
    parts = [f'<text class="title" x="2" y="{20 + 20 * j}">{escape(line)}</text>' for j, line in enumerate(lines)]
    at, said = 14.0 + 20.0 * max(len(lines), 1), list(notes)
    for k, panel in enumerate(figures):
        if panel.title not in ("", title):
            parts.append(f'<text class="label" x="2" y="{at + 13.0:.1f}">{escape(panel.title)}</text>')
            at += LINE
        if isinstance(panel, Bars):
            parts += bars.picture(panel, classes, known, at)
            at += bars.height(panel)
            continue
        frame = frames[k]
        legend, height = _legend(frame, classes, at)
        parts += legend
        at += height
        inner = panel.x_ends is not None and k + 1 in frames and frames[k + 1].figure.x_ends is not None
        canvas = Canvas(frame, left if panel.x_ends is not None else 0.0, BETWEEN if inner else BOTTOM)
        picture = svg.picture(frame, f"panel-{k}", classes, canvas)
        place = f'<svg y="{at:.1f}" width="{WIDTH:g}" height="{canvas.total:.1f}" overflow="visible" '
        parts.append(picture.replace("<svg ", place, 1))
        at += canvas.total
        said += [frame.left_out] if frame.left_out else []
        said += [f"{frame.unplaced} more outcomes are not shown."] if frame.unplaced else []
    for line in _wrapped(said):
        at += 17.0
        parts.append(f'<text class="note" x="2" y="{at:.1f}">{escape(line)}</text>')
    size = f'viewBox="0 0 {WIDTH:g} {at + 10.0:.0f}" width="{WIDTH:g}" height="{at + 10.0:.0f}"'
    head = f'<svg xmlns="http://www.w3.org/2000/svg" {size}>'
    paper = '<rect width="100%" height="100%" fill="#ffffff"/>'
    return "\n".join((head, f"<style>\n{_style()}{colours}</style>", paper, *parts, "</svg>\n"))


def _wrapped(notes: Iterable[str]) -> list[str]:
    """The lines of the notes."""
    return [line for note in notes for line in textwrap.wrap(note, NOTE, break_long_words=False)]


def named(frame: PlotArea) -> list[Drawn]:
    """The curves of a legend, those behind the others last; none if the label of the vertical axis names the only
    one."""
    if len(frame.drawn) == 1 and frame.figure.y_label.startswith(frame.drawn[0].series.name):
        return []
    return sorted((d for d in frame.drawn if d.series.name), key=lambda d: d.series.style in BEHIND)


def _rows(lengths: Sequence[float], width: float) -> list[list[int]]:
    """Entries of these lengths in rows of at most ``width``; at least one in each."""
    found: list[list[int]] = []
    used = 0.0
    for k, length in enumerate(lengths):
        if not found or used + SPACE + length > width:
            found.append([k])
            used = length
        else:
            found[-1].append(k)
            used += SPACE + length
    return found


def _legend(frame: PlotArea, classes: dict[str, str], top: float) -> tuple[list[str], float]:
    """Texts and samples, and the height of the legend: 0 if it fits next to the label of the vertical axis."""
    shown = named(frame)
    lengths = [SAMPLE + 6.0 + LETTER * len(drawn.series.name) for drawn in shown]
    start = 26.0 + LETTER * len(frame.y.titled(frame.figure.y_label))
    lines = _rows(lengths, WIDTH - 4.0 - start)
    beside = len(lines) == 1 and sum(lengths) + SPACE * len(lengths) + start < WIDTH and not frame.rows
    if not beside:
        lines, start = _rows(lengths, WIDTH - 4.0), 2.0
    parts = []
    for j, line in enumerate(lines):
        x, y = start, top + (15.0 if beside else LINE * (j + 0.7))
        for k in line:
            sample = svg.swatch(shown[k]).replace(
                "<svg ", f'<svg x="{x:.1f}" y="{y - 12.5:.1f}" width="{SAMPLE:g}" height="16" ', 1
            )
            parts.append(f'<g class="{svg.colour(shown[k], classes)}">{sample}</g>')
            parts.append(f'<text x="{x + SAMPLE + 6.0:.1f}" y="{y:.1f}">{escape(shown[k].series.name)}</text>')
            x += lengths[k] + SPACE
    return parts, 0.0 if beside or not lines else LINE * len(lines) + 6.0
