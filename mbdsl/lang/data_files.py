"""Files of numbers beside a model: CSV with units in its header, ``s [m], z [mm]``, and npz of a run.

A model is data, perhaps of other authors: its files are in its folder or below, after all links are resolved, and never
elsewhere. Only the columns that tables use are kept.
"""

from __future__ import annotations

import ast
import csv
import io
import math
import os
import re
import stat
import sys
from array import array
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import chain, pairwise
from typing import TYPE_CHECKING, BinaryIO, NoReturn

from mbdsl.errors import ModelError, Span
from mbdsl.lang import limits, units
from mbdsl.mechanism.points import Points
from mbdsl.messages import count, did_you_mean, few

if TYPE_CHECKING:
    from zipfile import ZipFile

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
    if not is_inside(path, home):
        raise DataError("it leads out of the folder of the model", "a file of a table is beside the model or below it")
    return path


def is_inside(path: str, folder: str) -> bool:
    """Whether a path leads into a folder, after all links are resolved."""
    try:
        return os.path.commonpath([folder, os.path.realpath(path)]) == folder
    except ValueError:  # another drive
        return False


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
                found = _npz(stream, x, y) if path.lower().endswith(".npz") else _csv(stream, x, y)
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
    scales = [units.valid(c.unit).factor if c.unit else 1.0 for c in columns.values()]
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
    header = text.readline(limits.TEXT)
    mark = next((c for c in (",", ";", "\t") if c in header), ",")
    heads = [_HEAD.fullmatch(cell) for cell in next(csv.reader([header], delimiter=mark), [])]
    names, own = [m[1] for m in heads if m], [m[2] or "" for m in heads if m]
    if not any(names) or all(_is_number(name) for name in names if name):
        raise DataError("it has no names of columns", FORM, 1, header)
    i, j = _place(names, x, "x", 0, header), _place(names, y, "y", 1, header)
    rows = csv.reader(text, delimiter=mark)
    first = next(rows, [])
    if len(first) == len(names) and not any(own) and not any(map(_is_number, first)) and any(first):
        own = ["" if cell.strip() in ("1", "-") else cell.strip() for cell in first]  # a row of units
        first = []
    units_of = [_unit(own[k], names[k], 1, header) for k in (i, j)]
    us, ys, before = array("d"), array("d"), -math.inf
    for row in chain([first], rows):
        try:
            u, y_of_u = float(row[i]), float(row[j])
            if len(row) > len(names) and any(map(str.strip, row[len(names) :])):
                raise ValueError
            if not (before < u < math.inf and -math.inf < y_of_u < math.inf) or len(us) == limits.DATA_ROWS:
                raise ValueError
        except (ValueError, IndexError):
            if any(map(str.strip, row)):
                _blame(row, rows.line_num + 1, mark, names, (i, j), before, len(us))
            continue
        us.append(u)
        ys.append(y_of_u)
        before = u
    if len(us) < 2:
        raise DataError(f"it has {count(len(us), 'row')} of numbers, expected at least 2", FORM)
    return _made([names[i], names[j]], [us, ys], units_of)


def _made(names: Sequence[str], columns: Sequence[array[float]], units_of: Sequence[str]) -> Columns:
    """Columns in SI units."""
    found = {}
    for name, numbers, unit in zip(names, columns, units_of, strict=True):
        scale = units.valid(unit).factor if unit else 1.0
        found[name] = Column(Points(numbers if scale == 1.0 else (scale * number for number in numbers)), unit)
    return found


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


def _blame(
    row: Sequence[str], line: int, mark: str, names: Sequence[str], places: Sequence[int], before: float, rows: int
) -> NoReturn:
    """Raise the error of a row."""
    shown, each = mark.join(row), "each row has a number in each column"
    if rows == limits.DATA_ROWS:
        raise DataError(f"it has more than {limits.DATA_ROWS} rows")
    if len(row) > len(names) and any(map(str.strip, row[len(names) :])):
        right = "write decimals with a point, or separate columns by semicolons"
        raise DataError(
            f"it has {len(row)} values, but the header names {count(len(names), 'column')}", right, line, shown
        )
    for k in places:
        value = row[k].strip() if k < len(row) else ""
        if not value:
            raise DataError(f"it has no value in column `{names[k]}`", each, line, shown)
        if not _is_number(value):
            decimal = _is_number(value.replace(",", ".", 1))
            right = "write decimals with a point" if decimal else "expected a number; units are in the first line"
            raise DataError(f"found `{value[:40]}` in column `{names[k]}`", right, line, shown)
        if not math.isfinite(float(value)):
            raise DataError(f"found `{value}` in column `{names[k]}`, expected a finite number", None, line, shown)
    message = f"column `{names[places[0]]}` must increase strictly: {float(row[places[0]]):.12g} follows {before:.12g}"
    raise DataError(message, "sort the rows, and give each value once", line, shown)


