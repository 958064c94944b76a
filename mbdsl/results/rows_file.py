"""Rows of signals in a scratch file, for results that are longer than the memory.

The rows of a run are appended during the run; the formats then read the columns part by part. A block of rows is
stored column after column, so that both rows and columns are read in long pieces. Only the last block is in memory.
"""

from __future__ import annotations

import os
import tempfile
from collections.abc import Sequence
from pathlib import Path
from types import TracebackType
from typing import TYPE_CHECKING, BinaryIO

from mbdsl.errors import UsageError

if TYPE_CHECKING:
    import numpy as np

NUMBERS = 2**20  #: in a block
ROWS = 2**16  #: most rows of a block


class RowsFile:
    """Rows of signals in a file.

    Parameters
    ----------
    names : sequence of str
        Names of the signals.
    near : path
        A file, in whose folder the scratch file is; it disappears when the process ends.
    kept : bool, optional
        ``near`` is the name of the scratch file itself, which stays until ``remove`` is called.
    count : int, optional
        Number of rows of an existing ``kept`` file to continue after; the later ones are dropped.

    Raises
    ------
    UsageError
        If the file cannot be written, or has fewer than ``count`` rows.
    """

    def __init__(self, names: Sequence[str], near: str | os.PathLike, kept: bool = False, count: int = 0) -> None:
        import numpy as np

        self.names = list(names)
        self.count = count  #: number of rows
        self._path = Path(os.path.realpath(near)) if kept else None
        self.rows = max(1, min(ROWS, NUMBERS // max(1, len(self.names))))  #: of a block
        self._block = np.zeros((len(self.names), self.rows))
        try:
            self._file: BinaryIO = self._opened(near, count)
        except OSError as problem:
            raise UsageError(f"cannot write `{near!s}`: {problem.strerror or problem}") from problem
        if used := count % self.rows:
            self._file.seek(self._place(count))
            data = self._file.read(self._block.nbytes)
            if len(data) == self._block.nbytes:
                self._block[:, :used] = np.frombuffer(data).reshape(self._block.shape)[:, :used]
        if count and os.fstat(self._file.fileno()).st_size < -(-count // self.rows) * self._block.nbytes:
            self._file.close()
            raise UsageError(f"`{near!s}` has fewer than {count} rows", hint="repeat the whole run")

    def _opened(self, near: str | os.PathLike, count: int) -> BinaryIO:
        if self._path is not None:
            return open(self._path, "r+b" if count else "w+b")
        target = Path(os.path.realpath(near))
        folder = target.parent if target.is_file() or not target.exists() else None
        return tempfile.TemporaryFile(dir=folder, prefix=".mbdsl-rows-", buffering=0)

    def append(self, columns: Sequence[np.ndarray]) -> None:
        """Append rows.

        Parameters
        ----------
        columns : sequence of (k,)
            Values of each signal.

        Raises
        ------
        UsageError
            If they cannot be written, as on a full disk.
        """
        added, done = len(columns[0]), 0
        while done < added:
            used = self.count % self.rows
            some = min(added - done, self.rows - used)
            for own, values in zip(self._block, columns, strict=True):
                own[used : used + some] = values[done : done + some]
            if used + some == self.rows:
                self._write(self.count)
            done, self.count = done + some, self.count + some

    def flush(self) -> None:
        """Write also the last block, and wait until the disk has everything."""
        if self.count % self.rows:
            self._write(self.count)
        self._file.flush()
        os.fsync(self._file.fileno())

    def _place(self, row: int) -> int:
        return row // self.rows * self._block.nbytes

    def _write(self, row: int) -> None:
        try:
            self._file.seek(self._place(row))
            left = self._block.data.cast("B")
            while left:
                left = left[self._file.write(left) :]
        except OSError as problem:
            raise UsageError(f"cannot write the results: {problem.strerror or problem}") from problem

    def columns(self) -> dict[str, StoredColumn]:
        """The signals by name, which read their values from the file when they are sliced."""
        return {name: StoredColumn(self, k) for k, name in enumerate(self.names)}

    def values(self, column: int, start: int, stop: int) -> np.ndarray:
        """The values (stop - start,) of a column."""
        import numpy as np

        found, done = np.empty(max(0, stop - start)), 0
        while done < len(found):
            row = start + done
            used = row % self.rows
            some = min(len(found) - done, self.rows - used)
            if row // self.rows == self.count // self.rows:
                found[done : done + some] = self._block[column, used : used + some]
            else:
                self._file.seek(self._place(row) + 8 * (column * self.rows + used))
                left = found[done : done + some].data.cast("B")
                while left:
                    read = self._file.read(len(left))
                    if not read:
                        raise OSError("the scratch file of the results ends early")
                    left[: len(read)] = read
                    left = left[len(read) :]
            done += some
        return found

    def close(self) -> None:
        """Close the file; one without a name disappears."""
        self._file.close()

    def remove(self) -> None:
        """Close the file and delete it."""
        self._file.close()
        if self._path is not None:
            self._path.unlink(missing_ok=True)

    def __enter__(self) -> RowsFile:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, problem: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()


class StoredColumn:
    """A signal in a ``RowsFile``: slices are arrays."""

    def __init__(self, file: RowsFile, place: int) -> None:
        self._file, self._place = file, place

    def __len__(self) -> int:
        return self._file.count

    def __getitem__(self, part: slice) -> np.ndarray:
        start, stop, step = part.indices(len(self))
        assert step == 1
        return self._file.values(self._place, start, stop)

    def __array__(self, dtype=None, copy=None) -> np.ndarray:
        return self[:] if dtype is None else self[:].astype(dtype)
