"""Files of numbers beside a model: CSV with units in its header, ``s [m], z [mm]``, and npz of a run.

A model is data, perhaps of other authors: its files are in its folder or below, after all links are resolved, and never
elsewhere. Only the columns that tables use are kept.
"""

from __future__ import annotations

import csv
import io
import math
import os
import re
import stat
from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from itertools import chain, count, islice
from typing import BinaryIO, NoReturn

from mbdsl.errors import ModelError, Span
from mbdsl.lang import limits, units
from mbdsl.mechanism.points import Points
from mbdsl.messages import count as count_of
from mbdsl.messages import did_you_mean, few

SUFFIXES = (".csv", ".npz")
DIGEST = "SHA-256 of the columns: "  #: begins the text of a file that is too long to be stored with results
FORM = "the first line names the columns, with units: `s [m], z [mm]`; a row of numbers follows for each point"
_HEAD = re.compile(r"\s*(.*?)\s*(?:\[\s*([^\[\]]*?)\s*\]\s*)?", re.DOTALL)
_CACHED = 2  #: number of pairs of columns that are kept for models that are read again
_cache: dict[tuple, Columns] = {}


@dataclass(frozen=True)
class Column:
    """A column of a file: its numbers in the SI unit, its unit as written ("" if it has none) and its dimension."""

    numbers: Points
    unit: str

    @property
    def dimension(self) -> units.Dimension | None:
        return units.dimension(self.unit) if self.unit else None


Columns = dict[str, Column]


class DataError(Exception):
    """What is wrong in a file; ``line`` from 1 and its text, if it is a line; ``remedy`` is what would be right."""

    def __init__(self, problem: str, remedy: str | None = None, line: int = 0, text: str = "") -> None:
        super().__init__(problem)
        self.problem, self.remedy, self.line, self.text = problem, remedy, line, text


def resolved(name: str, importing: str, home: str) -> str:
    """The path of a file beside a model, checked before the file is accessed.

    Parameters
    ----------
    name : str
        As in the model.
    importing : str
        The file that names it.
    home : str
        The folder of the model, without links.

    Raises
    ------
    DataError
        If it is elsewhere.
    """
    parts = re.split(r"[/\\]", name)
    if "://" in name or name.startswith(("/", "\\", "~")) or name[1:2] == ":" or ".." in parts:
        raise DataError("it leads out of the folder of the model", "a file of a table is beside the model or below it")
    if not name.strip() or "\0" in name:
        raise DataError("it names no file", 'write its name: `file = "road.csv"`')
    if not name.lower().endswith(SUFFIXES):
        raise DataError("its suffix is none of .csv and .npz", "CSV with units in the first line, or the npz of a run")
    path = os.path.normpath(os.path.join(os.path.dirname(importing), name))
    try:
        inside = os.path.commonpath([home, os.path.realpath(path)]) == home
    except ValueError:  # another drive
        inside = False
    if not inside:
        raise DataError("it leads out of the folder of the model", "a file of a table is beside the model or below it")
    return path


def read(path: str, x: str | None, y: str | None) -> Columns:
    """Two columns of a file, ``x`` first; without names the first and the second of a file that has two.

    Raises
    ------
    DataError
        If they cannot be read.
    """
    try:
        # of a pipe or a device nothing is read
        handle = os.open(path, os.O_RDONLY | getattr(os, "O_NONBLOCK", 0) | getattr(os, "O_BINARY", 0))
        status = os.fstat(handle)
        if not stat.S_ISREG(status.st_mode):
            os.close(handle)
            raise DataError("it is not a regular file")
        with open(handle, "rb") as stream:
            if status.st_size > limits.DATA_SIZE:
                raise DataError(f"it has {status.st_size} bytes; a file of a table has at most {limits.DATA_SIZE}")
            key = os.path.realpath(path), status.st_mtime_ns, status.st_size, status.st_ino, x, y
            if key not in _cache:
                found = _npz(path, x, y) if path.lower().endswith(".npz") else _csv(stream, x, y)
                while len(_cache) >= _CACHED:
                    del _cache[next(iter(_cache))]
                _cache[key] = found
            return _cache[key]
    except FileNotFoundError:
        raise DataError("there is no such file", _close(path)) from None
    except (OSError, ValueError) as problem:
        raise DataError(f"it cannot be read: {getattr(problem, 'strerror', None) or problem}") from None


def _close(path: str) -> str | None:
    try:
        names = [n for n in sorted(os.listdir(os.path.dirname(path) or "."))[:2000] if n.lower().endswith(SUFFIXES)]
    except OSError:
        return None
    return did_you_mean(os.path.basename(path), names)


