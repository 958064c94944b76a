"""Common phrases of messages, values with their units, and escaping of characters for terminals and pages.

A model may contain escape sequences that clear a screen or write to the clipboard, overrides of the writing direction,
which make a line read as another one, and characters without a width. ``visible`` replaces all of them by their
escapes, ``\\x1b`` or ``\\u202e``, and keeps all other characters.
"""

from __future__ import annotations

import unicodedata
from collections.abc import Callable, Iterable
from dataclasses import dataclass

FORMULA = tuple("=+-@＝＋－＠")  #: characters that begin a formula in a cell of a spreadsheet


def count(number: int, one: str, many: str = "") -> str:
    """``1 joint``, ``2 joints``."""
    return f"{number} {one if number == 1 else many or one + 's'}"


def few(names: Iterable[str], most: int = 6) -> str:
    """The first ``most`` names, and the number of all if there are more."""
    names = list(names)
    shown = ", ".join(names[:most])
    return shown if len(names) <= most else f"{shown}, ... ({len(names)} in all)"


def shortened(text: str, letters: int) -> str:
    """The beginning and the end of a text that is longer than so many letters."""
    if len(text) <= letters:
        return text
    half = (letters - 1) // 2
    return f"{text[: letters - 1 - half]}…{text[-half:]}"


def together(problems: Iterable[tuple[str, str]]) -> str:
    """Pairs (name, problem) as ``a, b: one problem; c: another``, each problem once."""
    whose: dict[str, dict[str, None]] = {}
    for name, problem in problems:
        whose.setdefault(problem, {})[name] = None
    return "; ".join(f"{', '.join(names)}: {problem}" for problem, names in whose.items())


def install(extra: str) -> str:
    """The remedy for a missing package: the command that installs the extra of mbdsl with it."""
    return f"in the folder of mbdsl: pip install '.[{extra}]'"


def duration(seconds: float) -> str:
    """A duration or a step with its unit: 1.5 ms."""
    for unit, size in (("s", 1.0), ("ms", 1e-3), ("us", 1e-6), ("ns", 1e-9)):
        if seconds >= size or unit == "ns":
            return f"{seconds / size:.3g} {unit}"
    raise AssertionError


def did_you_mean(name: str, known: Iterable[str], listed: str = "") -> str | None:
    """A hint with the names closest to ``name``; if none is close and there are few, all of them after ``listed``."""
    import difflib  # for errors only

    names = list(dict.fromkeys(known))[:5000]
    lower = {n.lower(): n for n in reversed(names)}
    close = [lower[c] for c in difflib.get_close_matches(name.lower(), lower, 3, 0.6)]
    if close:
        return f"did you mean {' or '.join(f'`{c}`' for c in close)}?"
    if listed and 0 < len(names) <= 25:
        return f"{listed}: {', '.join(names)}"
    return None


def once(announce: Callable[[str], None] | None, said: set[str]) -> Callable[[str], None] | None:
    """``announce`` for a command of several runs: it skips lines that are in ``said`` and adds new lines to it."""
    if announce is None:
        return None

    def new(line: str) -> None:
        if line not in said:
            said.add(line)
            announce(line)

    return new


def visible(text: str, line: bool = False) -> str:
    """``text`` with control and format characters escaped; line ends and tabs only if ``line`` is true."""
    if text.isprintable():
        return text
    kept = "" if line else "\n\t"
    return "".join(c if c.isprintable() or c in kept or _blank(c) else escape(c) for c in text)


def cell(text: str) -> str:
    """``text`` for a cell of a .csv file: spreadsheets calculate what begins with a sign of a formula, unless an
    apostrophe is in front of it. Files of other authors may have such names."""
    return f"'{text}" if text[:1] in ("\t", "\r", "\n") or text.lstrip()[:1] in FORMULA else text


def escape(c: str) -> str:
    """The escape of one character."""
    return c.encode("unicode_escape").decode()


def width(text: str) -> int:
    """Number of columns of a text on a terminal."""
    if text.isascii():
        return len(text)
    return sum(0 if unicodedata.combining(c) else 2 if unicodedata.east_asian_width(c) in "WF" else 1 for c in text)


def _blank(c: str) -> bool:
    """Whether ``c`` is a space of any width; str.isprintable() is false for most of them."""
    return unicodedata.category(c) == "Zs"


@dataclass(frozen=True)
class DisplayUnit:
    """A unit in which a value is displayed: its symbol, and its size in the unit of the value."""

    symbol: str = ""
    factor: float = 1.0

    def text(self, value: float, digits: int = 6) -> str:
        """A value in SI units with this unit: 30 deg."""
        return f"{value / self.factor:.{digits}g} {self.symbol}".rstrip()


class UnitsOfSignals:
    """The units in which signals are displayed: their own. ``mbdsl.lang.display_units`` has those that differ."""

    def of(self, unit: str, name: str = "") -> DisplayUnit:
        """The unit in which the signal ``name``, whose values are in ``unit``, is displayed."""
        return DisplayUnit(unit)


OWN = UnitsOfSignals()
