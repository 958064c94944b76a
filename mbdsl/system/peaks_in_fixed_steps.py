"""Peaks of laws within fixed steps: the search of :mod:`mbdsl.system.peaks_along_motion`, for many short steps at once.

Fixed steps do not end in zones. Therefore terms that depend on time alone are searched as well. The height of a peak is
compared with the largest value of its term in all steps that are searched together and in those before them.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from mbdsl.expressions.symbolic import walk
from mbdsl.kernels.arrays import Array
from mbdsl.system.interval_tape import SLIGHT
from mbdsl.system.paths import Looks, Paths
from mbdsl.system.peaks_along_motion import JUMPS, OnTheWay
from mbdsl.system.peaks_in_time import passable

if TYPE_CHECKING:
    from mbdsl.expressions.symbolic import Expr
    from mbdsl.system.system import System


#: negligible height of a peak, relative to the term's largest value
SMALL = 1e-3
#: number of steps whose bounds are computed together; only if these admit a peak, the steps are searched one by one
TOGETHER = 16


class InFixedSteps(OnTheWay):
    """The terms of a system that may have a hidden peak within a step h [s]."""

    A_STEP = 10.0  # fixed steps are short

    def __init__(self, system: System, h: float) -> None:
        super().__init__(system)
        for root, law in system.searched_laws.items():
            for term in passable([law], h):
                if term not in self.terms:
                    self.terms.append(term)
                    self._roots.append(root)
                    self._jumps.append(any(n.op in JUMPS for n in walk(term)))

    @property
    def roots(self) -> list[Expr]:
        """The expression of the model to which each term belongs."""
        return self._roots

    def _suspected(self, f: Paths, resolved: NDArray, seen: Array) -> Looks:
        count, terms = len(resolved), len(self.terms)
        first = np.arange(0, count, TOGETHER)
        y = f.at(np.append(first, count - 1), np.append(np.zeros(len(first)), 1.0))
        size = np.maximum(seen, np.abs(np.where(np.isfinite(y), y, 0.0)).max(axis=0))
        jet = f.over(first)
        # a peak requires slopes of both signs, large enough to reach its height within a step
        harmless = np.minimum(jet.d_hi, -jet.d_lo) <= SMALL * size
        suspected = resolved[:, None] & np.repeat(~harmless, TOGETHER, axis=0)[:count]
        slight, excess = np.zeros((count, terms)), np.zeros((count, terms))
        k = np.flatnonzero(suspected.any(axis=1))
        if len(k):
            zero, one = np.zeros(len(k)), np.ones(len(k))
            y0, y1, jet = f.at(k, zero), f.at(k, one), f.jets(k, zero, one)
            ends = np.abs(y0) + np.abs(y1)
            known = np.where(suspected[k] & np.isfinite(ends), ends, 0.0)
            size = np.maximum(size, known.max(axis=0))
            slight[k] = SLIGHT * ends + SMALL * size
            excess[k] = np.maximum(jet.hi - np.maximum(y0, y1), np.minimum(y0, y1) - jet.lo)
            suspected[k] &= np.minimum(excess[k], np.minimum(jet.d_hi, -jet.d_lo)) > slight[k]
        return Looks(np.tile(size, (count, 1)), slight, excess, suspected, bool(suspected.any()))
