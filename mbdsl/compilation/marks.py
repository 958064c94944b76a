"""Marks for kernels: array-only functions that :mod:`mbdsl.compilation.code_cache` compiles when numerics start.

Files that hold kernels are also read where no numerics may be loaded; therefore they only mark them.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import TypeVar

Function = TypeVar("Function", bound=Callable)


def kernel(function: Function) -> Function:
    """Mark ``function`` for compilation. What takes other kernels as arguments is compiled once for each of them."""
    function.__mbdsl_kernel__ = True  # type: ignore[attr-defined]
    return function


def rare(function: Function) -> Function:
    """Mark a kernel that is not worth inlining: seldom called, or long."""
    function.__mbdsl_rare__ = True  # type: ignore[attr-defined]
    return kernel(function)


def square(numbers, at):
    """The 6 x 6 matrix that stands in ``numbers`` from ``at`` on."""
    return numbers[at : at + 36].reshape((6, 6))
