"""Dymola's and OpenModelica's trajectory file: MATLAB 4 matrices, version 1.1, ``binTrans``.

Read by OMPlot, OMEdit, DyMat, BuildingsPy and others. The matrices that these programs expect:

``Aclass``     4 lines of text: "Atrajectory", "1.1", "", "binTrans"
``name``       the signals' names, ``description`` their texts "[unit]"; one name a column (transposed)
``dataInfo``   int32 (4, signals): data matrix (0: the abscissa), row in it, interpolation 0, extrapolation -1
``data_1``     constants: start and stop time in row 1, then one row per constant, two columns
``data_2``     trajectories: time in row 1, then one row per signal, one column per time

``meta`` is stored in the constants ``mbdsl.KEY``: numbers as values, texts in the description. Long texts follow as
matrices ``mbdsl_KEY`` of one line, because all descriptions are as long as the longest.

``scipy.io.savemat`` writes the same bytes, but the texts and tables have to be laid out for it as well: it would save
some 20 lines, and its import adds 0.25 s to the 0.55 s of a short run.
"""

from __future__ import annotations

import json
import struct
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, BinaryIO

if TYPE_CHECKING:
    import numpy as np

    from mbdsl.results.stored import Layout

SUFFIX = ".mat"
PREFIX = "mbdsl."
LONG, LONG_PREFIX = 200, "mbdsl_"  #: characters from which a text is a matrix of its own, and its name
NUMBERS = 2**18  #: that are written at once
_TYPES = {0: "<f8", 10: "<f4", 20: "<i4", 50: "u1", 51: "u1"}  #: code of little-endian matrices -> dtype


