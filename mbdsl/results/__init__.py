"""Result files: ``columns, meta = mbdsl.results.read("run.csv")`` reads the signals as arrays, ``write`` writes them.

The suffix of a file's name selects the format; each format is a module of this package.

A format has ``SUFFIX``, ``write(stream, columns, units, meta)`` and ``read(path)``. It may have ``layout(path)`` for
reading in parts (``mbdsl.results.stored``), ``mark(path, meta)``, called before the file gets its name, and
``settle(path, meta)``, called afterwards, and ``write_with_units`` if ``write`` leaves out the units.
``columns`` maps signal names to arrays of one length, ``time`` first, or to objects whose slices are arrays, so that
results of any length are written part by part (``mbdsl.results.rows_file``); ``units`` maps them to unit texts;
``meta`` are plain values (``complete``, ``model``, ``method``, ``step``, ``version``, ...).
"""

from __future__ import annotations

import importlib
import os
import pkgutil
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from functools import cache
from pathlib import Path
from types import ModuleType
from typing import TYPE_CHECKING

from mbdsl.errors import UsageError
from mbdsl.storage.output_files import writing

if TYPE_CHECKING:
    import numpy as np

    from mbdsl.results.rows_file import StoredColumn

    Columns = Mapping[str, np.ndarray] | Mapping[str, StoredColumn]
    Meta = Mapping[str, str | float | bool]

__all__ = ["read", "write"]


def __dir__() -> list[str]:
    return [*__all__]


@cache
def formats() -> dict[str, ModuleType]:
    """List the formats of result files.

    Returns
    -------
    dict
        Suffix -> the module that reads and writes it.
    """
    found = {}
    for info in pkgutil.iter_modules(__path__):
        module = importlib.import_module(f"{__name__}.{info.name}")
        if hasattr(module, "SUFFIX"):
            found[module.SUFFIX] = module
    return dict(sorted(found.items()))


def format_of(path: str | os.PathLike) -> ModuleType:
    """Return the module of a format.

    Parameters
    ----------
    path : path
        A file; its suffix selects the format.

    Returns
    -------
    module

    Raises
    ------
    UsageError
        If the suffix is unknown.
    """
    suffix = Path(path).suffix.lower()
    if suffix not in formats():
        known = ", ".join(formats())
        problem = f"unknown suffix `{suffix}` of" if suffix else "no suffix on"
        raise UsageError(f"{problem} result file `{path!s}`", hint=f"known suffixes are {known}")
    return formats()[suffix]


def write(
    path: str | os.PathLike,
    columns: Columns,
    units: Mapping[str, str] | None = None,
    meta: Meta | None = None,
    row_of_units: bool = False,
) -> None:
    """Write a result file atomically: the file gets its name when it is complete.

    Parameters
    ----------
    path : path
        The file; its suffix (.csv, .npz, .mat, .nc) selects the format.
    columns : dict of (N,)
        Signal name -> values, "time" first; arrays, or objects whose slices are arrays.
    units : mapping, optional
        Signal name -> unit.
    meta : mapping, optional
        Texts and numbers that describe the run ("complete", "model", "method", ...).
    row_of_units : bool, optional
        Write a second row with the units, in a format that contains none otherwise (.csv).

    Raises
    ------
    UsageError
        If the suffix is unknown or the file cannot be written.
    """
    module = format_of(path)
    target = Path(os.path.realpath(path))
    ordinary = target.is_file() or not target.exists()
    put = getattr(module, "write_with_units", module.write) if row_of_units else module.write
    with writing(path) as stream:
        put(stream, columns, units or {}, meta or {})
        if ordinary and hasattr(module, "mark"):
            module.mark(target, meta or {})  # before the file gets its name: never incomplete and unmarked
    if ordinary and hasattr(module, "settle"):
        module.settle(target, meta or {})


def read(path: str | os.PathLike) -> tuple[dict[str, np.ndarray], dict[str, str | float | bool]]:
    """Read a result file.

    Parameters
    ----------
    path : path
        The file; its suffix selects the format.

    Returns
    -------
    columns : dict of (N,)
        Signal name -> values.
    meta : dict
        Texts and numbers that describe the run.

    Raises
    ------
    UsageError
        If the suffix is unknown, or the file cannot be read or has another format.
    """
    module = format_of(path)
    with readable(str(path)):
        columns, meta = module.read(Path(path))
        check_about(meta)
        return columns, meta


@contextmanager
def readable(name: str) -> Iterator[None]:
    """Errors of reading a file as errors of the user.

    Parameters
    ----------
    name : str
        The file.

    Returns
    -------
    context manager

    Raises
    ------
    UsageError
        If the file cannot be read, has another format, or is damaged.
    """
    try:
        yield
    except (UsageError, GeneratorExit):
        raise
    except OSError as problem:
        raise UsageError(f"cannot read `{name}`: {problem.strerror or problem}") from problem
    except Exception as problem:  # zipfile, zlib, json, numpy and scipy each raise their own errors at damaged bytes
        why = " ".join(str(problem).split())[:200] or type(problem).__name__
        suffix = Path(name).suffix.lower()
        raise UsageError(f"`{name}` is not a {suffix} result file, or is damaged: {why}") from problem


def check_about(meta: object, units: object = {}) -> None:
    """Check what a file, perhaps of another author, says about its columns: texts and numbers by names.

    Parameters
    ----------
    meta, units : object
        As read, before they are used as mappings.

    Raises
    ------
    ValueError
        If they are something else. The text of a message is that of a damaged file.
    """
    for what, found, kinds in (("metadata", meta, (str, float, int)), ("units", units, (str,))):
        if not isinstance(found, dict):
            raise ValueError(f"its {what} are of the type {type(found).__name__}, expected names and values")
        for name, value in found.items():
            if not isinstance(value, kinds):
                raise ValueError(f"`{name!s:.40}` in its {what} is of the type {type(value).__name__}")
            for text in (name, value):
                text.encode() if isinstance(text, str) else float(text)  # lone surrogates, numbers of 400 digits
