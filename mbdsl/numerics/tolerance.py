"""The least tolerance that a run can keep: rounding errors in the relative error norm."""

from __future__ import annotations

import sys
from numbers import Real

#: the least tolerance of any run: a run with error-controlled steps has 50 steps or more, and each rounds positions and
#: velocities; these errors sum to 100 units in the last place, 2.2e-14
LEAST = 2.5e-14
#: rounding error of the state in every run [units in the last place]
ULPS = 4.0


def misfit(value: object, what: str = "a tolerance") -> str | None:
    """Why no run can keep ``value`` as its tolerance; None if a run can."""
    if isinstance(value, bool) or not isinstance(value, Real):
        return f"{what} is a number between 0 and 1, not {value!r}"
    number = float(value)
    if not 0.0 < number < 1.0:
        return f"{what} is between 0 and 1, not {number:g}"
    if number < LEAST:
        return (
            f"{what} of {number:g} is less than the rounding errors of a run, as numbers have 16 digits; "
            f"expected {LEAST:g} or more"
        )
    return None


def rounding(magnitude: float) -> float:
    """The relative rounding error of positions or times that are ``magnitude`` times the size or duration."""
    return ULPS * sys.float_info.epsilon * magnitude
