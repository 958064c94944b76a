"""NumPy's archive: ``numpy.load("result.npz")["crank.phi"]``; units and meta as JSON text in ``_mbdsl``."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping, Sequence
from contextlib import ExitStack
from pathlib import Path
from typing import IO, TYPE_CHECKING, BinaryIO

if TYPE_CHECKING:
    import numpy as np

    from mbdsl.results.stored import Layout

SUFFIX = ".npz"
ABOUT = "_mbdsl"
ROWS = 2**16  #: number of rows that are written at once
KEEPS_MODEL = True  #: the meta data may contain the model's text


def write(stream: BinaryIO, columns: Mapping, units: Mapping, meta: Mapping) -> None:
    # numpy.savez takes the names as keyword arguments and has an argument "file" itself.
    import zipfile

    import numpy as np

    about = np.array(json.dumps({"names": list(columns), "units": dict(units), "meta": dict(meta)}))
    with zipfile.ZipFile(stream, "w", zipfile.ZIP_STORED, allowZip64=True) as archive:
        for name, values in columns.items():
            with archive.open(f"{name}.npy", "w", force_zip64=True) as member:
                head = {"descr": "<f8", "fortran_order": False, "shape": (len(values),)}
                np.lib.format.write_array_header_1_0(member, head)
                for k in range(0, len(values), ROWS):
                    member.write(np.asarray(values[k : k + ROWS], dtype="<f8").tobytes())
        with archive.open(f"{ABOUT}.npy", "w", force_zip64=True) as member:
            np.lib.format.write_array(member, about, allow_pickle=False)


def read(path: Path) -> tuple[dict, dict]:
    import zipfile

    import numpy as np

    try:
        if not zipfile.is_zipfile(path):  # NumPy would take it for an array of Python objects
            with open(path, "rb"):  # or it cannot be opened
                raise zipfile.BadZipFile("File is not a zip file")
        with open(path, "rb") as stream, np.load(stream, allow_pickle=False) as archive:
            about = json.loads(archive[ABOUT].item()) if ABOUT in archive.files else {}
            found = {name: archive[name] for name in about.get("names", archive.files)}
            # archives of other programs may contain texts and records
            kept = {name: x for name, x in found.items() if x.dtype.kind in "fiub"}
            return kept, about.get("meta", {"complete": True})
    except (zipfile.BadZipFile, EOFError) as problem:
        raise ValueError(str(problem)) from problem


def layout(path: Path) -> Layout:
    """The columns, for reading in parts: each member of the archive is a stream."""
    import zipfile

    import numpy as np

    from mbdsl.results.stored import Layout

    about: dict = {}
    with zipfile.ZipFile(path) as archive:
        if f"{ABOUT}.npy" in archive.namelist():
            with archive.open(f"{ABOUT}.npy") as member:
                about = json.loads(np.lib.format.read_array(member, allow_pickle=False).item())
        shapes = {}
        for file in archive.namelist():
            if file.endswith(".npy") and file != f"{ABOUT}.npy":
                with archive.open(file) as member:
                    shapes[file[:-4]] = _header(member)
    time = next((shape for name, (shape, _) in shapes.items() if name.lower() == "time"), None)
    fits = [name for name, (shape, kind) in shapes.items() if shape == time and len(shape) == 1 and kind.kind in "fiub"]
    names = [name for name in about.get("names", fits) if name in fits]

    def chunks(asked: Sequence[str], rows: int) -> Iterator:
        with zipfile.ZipFile(path) as archive, ExitStack() as stack:
            members = [stack.enter_context(archive.open(f"{name}.npy")) for name in asked]
            kinds = [_header(member)[1] for member in members]
            left = shapes[asked[0]][0][0]
            while left:
                count = min(left, rows)
                yield [_values(m, kind, count) for m, kind in zip(members, kinds, strict=True)]
                left -= count

    return Layout(names, about.get("units", {}), chunks, about.get("meta", {"complete": True}))


def _header(member: IO[bytes]) -> tuple[tuple[int, ...], np.dtype]:
    """Shape and type of the array in a member, which is then read up to its values."""
    import numpy as np

    version = np.lib.format.read_magic(member)
    read = np.lib.format.read_array_header_1_0 if version == (1, 0) else np.lib.format.read_array_header_2_0
    shape, _, kind = read(member)
    if kind.hasobject:
        raise ValueError("it has an array of objects")
    return shape, kind


def _values(member: IO[bytes], kind: np.dtype, count: int) -> np.ndarray:
    import numpy as np

    data = member.read(count * kind.itemsize)
    if len(data) < count * kind.itemsize:
        raise ValueError("an array is shorter than its header says")
    return np.frombuffer(data, kind).astype(float, copy=False)
