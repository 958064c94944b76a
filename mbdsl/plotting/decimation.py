"""Decimation of long curves: the few points that are needed to draw them, found part by part in bounded memory."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from numpy.typing import NDArray

    from mbdsl.results.stored import Result

    Array = NDArray[np.float64]

POINTS = 16_384  #: largest number of points of a curve over an ascending coordinate
CELLS = (2048, 1152)  #: grid of the plane for phase plots: finer than the pixels of a picture
SEGMENTS = 150_000  #: largest number of segments between cells; beyond it the cells are doubled
#: default quantity of rows of a result, of numbers in them, and least number of rows
ROWS, NUMBERS, FEWEST = 50_000, 2**23, 5000


class ThinnedRows:
    """Rows of signals that keep the extremes of all of them: of each bucket the first and the last row, and those in
    which a signal is least or greatest or has its first gap (nan).

    Jugel, Jerzak, Hackenbroich, Markl, "M4: a visualization-oriented time series data aggregation", Proc. VLDB 7 (2014)
    797: a line through these points is the line through all points, if the buckets are the columns of pixels.
    The buckets are doubled when there are too many rows; the extremes of two buckets are among those of both together.

    Parameters
    ----------
    names : sequence of str
        The signals.
    along : str
        The ascending one among them, whose extremes are not kept.
    most : int
        Largest number of rows. Fewer rows are unchanged.
    even : bool, optional
        Whether buckets are equal intervals of ``along``; otherwise they have equal numbers of rows.

    Attributes
    ----------
    count : int
        Number of rows that were added.
    width : float
        Size of a bucket; 0 as long as all rows are kept.
    index : (K,)
        Numbers of the rows that are kept.
    """

    def __init__(self, names: Sequence[str], along: str, most: int, even: bool = False) -> None:
        self.names, self.count, self.width = list(names), 0, 0.0
        self._along, self._most, self._even = self.names.index(along), max(2, most), even
        self.index, self._rows = np.zeros(0, np.int64), np.zeros((len(self.names), 0))

    @property
    def reduced(self) -> bool:
        """Whether rows were left out."""
        return self.count > len(self.index)

    def add(self, columns: Mapping[str, Array]) -> None:
        """Add the rows (k,) that follow."""
        rows = np.array([columns[name] for name in self.names])
        self.index = np.append(self.index, np.arange(self.count, self.count + rows.shape[1]))
        self._rows = np.append(self._rows, rows, axis=1)
        self.count += rows.shape[1]
        if self.width:
            self._thin()
        place = self._places()
        while len(self.index) > self._most and self.width <= place[-1]:
            self.width = 2.0 * self.width or (4.0 * place[-1] / self._most if self._even else 2.0)
            self._thin()

    def columns(self) -> dict[str, Array]:
        """Name -> values (K,) of the rows that are kept."""
        return dict(zip(self.names, self._rows, strict=True))

    def _places(self) -> Array:
        """What buckets divide: the number of a row, or its distance from the first."""
        return self._rows[self._along] - self._rows[self._along, 0] if self._even else self.index.astype(float)

    def _thin(self) -> None:
        bucket = (self._places() / self.width).astype(np.int64)
        chosen = np.zeros(len(bucket), bool)
        for k, x in enumerate(self._rows):
            if k != self._along or len(self.names) == 1:
                chosen[extremes(bucket, x)] = True
        self.index, self._rows = self.index[chosen], self._rows[:, chosen]


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


def extremes(column: NDArray[np.int64], y: Array) -> NDArray[np.int64]:
    """Indices of the first, least, greatest and last point of each column, and of its first gap, ascending.

    Parameters
    ----------
    column : (N,)
        The column of each point; equal numbers are neighbours.
    y : (N,)
        Values; nan is a gap.

    Returns
    -------
    (K,)
        Indices of the points, ascending.
    """
    first = np.flatnonzero(np.concatenate(([True], column[1:] != column[:-1])))
    last = np.concatenate((first[1:], [len(y)])) - 1
    count = last - first + 1
    chosen = np.zeros(len(y), bool)
    chosen[first] = chosen[last] = True
    for least in (np.fmin.reduceat(y, first), np.fmax.reduceat(y, first)):
        chosen[_first(np.flatnonzero(y == np.repeat(least, count)), first)] = True
    chosen[_first(np.flatnonzero(np.isnan(y)), first)] = True
    return np.flatnonzero(chosen)


def _first(hits: NDArray[np.int64], first: NDArray[np.int64]) -> NDArray[np.int64]:
    """The first of the ascending ``hits`` in each column."""
    column = np.searchsorted(first, hits, side="right")
    return hits[np.concatenate(([True], column[1:] != column[:-1]))] if len(hits) else hits


class Visited:
    """A curve in the plane: its segments between cells of a fine grid, each drawn once.

    A point is left out if it is in the cell of its predecessor, and a segment if another one between the same two cells
    was drawn. Every cell that the curve visits contains a point of the result. Gaps (nan) divide the result.

    Parameters
    ----------
    x, y : (float, float)
        Least and greatest value of all points.
    cells : (int, int)
        Number of cells along each axis; halved as often as there are too many segments.
    most : int
        Largest number of segments.
    """

    def __init__(
        self,
        x: tuple[float, float],
        y: tuple[float, float],
        cells: tuple[int, int] = CELLS,
        most: int = SEGMENTS,
    ) -> None:
        self._low = np.array([x[0], y[0]])
        size = np.array([x[1] - x[0], y[1] - y[0]])
        self._size, self._cells, self._most = np.where(size > 0.0, size, 1.0), np.array(cells), most
        self._known = np.empty(0, np.int64)  #: keys of the segments, ascending
        self._x, self._y = [np.empty(0)], [np.empty(0)]
        self._end: tuple[float, float] | None = None
        self.count = 0  #: number of points that were added

    @property
    def x(self) -> Array:
        """Coordinates (K,) of the result."""
        return np.concatenate(self._x)

    @property
    def y(self) -> Array:
        """Coordinates (K,) of the result."""
        return np.concatenate(self._y)

    def add(self, x: Array, y: Array) -> None:
        """Add the points (k,) that follow."""
        self.count += len(x)
        if self._end is not None:  # the segment from the last part
            x, y = np.concatenate(([self._end[0]], x)), np.concatenate(([self._end[1]], y))
        if not len(x):
            return
        self._end = (x[-1], y[-1])
        self._draw(x, y)
        while len(self._known) > self._most and self._cells.max() > 8:
            drawn = self.x, self.y
            self._cells = np.maximum(self._cells // 2, 1)
            self._known, self._x, self._y = np.empty(0, np.int64), [np.empty(0)], [np.empty(0)]
            self._draw(*drawn)

    def _draw(self, x: Array, y: Array) -> None:
        gap = np.isnan(x) | np.isnan(y)
        places = ((np.column_stack([x, y]) - self._low) / self._size * self._cells)[~gap]
        cell = np.full(len(x), -1, np.int64)
        inside = np.minimum(places.astype(np.int64), self._cells - 1)
        cell[~gap] = inside[:, 0] * self._cells[1] + inside[:, 1]
        before, key = cell[:-1], cell[:-1] * int(self._cells.prod()) + cell[1:]
        moves = np.flatnonzero((before != cell[1:]) & (before >= 0) & (cell[1:] >= 0))
        if not len(self._known) and not len(moves):  # a curve within one cell
            moves = np.flatnonzero((before >= 0) & (cell[1:] >= 0))[:1]
        _, where = np.unique(key[moves], return_index=True)
        moves = np.sort(moves[where])
        place = np.minimum(np.searchsorted(self._known, key[moves]), max(len(self._known) - 1, 0))
        if len(self._known):
            moves = moves[self._known[place] != key[moves]]
        if not len(moves):
            return
        self._known = np.union1d(self._known, key[moves])
        # Gap, start and end of each segment; only the end where a segment continues its predecessor.
        joined = np.concatenate(([False], self._joined(moves, cell)))
        keep = np.column_stack([~joined, ~joined, np.ones(len(moves), bool)])
        gaps = np.full(len(moves), np.nan)
        self._x.append(np.column_stack([gaps, x[moves], x[moves + 1]])[keep])
        self._y.append(np.column_stack([gaps, y[moves], y[moves + 1]])[keep])

    @staticmethod
    def _joined(moves: NDArray[np.int64], cell: NDArray[np.int64]) -> NDArray[np.bool_]:
        """Whether a segment begins in the cell where its predecessor ended, with only points of this cell between."""
        run = np.concatenate(([0], np.cumsum(cell[1:] != cell[:-1])))  # number of the stay in a cell
        return run[moves[1:]] == run[moves[:-1] + 1]
