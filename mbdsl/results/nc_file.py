"""NetCDF 3 (64-bit offsets), which xarray, MATLAB, ncdump and others read: one variable a signal, over ``time``."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, BinaryIO

if TYPE_CHECKING:
    from mbdsl.results.stored import Layout

SUFFIX = ".nc"
PREFIX = "mbdsl_"  #: prefix of the global attributes of ``meta``


def write(stream: BinaryIO, columns: Mapping, units: Mapping, meta: Mapping) -> None:
    import numpy as np
    from scipy.io import netcdf_file

    time = next(iter(columns))
    rows = len(columns[time])
    with netcdf_file(stream, "w", version=2) as file:
        file.createDimension(time, rows or None)  # the format has no empty dimension, only an unlimited one
        for name, values in columns.items():
            variable = file.createVariable(name, np.dtype(">f8"), (time,))
            variable[:] = np.asarray(values, dtype=float)
            if units.get(name):
                variable.units = units[name].encode()
        for key, value in meta.items():
            setattr(file, PREFIX + key, value.encode() if isinstance(value, str) else _number(value))


def read(path: Path) -> tuple[dict, dict]:
    import numpy as np
    from scipy.io import netcdf_file

    with netcdf_file(path, "r", mmap=False) as file:
        columns = {name: np.array(v[:], dtype=float) for name, v in file.variables.items()}
        found = {k.removeprefix(PREFIX): v for k, v in file._attributes.items() if k.startswith(PREFIX)}
    return columns, {"complete": True, **{key: _value(value) for key, value in found.items()}}


def layout(path: Path) -> Layout:
    """The columns, for reading in parts: the variables are mapped into memory, anew for each part."""
    import numpy as np
    from scipy.io import netcdf_file

    from mbdsl.results.stored import Layout

    with netcdf_file(path, "r", mmap=True) as file:
        time = next((v.shape for name, v in file.variables.items() if name.lower() == "time"), None)
        fits = [name for name, v in file.variables.items() if v.shape == time and len(v.shape) == 1]
        units = {name: _value(getattr(file.variables[name], "units", b"")) for name in fits}
        found = {k.removeprefix(PREFIX): v for k, v in file._attributes.items() if k.startswith(PREFIX)}
        meta = {"complete": True, **{key: _value(value) for key, value in found.items()}}

    def chunks(asked: Sequence[str], rows: int) -> Iterator:
        for k in range(0, time[0] if time else 0, rows):
            with netcdf_file(path, "r", mmap=True) as file:
                part = [np.array(file.variables[name].data[k : k + rows], dtype=float) for name in asked]
            yield part

    return Layout(fits, {name: str(unit) for name, unit in units.items() if unit}, chunks, meta)


def _number(value: float | bool):
    """A boolean as a byte, which is read as a boolean; a number as a double."""
    import numpy as np

    return np.int8(value) if isinstance(value, bool) else np.float64(value)


def _value(stored) -> str | float | bool:
    if isinstance(stored, bytes):
        return stored.decode(errors="replace")
    return bool(stored) if getattr(stored, "dtype", None) == "int8" else float(stored)
