"""Values that a program gives: numbers in SI units, or texts with units, which are read as on the command line."""

from __future__ import annotations

import numbers
from typing import overload

from mbdsl.errors import UsageError
from mbdsl.lang import units


@overload
def value(given: str | float, unit: str, what: str) -> float: ...
@overload
def value(given: str | float | None, unit: str, what: str) -> float | None: ...
def value(given: str | float | None, unit: str, what: str) -> float | None:
    """A number in ``unit``, from a number or from a text such as "10 ms"; None remains None.

    Raises
    ------
    UsageError
        If it is neither, or its unit has another dimension; the message calls it ``what``.
    """
    if given is None:
        return None
    if isinstance(given, str):
        try:
            return units.measure(given, unit)
        except ValueError as problem:
            raise UsageError(f"{what}: {problem}") from None
    if isinstance(given, numbers.Real) and not isinstance(given, bool) and not type(given).__name__.startswith("bool"):
        return float(given)
    expected = "a number" if unit == "1" else f'a number in {unit}, or a text such as "10 m{unit}"'
    raise UsageError(f"{what}: found {given!r}, expected {expected}")


@overload
def seconds(given: str | float, what: str) -> float: ...
@overload
def seconds(given: str | float | None, what: str) -> float | None: ...
def seconds(given: str | float | None, what: str) -> float | None:
    """A time [s]; see :func:`value`."""
    return value(given, "s", what)
