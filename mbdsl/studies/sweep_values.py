"""The values that a sweep gives to a parameter: ranges and lists, as numbers with units or as other values."""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from fractions import Fraction

from mbdsl.errors import UsageError
from mbdsl.lang import units
from mbdsl.messages import UnitsOfSignals

MOST = 100_000  #: largest number of runs of a sweep
DIGITS = 12  #: significant digits of the values of a range, so that the third of 1:2:11 is 1.2
FORMS = "L=1:2:11 (start:stop:count), L=1:1000:4:log, L=0.5,1,2, each with a unit after it: k=1:10:5 N/mm"
RANGES = "m=100:1000 kg (start:stop), or m=1:1000:log kg for a range of several powers of ten"
_NUMBER = re.compile(r"\s*([+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?)\s*(.*?)\s*")
_SPACING = re.compile(r"\s*(log|lin)\b\s*(.*?)\s*")


@dataclass(frozen=True)
class Varied:
    """A parameter and its values.

    Attributes
    ----------
    name : str
        Name of the parameter, as for ``--set``.
    texts : tuple of str
        The values as the language reads them: "2.5 N/mm".
    numbers : tuple of float or None
        The values in ``unit``; None if one of them is not a number.
    unit : str
        The unit of the numbers; "" if none was given, or there is none.
    log : bool
        Whether they are evenly spaced by their logarithms.
    """

    name: str
    texts: tuple[str, ...]
    numbers: tuple[float, ...] | None = None
    unit: str = ""
    log: bool = False

    def __len__(self) -> int:
        return len(self.texts)

    def displayed(self, display: UnitsOfSignals) -> Varied:
        """The parameter with its numbers in the unit in which it is displayed, for tables and pictures.

        Parameters
        ----------
        display : UnitsOfSignals

        Returns
        -------
        Varied
        """
        unit = display.of(self.unit, self.name)
        if self.numbers is None or unit.factor == 1.0:
            return self
        return replace(self, numbers=tuple(x / unit.factor for x in self.numbers), unit=unit.symbol)

    def shown(self, k: int, digits: int = 6) -> str:
        """Return a value as text, without its unit.

        Parameters
        ----------
        k : int
            Number of the value, from 0.
        digits : int, optional
            Significant digits of a number.

        Returns
        -------
        str
        """
        return self.texts[k] if self.numbers is None else f"{self.numbers[k]:.{digits}g}"

    @property
    def head(self) -> str:
        """The name with the unit in brackets, for a table or an axis."""
        return f"{self.name} [{self.unit}]" if self.unit and self.numbers is not None else self.name

    def said(self, k: int) -> str:
        """Return a value with the name and the unit: ``k = 2.5 N/mm``.

        Parameters
        ----------
        k : int
            Number of the value, from 0.

        Returns
        -------
        str
        """
        unit = f" {self.unit}" if self.unit and self.numbers is not None else ""
        return f"{self.name} = {self.shown(k)}{unit}"


def number_text(x: float) -> str:
    """A number of a range as text that the language reads."""
    return f"{x:.{DIGITS}g}"


def half(p: Varied, x: float | str, y: float | str) -> float | str | None:
    """The value of a parameter between two others; None if there is none."""
    if x == y:
        return x
    if isinstance(x, str) or isinstance(y, str):
        return None
    middle = math.sqrt(x * y) if p.log and x > 0.0 < y else 0.5 * (x + y)
    found = float(number_text(middle))
    return None if found in (x, y) else found


def varied(name: str, given: str | Iterable) -> Varied:
    """The values of a parameter.

    Parameters
    ----------
    name : str
        The parameter.
    given : str or iterable
        A text as on the command line ("1:2:11", "1:1000:4:log N/m", "1, 2, 5 mm"), or the values: numbers in SI units,
        Booleans, or texts with units.

    Raises
    ------
    UsageError
        If the text is neither a range nor a list, or a value is given twice.
    """
    try:
        if isinstance(given, str):
            found = _range(name, given) if len(_parts(given, ":")) > 1 else _list(name, _parts(given, ","))
        else:
            if isinstance(given, Mapping) or not isinstance(given, Iterable):
                raise ValueError(f"found {given!r}, expected values, such as [1, 2]")
            texts = [_text(x) for x in given]
            found = _list(name, texts)
            if found.unit and any(_number(text)[1] == "" for text in texts):
                raise ValueError("some values have a unit and some have none: give it to all, or to none (SI)")
    except ValueError as problem:
        raise UsageError(f"--vary {name}: {problem}", hint=FORMS) from None
    twice = next((text for k, text in enumerate(found.texts) if text in found.texts[:k]), None)
    if twice is not None and len(found) <= 1000:
        raise UsageError(f"--vary {name}: the value {twice} is given twice", hint="give each value once")
    return found


def _text(x: object) -> str:
    if isinstance(x, str):
        return x
    if isinstance(x, bool) or type(x).__name__ in ("bool_", "bool"):  # of Python and of numpy
        return "true" if x else "false"
    try:
        value = float(x)  # type: ignore[arg-type]
    except (TypeError, ValueError):
        raise ValueError(f"{x!r} is not a value of a parameter") from None
    if not math.isfinite(value):
        raise ValueError(f"{value} is not a value of a parameter")
    return repr(int(value)) if value == int(value) and abs(value) < 1e15 else repr(value)


