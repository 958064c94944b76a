"""Shapes that a model gives for the pictures of its bodies; they do not affect the motion."""

from __future__ import annotations

from dataclasses import dataclass

Point = tuple[float, float]


@dataclass(frozen=True)
class DrawnShape:
    """A shape fixed to a body or to the ground."""

    #: "area" (closed lines, filled where a point is inside an odd number of them), "line" (open lines) or "ellipse"
    form: str
    #: [m] points of each line; of an ellipse its centre. In the body's axes, from its reference point.
    parts: tuple[tuple[Point, ...], ...]
    #: of an ellipse: its half axes and the angle of the first, (a, b, angle) [m, m, rad]
    axes: tuple[float, float, float] = (0.0, 0.0, 0.0)
    #: colours "#rrggbb"; "none" for nothing; "" for those of the body
    fill: str = ""
    line: str = ""
    width: float = 0.0  #: [m] width of the line; 0: a thin line at every scale

    def __len__(self) -> int:
        """Number of its points."""
        return sum(map(len, self.parts))