def write(stream: BinaryIO, columns: Mapping, units: Mapping, meta: Mapping) -> None:
    import numpy as np

    signals = list(columns)
    long = {key: value for key, value in meta.items() if isinstance(value, str) and len(value) >= LONG}
    meta = {key: value for key, value in meta.items() if key not in long}
    names = signals + [PREFIX + key for key in meta]
    notes = [f"[{units[name]}]" if units.get(name) else "" for name in signals]
    notes += [json.dumps(value) for value in meta.values()]
    info = [(2 if k else 0, k + 1, 0, -1) for k in range(len(signals))]
    info += [(1, k + 2, 0, 0) for k in range(len(meta))]
    time, count = columns[signals[0]], len(columns[signals[0]])
    constants = [(float(time[:1][0]), float(time[count - 1 :][0])) if count else (0.0, 0.0)]
    constants += [(x, x) for x in (float(v) if isinstance(v, (int, float)) else np.nan for v in meta.values())]
    _matrix(stream, "Aclass", _text(["Atrajectory", "1.1", "", "binTrans"]).T, 51)
    _matrix(stream, "name", _text(names), 51)
    _matrix(stream, "description", _text(notes), 51)
    _matrix(stream, "dataInfo", np.array(info, dtype="<i4").T, 20)
    _matrix(stream, "data_1", np.array(constants), 0)
    _head(stream, "data_2", (len(signals), count), 0)
    rows = max(1, NUMBERS // len(signals))
    for k in range(0, count, rows):
        part = np.column_stack([np.asarray(c[k : k + rows], dtype=_TYPES[0]) for c in columns.values()])
        stream.write(part.tobytes())
    for key, value in long.items():
        _matrix(stream, LONG_PREFIX + key, _text([json.dumps(value)]).T, 51)


def read(path: Path) -> tuple[dict, dict]:
    matrices = {name: values for name, values, _ in _matrices(path.read_bytes())}
    if _normal(matrices["Aclass"]):
        matrices = {key: value.T for key, value in matrices.items()}
    names, notes = _lines(matrices["name"]), _lines(matrices["description"])
    columns, meta = {}, {"complete": True, **_long(matrices)}
    for name, note, (matrix, row, *_) in zip(names, notes, matrices["dataInfo"].T.tolist(), strict=True):
        if matrix == 1 and name.startswith(PREFIX):
            meta[name[len(PREFIX) :]] = json.loads(note)
        elif matrix in (0, 2):
            values = matrices["data_2"][abs(row) - 1].astype(float)
            columns[name] = values if row > 0 else -values  # a negated alias, as Dymola writes them
    return columns, meta


def layout(path: Path) -> Layout:
    """The columns, for reading in parts: the data matrix is mapped into memory, and unmapped after each part."""
    import numpy as np

    from mbdsl.results.stored import Layout

    matrices, places = {}, {}
    for name, values, place in _matrices(np.memmap(path, dtype="u1", mode="r")):
        matrices[name], places[name] = values, place
    data, offset = matrices.pop("data_2"), places["data_2"]
    long = _long(matrices)
    normal = _normal(matrices["Aclass"])
    turned = {key: np.array(value.T if normal else value) for key, value in matrices.items()}
    names, notes, info = _lines(turned["name"]), _lines(turned["description"]), turned["dataInfo"].T.tolist()
    rows_of, units, meta = {}, {}, {"complete": True, **long}
    for name, note, (matrix, row, *_) in zip(names, notes, info, strict=True):
        if matrix in (0, 2) and row:
            rows_of[name] = row
            units[name] = note[note.rfind("[") + 1 : -1].partition("|")[0] if note.endswith("]") else ""
        elif matrix == 1 and name.startswith(PREFIX):
            meta[name[len(PREFIX) :]] = json.loads(note)
    shape, kind = data.shape, data.dtype
    del matrices, data, values

    def chunks(asked: Sequence[str], rows: int) -> Iterator:
        count = shape[0] if normal else shape[1]
        for k in range(0, count, rows):
            mapped = np.memmap(path, kind, "r", offset, shape, order="F")
            part = mapped[k : k + rows].T if normal else mapped[:, k : k + rows]
            values = [np.array(part[abs(rows_of[name]) - 1], dtype=float) for name in asked]
            yield [x if rows_of[name] > 0 else -x for x, name in zip(values, asked, strict=True)]

    return Layout(list(rows_of), units, chunks, meta)


def _long(matrices: Mapping[str, np.ndarray]) -> dict[str, str]:
    """The long texts among the data about the run."""
    found = {key: bytes(x.astype("u1")) for key, x in matrices.items() if key.startswith(LONG_PREFIX)}
    return {key.removeprefix(LONG_PREFIX): json.loads(text) for key, text in found.items()}


def _normal(form: np.ndarray) -> bool:
    """Whether the matrices are not transposed, by the matrix Aclass.

    Raises
    ------
    ValueError
        If the file is not a trajectory.
    """
    kind = _lines(form.T)
    if kind[:2] != ["Atrajectory", "1.1"] or kind[3] not in ("binTrans", "binNormal"):
        raise ValueError(f"it is {', '.join(kind)}, not a binary trajectory of version 1.1")
    return kind[3] == "binNormal"


def _text(lines: list[str]) -> np.ndarray:
    """One line a column, padded with blanks."""
    import numpy as np

    raw = [line.encode() for line in lines]
    width = max(1, *map(len, raw))
    return np.frombuffer(b"".join(line.ljust(width) for line in raw), dtype="u1").reshape(len(raw), width).T


def _lines(matrix: np.ndarray) -> list[str]:
    return [bytes(column).decode(errors="replace").rstrip(" \0") for column in matrix.astype("u1").T]


def _head(stream: BinaryIO, name: str, shape: tuple[int, ...], code: int) -> None:
    stream.write(struct.pack("<5i", code, *shape, 0, len(name) + 1) + name.encode() + b"\0")


def _matrix(stream: BinaryIO, name: str, values: np.ndarray, code: int) -> None:
    _head(stream, name, values.shape, code)
    stream.write(values.astype(_TYPES[code], copy=False).tobytes(order="F"))


def _matrices(data: Any) -> Iterator[tuple[str, np.ndarray, int]]:
    """(Name, values, place of the values in the file) of each matrix in the bytes of a file."""
    import numpy as np

    at = 0
    while at < len(data):
        if len(data) - at < 20:
            raise ValueError("the file ends within a header")
        code, rows, columns, imaginary, length = struct.unpack_from("<5i", data, at)
        if code not in _TYPES or imaginary or rows < 0 or columns < 0 or not 0 < length < 64:
            raise ValueError("the file has no matrices of MATLAB 4, or of a kind not used in trajectories")
        name = bytes(data[at + 20 : at + 20 + length]).rstrip(b"\0").decode()
        values = np.frombuffer(data, _TYPES[code], rows * columns, at + 20 + length)
        yield name, values.reshape((rows, columns), order="F"), at + 20 + length
        at += 20 + length + values.nbytes
