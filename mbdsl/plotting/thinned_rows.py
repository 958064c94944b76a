"""Thinning of long results: rows that keep the extremes of all signals, chosen in bounded memory.

Rows are grouped in buckets of equal numbers of rows. Of each bucket the first and the last row are kept, and those in
which a signal has its least or greatest value. The buckets are doubled when more rows are kept than allowed; the
extremes of two buckets are among those of both.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from mbdsl.plotting.decimation import extremes

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from numpy.typing import NDArray

    from mbdsl.results.stored import Result

    Array = NDArray[np.float64]

#: default quantity of rows, of numbers in them, and least number of rows
ROWS, NUMBERS, FEWEST = 50_000, 2**23, 5000


class ThinnedRows:
    """At most ``most`` rows of a result.

    Parameters
    ----------
    names : sequence of str
        The signals; "time" among them.
    time : str
        Name of the times, whose extremes are not kept.
    most : int
        Largest number of rows.

    Attributes
    ----------
    count : int
        Number of rows that were added.
    width : int
        Number of rows of a bucket.
    index : (K,)
        Numbers of the rows that are kept.
    """

    def __init__(self, names: Sequence[str], time: str, most: int) -> None:
        self.names, self.count, self._time = list(names), 0, time
        self._most, self.width = max(2, most), 1
        self.index = np.zeros(0, np.int64)
        self._rows = np.zeros((len(self.names), 0))

    def add(self, columns: Mapping[str, Array]) -> None:
        """Add the rows (k,) that follow."""
        rows = np.array([columns[name] for name in self.names])
        index = np.arange(self.count, self.count + rows.shape[1])
        self.count += rows.shape[1]
        if self.width > 1:
            chosen = self._chosen(index, rows)
            index, rows = index[chosen], rows[:, chosen]
        self.index, self._rows = np.append(self.index, index), np.append(self._rows, rows, axis=1)
        while len(self.index) > self._most and self.width <= self.count:
            self.width *= 2
            chosen = self._chosen(self.index, self._rows)
            self.index, self._rows = self.index[chosen], self._rows[:, chosen]

    def columns(self) -> dict[str, Array]:
        """Name -> values (K,) of the rows that are kept."""
        return dict(zip(self.names, self._rows, strict=True))

    def _chosen(self, index: NDArray[np.int64], rows: Array) -> NDArray[np.int64]:
        bucket = index // self.width
        chosen = np.zeros(len(index), bool)
        for name, x in zip(self.names, rows, strict=True):
            if name != self._time or len(self.names) == 1:
                chosen[extremes(bucket, x)] = True
        return np.flatnonzero(chosen)


def thinned(result: Result, most: int | None = None) -> ThinnedRows:
    """The rows of a result, thinned if there are more than ``most``.

    Parameters
    ----------
    result : Result
        An open result, which is read in parts.
    most : int, optional
        Largest number of rows. Default: by the number of signals.

    Returns
    -------
    ThinnedRows
        Times and signals.

    Raises
    ------
    UsageError
        If the file is damaged.
    """
    names = [result.time, *result.names]
    if most is None:
        most = max(FEWEST, min(ROWS, NUMBERS // len(names)))
    rows = ThinnedRows(names, result.time, most)
    for _, columns in result.chunks(result.names):
        rows.add(columns)
    return rows
