"""Tolerances that a run can keep: what rounding leaves of an error norm that is relative."""

from __future__ import annotations

import sys
from numbers import Real

#: a run with error-controlled steps has at least 50, and each rounds positions and velocities, which sum to 100 units
#: in the last place, 2.2e-14
LEAST = 2.5e-14
#: units in the last place of the state that any run is off by
ULPS = 4.0


def misfit(value: object, what: str = "a tolerance") -> str | None:
    """Why ``value`` is no tolerance that a run could keep; None if it is one."""
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
    """The rounding error of positions or times that are ``magnitude`` times as large as what they are compared with."""
    return ULPS * sys.float_info.epsilon * magnitude
