"""One frame of a motion as marks in pixels: the display list of a mechanism, placed and sized, with its overlays.

``canvas.js`` does the same in pages.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from mbdsl.viewing.display import ALONG, ON, TURNED, Beam, Circle, DrawnPath, Item
from mbdsl.viewing.marks import THEME, Array, DiscMark, LineMark, Mark, finite, hexadecimal, line, mixed, paled
from mbdsl.viewing.overlays import Overlays, Painted, colour_bar
from mbdsl.viewing.projection import drawing as shapes_of
from mbdsl.viewing.shapes import Drawing, behind, outline
from mbdsl.viewing.tracks import Tracks, largest_strain
from mbdsl.viewing.view import PictureView
from mbdsl.viewing.writers import pixels

if TYPE_CHECKING:
    from PIL import Image

GHOST = 0.28  #: opacity of another motion behind the first
EDGE = 2.5  #: width of both edges of a line together [px]
SHORT = 6.0  #: units of x along a line that is shorter than this number of them are a part of it
CURVE = np.linspace(0.0, 1.0, 13)[:, None]  #: where a parabola is evaluated
NOTHING_ELSE = Overlays()


class Picture(PictureView):
    """Draws frames of a motion, all in the same view."""

    def __init__(
        self, motion: Tracks, drawing: Drawing, width: int, height: int, overlays: Overlays = NOTHING_ELSE
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
        """The picture of a row of the motion, by Pillow."""
        return pixels(self.marks(row), *self.size)

    def marks(self, row: int) -> list[Mark]:
        """A row of the motion, the other motion behind it at the same time, and the overlays."""
        found: list[Mark] = []
        if (ghost := self.ghost) is not None:
            at = np.searchsorted(ghost.motion.t, self.motion.t[row], side="right") - 1
            found = paled(ghost.mechanism(max(0, int(at))), GHOST)
        found += self.mechanism(row)
        found += finite(list(self.overlays.marks(self)))
        if self.strain:
            beam = next(item for item in self.items if isinstance(item, Beam))
            found += colour_bar(self.size, hexadecimal(beam.stroke) or "", self.strain)
        return found

    def mechanism(self, row: int) -> list[Mark]:
        """The mechanism in a row of the motion."""
        self.row = row
        return finite([mark for item in self.items for mark in self._marks(item)])

    # -- items -------------------------------------------------------------------------------------------------------
    def _marks(self, item: Item) -> Iterator[Mark]:
        width = self.length(item.width)
        stroke = hexadecimal(item.stroke)
        if isinstance(item, Circle):
            x, y, _ = self.places(item.at)[0].tolist()
            yield DiscMark(x, y, self.length(item.radius), hexadecimal(item.fill), stroke, width)
        elif isinstance(item, Beam):
            yield from self._beam(item, width)
        else:
            points = self._points(item)
            fill = hexadecimal(item.fill)
            if item.hatch:
                yield from self._hatches(points, item.hatch)
                width *= 1.2
            parts = np.split(points, item.cuts) if item.cuts else [points]
            if item.edge:
                yield LineMark(parts, hexadecimal(item.edge), width, item.closed)
                width = max(1.0, width - EDGE)
            yield LineMark(parts, stroke, width, item.closed, fill, item.dashed)

    def _points(self, path: DrawnPath) -> Array:
        """The points (n, 2) of a path [px]."""
        places = self.places(path.at)
        if path.axes == ON:
            points = places[:, :2]
            if path.curved:
                ends = points[:1] + CURVE * (points[1:2] - points[:1])
                return ends + 4.0 * CURVE * (1.0 - CURVE) * (points[2:] - points[:2].mean(axis=0))
            is_hull = path.hull and np.isfinite(points).all()
            return np.array(outline(points.tolist())) if is_hull else points
        (x, y, phi), unit, turn = places[0].tolist(), self.U, np.zeros(1)
        found = self.scale * np.array(path.metres or [(0.0, 0.0)])
        if path.axes == ALONG:
            dx, dy = (places[1, :2] - places[0, :2]).tolist()
            length = float(np.hypot(dx, dy))
            phi = float(np.arctan2(-dy, dx)) if length > 1e-6 else phi
            unit = min(unit, length / SHORT)
            found = found + np.stack([length * np.array(path.share or [0.0]), np.zeros(len(path.share or [0]))], axis=1)
            if path.state:
                span = path.high - path.low
                part = min(1.0, max(0.0, (length / self.scale - path.low) / span)) if span > 0.0 else 0.5
                found[:, 0] += unit * part * np.array(path.state)
        elif path.axes == TURNED:
            own, phi = phi, float(places[1, 2])
            turn = max(-2 * np.pi, min(4 * np.pi, own - phi)) * np.array(path.state or [0.0])
        if path.units:
            found = found + np.array(path.units) * (unit, self.U)
        c, s = np.cos(phi + turn), np.sin(phi + turn)
        return np.stack([x + c * found[:, 0] - s * found[:, 1], y - s * found[:, 0] - c * found[:, 1]], axis=1)

    def _hatches(self, ends: Array, side: int) -> Iterator[LineMark]:
        """Short lines on one side of a line."""
        along = ends[1] - ends[0]
        length = float(np.hypot(*along))
        if not length > 0.0:
            return
        count = max(1, round(length / (0.55 * self.U)))
        t = along / length
        n = np.array([t[1], -t[0]]) * side
        for k in range(count):
            foot = ends[0] + (k + 0.5) / count * along
            stroke = np.stack([foot + 0.2 * self.U * t, foot + self.U * (0.5 * n - 0.25 * t)])
            yield line(stroke, 0.8 * self.thin, THEME["pale"])

    def _beam(self, beam: Beam, width: float) -> Iterator[LineMark]:
        points = self.motion.curves[beam.curve].points[self.row]
        points = np.stack([self.left + self.scale * points[:, 0], self.top - self.scale * points[:, 1]], axis=1)
        yield line(points, width + EDGE, hexadecimal(beam.edge) or "")
        shades = np.nan_to_num(self.strains[beam.curve][self.row] / (self.strain or 1.0))
        plain = hexadecimal(beam.stroke) or ""
        for k, part in enumerate(((shades[:-1] + shades[1:]) / 2).tolist()):
            yield line(points[k : k + 2], width, mixed(plain, THEME["hot"], part))


def _around(a: Sequence[float], b: Sequence[float]) -> tuple[float, float, float, float]:
    """The rectangle around two."""
    return min(a[0], b[0]), min(a[1], b[1]), max(a[2], b[2]), max(a[3], b[3])
