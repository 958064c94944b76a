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
from itertools import islice
from pathlib import Path
from typing import TYPE_CHECKING, BinaryIO

from mbdsl.errors import UsageError
from mbdsl.storage.output_files import write_text

if TYPE_CHECKING:
    from mbdsl.results.stored import Layout

SUFFIX = ".csv"
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
    """The columns, for reading in parts."""
    import numpy as np

    from mbdsl.results.stored import Layout

    with open(path, encoding="utf-8", newline="") as stream:
        names = next(csv.reader([stream.readline()]), [])
    if [name.lower() for name in names[:1]] != ["time"]:
        raise ValueError("its first line does not begin with time")
    place = {name: k for k, name in enumerate(names)}

    def chunks(asked: Sequence[str], rows: int) -> Iterator:
        at = [place[name] for name in asked]
        for lines in _parts(path, rows):
            yield np.loadtxt(lines, delimiter=",", usecols=at, ndmin=2).T

    return Layout(names, {}, chunks, dict(complete=not os.path.exists(_mark(path))))


def _parts(path: Path, rows: int) -> Iterator[list[str]]:
    """The rows as text, in parts.

    Raises
    ------
    ValueError
        If the file was cut.
    """
    with open(path, encoding="utf-8", newline="") as stream:
        header, count, ours, last = stream.readline(), 0, False, ""
        while lines := list(islice(stream, rows)):
            if count == 0:
                ours = header.endswith("\r\n") and not lines[0].endswith("\r\n")
            count, last = count + len(lines), lines[-1]
            yield lines
    if (ours and not last.endswith("\r\n")) or (header.endswith("\r\n") and not count) or not header.endswith("\n"):
        raise ValueError(f"it was cut after {max(0, count - 1)} whole rows")


def _cut(header: str, lines: list[str]) -> bool:
    """Whether rows are missing at the end. In files of other programs all lines end alike."""
    if not header.endswith("\r\n"):
        return not header.endswith("\n")
    ours = not any(line.endswith("\r\n") for line in lines[:-1])
    return not lines or (ours and not lines[-1].endswith("\r\n"))


def _mark(path: Path) -> Path:
    return path.with_name(f"{path.name}.incomplete")
