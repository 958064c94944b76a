"""Marks of a picture in pixels: lines, areas, discs and texts, which the writers draw."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from mbdsl.kernels.arrays import Array
from mbdsl.plotting.series_styles import LIGHT_PAPER, OTHERS
from mbdsl.viewing.display import Colour

#: the colours of ``player.css`` on light paper
THEME = {
    **{f"s{k}": look.light for k, look in enumerate(OTHERS)},
    "ink": "#1f2328",
    "pale": "#57606a",
    "paper": LIGHT_PAPER,
    "shade": "#eceef1",
    "force": "#4b5563",
    "drive": "#b3360a",
    "rod": "#5f6b73",
    "hot": "#d81b60",
    "load": "#c2185b",
    "reaction": "#00758f",
}
DASH = (5.0, 4.0)  #: lengths of dashes and of gaps [px]


class LineMark(NamedTuple):
    """Open or closed lines through points (n, 2) [px], y down; ``fill`` is inside of an odd number of them."""

    parts: Sequence[Array]
    stroke: str | None
    width: float
    closed: bool = False
    fill: str | None = None
    dashed: bool = False


class DiscMark(NamedTuple):
    """A disc about a point [px]."""

    x: float
    y: float
    radius: float
    fill: str | None
    stroke: str | None
    width: float


class TextMark(NamedTuple):
    """A text that is centred at a point [px], or begins there."""

    x: float
    y: float
    words: str
    colour: str
    size: float
    centred: bool = False


Mark = LineMark | DiscMark | TextMark


def hexadecimal(colour: Colour) -> str | None:
    """The "#rrggbb" of a colour on light paper."""
    if colour is None or isinstance(colour, str):
        return None if colour is None else THEME.get(colour, colour)
    a, b, part = colour
    return mixed(THEME.get(a, a), THEME.get(b, b), part)


def mixed(a: str, b: str, part: float) -> str:
    """A colour between two, ``part`` of the way from a to b."""
    x, y = ([int(c[k : k + 2], 16) for k in (1, 3, 5)] for c in (a, b))
    return "#" + "".join(f"{round(u + (v - u) * part):02x}" for u, v in zip(x, y, strict=True))


def line(points: Array, width: float, colour: str, dashed: bool = False) -> LineMark:
    """An open line through points (n, 2) [px]."""
    return LineMark([np.asarray(points, float)], colour, width, dashed=dashed)


def finite(marks: Sequence[Mark]) -> list[Mark]:
    """Marks without points that are not numbers: open lines leave them out, other marks are left out."""
    found: list[Mark] = []
    for mark in marks:
        if not isinstance(mark, LineMark):
            if np.isfinite(mark.x) and np.isfinite(mark.y):
                found.append(mark)
        elif all(np.isfinite(part).all() for part in mark.parts):
            found.append(mark)
        elif not mark.closed:
            parts = [part[np.isfinite(part).all(axis=1)] for part in mark.parts]
            found.append(mark._replace(parts=[part for part in parts if len(part) > 1]))
    return found


def paled(marks: Sequence[Mark], part: float) -> list[Mark]:
    """Marks on paper that shows through them; ``part`` of their own colours remains."""

    def pale(colour: str | None) -> str | None:
        return None if colour is None else mixed(LIGHT_PAPER, colour, part)

    def whole(mark: Mark) -> Mark:
        if isinstance(mark, TextMark):
            return mark._replace(colour=pale(mark.colour) or "")
        return mark._replace(fill=pale(mark.fill), stroke=pale(mark.stroke))

    return [whole(mark) for mark in marks]
