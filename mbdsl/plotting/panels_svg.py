"""A plot as one SVG picture: panels one below the other with aligned axes, and legends above the frames."""

from __future__ import annotations

import textwrap
from collections.abc import Sequence

from mbdsl.plotting import svg as figure_svg
from mbdsl.plotting.escaping import escape
from mbdsl.plotting.figure_layout import Drawn, Frame, lay_out
from mbdsl.plotting.figures import Panels
from mbdsl.plotting.svg import BOTTOM, WIDTH, Canvas

LETTER = 7.4  #: width of a letter of a legend, rather too large than too small [px]
LINE = 20.0  #: height of a line of a legend
SAMPLE, SPACE = 34.0, 18.0  #: width of the sample of a line, and the space between two entries
BETWEEN = 20.0  #: space below the frame of all panels but the last
NOTE = 120  #: number of letters of a line of the notes
STYLE = """\
text { fill: #1f2328; font: 13px system-ui, "Segoe UI", "DejaVu Sans", sans-serif; }
.title { font-size: 16px; font-weight: 700; }
.tick { font-size: 12.5px; font-variant-numeric: tabular-nums; }
.note { fill: #57606a; font-size: 12px; }
.grid { stroke: #e4e7eb; fill: none; }
.axis { stroke: #57606a; fill: none; }
.line { stroke: currentColor; stroke-width: 1.6; fill: none; stroke-linejoin: round; }
.mark { fill: currentColor; stroke: currentColor; stroke-width: 1.3; stroke-linejoin: round; }
.hollow { fill: #ffffff; }
.dots { stroke: currentColor; stroke-width: 2.6; stroke-linecap: round; fill: none; }
.cross { stroke: currentColor; stroke-width: 2.4; fill: none; }
.small { fill: #57606a; font-size: 12px; }
"""


def svg(plot: Panels) -> str:
    """The plot as the text of one SVG file, on white paper."""
    frames = [lay_out(panel, plot.looks, figure_svg.letter()) for panel in plot.panels]
    left = max((Canvas(frame).left for frame in frames), default=0.0)
    classes = {name: f"c{k}" for k, name in enumerate(plot.looks)}
    colours = "".join(f".{classes[name]} {{ color: {look.light}; }}\n" for name, look in plot.looks.items())
    parts, at = [], 34.0
    parts.append(f'<text class="title" x="2" y="20">{escape(plot.title)}</text>')
    for k, frame in enumerate(frames):
        legend, height = _legend(frame, classes, at)
        parts += legend
        at += height
        last = k == len(frames) - 1
        canvas = Canvas(frame, left, BOTTOM if last else BETWEEN)
        picture = figure_svg.picture(frame, f"panel-{k}", classes, canvas)
        place = f'<svg y="{at:.1f}" width="{WIDTH:g}" height="{canvas.total:.1f}" overflow="visible" '
        parts.append(picture.replace("<svg ", place, 1))
        at += canvas.total
    for line in notes(plot, NOTE):
        at += 17.0
        parts.append(f'<text class="note" x="2" y="{at:.1f}">{escape(line)}</text>')
    size = f'viewBox="0 0 {WIDTH:g} {at + 10.0:.0f}" width="{WIDTH:g}" height="{at + 10.0:.0f}"'
    head = f'<svg xmlns="http://www.w3.org/2000/svg" {size}>'
    paper = '<rect width="100%" height="100%" fill="#ffffff"/>'
    return "\n".join((head, f"<style>\n{STYLE}{colours}</style>", paper, *parts, "</svg>\n"))


def named(frame: Frame) -> list[Drawn]:
    """The curves of a legend: none if the label of the vertical axis names the only one."""
    if len(frame.drawn) == 1 and frame.figure.y_label.startswith(frame.drawn[0].series.name):
        return []
    return frame.drawn


def notes(plot: Panels, width: int) -> list[str]:
    """The lines of the notes, each of at most about ``width`` letters."""
    return [line for note in plot.notes for line in textwrap.wrap(note, width, break_long_words=False)]


def rows(lengths: Sequence[float], width: float, space: float) -> list[list[int]]:
    """Entries of these lengths in rows of at most ``width``; at least one in each."""
    found: list[list[int]] = []
    used = 0.0
    for k, length in enumerate(lengths):
        if not found or used + space + length > width:
            found.append([k])
            used = length
        else:
            found[-1].append(k)
            used += space + length
    return found


def _legend(frame: Frame, classes: dict[str, str], top: float) -> tuple[list[str], float]:
    """Texts and samples, and the height of the legend: 0 if it fits next to the label of the vertical axis."""
    shown = named(frame)
    lengths = [SAMPLE + 6.0 + LETTER * len(drawn.series.name) for drawn in shown]
    start = 26.0 + LETTER * len(frame.y.titled(frame.figure.y_label))
    lines = rows(lengths, WIDTH - 4.0 - start, SPACE)
    beside = len(lines) == 1 and sum(lengths) + SPACE * len(lengths) + start < WIDTH
    if not beside:
        lines, start = rows(lengths, WIDTH - 4.0, SPACE), 2.0
    parts = []
    for j, line in enumerate(lines):
        x, y = start, top + (15.0 if beside else LINE * (j + 0.7))
        for k in line:
            sample = figure_svg.swatch(shown[k]).replace(
                "<svg ", f'<svg x="{x:.1f}" y="{y - 12.5:.1f}" width="{SAMPLE:g}" height="16" ', 1
            )
            parts.append(f'<g class="{classes[shown[k].series.name]}">{sample}</g>')
            parts.append(f'<text x="{x + SAMPLE + 6.0:.1f}" y="{y:.1f}">{escape(shown[k].series.name)}</text>')
            x += lengths[k] + SPACE
    return parts, 0.0 if beside or not lines else LINE * len(lines) + 6.0
