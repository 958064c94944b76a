"""A row: a scalar coordinate of two frames as a formula. :mod:`mbdsl.elements.rows` has those of several kinds."""

from __future__ import annotations

import re
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
    motions without a coordinate, the formula of the rate. ``turned`` is the formula in space in axes of frame_a, of
    rows that hold components of r_b - r_a.

    ``kernel`` names the functions of :mod:`mbdsl.elements.coordinates_in_space`, such as ``angle`` and
    ``angle_hessian``, that are used in space in place of derivatives of the formula: of angles that count turns.
    """

    space: str
    plane: str = ""
    kernel: str = ""
    turned: str = ""
    reacts: tuple[bool, bool] | None = None  #: whether it exerts a force, a torque, if the formula does not say it

    def formula(self, spatial: bool) -> str:
        return self.space if spatial else self.plane

    def curved(self, spatial: bool) -> bool:
        """Whether its gradient is not constant: the formula contains more than sums, or a function of coordinates."""
        return bool(_NONLINEAR.search(self.formula(spatial)))

    @property
    def curved_by_rotations(self) -> bool:
        """Whether in space it has no second derivatives with respect to translations: it is linear, or a function of
        axes alone."""
        return not (self.kernel or (self.curved(True) and _ORIGIN.search(self.space)))

    def is_rate(self, spatial: bool) -> bool:
        """Whether the formula is that of a rate, as of rotations about an axis, which have no coordinate."""
        return bool(_RATE.search(self.formula(spatial)))

    def acts(self, spatial: bool) -> tuple[bool, bool]:
        """Whether it exerts a force on frame_b, and a torque."""
        formula = self.formula(spatial)
        if self.reacts is not None:
            return self.reacts
        return bool(_PLACE.search(formula)), bool(_ATTITUDE.search(formula))

    def parameters(self, spatial: bool) -> tuple[str, ...]:
        """The names in the formula that are not coordinates of frames."""
        return tuple(_NAME.findall(_PORT.sub("", self.formula(spatial))))
