"""Peaks of laws within fixed steps: the search of :mod:`mbdsl.system.peaks_along_motion`, for many short steps at once.

Fixed steps do not end in zones. Therefore terms that depend on time alone are searched as well. The height of a peak is
compared with the largest value of its term in all steps that are searched together and in those before them.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from mbdsl.expressions.symbolic import leaves, walk
from mbdsl.system.peaks_along_motion import JUMPS, SLIGHT, Functions, OnTheWay
from mbdsl.system.peaks_in_time import passable

if TYPE_CHECKING:
    from mbdsl.expressions.symbolic import Expr
    from mbdsl.system.system import System

Array = NDArray[np.float64]

#: negligible height of a peak, relative to the term's largest value
SMALL = 1e-3
#: number of steps whose bounds are computed together; only if these admit a peak, the steps are searched one by one
TOGETHER = 16


class InFixedSteps(OnTheWay):
    """The terms of a system that may have a hidden peak within a step h [s]."""

    def __init__(self, system: System, h: float) -> None:
        super().__init__(system)
        for root, law in system.searched_laws.items():
            for term in passable([law], h):
                if term not in self.terms:
                    self.terms.append(term)
                    self._roots.append(root)
                    self._jumps.append(any(n.op in JUMPS for n in walk(term)))
        self._leaves = leaves(*self.terms)

    @property
    def roots(self) -> list[Expr]:
        """The expression of the model to which each term belongs."""
        return self._roots

    def _suspected(self, f: Functions, resolved: NDArray, seen: Array) -> list[tuple[Array, Array, NDArray]]:
        count = len(resolved)
        first = np.arange(0, count, TOGETHER)
        states = f.at(np.append(first, count - 1), np.append(np.zeros(len(first)), 1.0))
        found = []
        for n, (y, jet) in enumerate(zip(states, f.over(first), strict=True)):
            size = max(seen[n], np.abs(y[np.isfinite(y)]).max(initial=0.0))
            # a peak requires slopes of both signs, large enough to reach its height within a step
            harmless = np.minimum(jet.d_hi, -jet.d_lo) <= SMALL * size
            k = np.flatnonzero(resolved & np.repeat(~np.broadcast_to(harmless, first.shape), TOGETHER)[:count])
            slight = np.zeros(count)
            if len(k):
                zero, one = np.zeros(len(k)), np.ones(len(k))
                y0, y1 = f.at(k, zero)[n], f.at(k, one)[n]
                ends = np.abs(y0) + np.abs(y1)
                size = max(size, ends[np.isfinite(ends)].max(initial=0.0))
                slight[k] = SLIGHT * ends + SMALL * size
                jet = f.jet(k, zero, one)[n]
                over = np.maximum(jet.hi - np.maximum(y0, y1), np.minimum(y0, y1) - jet.lo)
                k = k[np.minimum(over, np.minimum(jet.d_hi, -jet.d_lo)) > slight[k]]
            found.append((np.full(count, size), slight, k))
        return found
