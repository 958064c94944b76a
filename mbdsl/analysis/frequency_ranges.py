"""Ranges of frequencies as texts: ``0.1:100Hz``, ``1:600 rad/s``, ``60:6000 rpm``."""

from __future__ import annotations

import math
import re
from collections.abc import Sequence

from mbdsl.errors import UsageError
from mbdsl.lang import units

EXAMPLE = "write 0.1:100Hz, or 1:600 rad/s"
_END = re.compile(r"\s*([+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?)\s*(.*?)\s*")


def read(given: str | Sequence[str | float]) -> tuple[float, float]:
    """The ends [Hz] of a range: a text, or two numbers [Hz] or texts.

    Raises
    ------
    UsageError
        If it is neither, has no unit or a wrong one, or does not ascend from above zero.
    """
    parts = given.split(":") if isinstance(given, str) else list(given) if isinstance(given, Sequence) else []
    if len(parts) != 2:
        raise UsageError(f"range: found `{given}`, expected two frequencies", hint=EXAMPLE)
    unit = _unit(parts[1]) if isinstance(parts[1], str) else ""
    low, high = (_hertz(part, unit, given) for part in parts)
    if not 0.0 < low < math.inf or not high < math.inf:
        raise UsageError(f"range: `{given}` does not begin above zero, or does not end", hint=EXAMPLE)
    if low == high:
        raise UsageError(f"the range is empty: both ends are {high:g} Hz", hint=EXAMPLE)
    if not low < high:
        raise UsageError(f"the range ends at {high:g} Hz, and begins at {low:g} Hz", hint="give the lower one first")
    return low, high


def _unit(text: str) -> str:
    match = _END.fullmatch(text)
    return match[2] if match else ""


def _hertz(part: str | float, unit: str, given: object) -> float:
    """One end; ``unit`` is that of the other one."""
    if isinstance(part, (int, float)) and not isinstance(part, bool):
        return float(part)
    match = _END.fullmatch(part) if isinstance(part, str) else None
    if match is None:
        raise UsageError(f"range: `{part}` is not a frequency", hint=EXAMPLE)
    written = match[2] or unit
    if not written:
        raise UsageError(f"range: `{given}` has no unit", hint=EXAMPLE)
    found = units.parse(written)
    cycles = "Hz" in written
    turns = re.search(r"\b(rad|deg|rev|rpm)\b", written)
    if found is None or found.dimension != units.dimension("Hz") or not (cycles or turns):
        raise UsageError(f"range: `{written}` is not a unit of a frequency", hint=f"{EXAMPLE} or 60:6000 rpm")
    return float(match[1]) * found.factor / (1.0 if cycles else 2.0 * math.pi)
