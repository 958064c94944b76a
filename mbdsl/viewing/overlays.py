"""What a film shows in addition to the mechanism, as the page does: paths of points, arrows, another motion behind."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from mbdsl.kernels.arrays import Array
from mbdsl.plotting.series_styles import LIGHT_PAPER, OTHERS
from mbdsl.viewing.display import head
from mbdsl.viewing.marks import THEME, DiscMark, LineMark, Mark, TextMark, line, mixed
from mbdsl.viewing.tracks import Tracks
from mbdsl.viewing.vectors import FORCES, Vector, largest
from mbdsl.viewing.view import PictureView

LONGEST = 0.22  #: length of the longest arrow relative to the shorter side of the picture
BAR, BAR_AT, LETTERS = (90, 8), (14, 26), 12  #: size and place of the colour bar, size of letters [px]
PALE_PATH = 0.3  #: of a path's colour, for the part that is still to come


@dataclass(frozen=True)
class Overlays:
    """Names of frames whose paths are drawn, arrows, and a motion that is drawn pale behind the first.

    With ``one_scale``, arrows of forces and reactions of the same size have the same length.
    """

    traced: Sequence[str] = ()
    vectors: Sequence[Vector] = ()
    ghost: Tracks | None = None
    one_scale: bool = False


class Painted:
    """The overlays of a motion, prepared for all of its frames."""

    def __init__(self, overlays: Overlays, motion: Tracks) -> None:
        self.paths = [motion.positions(motion.spot_of(name)) for name in overlays.traced]
        self.vectors = list(overlays.vectors)
        self.largest = largest(self.vectors, overlays.one_scale)

    def marks(self, p: PictureView) -> Iterator[Mark]:
        """Paths, pale as a whole and strong up to the present, with a dot at the point; arrows."""
        lines = []
        for k, path in enumerate(self.paths):
            points = np.column_stack([p.left + p.scale * path[:, 0], p.top - p.scale * path[:, 1]])
            lines.append((points, OTHERS[k % len(OTHERS)].light))
        for points, colour in lines:
            yield line(points, 1.6, mixed(LIGHT_PAPER, colour, PALE_PATH))
            yield line(points[: p.row + 1], 1.6, colour)
        for points, colour in lines:
            yield DiscMark(points[p.row, 0], points[p.row, 1], 2.6, colour, LIGHT_PAPER, p.thin)
        for v in self.vectors:
            values = np.nan_to_num(v.values[p.row]) / (self.largest[v.key] or 1.0)
            colour = THEME["load" if v.group == FORCES else "reaction"]
            place = p.places([v.at])[0, :2]
            if len(values) == 2:
                yield from _arrow(place, LONGEST * min(p.size) * values, colour)
            else:
                yield from _turning(place, 1.6 * p.U + 6.0, float(values[0]), colour)


def _head(at: Array, direction: Array, size: float, colour: str) -> LineMark:
    """The head of an arrow in a direction (x, y), y up."""
    points = np.array(head(0.0, 0.0, tuple(direction.tolist()), size)) * (1.0, -1.0)
    return LineMark([at + points], colour, 1.0, True, colour)


def _arrow(start: Array, by: Array, colour: str) -> Iterator[LineMark]:
    """An arrow by (x, y) pixels, y up."""
    length = float(np.hypot(*by))
    if length >= 2.0:
        size, along = min(9.0, 0.6 * length), by / length
        end, back = start + by * (1.0, -1.0), along * (1.0, -1.0)
        yield line(np.stack([start, end - 0.5 * size * back]), 2.0, colour)
        yield _head(end - 0.4 * size * back, along, size, colour)


def _turning(at: Array, radius: float, part: float, colour: str) -> Iterator[LineMark]:
    """An arc, counter-clockwise for positive values; ``part`` is relative to the largest of the motion."""
    if abs(part) >= 0.01:
        angles = np.linspace(0.0, 4.7 * part, 40)
        points = at + radius * np.stack([np.cos(angles), -np.sin(angles)], axis=1)
        yield line(points, 2.0, colour)
        last = angles[-1] + np.sign(part) * np.pi / 2
        yield _head(points[-1], np.array([np.cos(last), np.sin(last)]), 9.0, colour)


def colour_bar(size: tuple[int, int], pale: str, most: float) -> Iterator[Mark]:
    """The colours of beams, from no strain to the largest, in the lower left corner."""
    left, top = BAR_AT[0], size[1] - BAR_AT[1]
    for k in range(2 * BAR[0]):
        x, shade = left + k / 2, mixed(pale, THEME["hot"], k / (2 * BAR[0]))
        yield line(np.array([(x, top), (x, top + BAR[1])]), 0.5, shade)
    corners = [(left, top), (left + BAR[0], top), (left + BAR[0], top + BAR[1]), (left, top + BAR[1])]
    yield LineMark([np.array(corners, float)], THEME["pale"], 0.75, closed=True)
    words = f"bending strain 0 ... {most:.3g}"
    yield TextMark(left + BAR[0] + 8, top + BAR[1] / 2, words, THEME["pale"], LETTERS)