def from_text(text: str, x: str | None, y: str | None) -> Columns:
    """As :func:`read`, from the text of :func:`as_text`."""
    if text.startswith(DIGEST):
        raise DataError("it is too long to be stored with results", "load the model from its file")
    return _csv(io.BytesIO(text.encode()), x, y)


def as_text(columns: Mapping[str, Column]) -> str:
    """Columns as CSV, with all digits; of long ones a digest."""
    if sum(len(c.numbers) for c in columns.values()) > limits.ARRAY:
        return DIGEST + " ".join(f"{name} [{c.unit}] {c.numbers.digest}" for name, c in columns.items())
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(f"{name} [{c.unit}]" if c.unit else name for name, c in columns.items())
    scales = [units.parse(c.unit).factor if c.unit else 1.0 for c in columns.values()]  # type: ignore[union-attr]
    ones = all(scale == 1.0 for scale in scales)
    rows = zip(*(c.numbers for c in columns.values()), strict=True)
    writer.writerows(rows if ones else _unscaled(rows, scales))
    return text.getvalue()


def _unscaled(rows: Iterator, scales: Sequence[float]) -> Iterator[list[float]]:
    """Numbers that become those of the rows again when they are multiplied by the scales."""
    for row in rows:
        yield [_quotient(number, scale) for number, scale in zip(row, scales, strict=True)]


def _quotient(number: float, scale: float) -> float:
    first = number / scale
    near = (first, math.nextafter(first, math.inf), math.nextafter(first, -math.inf))
    return next((x for x in near if x * scale == number), first)


# -- CSV ---------------------------------------------------------------------------------------------------------------


def _csv(stream: BinaryIO, x: str | None, y: str | None) -> Columns:
    text = io.TextIOWrapper(stream, encoding="utf-8-sig", newline="")
    try:
        return _columns(text, x, y)
    except UnicodeDecodeError:
        raise DataError("it is not a text (UTF-8)", FORM) from None
    except csv.Error as problem:
        raise DataError(str(problem), FORM) from None
    finally:
        text.detach()  # the caller closes the stream


def _columns(text: io.TextIOWrapper, x: str | None, y: str | None) -> Columns:
    import numpy as np

    header = text.readline(limits.TEXT)
    mark = next((c for c in (",", ";", "\t") if c in header), ",")
    heads = [_HEAD.fullmatch(cell) for cell in next(csv.reader([header], delimiter=mark), [])]
    names, own = [m[1] for m in heads if m], [m[2] or "" for m in heads if m]
    if not any(names) or all(_is_number(name) for name in names if name):
        raise DataError("it has no names of columns", FORM, 1, header)
    places = [_place(names, x, "x", 0, header), _place(names, y, "y", 1, header)]
    line = text.readline()
    second = next(csv.reader([line], delimiter=mark), [])
    before = 1
    if len(second) == len(names) and not any(own) and not any(map(_is_number, second)) and any(second):
        own, before, line = ["" if cell.strip() in ("1", "-") else cell.strip() for cell in second], 2, text.readline()
    found = [_unit(own[k], names[k], before, header) for k in places]
    while line and not line.strip():
        line = text.readline()
    rows = None
    if not line:
        rows = np.empty((0, 2))
    else:
        lines = chain([line], islice(text, limits.DATA_ROWS))
        with suppress(ValueError):
            rows = np.loadtxt(lines, delimiter=mark, usecols=places, ndmin=2, comments=None, quotechar='"')
    if rows is None or not np.isfinite(rows).all():
        _blame(text, before, mark, names, places)
    if len(rows) > limits.DATA_ROWS or next(text, ""):
        raise DataError(f"it has more than {limits.DATA_ROWS} rows")
    if len(rows) < 2:
        raise DataError(f"it has {count_of(len(rows), 'row')} of numbers, expected at least 2", FORM)
    falls = np.flatnonzero(~(rows[1:, 0] > rows[:-1, 0]))
    if len(falls):
        at, row = next(islice(_rows(text, before, mark), int(falls[0]) + 1, None))
        u, v = (f"{value:.12g}" for value in rows[falls[0] : falls[0] + 2, 0])
        message = f"column `{names[places[0]]}` must grow, but has {v} after {u}"
        raise DataError(message, "sort the rows, and give each value once", at, mark.join(row))
    scales = [units.parse(unit).factor if unit else 1.0 for unit in found]  # type: ignore[union-attr]
    return {names[k]: Column(Points((rows[:, j] * scales[j]).tolist()), found[j]) for j, k in enumerate(places)}


def _is_number(text: str) -> bool:
    try:
        float(text)
    except ValueError:
        return False
    return True


