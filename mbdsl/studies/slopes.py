"""Slopes of errors: straight lines through log(error) as a function of log(size).

At large sizes the errors have not reached their asymptotic order; at small ones they level off in rounding or below the
resolution of the reference. The line is fitted to the longest run of neighbours whose slopes agree.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

AGREE = 0.25  #: largest difference between slopes of neighbours in a run
LEAST = 0.15  #: errors with smaller slopes do not converge
STAYS = 0.5  #: errors within this factor of the smallest one so far have levelled off
CLEAR = 5.0  #: errors within this factor of the resolution of the reference are affected by it


@dataclass(frozen=True)
class Fit:
    """error ~ size^slope for sizes from ``low`` to ``high``; ``uncertainty`` is half of the 95 % interval.

    ``below`` describes errors at sizes smaller than ``low``: "" (there are none), "levels off" (generally because of
    rounding), "reference" (below its resolution), or "irregular".
    """

    slope: float
    uncertainty: float
    low: float
    high: float
    count: int
    below: str = ""

    def __str__(self) -> str:
        return f"{self.slope:.2f} ± {self.uncertainty:.2f}"


def fit(sizes: Sequence[float], errors: Sequence[float], floor: float = 0.0, agree: float = AGREE) -> Fit | None:
    """The slope of ``errors`` over ``sizes``; None if no three in a row, above ``floor``, lie on a line.

    ``floor`` is the resolution of the reference.
    """
    order = np.argsort(-np.asarray(sizes, float))
    x, e = np.asarray(sizes, float)[order], np.asarray(errors, float)[order]
    known = np.isfinite(e) & (e > 0.0)
    x, e = x[known], e[known]
    usable = e > CLEAR * floor
    best: tuple[int, int] | None = None
    slopes = np.diff(np.log(e)) / np.diff(np.log(x)) if len(x) > 1 else np.empty(0)
    for first in range(len(slopes)):
        for last in range(first + 1, len(slopes)):
            part = slopes[first : last + 1]
            if not usable[first : last + 2].all() or part.min() < LEAST or np.ptp(part) > agree:
                break
            # the longest; of two equally long ones that with smaller sizes
            if best is None or last - first >= best[1] - best[0]:
                best = first, last
    if best is None:
        return None
    first, last = best[0], best[1] + 2
    X, E = np.log(x[first:last]), np.log(e[first:last])
    slope, uncertainty = _line(X, E)
    below = ""
    if last < len(x):
        stays = e[-1] > STAYS * e[last - 1 : -1].min()
        below = "reference" if not usable[last] else "levels off" if stays else "irregular"
    return Fit(slope, uncertainty, float(x[last - 1]), float(x[first]), last - first, below)


def _line(X: np.ndarray, Y: np.ndarray) -> tuple[float, float]:
    """Slope of the least-squares line, and half of its 95 % interval by Student's t."""
    from scipy.special import stdtrit

    dX = X - X.mean()
    slope = float(dX @ Y / (dX @ dX))
    rest = Y - Y.mean() - slope * dX
    spread = float(np.sqrt(rest @ rest / (len(X) - 2) / (dX @ dX)))
    return slope, float(stdtrit(len(X) - 2, 0.975)) * spread


def verdict(found: Fit | None, order: int, errors: Sequence[float], floor: float) -> str:
    """Verdict on the slope of a method of ``order``: "" if they agree. ``errors`` are from coarse to fine."""
    known = [e for e in errors if np.isfinite(e)]
    if not known or max(known) <= CLEAR * floor:
        return "below the reference's resolution"
    if found is None:
        if len(known) < 3 or min(known) <= CLEAR * floor:
            return "too few points"
        falls = all(b < STAYS * a for a, b in pairwise(known))
        return "no line at these sizes" if falls else "does not converge at these sizes"
    if found.below == "irregular":
        return "not settled"
    allowed = AGREE + found.uncertainty
    if found.slope < order - allowed:
        return f"below its order {order}"
    return f"above its order {order}" if found.slope > order + allowed else ""
