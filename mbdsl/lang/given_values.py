"""Values that a program gives: numbers in SI units, or texts with units, which are read as on the command line."""

from __future__ import annotations

import numbers
from collections.abc import Mapping, Sequence
from typing import overload

from mbdsl.errors import UsageError
from mbdsl.lang import units


def value(given: str | float, unit: str, what: str) -> float:
    """A number in ``unit``, from a number or from a text such as "10 ms".

    Raises
    ------
    UsageError
        If it is neither, or its unit has another dimension; the message calls it ``what``.
    """
    if isinstance(given, str):
        try:
            return units.measure(given, unit)
        except ValueError as problem:
            raise UsageError(f"{what}: {problem}") from None
    example = "ms" if unit == "s" else unit
    if isinstance(given, numbers.Real) and not isinstance(given, bool):
        return float(given)
    expected = "a number" if unit == "1" else f'a number in {unit}, or a text such as "10 {example}"'
    raise UsageError(f"{what}: found {given!r}, expected {expected}")


def mapping(given: object, what: str, hint: str | None = None) -> Mapping:
    """An argument that has to be a mapping; None is an empty one.

    Raises
    ------
    UsageError
        If it is not.
    """
    if given is None:
        return {}
    if not isinstance(given, Mapping):
        raise UsageError(f"{what}: found {given!r}, expected a mapping", hint=hint)
    return given


@overload
def optional(given: str | float, unit: str, what: str) -> float: ...
@overload
def optional(given: str | float | None, unit: str, what: str) -> float | None: ...
def optional(given: str | float | None, unit: str, what: str) -> float | None:
    """As :func:`value`; None remains None."""
    return None if given is None else value(given, unit, what)


@overload
def seconds(given: str | float, what: str) -> float: ...
@overload
def seconds(given: str | float | None, what: str) -> float | None: ...
def seconds(given: str | float | None, what: str) -> float | None:
    """A time [s], as :func:`value`; None remains None."""
    return optional(given, "s", what)


def values(given: Sequence[str | float] | None, unit: str, what: str) -> list[float] | None:
    """Numbers in ``unit``; see :func:`value`. A single one has to be in a list.

    Raises
    ------
    UsageError
        If one is not a number with a unit of this dimension.
    """
    if given is None:
        return None
    if isinstance(given, (str, numbers.Real)):
        raise UsageError(f"{what}: found {given!r}, expected a list", hint=f"write {what}=[{given!r}]")
    return [value(x, unit, what) for x in given]
