"""Location of the time at which a state changes, by the quantities that decide it."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from mbdsl.kernels.arrays import Array

Look = Callable[[float], tuple[bool, Array]]

#: so many evaluations that do not halve the interval, and then the middle is tried: quantities may have corners
PATIENCE = 3


def first_change(
    look: Look,
    low: float,
    high: float,
    ends: tuple[Array, Array],
    close: tuple[float, float],
) -> float:
    """The time just behind a change between ``low``, where nothing has changed, and ``high``, where something has.

    Of the quantities that change their sign, the first zero by linear interpolation is tried, which with one of the
    ends retained is the Illinois method (M. Dowell, P. Jarratt, BIT 11 (1971) 168-174); without any the middle.

    Parameters
    ----------
    look : function of a time
        Whether nothing has changed there, and quantities (k,) whose signs differ before and behind a change; infinite
        or nan if they are not known.
    ends : two of (k,)
        The quantities at both ends.
    close : (float, float)
        Largest error of the result: relative to it, and absolute; the larger one counts.
    """
    (a, b), last, idle = ends, 0, 0
    while high - low > (error := max(close[0] * abs(high), close[1])):
        width, at = high - low, 0.5 * (low + high)
        with np.errstate(all="ignore"):
            part = a / (a - b)
        if idle < PATIENCE and (crossing := (a * b <= 0.0) & np.isfinite(part)).any():
            at = low + float(part[crossing].min()) * width
            at = min(max(at, low + 0.5 * error), high - 0.5 * error)
        same, found = look(at)
        if same:
            low, a, b = at, found, b * (0.5 if last > 0 else 1.0)
        else:
            high, b, a = at, found, a * (0.5 if last < 0 else 1.0)
        last, idle = 1 if same else -1, idle + 1 if high - low > 0.5 * width else 0
    return high
