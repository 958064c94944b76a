"""Comma-separated values: one header row with the signals' names, numbers that read back to the same double.

CSV has no remarks that all readers skip. Therefore incomplete results in ``NAME.csv`` have a second file
``NAME.csv.incomplete`` with the reason, which complete results remove; and results with events have them in
``NAME.csv.events``, whose first line is the size of ``NAME.csv``, so that events of older results are recognised. The
header and the last row end with CR LF, the other rows with LF, which readers treat alike, so that a truncated file is
recognised. A second row may contain units.
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
from mbdsl.messages import cell
from mbdsl.storage.output_files import write_text

if TYPE_CHECKING:
    import numpy as np

    from mbdsl.results.stored import Layout

SUFFIX = ".csv"
TOGETHER = 2**18  #: quantity of numbers that are read at once
MANY = 2**16  #: least quantity of numbers for which the import of the fast reader pays off
TIMES = ("s", "ms", "us", "µs", "ns", "min", "h")  #: units of the first column, by which a row of units is known
INCOMPLETE = "incomplete"  #: suffix of the mark of incomplete results
NO_UNIT = "1"  #: in the row of units
EVENTS = "events"  #: name of their text in the metadata
DIGITS = b"0123456789+-.eE,\r\nnaNAifIF"  #: characters of numbers and separators
CHUNK = 8192  #: number of rows converted to text at a time, to limit the memory


def write(stream: BinaryIO, columns: Mapping, units: Mapping, meta: Mapping) -> None:
    _write(stream, columns, [])


def write_with_units(stream: BinaryIO, columns: Mapping, units: Mapping, meta: Mapping) -> None:
    """As ``write``, with a second row of the units."""
    _write(stream, columns, [units.get(name) or NO_UNIT for name in columns])


def _write(stream: BinaryIO, columns: Mapping, units: Sequence[str]) -> None:
    import numpy as np

    count = len(next(iter(columns.values())))
    header = io.StringIO()
    csv.writer(header, lineterminator="\r\n" if count else "\n").writerow(map(cell, columns))
    if units:
        csv.writer(header, lineterminator="\n").writerow(map(cell, units))
    stream.write(header.getvalue().encode())
    for k in range(0, count, CHUNK):
        rows = np.column_stack([np.asarray(c[k : k + CHUNK], dtype=float) for c in columns.values()])
        # The text of a nested list is the fastest conversion of many doubles to their shortest digits.
        text = repr(rows.tolist())[2:-2].replace("], [", "\n").replace(", ", ",")
        stream.write(text.encode() + (b"\r\n" if k + CHUNK >= count else b"\n"))


def mark(path: Path, meta: Mapping) -> None:
    """Mark incomplete results, before ``path`` gets its name."""
    if not meta.get("complete", True):
        said = {key: value for key, value in meta.items() if key != EVENTS}
        write_text(_beside(path, INCOMPLETE), "".join(f"{key} = {value}\n" for key, value in said.items()))


def settle(path: Path, meta: Mapping) -> None:
    """Write or remove the events, and remove the mark of complete results, after ``path`` has got its name."""
    if events := meta.get(EVENTS):
        write_text(_beside(path, EVENTS), f"{os.path.getsize(path)}\n{events}\n")
    else:
        _remove(_beside(path, EVENTS), f"which has events of earlier results in `{path}`")
    if meta.get("complete", True):
        _remove(_beside(path, INCOMPLETE), f"which marks `{path}` as incomplete")


def _remove(file: Path, why: str) -> None:
    if not os.path.lexists(file):  # also where its name would be too long
        return
    try:
        file.unlink()
    except OSError as problem:
        raise UsageError(f"cannot remove `{file}`, {why}: {problem.strerror or problem}") from problem


def _about(path: Path) -> dict[str, str | float | bool]:
    """What the files beside the results say."""
    said = dict[str, str | float | bool](complete=not os.path.exists(_beside(path, INCOMPLETE)))
    events = _beside(path, EVENTS)
    if os.path.isfile(events):  # not where its name would be too long
        size, _, text = events.read_text(encoding="utf-8").partition("\n")
        if size == str(os.path.getsize(path)):
            said[EVENTS] = text
    return said


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
    if _units(names, lines[0] if lines else ""):
        del lines[0]
    rows = np.loadtxt(lines, delimiter=",", ndmin=2) if lines else np.empty((0, len(names)))
    if rows.shape[1] != len(names):
        raise ValueError(f"the header names {len(names)} columns, the rows have {rows.shape[1]}")
    return {name: rows[:, k] for k, name in enumerate(names)}, _about(path)


def layout(path: Path) -> Layout:
    """The columns, for reading in parts."""
    import numpy as np

    from mbdsl.results.stored import Layout

    with open(path, "rb") as stream:
        header, first = stream.readline(), stream.readline()
        names = next(csv.reader([header.decode()]), [])
        units = _units(names, first.decode(errors="replace"))
        begin = len(header) + (len(first) if units else 0)
        first = stream.readline() if units else first
        stream.seek(-min(2, os.path.getsize(path)), os.SEEK_END)
        end = stream.read()
    if [name.lower() for name in names[:1]] != ["time"]:
        raise ValueError("its first line does not begin with time")
    if not header.endswith(b"\n") or (header.endswith(b"\r\n") and not first):
        raise ValueError("it was cut after its first line")
    if header.endswith(b"\r\n") and not first.endswith(b"\r\n") and end != b"\r\n":  # ours: see ``_cut``
        raise ValueError("it was cut: its last row is incomplete")
    place = {name: k for k, name in enumerate(names)}

    def chunks(asked: Sequence[str], rows: int) -> Iterator:
        at = [place[name] for name in asked]
        with open(path, "rb") as stream:
            stream.seek(begin)
            while parts := list(_parts(stream, at, len(names), rows)):
                yield parts[0] if len(parts) == 1 else np.concatenate(parts, axis=1)

    return Layout(names, units, chunks, _about(path))


def _parts(stream: BinaryIO, at: Sequence[int], columns: int, rows: int) -> Iterator[np.ndarray]:
    """The values (columns, k) of the next ``rows`` rows, in parts whose text is short."""
    some = max(1, TOGETHER // columns)
    while rows > 0 and (lines := list(islice(stream, min(some, rows)))):
        rows -= len(lines)
        found = _fast(lines, columns)
        yield _by_numpy(lines, at) if found is None else found[list(at)]


def _by_numpy(lines: list[bytes], at: Sequence[int]) -> np.ndarray:
    import numpy as np

    return np.loadtxt(lines, delimiter=",", usecols=at, ndmin=2).T


def _fast(lines: list[bytes], columns: int) -> np.ndarray | None:
    """Values (columns, rows) of many lines; None for few lines, and for what only the strict reader can judge.

    SciPy reads a text of one number a line, as in files of Matrix Market, three times as fast as NumPy reads rows.
    """
    if len(lines) * columns < MANY or not find_spec("scipy.io._fast_matrix_market"):
        return None
    from scipy.io import mmread

    text = b"".join(lines)
    if text.translate(None, DIGITS) or text.count(b",") != len(lines) * (columns - 1):
        return None
    head = b"%%%%MatrixMarket matrix array real general\n%d %d\n" % (columns, len(lines))
    try:
        return mmread(io.BytesIO(head + text.replace(b",", b"\n")))
    except ValueError:
        return None


def _units(names: Sequence[str], line: str) -> dict[str, str]:
    """The units in the second line of a file; none if it is a row of numbers."""
    found = next(csv.reader([line]), [])
    try:
        float(found[0])
    except ValueError:
        if len(found) == len(names) and found[0] in TIMES:
            return {name: "" if unit == NO_UNIT else unit for name, unit in zip(names, found, strict=True)}
    except IndexError:
        pass
    return {}


def _cut(header: str, lines: list[str]) -> bool:
    """Whether rows are missing at the end. In files of other programs all lines end alike."""
    if not header.endswith("\r\n"):
        return not header.endswith("\n")
    ours = not any(line.endswith("\r\n") for line in lines[:-1])
    return not lines or (ours and not lines[-1].endswith("\r\n"))


def _beside(path: Path, what: str) -> Path:
    return path.with_name(f"{path.name}.{what}")
