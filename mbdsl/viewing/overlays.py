"""What a film shows in addition to the mechanism, as the page does: paths of points, arrows, another motion behind."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mbdsl.plotting.series_styles import LIGHT_PAPER, OTHERS
from mbdsl.viewing.motion import Motion
from mbdsl.viewing.pixels import FINE, HOT, PALE, Pixels, mixed
from mbdsl.viewing.vectors import FORCES, Vector, key_of, largest

LOAD, REACTION = "#c2185b", "#00758f"
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
    ghost: Motion | None = None
    one_scale: bool = False


class Painted:
    """The overlays of a motion, prepared for all of its frames."""

    def __init__(self, overlays: Overlays, motion: Motion) -> None:
        self.paths = [motion.pose(motion.spot_of(name))[:, :2] for name in overlays.traced]
        self.vectors = list(overlays.vectors)
        self.largest = largest(self.vectors, overlays.one_scale)

    def draw(self, p: Pixels) -> None:
        """Paths, pale as a whole and strong up to the present, with a dot at the point; arrows."""
        lines = []
        for k, path in enumerate(self.paths):
            points = np.column_stack([p.left + p.scale * path[:, 0], p.top - p.scale * path[:, 1]]).tolist()
            lines.append((points, OTHERS[k % len(OTHERS)].light))
        for points, colour in lines:
            p.line(points, 1.6, mixed(LIGHT_PAPER, colour, PALE_PATH))
            p.line(points[: p.row + 1], 1.6, colour)
        for points, colour in lines:
            p.circle(points[p.row], 2.6, colour, LIGHT_PAPER)
        for v in self.vectors:
            values = np.nan_to_num(v.values[p.row]) / (self.largest[key_of(v)] or 1.0)
            colour = LOAD if v.group == FORCES else REACTION
            place = p.place(v.at)
            if len(values) == 2:
                _arrow(p, place[:2], LONGEST * min(p.size) * values, colour)
            else:
                _turning(p, place[:2], float(values[0]), colour)


def _arrow(p: Pixels, start: tuple[float, float], by: NDArray[np.float64], colour: str) -> None:
    """An arrow by (x, y) pixels, y up."""
    length = float(np.hypot(*by))
    if length < 2.0 or not np.isfinite(start).all():
        return
    size, (c, s) = min(9.0, 0.6 * length), by / length
    end = start[0] + by[0], start[1] - by[1]
    p.line([start, (end[0] - 0.5 * size * c, end[1] + 0.5 * size * s)], 2.0, colour)
    tip = end[0] - 0.4 * size * c, end[1] + 0.4 * size * s
    p.head(p.axes((*tip, float(np.arctan2(s, c)))), colour, size)


def _turning(p: Pixels, at: tuple[float, float], part: float, colour: str) -> None:
    """An arc, counter-clockwise for positive values; ``part`` is relative to the largest of the motion."""
    if abs(part) < 0.01 or not np.isfinite(at).all():
        return
    radius, angles = 1.6 * p.U + 6.0, np.linspace(0.0, 4.7 * part, 40)
    points = [(at[0] + radius * np.cos(u), at[1] - radius * np.sin(u)) for u in angles]
    p.line(points, 2.0, colour)
    p.head(p.axes((*points[-1], float(angles[-1] + np.sign(part) * np.pi / 2))), colour, 9.0)


def colour_bar(p: Pixels, colour: str, most: float) -> None:
    """The colours of beams, from no strain to the largest, in the lower left corner."""
    left, top = BAR_AT[0], p.size[1] - BAR_AT[1]
    pale = mixed(colour, LIGHT_PAPER, 0.72)
    for k in range(FINE * BAR[0]):
        x = left + k / FINE
        p.line([(x, top), (x, top + BAR[1])], 1.0 / FINE, mixed(pale, HOT, k / (FINE * BAR[0])))
    corners = [(left, top), (left + BAR[0], top), (left + BAR[0], top + BAR[1]), (left, top + BAR[1]), (left, top)]
    p.line(corners, 0.75, PALE)
    p.label((left + BAR[0] + 8, top + BAR[1] / 2), f"bending strain 0 ... {most:.3g}", PALE, LETTERS)
