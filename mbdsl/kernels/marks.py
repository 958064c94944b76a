"""Marks for kernels: functions of numbers and arrays, which :mod:`mbdsl.compilation.code_cache` compiles on demand.

Files with kernels are also imported by commands that must not load numerics. Therefore a mark only sets an attribute.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import TypeVar

Function = TypeVar("Function", bound=Callable)
TEXT = "__mbdsl_text__"  #: attribute of emitted modules: their source


def kernel(function: Function) -> Function:
    """Mark ``function`` for compilation. A kernel that takes kernels as arguments is compiled once for each of them."""
    vars(function)["__mbdsl_kernel__"] = True
    return function


def rare(function: Function) -> Function:
    """Mark a kernel that is not inlined, because it is long or seldom called."""
    vars(function)["__mbdsl_rare__"] = True
    return kernel(function)


def square(numbers, at, size):
    """The square matrix in ``numbers`` that begins at index ``at``: a view."""
    return numbers[at : at + size * size].reshape((size, size))
