"""Comma-separated values: one header row with the signals' names, numbers that read back to the same double.

CSV has no remarks that all readers skip. Therefore incomplete results in ``NAME.csv`` have a second file
``NAME.csv.incomplete`` with the reason, which complete results remove. The header and the last row end with CR LF, the
other rows with LF, which readers treat alike, so that a truncated file is recognised.
"""

from __future__ import annotations

import csv
import io
import os
from collections.abc import Iterator, Mapping, Sequence
from importlib.util import find_spec
from itertools import islice
from pathlib import Path
from typing import TYPE_CHECKING, BinaryIO

from mbdsl.errors import UsageError
from mbdsl.storage.output_files import write_text

if TYPE_CHECKING:
    from mbdsl.results.stored import Layout

SUFFIX = ".csv"
LARGE = 2**25  #: size [byte] above which files are read by pandas, whose import takes longer than reading a small file
CHUNK = 8192  #: number of rows converted to text at a time, to limit the memory


def write(stream: BinaryIO, columns: Mapping, units: Mapping, meta: Mapping) -> None:
    import numpy as np

    rows = np.column_stack([np.asarray(c, dtype=float) for c in columns.values()])
    header = io.StringIO()
    csv.writer(header, lineterminator="\r\n" if len(rows) else "\n").writerow(columns)
    stream.write(header.getvalue().encode())
    for k in range(0, len(rows), CHUNK):
        # The text of a nested list is the fastest conversion of many doubles to their shortest digits.
        text = repr(rows[k : k + CHUNK].tolist())[2:-2].replace("], [", "\n").replace(", ", ",")
        last = k + CHUNK >= len(rows)
        stream.write(text.encode() + (b"\r\n" if last else b"\n"))


def mark(path: Path, meta: Mapping) -> None:
    """Mark incomplete results, before ``path`` gets its name."""
    if not meta.get("complete", True):
        write_text(_mark(path), "".join(f"{key} = {value}\n" for key, value in meta.items()))


def settle(path: Path, meta: Mapping) -> None:
    """Remove the mark of complete results, after ``path`` has got its name."""
    mark = _mark(path)
    if not meta.get("complete", True) or not os.path.lexists(mark):
        return
    try:
        mark.unlink()
    except OSError as problem:
        why = problem.strerror or problem
        raise UsageError(f"cannot remove `{mark}`, which marks `{path}` as incomplete: {why}") from problem


def read(path: Path) -> tuple[dict, dict]:
    import numpy as np

    with open(path, encoding="utf-8", newline="") as stream:
        header = stream.readline()
        names = next(csv.reader([header]), [])
        if names[:1] != ["time"]:
            raise ValueError("its first line does not begin with time")
        lines = stream.readlines()
    if _cut(header, lines):
        raise ValueError(f"it was cut after {max(0, len(lines) - 1)} whole rows")
    rows = np.loadtxt(lines, delimiter=",", ndmin=2) if lines else np.empty((0, len(names)))
    if rows.shape[1] != len(names):
        raise ValueError(f"the header names {len(names)} columns, the rows have {rows.shape[1]}")
    meta = dict[str, str | float | bool](complete=not os.path.exists(_mark(path)))
    return {name: rows[:, k] for k, name in enumerate(names)}, meta


def layout(path: Path) -> Layout:
    """The columns, for reading in parts: large files by pandas, if it is installed."""
    from mbdsl.results.stored import Layout

    with open(path, "rb") as stream:
        header, first = stream.readline(), stream.readline()
        stream.seek(-min(2, os.path.getsize(path)), os.SEEK_END)
        end = stream.read()
    names = next(csv.reader([header.decode()]), [])
    if [name.lower() for name in names[:1]] != ["time"]:
        raise ValueError("its first line does not begin with time")
    if not header.endswith(b"\n") or (header.endswith(b"\r\n") and not first):
        raise ValueError("it was cut after its first line")
    if header.endswith(b"\r\n") and not first.endswith(b"\r\n") and end != b"\r\n":  # ours: see ``_cut``
        raise ValueError("it was cut: its last row is incomplete")
    place = {name: k for k, name in enumerate(names)}
    large = os.path.getsize(path) > LARGE

    def chunks(asked: Sequence[str], rows: int) -> Iterator:
        at = [place[name] for name in asked]
        if large and find_spec("pandas"):
            return _by_pandas(path, at, rows)
        return _by_numpy(path, at, rows)

    return Layout(names, {}, chunks, dict(complete=not os.path.exists(_mark(path))))


def _by_numpy(path: Path, at: Sequence[int], rows: int) -> Iterator:
    import numpy as np

    with open(path, encoding="utf-8", newline="") as stream:
        stream.readline()
        while lines := list(islice(stream, rows)):
            yield np.loadtxt(lines, delimiter=",", usecols=at, ndmin=2).T


def _by_pandas(path: Path, at: Sequence[int], rows: int) -> Iterator:
    """Measured with 1e7 rows and 4 columns: five times as fast as NumPy."""
    import pandas

    with pandas.read_csv(path, header=None, skiprows=1, usecols=sorted(at), dtype=float, chunksize=rows) as reader:
        for frame in reader:
            yield [frame[k].to_numpy() for k in at]


def _cut(header: str, lines: list[str]) -> bool:
    """Whether rows are missing at the end. In files of other programs all lines end alike."""
    if not header.endswith("\r\n"):
        return not header.endswith("\n")
    ours = not any(line.endswith("\r\n") for line in lines[:-1])
    return not lines or (ours and not lines[-1].endswith("\r\n"))


def _mark(path: Path) -> Path:
    return path.with_name(f"{path.name}.incomplete")
