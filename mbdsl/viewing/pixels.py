"""Lines, areas and circles of pixels in the view of a motion, drawn by Pillow."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from typing import TYPE_CHECKING

import numpy as np

from mbdsl.plotting.series_styles import OTHERS
from mbdsl.viewing.motion import GROUND, Motion, Spot
from mbdsl.viewing.shape import Shape
from mbdsl.viewing.shapes import Drawing

if TYPE_CHECKING:
    from PIL import ImageDraw

INK, PALE, SHADE, FORCE, DRIVE, ROD, HOT = "#1f2328", "#57606a", "#eceef1", "#4b5563", "#b3360a", "#5f6b73", "#d81b60"
FINE = 2  #: pixels drawn for each pixel of the picture, per direction: smooth edges
MARGIN = 0.12  #: of the shorter side
Place = tuple[float, float, float]
Point = tuple[float, float]


def mixed(a: str, b: str, part: float) -> str:
    """A colour between two, ``part`` of the way from a to b."""
    x, y = ([int(c[k : k + 2], 16) for k in (1, 3, 5)] for c in (a, b))
    return "#" + "".join(f"{round(u + (v - u) * part):02x}" for u, v in zip(x, y, strict=True))


class Pixels:
    """The view of a motion and the primitives of its pictures; ``U`` is the size of symbols [px]."""

    draw: ImageDraw.ImageDraw
    row: int

    def __init__(self, motion: Motion, drawing: Drawing, width: int, height: int) -> None:
        self.motion, self.shapes = motion, drawing.shapes
        self.size = width, height
        x0, y0, x1, y1 = drawing.bounds
        margin = min(64.0, MARGIN * min(width, height))
        across = (width - 2 * margin) / max(x1 - x0, 1e-300), (height - 2 * margin) / max(y1 - y0, 1e-300)
        self.scale = min(across) if min(across) < 1e200 else 100.0 / drawing.unit
        self.left = width / 2 - self.scale * (x0 + x1) / 2
        self.top = height / 2 + self.scale * (y0 + y1) / 2
        self.U = min(26.0, 0.065 * min(width, height), max(2.5, drawing.unit * self.scale))
        self.thin = min(1.5, max(0.75, self.U / 8))
        self.unit = drawing.unit
        names = [c.name for c in motion.scene.bodies()]
        self.colours = {name: OTHERS[k % len(OTHERS)].light for k, name in enumerate(names)}

    def place(self, spot: Spot) -> Place:
        """A spot in pixels, y down, and its angle in the world, counter-clockwise."""
        if spot.track == GROUND:
            x, y, phi = spot.x, spot.y, spot.phi
        else:
            x, y, turn = self.motion.poses[self.row, spot.track].tolist()
            c, s = np.cos(turn), np.sin(turn)
            x, y, phi = x + c * spot.x - s * spot.y, y + s * spot.x + c * spot.y, turn + spot.phi
        return self.left + self.scale * x, self.top - self.scale * y, phi

    def colour(self, shape: Shape) -> str:
        """The colour of the body that a shape belongs to."""
        if shape.name in self.colours:
            return self.colours[shape.name]
        track = self.motion.tracks[shape.at[0].track] if shape.at and shape.at[0].track != GROUND else ""
        return self.colours.get(track, self.colours.get(track.rpartition(".")[0], PALE))

    # -- primitives ----------------------------------------------------------------------------------------------
    def line(self, points: Iterable[Point], width: float, colour: str) -> None:
        """A line with round corners and ends."""
        found = [(FINE * x, FINE * y) for x, y in points if np.isfinite(x) and np.isfinite(y)]
        if len(found) < 2:
            return
        pixels = max(1, round(FINE * width))
        self.draw.line(found, fill=colour, width=pixels, joint="curve")
        if pixels > 3:
            for x, y in (found[0], found[-1]):
                self.draw.ellipse((x - pixels / 2, y - pixels / 2, x + pixels / 2, y + pixels / 2), fill=colour)

    def area(self, points: Iterable[Point], fill: str, outline: str = INK, width: float | None = None) -> None:
        found = [(x, y) for x, y in points]
        if not np.isfinite(found).all():
            return
        self.draw.polygon([(FINE * x, FINE * y) for x, y in found], fill=fill)
        self.line([*found, found[0]], self.thin if width is None else width, outline)

    def areas(self, parts: Sequence[Sequence[Point]], fill: str) -> None:
        """Fill the points that are inside an odd number of closed lines."""
        fine = [[(FINE * x, FINE * y) for x, y in part] for part in parts]
        if not all(np.isfinite(part).all() for part in fine):
            return
        if len(fine) == 1:
            self.draw.polygon(fine[0], fill=fill)
            return
        from PIL import Image, ImageChops, ImageDraw

        size = FINE * self.size[0], FINE * self.size[1]
        inside = Image.new("1", size)
        for part in fine:
            one = Image.new("1", size)
            ImageDraw.Draw(one).polygon(part, fill=1)
            inside = ImageChops.logical_xor(inside, one)
        self.draw.bitmap((0, 0), inside, fill=fill)

    def circle(self, at: Sequence[float], radius: float, fill: str | None, outline: str = INK, width=None) -> None:
        x, y = at[:2]
        if not (np.isfinite(x) and np.isfinite(y)):
            return
        box = [FINE * v for v in (x - radius, y - radius, x + radius, y + radius)]
        self.draw.ellipse(box, fill=fill, outline=outline, width=max(1, round(FINE * (width or self.thin))))

    def label(self, at: Point, text: str, colour: str, size: float) -> None:
        """A text whose left end is centred vertically at a point; ``size`` is that of its letters."""
        from PIL import ImageFont

        try:
            font = ImageFont.load_default(FINE * size)
        except TypeError:  # before Pillow 10.1: a font of one size, too small here
            return
        self.draw.text((FINE * at[0], FINE * at[1]), text, fill=colour, font=font, anchor="lm")

    def axes(self, place: Sequence[float], angle: float | None = None) -> Callable[[float, float], Point]:
        """A function from coordinates in the axes of a place, y down for angle 0, to pixels."""
        phi = place[2] if angle is None else angle
        c, s = np.cos(phi), np.sin(phi)
        return lambda x, y: (place[0] + c * x + s * y, place[1] - s * x + c * y)

    def hatched(self, at: Callable[[float, float], Point], a: float, b: float, y: float, side: float) -> None:
        count = max(1, round((b - a) / (0.55 * self.U)))
        for k in range(count):
            x = a + (k + 0.5) * (b - a) / count
            ends = at(x + 0.2 * self.U, y), at(x - 0.25 * self.U, y + side * 0.5 * self.U)
            self.line(ends, 0.8 * self.thin, PALE)
        self.line([at(a, y), at(b, y)], 1.2 * self.thin, INK)

    def between(self, p: Place, q: Place) -> tuple[Callable[[float, float], Point], float]:
        """Axes along the line from p to q, and its length."""
        dx, dy = q[0] - p[0], q[1] - p[1]
        return self.axes(p, float(np.arctan2(-dy, dx))), float(np.hypot(dx, dy))

    def head(self, at: Callable[[float, float], Point], colour: str, size: float) -> None:
        self.area([at(0.4 * size, 0.0), at(-0.6 * size, 0.45 * size), at(-0.6 * size, -0.45 * size)], colour, colour)
