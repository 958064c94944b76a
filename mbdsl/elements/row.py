"""A row: a scalar coordinate of two frames as a formula. :mod:`mbdsl.elements.rows` has those of several kinds."""

from __future__ import annotations

import re
from collections.abc import Iterator
from typing import NamedTuple

_PORT = re.compile(r"frame_[ab]\.\w+")
_NAME = re.compile(r"[a-zA-Z_]\w*(?:\[\d+\])?(?![\w(\[])")
_RATE = re.compile(r"frame_[ab]\.[vw]")
_NONLINEAR = re.compile(r"[*/^]|\w\(|law\[")
_ORIGIN = re.compile(r"frame_[ab]\.[xyz]\b|law\[")
_PLACE, _ATTITUDE = re.compile(r"frame_b\.[xyz]\b"), re.compile(r"frame_b\.([xyz][xyz]|phi)\b")


class Row(NamedTuple):
    """A row by its formulas in space and in the plane; "" where there is none.

    Formulas are those of :mod:`mbdsl.expressions.formulas`, over the frames and the parameters of a component; of
    motions without a coordinate, the formula of the rate. ``angle`` counts turns. ``turned`` is the formula in space in
    axes of frame_a, of rows that hold components of r_b - r_a.
    """

    space: str
    plane: str = ""
    turned: str = ""
    reacts: tuple[bool, bool] | None = None  #: whether it exerts a force, a torque, if the formula does not say it


class Rows:
    """What the formulas of the rows of a kind say, in the plane or in space."""

    def __init__(self, rows: tuple[Row, ...], spatial: bool) -> None:
        self._rows = [row for row in rows if (row.space if spatial else row.plane)]
        self.formulas = tuple(row.space if spatial else row.plane for row in self._rows)

    @property
    def counted(self) -> int:
        """The number of angles that count turns."""
        return sum(x.count("angle(") for x in self.formulas)

    @property
    def parameters(self) -> tuple[str, ...]:
        """The names in the formulas that are not coordinates of frames: of parameters."""
        names = [name for x in self.formulas for name in _NAME.findall(_PORT.sub("", x))]
        return tuple(dict.fromkeys(name for name in names if not name.startswith("law[")))

    @property
    def rates(self) -> tuple[bool, ...]:
        """Of each row whether it is a rate, as of rotations about an axis, which have no coordinate."""
        return tuple(bool(_RATE.search(x)) for x in self.formulas)

    @property
    def curved(self) -> bool:
        """Whether a gradient is not constant: a formula contains more than sums, or a function of coordinates."""
        return any(map(_NONLINEAR.search, self.formulas))

    @property
    def curved_by_rotations(self) -> bool:
        """Whether in space there are no second derivatives with respect to translations: each row is linear, or a
        function of axes alone."""
        return not any(_NONLINEAR.search(x) and _ORIGIN.search(x) for x in self.formulas) and not self.counted

    @property
    def acts(self) -> tuple[bool, bool]:
        """Whether they exert a force on frame_b, and a torque."""
        found = [row.reacts or (bool(_PLACE.search(x)), bool(_ATTITUDE.search(x))) for row, x in self]
        return any(force for force, _ in found), any(torque for _, torque in found)

    def __iter__(self) -> Iterator[tuple[Row, str]]:
        return zip(self._rows, self.formulas, strict=True)
