"""Comma-separated values: one header row with the signals' names, numbers that read back to the same double.

A CSV has no place for remarks that every reader skips, so that a file ``NAME.csv`` with incomplete results has a
``NAME.csv.incomplete`` beside it that says why. Complete results remove it.
"""

from __future__ import annotations

import csv
import io
from collections.abc import Mapping
from pathlib import Path
from typing import BinaryIO

SUFFIX = ".csv"
CHUNK = 8192  #: rows turned to text at a time, to bound the memory


def write(stream: BinaryIO, path: Path, columns: Mapping, units: Mapping, meta: Mapping) -> None:
    import numpy as np

    if not meta.get("complete", True):  # marked before it gets its name: never incomplete and unmarked
        _mark(path).write_text("".join(f"{key} = {value}\n" for key, value in meta.items()), encoding="utf-8")
    header = io.StringIO()
    csv.writer(header, lineterminator="\n").writerow(columns)
    stream.write(header.getvalue().encode())
    rows = np.column_stack([np.asarray(c, dtype=float) for c in columns.values()])
    for k in range(0, len(rows), CHUNK):
        # The text of a nested list is the fastest way to the shortest digits of many doubles.
        text = repr(rows[k : k + CHUNK].tolist())
        stream.write(text[2:-2].replace("], [", "\n").replace(", ", ",").encode() + b"\n")


def settle(path: Path, meta: Mapping) -> None:
    """Called when ``path`` has got its name."""
    if meta.get("complete", True):
        _mark(path).unlink(missing_ok=True)


def read(path: Path) -> tuple[dict, dict]:
    import numpy as np

    with open(path, encoding="utf-8", newline="") as stream:
        names = next(csv.reader(stream), [])
        if names[:1] != ["time"]:
            raise ValueError("its first line does not begin with time")
        lines = stream.readlines()
    rows = np.loadtxt(lines, delimiter=",", ndmin=2) if lines else np.empty((0, len(names)))
    if rows.shape[1] != len(names):
        raise ValueError(f"the header names {len(names)} columns, the rows have {rows.shape[1]}")
    meta = dict[str, str | float | bool](complete=not _mark(path).exists())
    return {name: rows[:, k] for k, name in enumerate(names)}, meta


def _mark(path: Path) -> Path:
    return path.with_name(f"{path.name}.incomplete")
