"""NetCDF 3 (64-bit offsets), which xarray, MATLAB, ncdump and others read: one variable a signal, over ``time``."""

from __future__ import annotations

import struct
import unicodedata
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, BinaryIO

if TYPE_CHECKING:
    from mbdsl.results.stored import Layout

SUFFIX = ".nc"
PREFIX = "mbdsl_"  #: prefix of the global attributes of ``meta``
SLASH = "\u2215"  #: in names, which contain no "/" in this format
ROWS = 2**16  #: number of rows that are written at once
_BYTE, _CHAR, _DOUBLE, _DIMENSION, _VARIABLE, _ATTRIBUTE = 1, 2, 6, 10, 11, 12  #: tags of the format


def write(stream: BinaryIO, columns: Mapping, units: Mapping, meta: Mapping) -> None:
    import numpy as np

    time = next(iter(columns))
    rows, place = len(columns[time]), 0
    for _ in range(2):  # the size of the header does not depend on the places in it
        header = _header(time, rows, columns, units, meta, place)
        place = len(header)
    stream.write(header)
    for values in columns.values():
        for k in range(0, rows, ROWS):
            stream.write(np.asarray(values[k : k + ROWS], dtype=">f8").tobytes())


def _header(time: str, rows: int, columns: Mapping, units: Mapping, meta: Mapping, place: int) -> bytes:
    """The header of a file whose first variable begins at ``place``.

    scipy.io.netcdf_file holds all values in memory. Its grammar: Unidata, "NetCDF classic format specification", with
    offsets of 64 bits. The format has no empty dimension, only an unlimited one.
    """
    dimension = struct.pack(">2i", _DIMENSION, 1) + _text(time) + struct.pack(">i", rows)
    found = [_attribute(PREFIX + key, value) for key, value in meta.items()]
    parts = [b"CDF\x02" + struct.pack(">i", 0), dimension, _list(_ATTRIBUTE, found)]
    variables = []
    for k, name in enumerate(columns):
        own = [_attribute("units", units[name])] if units.get(name) else []
        size = min(8 * rows if rows else 8, 2**32 - 1)
        end = struct.pack(">iIq", _DOUBLE, size, place + 8 * rows * k)
        variables.append(_text(name) + struct.pack(">2i", 1, 0) + _list(_ATTRIBUTE, own) + end)
    return b"".join([*parts, _list(_VARIABLE, variables)])


def _list(tag: int, items: list[bytes]) -> bytes:
    return struct.pack(">2i", tag if items else 0, len(items)) + b"".join(items)


def _text(text: str) -> bytes:
    data = unicodedata.normalize("NFC", text).replace("/", SLASH).encode()  # as the format defines names
    return struct.pack(">i", len(data)) + _padded(data)


def _name(found: str) -> str:
    """A name as scipy.io.netcdf_file decodes it, from Latin-1 instead of UTF-8; some programs write Latin-1."""
    try:
        return found.encode("latin-1").decode().replace(SLASH, "/")
    except UnicodeError:
        return found


def _padded(data: bytes) -> bytes:
    return data + bytes(-len(data) % 4)


def _attribute(name: str, value: str | float | bool) -> bytes:
    """Text, a number as a double, or a boolean as a byte, which is read as a boolean."""
    if isinstance(value, str):
        data = value.encode()
        return _text(name) + struct.pack(">2i", _CHAR, len(data)) + _padded(data)
    if isinstance(value, bool):
        return _text(name) + struct.pack(">2ib3x", _BYTE, 1, value)
    return _text(name) + struct.pack(">2id", _DOUBLE, 1, value)


def read(path: Path) -> tuple[dict, dict]:
    import numpy as np
    from scipy.io import netcdf_file

    with netcdf_file(path, "r", mmap=False) as file:
        columns = {_name(name): np.array(v[:], dtype=float) for name, v in file.variables.items()}
        return columns, _meta(file._attributes)


def layout(path: Path) -> Layout:
    """The columns, for reading in parts: the variables are mapped into memory, anew for each part."""
    import numpy as np
    from scipy.io import netcdf_file

    from mbdsl.results.stored import Layout

    with netcdf_file(path, "r", mmap=True) as file:
        time = next((v.shape for name, v in file.variables.items() if name.lower() == "time"), None)
        fits = {_name(name): name for name, v in file.variables.items() if v.shape == time and len(v.shape) == 1}
        units = {name: _value(getattr(file.variables[own], "units", b"")) for name, own in fits.items()}
        meta = _meta(file._attributes)

    def chunks(asked: Sequence[str], rows: int) -> Iterator:
        for k in range(0, time[0] if time else 0, rows):
            with netcdf_file(path, "r", mmap=True) as file:
                part = [np.array(file.variables[fits[name]].data[k : k + rows], dtype=float) for name in asked]
            yield part

    return Layout(list(fits), {name: str(unit) for name, unit in units.items() if unit}, chunks, meta)


def _meta(attributes: Mapping) -> dict:
    found = {key.removeprefix(PREFIX): _value(value) for key, value in attributes.items() if key.startswith(PREFIX)}
    return {"complete": True, **{_name(key): value for key, value in found.items()}}


def _value(stored) -> str | float | bool:
    if isinstance(stored, bytes):
        return stored.decode(errors="replace")
    return bool(stored) if getattr(stored, "dtype", None) == "int8" else float(stored)