def _parts(text: str, sign: str) -> list[str]:
    """The parts of a text between signs outside of brackets."""
    found, depth = [""], 0
    for c in text:
        depth += (c in "([{") - (c in ")]}")
        if c == sign and depth == 0:
            found.append("")
        else:
            found[-1] += c
    return [part.strip() for part in found]


def _number(text: str) -> tuple[float, str]:
    """A number and the unit after it.

    Raises
    ------
    ValueError
    """
    match = _NUMBER.fullmatch(text)
    if match is None:
        raise ValueError(f"`{text}` is not a number")
    if match[2] and units.parse(match[2]) is None:
        meant = units.meant(match[2])
        raise ValueError(f"unknown unit `{match[2]}`{f'; did you mean {meant}?' if meant else ''}")
    return float(match[1]), match[2]


def _in(unit: str, number: float, own: str) -> float:
    return number if own in ("", unit) else units.measure(f"{number!r}{own}", unit)


def _range(name: str, text: str) -> Varied:
    parts = _parts(text, ":")
    if len(parts) not in (3, 4):
        raise ValueError(f"`{text}` is not a range: expected start:stop:count")
    spacing, unit = "lin", ""
    if len(parts) == 4:
        match = _SPACING.fullmatch(parts[3])
        if match is None:
            raise ValueError(f"`{parts[3]}` is not a spacing: expected log or lin")
        spacing, unit = match[1], match[2]
    number, own = _number(parts[2])
    if number != int(number) or number < 1:
        raise ValueError(
            f"the count is {parts[2]}, expected a whole number: a range is start:stop:count, not start:step:stop"
        )
    count = int(number)
    if own and unit:
        raise ValueError(f"`{text}` has two units at its end")
    if count > MOST:
        raise ValueError(f"{count} values are too many: a sweep has at most {MOST} runs")
    ends = [_number(part) for part in parts[:2]]
    unit = unit or own or ends[1][1] or ends[0][1]
    if units.parse(unit) is None:
        raise ValueError(f"unknown unit `{unit}`")
    start, stop = (_in(unit, x, of) for x, of in ends)
    if count == 1 and start != stop:
        raise ValueError(f"a range from {parts[0]} to {parts[1]} has at least two values")
    if spacing == "log" and not start * stop > 0.0:
        raise ValueError("the ends of a logarithmic range are both above zero, or both below")
    values = [_between(start, stop, k, count, spacing == "log") for k in range(count)]
    texts = tuple(f"{number_text(x)} {unit}".strip() for x in values)
    return Varied(name, texts, tuple(float(number_text(x)) for x in values), unit, spacing == "log")


def interval(name: str, given: str | Iterable) -> Varied:
    """The two ends of a range in which a value is sought.

    Parameters
    ----------
    name : str
        The parameter.
    given : str or iterable
        A text as on the command line ("100:1000 kg", "1:1000:log N/mm"), or the two ends: numbers in SI units, or texts
        with units.

    Returns
    -------
    Varied
        With two values.

    Raises
    ------
    UsageError
        If it is not a range of two different numbers.
    """
    try:
        if not isinstance(given, str):
            ends = [] if isinstance(given, Mapping) or not isinstance(given, Iterable) else [_text(x) for x in given]
            if len(ends) != 2:
                raise ValueError(f"found {given!r}, expected the two ends of a range, such as (100, 1000)")
            given = ":".join(ends)
        first, *rest = _parts(given, ":")
        spacing = _SPACING.fullmatch(rest[-1]) if len(rest) == 2 else None
        if not first or not (len(rest) == 1 or spacing):
            raise ValueError(f"`{given}` is not a range: expected start:stop")
        text = f"{first}:{rest[0]}:2" + (f":{spacing[1]} {spacing[2]}" if spacing else "")
        found = _range(name, text)
    except ValueError as problem:
        raise UsageError(f"--vary {name}: {problem}", hint=f"write {RANGES}") from None
    if found.texts[0] == found.texts[1]:
        raise UsageError(f"--vary {name}: both ends of the range are {found.texts[0]}", hint=f"write {RANGES}")
    return found


def _between(start: float, stop: float, k: int, count: int, log: bool) -> float:
    """Value ``k`` of ``count``; the ends exactly."""
    if k in (0, count - 1):
        return stop if k else start
    if log:
        return math.copysign(abs(start) * (stop / start) ** (k / (count - 1)), start)
    a, b = Fraction(start), Fraction(stop)  # rounded once
    return float(a + (b - a) * k / (count - 1))


def _list(name: str, parts: list[str]) -> Varied:
    if not any(parts):
        raise ValueError("there is no value")
    if not all(parts):
        raise ValueError(f"a value is missing in `{','.join(parts)}`")
    try:
        found = [_number(part) for part in parts]
    except ValueError:
        if all(_NUMBER.fullmatch(part) for part in parts):
            raise
        return Varied(name, tuple(parts))  # expressions, Booleans, vectors: the language reads them
    unit = found[-1][1] or next((own for _, own in found if own), "")
    values = tuple(_in(unit, x, own) for x, own in found)
    texts = (part if own or not unit else f"{part} {unit}" for part, (_, own) in zip(parts, found, strict=True))
    return Varied(name, tuple(texts), values, unit)
