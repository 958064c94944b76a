"""One frame of a motion as a picture of pixels, for films: the shapes of the page, drawn by Pillow.

Sizes and colours are those of ``drawing.js`` and ``elements.js``, on light paper.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from mbdsl.plotting.series_styles import LIGHT_PAPER, OTHERS
from mbdsl.viewing.gear_pictures import DRAWN as GEARS
from mbdsl.viewing.motion import Motion, largest_strain
from mbdsl.viewing.overlays import Overlays, Painted, colour_bar
from mbdsl.viewing.pixels import DRIVE, FINE, FORCE, HOT, INK, PALE, ROD, SHADE, Pixels, Place, mixed
from mbdsl.viewing.shape import Shape
from mbdsl.viewing.shapes import Drawing, behind
from mbdsl.viewing.shapes import drawing as shapes_of

if TYPE_CHECKING:
    from PIL import Image


GHOST = 0.28  #: opacity of another motion behind the first
NOTHING_ELSE = Overlays()
ELLIPSE = 72  #: sides of the polygon that is drawn for an ellipse
MANY = 600  #: number of shapes from which links are lines and pins are left out


class Picture(Pixels):
    """Draws frames of a motion, all in the same view."""

    def __init__(
        self, motion: Motion, drawing: Drawing, width: int, height: int, overlays: Overlays = NOTHING_ELSE
    ) -> None:
        self.ghost: Picture | None = None
        if (other := overlays.ghost) is not None:
            back = behind(shapes_of(other), drawing)
            drawing = replace(drawing, bounds=_around(drawing.bounds, back.bounds))
            self.ghost = Picture(other, replace(back, bounds=drawing.bounds, unit=drawing.unit), width, height)
            self.ghost.strain = np.inf  # its beams have the colours of their bodies
        super().__init__(motion, drawing, width, height)
        self.overlays = Painted(overlays, motion)
        self.strains = [curve.strain() for curve in motion.curves]
        self.strain = largest_strain(motion.curves)

    def frame(self, row: int) -> Image.Image:
        """The picture of a row of the motion."""
        from PIL import Image, ImageDraw

        width, height = self.size
        image = Image.new("RGB", (FINE * width, FINE * height), LIGHT_PAPER)
        if (ghost := self.ghost) is not None:
            at = np.searchsorted(ghost.motion.t, self.motion.t[row], side="right") - 1
            ghost.draw = ImageDraw.Draw(image)
            ghost.shown(max(0, int(at)))
            image = Image.blend(Image.new("RGB", image.size, LIGHT_PAPER), image, GHOST)
        self.draw, self.row = ImageDraw.Draw(image), row
        self.shown(row)
        self.overlays.draw(self)
        if self.strain:
            colour_bar(self, self.colours[self.motion.curves[0].body], self.strain)
        return image.reduce(FINE)

    def shown(self, row: int) -> None:
        """Draw the mechanism in a row of the motion."""
        self.row = row
        many = len(self.shapes) > MANY
        for shape in self.shapes:
            if many and shape.draw in ("link", "pin"):
                if shape.draw == "link":
                    _plain_link(self, shape, self.place(shape.at[0]))
            elif (act := DRAWN.get(shape.draw)) is not None:
                act(self, shape, *(self.place(spot) for spot in shape.at))


def _around(a: Sequence[float], b: Sequence[float]) -> tuple[float, float, float, float]:
    """The rectangle around two."""
    return min(a[0], b[0]), min(a[1], b[1]), max(a[2], b[2]), max(a[3], b[3])


# -- shapes ------------------------------------------------------------------------------------------------------------
def _link(p: Pixels, shape: Shape, place: Place) -> None:
    at, colour = p.axes(place), p.colour(shape)
    points = [at(p.scale * x, -p.scale * y) for x, y in shape.data["points"]]
    pale, width = mixed(colour, LIGHT_PAPER, 0.72), 0.85 * p.U
    closed = [*points, points[0]] if len(points) > 2 else points
    p.line(closed, width, colour)
    if len(points) > 2:
        for corner in points:  # round corners
            p.circle(corner, width / 2, colour, colour)
        p.area(points, pale, pale, 1.0)
        for corner in points:
            p.circle(corner, width / 2 - 1.25, pale, pale)
    p.line(closed, max(1.0, width - 2.5), pale)


def _plain_link(p: Pixels, shape: Shape, place: Place) -> None:
    at = p.axes(place)
    points = [at(p.scale * x, -p.scale * y) for x, y in shape.data["points"]]
    p.line(points, max(1.6, 0.5 * p.U), OTHERS[0].light)


def _beam(p: Picture, shape: Shape) -> None:
    curve = p.motion.curves[shape.data["beam"]]
    points = [(p.left + p.scale * x, p.top - p.scale * y) for x, y in curve.points[p.row].tolist()]
    shades = (p.strains[shape.data["beam"]][p.row] / (p.strain or 1.0)).tolist()
    width, colour = max(2.5, 0.42 * p.U), p.colour(shape)
    p.line(points, width + 2.5, colour)
    for k in range(len(points) - 1):
        part = (shades[k] + shades[k + 1]) / 2
        p.line(points[k : k + 2], width, mixed(mixed(colour, LIGHT_PAPER, 0.72), HOT, part if part == part else 0.0))


def _outline(p: Pixels, shape: Shape, place: Place) -> None:
    at, data, body = p.axes(place), shape.data, p.colour(shape)
    if data["form"] == "ellipse":
        (x, y), (a, b, phi) = data["parts"][0][0], data["axes"]
        turn = 2 * np.pi * np.arange(ELLIPSE) / ELLIPSE
        px, py = a * np.cos(turn), b * np.sin(turn)
        c, s = np.cos(phi), np.sin(phi)
        parts = [list(zip(x + c * px - s * py, y + s * px + c * py, strict=True))]
    else:
        parts = data["parts"]
    lines = [[at(p.scale * x, -p.scale * y) for x, y in part] for part in parts]
    if data["form"] != "line":
        if data["fill"] != "none":
            p.areas(lines, data["fill"] or mixed(body, LIGHT_PAPER, 0.72))
        lines = [[*part, part[0]] for part in lines]
    if data["line"] != "none":
        for part in lines:
            p.line(part, max(1.2, p.scale * data["width"]), data["line"] or body)


def _block(p: Pixels, shape: Shape, place: Place, axis: Place) -> None:
    at, colour, x, y = p.axes(place, axis[2]), p.colour(shape), 1.15 * p.U, 0.78 * p.U
    corners = [at(-x, -y), at(x, -y), at(x, y), at(-x, y)]
    p.area(corners, mixed(colour, LIGHT_PAPER, 0.6), mixed(colour, INK, 0.4))


def _wheel(p: Pixels, shape: Shape, place: Place) -> None:
    at, colour, radius = p.axes(place), p.colour(shape), shape.data["radius"] * p.scale
    p.circle(place, radius, mixed(colour, LIGHT_PAPER, 0.85), colour, 2.0)
    p.line([at(0, -radius), at(0, radius)], p.thin, mixed(colour, LIGHT_PAPER, 0.5))
    p.line([at(-radius, 0), at(radius, 0)], p.thin, colour)
    p.circle(at(0.78 * radius, 0), max(1.5, 0.07 * radius), colour, colour)
    p.circle(place, max(2.0, 0.25 * p.U), LIGHT_PAPER)


def _hub(p: Pixels, shape: Shape, place: Place) -> None:
    colour = p.colour(shape)
    p.circle(place, 0.95 * p.U, mixed(colour, LIGHT_PAPER, 0.72), colour)
    p.line([place[:2], p.axes(place)(0.95 * p.U, 0.0)], p.thin, colour)


def _support(p: Pixels, shape: Shape, place: Place) -> None:
    at, down = p.axes(place, 0.0), 1.0 if shape.data["side"] < 0 else -1.0
    base = 1.25 * p.U * down
    p.area([at(0, 0), at(-0.8 * p.U, base), at(0.8 * p.U, base)], SHADE)
    p.hatched(at, -1.25 * p.U, 1.25 * p.U, base, down)


def _wall(p: Pixels, shape: Shape, a: Place, b: Place) -> None:
    apart = np.hypot(b[0] - a[0], b[1] - a[1]) > 1e-6
    angle = float(np.arctan2(a[1] - b[1], b[0] - a[0])) if apart else a[2]
    p.hatched(p.axes(a, angle + np.pi / 2), -1.3 * p.U, 1.3 * p.U, 0.0, -1.0)


def _guide(p: Pixels, shape: Shape, place: Place) -> None:
    a, b = shape.data["from"] * p.scale - 2 * p.U, shape.data["to"] * p.scale + 2 * p.U
    at, side = p.axes(place), 1.0 if shape.data["side"] < 0 else -1.0
    if shape.data["fixed"]:
        p.hatched(at, a, b, side * 0.8 * p.U, side)
    else:
        p.line([at(a, side * 0.8 * p.U), at(b, side * 0.8 * p.U)], 0.3 * p.U, PALE)


def _slot(p: Pixels, shape: Shape, place: Place) -> None:
    at = p.axes(place)
    ends = [at(shape.data[key] * p.scale, 0.0) for key in ("from", "to")]
    p.line(ends, 0.95 * p.U, PALE)
    p.line(ends, 0.95 * p.U - 2 * p.thin, LIGHT_PAPER)


def _floor(p: Pixels, shape: Shape, place: Place) -> None:
    at, a, b = p.axes(place), shape.data["from"] * p.scale, shape.data["to"] * p.scale
    if shape.data["fixed"]:
        p.hatched(at, a, b, 0.0, 1.0)
    else:
        p.line([at(a, 0.0), at(b, 0.0)], 2 * p.thin, INK)


def _square(p: Pixels, place: Place, radius: float, fill: str, turn: float = 0.0) -> None:
    at = p.axes(place, place[2] + turn)
    p.area([at(-radius, -radius), at(radius, -radius), at(radius, radius), at(-radius, radius)], fill)


def _zigzag(p: Pixels, shape: Shape, at, a: float, b: float, y: float, height: float) -> None:
    coils = min(24, max(3, round(shape.data["mean"] / p.unit / 1.1)))
    lead = min(0.8 * p.U, 0.15 * (b - a))
    step = (b - a - 2 * lead) / (2 * coils)
    tops = [at(a + lead + (k + 0.5) * step, y + (-height if k % 2 else height)) for k in range(2 * coils)]
    p.line([at(a, y), at(a + lead, y), *tops, at(b - lead, y), at(b, y)], 1.3 * p.thin, FORCE)


def _dashpot(p: Pixels, shape: Shape, at, a: float, b: float, y: float, height: float) -> None:
    low, high, width = shape.data["low"], shape.data["high"], 1.3 * p.thin
    part = min(1.0, max(0.0, ((b - a) / p.scale - low) / (high - low))) if high > low else 0.5
    length = min(3 * p.U, 0.45 * (b - a))
    start = a + 0.25 * (b - a - length)
    piston = start + (0.2 + 0.6 * part) * length
    p.line([at(a, y), at(start, y)], width, FORCE)
    walls = (start + length, -height), (start, -height), (start, height), (start + length, height)
    p.line([at(x, y + d) for x, d in walls], width, FORCE)
    p.line([at(piston, y - 0.75 * height), at(piston, y + 0.75 * height)], 1.6 * width, FORCE)
    p.line([at(piston, y), at(b, y)], width, FORCE)


def _spring(p: Pixels, shape: Shape, a: Place, b: Place) -> None:
    at, length = p.between(a, b)
    _zigzag(p, shape, at, 0.0, length, 0.0, 0.55 * p.U)


def _damper(p: Pixels, shape: Shape, a: Place, b: Place) -> None:
    at, length = p.between(a, b)
    _dashpot(p, shape, at, 0.0, length, 0.0, 0.45 * p.U)


def _spring_damper(p: Pixels, shape: Shape, a: Place, b: Place) -> None:
    (at, length), y = p.between(a, b), 0.7 * p.U
    lead = min(0.7 * p.U, 0.12 * length)
    for start, end in ((0.0, lead), (length, length - lead)):
        p.line([at(start, 0.0), at(end, 0.0)], 1.3 * p.thin, FORCE)
        p.line([at(end, -y), at(end, y)], 1.3 * p.thin, FORCE)
    _zigzag(p, shape, at, lead, length - lead, -y, 0.42 * p.U)
    _dashpot(p, shape, at, lead, length - lead, y, 0.36 * p.U)


def _spiral(p: Pixels, shape: Shape, b: Place, a: Place) -> None:
    turns = 4 * np.pi + max(-2 * np.pi, min(4 * np.pi, b[2] - a[2]))
    angle, radius = a[2] + turns * np.arange(61) / 60, p.U * (1.55 - 1.15 * np.arange(61) / 60)
    p.line(zip(b[0] + radius * np.cos(angle), b[1] - radius * np.sin(angle), strict=True), 1.2 * p.thin, FORCE)


def _bushing(p: Pixels, shape: Shape, b: Place, a: Place) -> None:
    p.circle(a, 0.85 * p.U, mixed(FORCE, LIGHT_PAPER, 0.7), FORCE)
    p.circle(b, 0.3 * p.U, LIGHT_PAPER)


def _turning(p: Pixels, shape: Shape, place: Place, _: Place) -> None:
    at, radius, angles = p.axes(place), 1.75 * p.U, np.linspace(-0.35, 2.6, 40)
    p.line([at(radius * np.cos(u), -radius * np.sin(u)) for u in angles], 1.8 * p.thin, DRIVE)
    tip = at(radius * np.cos(2.6), -radius * np.sin(2.6))
    p.head(p.axes(tip, place[2] + 2.6 + np.pi / 2), DRIVE, 0.75 * p.U)


def _pushing(p: Pixels, shape: Shape, place: Place, axis: Place) -> None:
    at = p.axes(place, axis[2])
    p.line([at(-1.1 * p.U, -1.4 * p.U), at(0.9 * p.U, -1.4 * p.U)], 1.8 * p.thin, DRIVE)
    p.head(p.axes(at(1.2 * p.U, -1.4 * p.U), axis[2]), DRIVE, 0.75 * p.U)


def _actuator(p: Pixels, shape: Shape, a: Place, b: Place) -> None:
    at, length = p.between(a, b)
    body = min(0.6 * length, max(0.35 * length, 4 * p.U))
    p.line([at(0.0, 0.0), at(body, 0.0)], 0.8 * p.U, ROD)
    p.line([at(body, 0.0), at(length, 0.0)], 0.35 * p.U, DRIVE)


def _blade(p: Pixels, shape: Shape, place: Place, _: Place) -> None:
    at = p.axes(place)
    p.line([at(-1.1 * p.U, 0.0), at(1.1 * p.U, 0.0)], max(2.5, 0.3 * p.U), INK)


def _disc(p: Pixels, shape: Shape, *rim: Place) -> None:
    colour = p.colour(shape)
    p.area([place[:2] for place in rim], mixed(colour, LIGHT_PAPER, 0.78), colour, 1.5)


DRAWN: dict[str, Callable[..., Any]] = {
    "link": _link,
    "beam": _beam,
    "outline": _outline,
    "backdrop": _outline,
    "mass": lambda p, shape, at: p.circle(at, 0.72 * p.U, mixed(p.colour(shape), LIGHT_PAPER, 0.25)),
    "hub": _hub,
    "block": _block,
    "wheel": _wheel,
    "pin": lambda p, shape, at: p.circle(at, max(1.5, 0.27 * p.U), LIGHT_PAPER),
    "support": _support,
    "wall": _wall,
    "guide": _guide,
    "slot": _slot,
    "floor": _floor,
    "weld": lambda p, shape, at: _square(p, at, 0.32 * p.U, INK),
    "mark": lambda p, shape, at, _: _square(p, at, 0.5 * p.U, LIGHT_PAPER, np.pi / 4),
    "blade": _blade,
    "bar": lambda p, shape, a, b: p.line([a[:2], b[:2]], max(3.0, 0.5 * p.U), p.colour(shape)),
    "disc": _disc,
    "rod": lambda p, shape, a, b: p.line([a[:2], b[:2]], max(2.0, 0.22 * p.U), ROD),
    "dashed": lambda p, shape, a, b: p.line([a[:2], b[:2]], p.thin, FORCE),
    "actuator": _actuator,
    "spring": _spring,
    "damper": _damper,
    "spring-damper": _spring_damper,
    "spiral": _spiral,
    "bushing": _bushing,
    "turning": _turning,
    "pushing": _pushing,
    **GEARS,
}
