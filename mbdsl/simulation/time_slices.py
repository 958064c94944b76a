"""The part of a trajectory between two times."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from mbdsl.errors import UsageError
from mbdsl.lang.given_values import seconds


def rows(t: NDArray[np.float64], times: slice) -> slice:
    """The rows of ``t`` (N,) [s] from ``times.start`` to ``times.stop``, both included up to rounding errors.

    Raises
    ------
    UsageError
        If the slice has a step, a border is not a time, or no output time is between the borders.
    """
    if times.step is not None:
        raise UsageError(
            f"found a slice with the step {times.step!r}, expected two times", hint="`trajectory[0.5:1.0]` is a part"
        )
    if not len(t):
        raise UsageError("the trajectory is empty: it has no part between two times")
    first = seconds(times.start, "the start of the slice")
    last = seconds(times.stop, "the end of the slice")
    first, last = float(t[0]) if first is None else first, float(t[-1]) if last is None else last
    if not (np.isfinite(first) and np.isfinite(last)):
        raise UsageError(f"found a slice from {first:g} to {last:g} s, expected finite times")
    # output times are sums of steps, and a text with a unit is a product
    rounding = 4.0 * np.finfo(float).eps * max(abs(first), abs(last))
    begin = int(np.searchsorted(t, first - rounding, "left"))
    end = int(np.searchsorted(t, last + rounding, "right"))
    if begin >= end:
        hint = f"the trajectory has {len(t)} output times from {t[0]:g} to {t[-1]:g} s"
        raise UsageError(f"there is no output time from {first:g} to {last:g} s", hint=hint)
    return slice(begin, end)


def part(state: dict[str, Any], kept: slice) -> dict[str, Any]:
    """The attributes of a trajectory, restricted to these rows; all arrays are views.

    Parameters
    ----------
    state : dict
        The attributes, with the reference angles for turns, which depend on all earlier rows.
    kept : slice
        Rows.
    """
    found = dict(state)
    for name in ("t", "q", "v", "_lam", "lam"):
        if found.get(name) is not None:
            found[name] = found[name][kept]
    for name in ("inputs", "turns", "_known", "_numbers"):
        if name in found:
            found[name] = {key: x[kept] for key, x in found[name].items()}
    for name in ("_motion", "_constraints"):
        if name in found:
            found[name] = tuple(x[kept] for x in found[name])
    t = found["t"]
    found["undetermined"] = [x for x in found["undetermined"] if t[0] <= x <= t[-1]]
    found["stats"] = dict(found["stats"])
    found["_from_start"] = found["_from_start"] and kept.start == 0
    return found