# -- npz ---------------------------------------------------------------------------------------------------------------


def _npz(stream: BinaryIO, x: str | None, y: str | None) -> Columns:
    import json
    import zipfile
    import zlib

    # archives may also be encrypted, packed by unknown methods, or have heads that cannot be read
    damaged = (zipfile.BadZipFile, zlib.error, EOFError, OSError, RuntimeError, MemoryError)
    damaged += (KeyError, ValueError, IndexError, SyntaxError, TypeError, AttributeError)
    try:
        with zipfile.ZipFile(stream) as archive:
            about = json.loads(_member(archive, "_mbdsl", limits.DATA_SIZE).decode("utf-32-le").rstrip("\0"))
            names, known = list(map(str, about["names"])), {"time": "s", **about["units"]}
            asked = [names[_place(names, name, what, k)] for k, (name, what) in enumerate(((x, "x"), (y, "y")))]
            columns = [array("d", _member(archive, name, 8 * limits.DATA_ROWS)) for name in asked]
    except damaged as problem:
        reason = str(problem)[:200] or None
        raise DataError("it is not the npz of a run, or is damaged", reason) from None
    if sys.byteorder == "big":
        for column in columns:
            column.byteswap()
    us, _ys = columns
    if len(us) < 2:
        raise DataError(f"it has {count(len(us), 'row')}, expected at least 2")
    for name, column in zip(asked, columns, strict=True):
        if not all(map(math.isfinite, column)):
            raise DataError(f"`{name}` is not a finite number in row {[*map(math.isfinite, column)].index(False) + 1}")
    for k, (u, v) in enumerate(pairwise(us), 2):
        if not u < v:
            raise DataError(f"`{asked[0]}` must increase strictly: {v:.12g} follows {u:.12g} in row {k}")
    return _made(asked, columns, [_unit(str(known.get(name) or ""), name, 0, "") for name in asked])


def _member(archive: ZipFile, name: str, most: int) -> bytes:
    """The numbers of an array of an archive, or its text, as they are stored (NEP 1 of NumPy).

    Raises
    ------
    DataError
        If they are more than ``most`` bytes.
    ValueError
        If it is not an array of 64-bit numbers, or a text.
    """
    with archive.open(f"{name}.npy") as member:
        if member.read(6) != b"\x93NUMPY":
            raise ValueError(f"`{name}` is not an array")
        long = member.read(2)[0] > 1
        head = ast.literal_eval(
            member.read(min(10_000, int.from_bytes(member.read(4 if long else 2), "little"))).decode()
        )
        kind, shape = head["descr"], head["shape"]
        if not (kind == "<f8" and len(shape) == 1) and not (kind[:2] == "<U" and shape == ()):
            raise ValueError(f"`{name}` is not a column of numbers")
        size = 8 * int(shape[0]) if shape else 4 * int(kind[2:])
        if size > most:
            raise DataError(f"it has more than {limits.DATA_ROWS} rows")
        data = member.read(size)
    if len(data) < size:
        raise ValueError(f"`{name}` is shorter than it says")
    return data


def blamed(problem: DataError, name: str, path: str | None, span: Span | None) -> ModelError:
    """The error of a file as that of the table that names it; a line of the file is shown below."""
    if not problem.line:
        return ModelError(f"`{name}`: {problem.problem}", span, problem.remedy)
    text = problem.text.rstrip("\r\n")[:1000]
    place = Span(path or name, problem.line, 1, max(1, len(text)), text)
    message = f"`{name}`, line {problem.line}: {problem.problem}"
    return ModelError(message, span, problem.remedy, (("the line is here", place),))
