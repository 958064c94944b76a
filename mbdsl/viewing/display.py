"""Display lists: paths and circles in the axes of frames, of which all pictures of a mechanism consist.

A list is made once for a motion. Pages, films and files draw it at any time and in any size: ``canvas.js`` and
``picture.py`` place its points by the poses of its frames. Lengths are in metres, which follow the zoom, or in units:
the size of symbols, which is limited in pixels.
"""

from __future__ import annotations

from dataclasses import dataclass, fields
from typing import Any, NamedTuple

from mbdsl.viewing.tracks import Frame, Tracks

#: a name of the theme ("ink", "s0"), "#rrggbb", or a mixture (colour, colour, part of the second); None: not drawn
Colour = str | tuple[str, str, float] | None
Points = tuple[tuple[float, float], ...]

BODIES = 8  #: number of colours of bodies
INK, PALE, PAPER, SHADE, FORCE, DRIVE, ROD = "ink", "pale", "paper", "shade", "force", "drive", "rod"
#: how a path is placed: in the axes of its frame, with the angle of a second frame, along the line to a second frame,
#: or by one frame for each point
OWN, TURNED, ALONG, ON = "own", "turned", "along", "on"


class Size(NamedTuple):
    """A length of a picture: ``units`` + ``metres`` + ``thin``, at least ``least`` [px]; ``thin`` is for thin lines."""

    least: float = 0.0
    units: float = 0.0
    metres: float = 0.0
    thin: float = 0.0


THIN, THICK = Size(thin=1.0), Size(2.5, 0.42)


@dataclass(frozen=True)
class DrawnPath:
    """A line or an area of n points."""

    at: tuple[Frame, ...]  #: frames that place it
    axes: str = OWN  #: how they do: ``OWN``, ``TURNED``, ``ALONG`` or ``ON``
    #: Coordinates in the axes [m] and [units], which are added. Along a line, units of x are at most a sixth of it.
    metres: Points = ()
    units: Points = ()
    share: tuple[float, ...] = ()  #: of the length of the line to the second frame, which is added to x
    #: what the state adds: with ``ALONG`` units of x times the stroke, which is 0 at the length ``low`` [m] of the line
    #: and 1 at ``high``; with ``TURNED`` a rotation by this part of the angle between the frames
    state: tuple[float, ...] = ()
    low: float = 0.0
    high: float = 0.0
    cuts: tuple[int, ...] = ()  #: numbers of the points at which further parts begin
    #: whether the last point is connected with the first, whether three points are a parabola's ends and middle, and
    #: whether the path is the convex hull of the points
    closed: bool = False
    curved: bool = False
    hull: bool = False
    hatch: int = 0  #: 1 or -1: hatched on the left or the right
    dashed: bool = False  #: whether the line is dashed
    #: colours of the area, of the line, and of its edges, which are inside of the width
    fill: Colour = None
    stroke: Colour = INK
    edge: Colour = None
    width: Size = THIN  #: width of the line


@dataclass(frozen=True)
class Circle:
    """A circle about a frame."""

    at: tuple[Frame]
    radius: Size
    fill: Colour = None
    stroke: Colour = INK
    width: Size = THIN


@dataclass(frozen=True)
class Beam:
    """The curve of this number between two edges, in shades of its strain from the colour to that of hot things."""

    curve: int
    stroke: Colour
    edge: Colour
    width: Size = THICK


Item = DrawnPath | Circle | Beam


@dataclass(frozen=True)
class Shape:
    """What is drawn for a body or an element: ``draw`` is the kind of drawing, which determines the order.

    Shapes that reach beyond their frames have a ``radius`` [m].
    """

    draw: str
    name: str
    at: tuple[Frame, ...]
    items: tuple[Item, ...]
    radius: float = 0.0


def values_of(item: Item) -> dict[str, Any]:
    """The fields of an item that differ from their defaults, without its frames."""
    return {f.name: value for f in fields(item) if f.name != "at" and (value := getattr(item, f.name)) != f.default}


def colour_of(motion: Tracks, owner: str | Frame) -> str:
    """The colour of a body, or of that on whose track a frame is."""
    if not isinstance(owner, str):
        owner = motion.owner(owner)
    k = motion.order.get(owner)
    return PALE if k is None else f"s{k % BODIES}"


def square(half: float, height: float | None = None) -> Points:
    """The corners of a square or a rectangle about the origin."""
    x, y = half, half if height is None else height
    return ((-x, -y), (x, -y), (x, y), (-x, y))


def head(x: float, y: float, across: tuple[float, float], size: float = 0.75) -> Points:
    """The head of an arrow at a point, in the direction of the unit vector ``across``."""
    c, s = across
    corners = ((0.4, 0.0), (-0.6, 0.45), (-0.6, -0.45))
    return tuple((x + size * (c * u - s * v), y + size * (s * u + c * v)) for u, v in corners)
