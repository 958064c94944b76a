"""The view of a motion: from its frames to pixels."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from mbdsl.viewing.display import Size
from mbdsl.viewing.marks import Array
from mbdsl.viewing.shapes import Drawing
from mbdsl.viewing.tracks import Tracks

MARGIN = 0.12  #: of the shorter side


class PictureView:
    """Places the display list of a motion in a row of it; ``U`` is the size of symbols [px]."""

    row: int

    def __init__(self, motion: Tracks, drawing: Drawing, width: int, height: int) -> None:
        self.motion, self.items = motion, [item for shape in drawing.shapes for item in shape.items]
        self.size = width, height
        x0, y0, x1, y1 = drawing.bounds
        margin = min(64.0, MARGIN * min(width, height))
        across = (width - 2 * margin) / max(x1 - x0, 1e-300), (height - 2 * margin) / max(y1 - y0, 1e-300)
        self.scale = min(across) if min(across) < 1e200 else 100.0 / drawing.unit
        self.left = width / 2 - self.scale * (x0 + x1) / 2
        self.top = height / 2 + self.scale * (y0 + y1) / 2
        self.U = min(26.0, 0.065 * min(width, height), max(2.5, drawing.unit * self.scale))
        self.thin = min(1.5, max(0.75, self.U / 8))

    def places(self, at: Sequence[Any]) -> Array:
        """Frames (n, 3) in pixels, y down, and their angles in the world, counter-clockwise."""
        found = self.motion.places(at, self.row)
        found[:, 0] = self.left + self.scale * found[:, 0]
        found[:, 1] = self.top - self.scale * found[:, 1]
        return found

    def length(self, size: Size) -> float:
        """A size in pixels."""
        return max(size.least, size.units * self.U + size.metres * self.scale + size.thin * self.thin)