def _place(names: Sequence[str], wanted: str | None, what: str, default: int, header: str = "") -> int:
    if wanted is None:
        if len(names) != 2:
            raise DataError(
                f"it has {len(names)} columns: {few(names, 8)}", f'name one of them: `{what} = "{names[0]}"`'
            )
        return default
    if wanted not in names:
        hint = did_you_mean(wanted, names, "columns") or f"its columns are {few(names, 8)}"
        raise DataError(f"it has no column `{wanted}`", hint)
    if names.count(wanted) > 1:
        raise DataError(
            f"it has {names.count(wanted)} columns `{wanted}`", "give each column a name of its own", 1, header
        )
    return names.index(wanted)


def _unit(unit: str, name: str, line: int, header: str) -> str:
    if unit in ("", "1", "-"):
        return ""
    if units.parse(unit) is None:
        meant = units.meant(unit)
        hint = f"did you mean {meant}?" if meant else "units are written as in the language: m, mm, N/mm, deg, rad/s"
        raise DataError(f"unknown unit `{unit}` of column `{name}`", hint, line, header if line == 1 else "")
    return unit


def _rows(text: io.TextIOWrapper, before: int, mark: str) -> Iterator[tuple[int, list[str]]]:
    """Number of the line, and cells, of each row that is not blank, from the beginning of the file."""
    text.seek(0)
    for _ in range(before):
        text.readline()
    for line in count(before + 1):
        found = text.readline()
        if not found:
            return
        if found.strip():
            yield line, next(csv.reader([found], delimiter=mark))


def _blame(text: io.TextIOWrapper, before: int, mark: str, names: Sequence[str], places: Sequence[int]) -> NoReturn:
    """Raise the error of the first row that is not a row of numbers."""
    for line, row in _rows(text, before, mark):
        for k in places:
            shown = mark.join(row)
            if len(row) <= k:
                raise DataError(
                    f"it has no value in column `{names[k]}`", "each row has a number in each column", line, shown
                )
            value = row[k].strip()
            if not value:
                raise DataError(f"column `{names[k]}` is empty", "each row has a number in each column", line, shown)
            if not _is_number(value):
                decimal = _is_number(value.replace(",", ".", 1))
                right = "write decimals with a point" if decimal else "expected a number; units are in the first line"
                raise DataError(f"found `{value[:40]}` in column `{names[k]}`", right, line, shown)
            if not math.isfinite(float(value)):
                raise DataError(f"found `{value}` in column `{names[k]}`, expected a finite number", None, line, shown)
    raise DataError("its rows are not rows of numbers", FORM)


# -- npz ---------------------------------------------------------------------------------------------------------------


def _npz(path: str, x: str | None, y: str | None) -> Columns:
    from pathlib import Path

    import numpy as np

    from mbdsl.results import npz_file

    try:
        layout = npz_file.layout(Path(path))
        names = list(layout.names)
        wanted = [names[_place(names, x, "x", 0)], names[_place(names, y, "y", 1)]]
        numbers = next(iter(layout.chunks(wanted, limits.DATA_ROWS + 1)), [np.empty(0), np.empty(0)])
        units_of = {**dict.fromkeys(["time"], "s"), **layout.units}
    except DataError:
        raise
    except Exception as problem:  # zipfile, zlib, json and numpy each raise their own errors at damaged bytes
        raise DataError("it is not the npz of a run, or is damaged", str(problem)[:200] or None) from None
    if len(numbers[0]) > limits.DATA_ROWS:
        raise DataError(f"it has more than {limits.DATA_ROWS} rows")
    if len(numbers[0]) < 2:
        raise DataError(f"it has {count_of(len(numbers[0]), 'row')}, expected at least 2")
    for name, values in zip(wanted, numbers, strict=True):
        if not np.isfinite(values).all():
            row = int(np.flatnonzero(~np.isfinite(values))[0])
            raise DataError(f"`{name}` is not a finite number in row {row + 1}")
    falls = np.flatnonzero(~(np.diff(numbers[0]) > 0.0))
    if len(falls):
        raise DataError(f"`{wanted[0]}` must grow, but has {numbers[0][falls[0] + 1]:.12g} after "
                        f"{numbers[0][falls[0]]:.12g} in row {falls[0] + 2}")  # fmt: skip
    pairs = zip(wanted, numbers, strict=True)
    return {
        name: Column(Points(np.asarray(v, float).tolist()), _unit(units_of.get(name) or "", name, 0, ""))
        for name, v in pairs
    }


def blamed(problem: DataError, name: str, path: str | None, span: Span | None) -> ModelError:
    """The error of a file as that of the table that names it; a line of the file is shown below."""
    if not problem.line:
        return ModelError(f"`{name}`: {problem.problem}", span, problem.remedy)
    text = problem.text.rstrip("\r\n")[:1000]
    place = Span(path or name, problem.line, 1, max(1, len(text)), text)
    message = f"`{name}`, line {problem.line}: {problem.problem}"
    return ModelError(message, span, problem.remedy, (("the line is here", place),))
