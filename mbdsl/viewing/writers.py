"""Writers of the marks of a picture: SVG, of which matplotlib makes PDF, and pixels by Pillow."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from mbdsl.plotting.escaping import escape
from mbdsl.plotting.series_styles import LIGHT_PAPER
from mbdsl.viewing.marks import DASH, Array, DiscMark, Mark, TextMark

if TYPE_CHECKING:
    from PIL import Image, ImageDraw

FINE = 2  #: pixels drawn for each pixel of the picture, per direction: smooth edges


# -- SVG ---------------------------------------------------------------------------------------------------------------
def svg_element(mark: Mark) -> str:
    """A mark as an element of SVG."""
    if isinstance(mark, TextMark):
        look = 'text-anchor="middle"' if mark.centred else 'dominant-baseline="central"'
        if not mark.centred:
            look += f' fill="{mark.colour}" font-size="{mark.size:g}" font-family="system-ui, sans-serif"'
        return f'<text x="{mark.x:.1f}" y="{mark.y:.1f}" {look}>{escape(mark.words)}</text>'
    look = f'fill="{escape(mark.fill or "none")}"'
    if mark.stroke:
        look += f' stroke="{escape(mark.stroke)}" stroke-width="{mark.width:.2f}"'
    if isinstance(mark, DiscMark):
        return f'<circle {look} cx="{mark.x:.2f}" cy="{mark.y:.2f}" r="{mark.radius:.2f}"/>'
    if mark.fill and len(mark.parts) > 1:
        look += ' fill-rule="evenodd"'
    if mark.dashed:
        look += f' stroke-dasharray="{DASH[0]:g} {DASH[1]:g}"'
    end = "Z" if mark.closed else ""
    ways = ("M" + "L".join(f"{x:.2f} {y:.2f}" for x, y in part.tolist()) + end for part in mark.parts)
    return f'<path {look} d="{"".join(ways)}"/>'


def svg(marks: Sequence[Mark], width: int, height: int) -> str:
    """An SVG file on light paper."""
    head = f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width} {height}" width="{width}" '
    head += f'height="{height}" stroke-linejoin="round" stroke-linecap="round">'
    paper = f'<rect width="100%" height="100%" fill="{LIGHT_PAPER}"/>'
    return "\n".join((head, paper, *map(svg_element, marks), "</svg>\n"))


# -- pixels ------------------------------------------------------------------------------------------------------------
def pixels(marks: Sequence[Mark], width: int, height: int) -> Image.Image:
    """A picture of pixels on light paper."""
    from PIL import Image, ImageDraw

    image = Image.new("RGB", (FINE * width, FINE * height), LIGHT_PAPER)
    draw = ImageDraw.Draw(image)
    for mark in marks:
        if isinstance(mark, TextMark):
            _text(draw, mark)
        elif isinstance(mark, DiscMark):
            x, y, r = FINE * mark.x, FINE * mark.y, FINE * mark.radius
            width_ = max(1, round(FINE * mark.width)) if mark.stroke else 0
            draw.ellipse((x - r, y - r, x + r, y + r), fill=mark.fill, outline=mark.stroke, width=width_)
        else:
            parts = [FINE * part for part in mark.parts]
            if mark.fill:
                _area(image, draw, parts, mark.fill)
            for part in parts if mark.stroke else ():
                _line(draw, np.concatenate([part, part[:1]]) if mark.closed else part, mark.stroke, mark.width)
    return image.reduce(FINE)


def _area(image: Image.Image, draw: ImageDraw.ImageDraw, parts: Sequence[Array], fill: str) -> None:
    """The points that are inside of an odd number of closed lines."""
    if len(parts) == 1:
        draw.polygon([tuple(p) for p in parts[0].tolist()], fill=fill)
        return
    from PIL import Image, ImageChops, ImageDraw

    inside = Image.new("1", image.size)
    for part in parts:
        own = Image.new("1", image.size)
        ImageDraw.Draw(own).polygon([tuple(p) for p in part.tolist()], fill=1)
        inside = ImageChops.logical_xor(inside, own)
    draw.bitmap((0, 0), inside, fill=fill)


def _line(draw: ImageDraw.ImageDraw, points: Array, colour: str | None, width: float) -> None:
    """A line with round corners and ends."""
    if len(points) < 2:
        return
    thick = max(1, round(FINE * width))
    draw.line([tuple(p) for p in points.tolist()], fill=colour, width=thick, joint="curve")
    if thick > 3:
        for x, y in (points[0].tolist(), points[-1].tolist()):
            draw.ellipse((x - thick / 2, y - thick / 2, x + thick / 2, y + thick / 2), fill=colour)


def _text(draw: ImageDraw.ImageDraw, mark: TextMark) -> None:
    from PIL import ImageFont

    try:
        font = ImageFont.load_default(FINE * mark.size)
    except TypeError:  # before Pillow 10.1: a font of one size, too small here
        return
    draw.text((FINE * mark.x, FINE * mark.y), mark.words, fill=mark.colour, font=font, anchor="lm")
