"""One thread of BLAS while mbdsl computes.

The dense matrices of a mechanism are small: threads cost more than they save, two to a hundred times with many cores.
OpenBLAS, the BLAS in the wheels of NumPy and SciPy, has functions that set the number of its threads. Other BLAS
libraries are left as they are.
"""

from __future__ import annotations

import ctypes
import os
import sys
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import wraps
from pathlib import Path
from typing import ParamSpec, TypeVar

P = ParamSpec("P")
R = TypeVar("R")

VARIABLE = "OPENBLAS_NUM_THREADS"  #: OpenBLAS reads it when it is loaded
#: packages whose wheels contain OpenBLAS -> the module with which it is loaded
PACKAGES = {"numpy": "numpy", "scipy": "scipy.linalg"}


class _OpenBlas:
    """The functions of a loaded library that get and set its number of threads."""

    def __init__(self, library: ctypes.CDLL) -> None:
        for name in ("scipy_openblas_{}64_", "scipy_openblas_{}", "openblas_{}64_", "openblas_{}_64", "openblas_{}"):
            if hasattr(library, name.format("set_num_threads")):
                self.get, self.set, self.processors = (
                    getattr(library, name.format(what))
                    for what in ("get_num_threads", "set_num_threads", "get_num_procs")
                )
                return
        raise OSError("no OpenBLAS")


_libraries: dict[str, _OpenBlas | None] = {}  #: by package
_lock = threading.Lock()
_depth = 0
_saved: dict[str, int] = {}  #: numbers of threads before the outermost block
_own_variable = False  #: whether the block has set the variable


def _loaded() -> dict[str, _OpenBlas]:
    """The libraries that are loaded, by package."""
    for package, module in PACKAGES.items():
        if package in _libraries or module not in sys.modules:
            continue
        _libraries[package] = None
        root = Path(sys.modules[package].__file__ or "").parent
        for folder in (root.parent / f"{package}.libs", root / ".dylibs"):
            for path in folder.glob("*openblas*"):
                try:  # loaded already: this is the same library
                    _libraries[package] = _OpenBlas(ctypes.CDLL(str(path)))
                except OSError:
                    continue
    return {package: library for package, library in _libraries.items() if library is not None}


@contextmanager
def one_thread() -> Iterator[None]:
    """One thread inside the block; afterwards as many as before. Blocks may be nested, also in several threads."""
    global _depth, _own_variable
    with _lock:
        _depth += 1
        if _depth == 1:
            _saved.clear()
            _own_variable = VARIABLE not in os.environ
            if _own_variable:  # for a library that is loaded inside the block
                os.environ[VARIABLE] = "1"
        for package, library in _loaded().items():
            if package not in _saved:
                _saved[package] = library.get()
                library.set(1)
    try:
        yield
    finally:
        with _lock:
            _depth -= 1
            if _depth == 0:
                if _own_variable:
                    del os.environ[VARIABLE]
                for package, library in _loaded().items():
                    library.set(_saved.get(package) or library.processors())


def with_one_thread(function: Callable[P, R]) -> Callable[P, R]:
    """A decorator: one thread of BLAS during a call."""

    @wraps(function)
    def call(*args: P.args, **named: P.kwargs) -> R:
        with one_thread():
            return function(*args, **named)

    return call
