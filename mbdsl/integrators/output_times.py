"""Output times that are computed part by part, and the window of rows that a run has in memory."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from mbdsl.kernels.arrays import Array


@dataclass(frozen=True)
class OutputTimes:
    """Evenly spaced output times after the start; the last one is ``stop`` [s].

    A run that has such times holds at most ``window`` rows of output, which ``RunState.release`` takes from it.
    """

    start: float
    stop: float
    spacing: float
    count: int
    window: int = 0

    def at(self, rows: ArrayLike) -> Array:
        """The times (k,) [s] of rows (k,)."""
        rows = np.asarray(rows, float)
        return np.where(rows == self.count - 1, self.stop, self.start + self.spacing * (rows + 1.0))

    def part(self, first: int, end: int) -> Array:
        """The times [s] of the rows from ``first`` to before ``end``."""
        return self.at(np.arange(first, end))

    def visible(self, first: int) -> Array:
        """The times (window,) [s] from row ``first`` on; infinite after the last one."""
        found = np.full(self.window, np.inf)
        there = self.part(first, min(first + self.window, self.count))
        found[: len(there)] = there
        return found
