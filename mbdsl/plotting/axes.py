"""Axes: their range, the place of a number on them, and their ticks."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass

LARGEST = 1e300  #: larger numbers are infinite on a linear axis, because differences would be
SUPERSCRIPTS = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")
NAN = float("nan")


@dataclass(frozen=True)
class Axis:
    """Range from ``low`` to ``high``, of the numbers or (``log``) of their decimal logarithms.

    ``ticks`` are (place, label) and ``minor`` places, both from 0 at the low end to 1 at the high end. ``scale`` is a
    text with the factor and the offset of the labels, "" if there is none.
    """

    low: float
    high: float
    log: bool
    ticks: tuple[tuple[float, str], ...] = ()
    minor: tuple[float, ...] = ()
    scale: str = ""

    def titled(self, label: str) -> str:
        """The axis' label, with the factor and the offset of its ticks."""
        return f"{label} (ticks {self.scale})" if self.scale else label

    def place(self, value: float) -> float:
        """Place of a number: 0 at the low end, 1 at the high end; nan if it has none."""
        return (coordinate(value, self.log) - self.low) / (self.high - self.low)


def coordinate(value: float, log: bool) -> float:
    """The number or its decimal logarithm; nan if it has none or is not finite."""
    value = float(value)
    if not abs(value) < LARGEST or (log and value <= 0.0):
        return NAN
    return math.log10(value) if log else value


def limits(values: Iterable[float], log: bool, pad: float = 0.04) -> tuple[float, float]:
    """The range of the coordinates of ``values``, extended by ``pad`` of it on both sides; never empty."""
    found = [c for c in (coordinate(v, log) for v in values) if not math.isnan(c)]
    if not found:
        return (-1.0, 0.0) if log else (0.0, 1.0)
    low, high = min(found), max(found)
    size = max(abs(low), abs(high))
    least = 1e-9 if log else 1e-12 * size  # smaller differences are rounding
    if high - low <= least:
        half = 0.5 if log else max(0.1 * size, 1e-300) if size else 1.0
        return low - half, high + half
    return low - pad * (high - low), high + pad * (high - low)


def axis(low: float, high: float, log: bool, wanted: int = 7) -> Axis:
    """The axis from ``low`` to ``high`` (coordinates) with about ``wanted`` labels."""
    bare = Axis(low, high, log)
    if not log:
        return _linear(bare, wanted)
    first, last = math.ceil(low - 1e-9), math.floor(high + 1e-9)
    if last - first < 1:
        return _within_a_decade(bare, wanted)
    step = -(-(last - first + 1) // max(wanted, 2))
    places = {e: (e - low) / (high - low) for e in range(first, last + 1)}
    ticks = tuple((p, power(e)) for e, p in places.items() if e % step == 0)
    if step == 1:
        between = (e + math.log10(m) for e in range(first - 1, last + 1) for m in range(2, 10))
        minor = tuple((c - low) / (high - low) for c in between if low <= c <= high)
    else:
        minor = tuple(p for e, p in places.items() if e % step)
    return Axis(low, high, log, ticks, minor)


def _within_a_decade(bare: Axis, wanted: int) -> Axis:
    """Labels at 1, 2 and 5 if at least two of them are in the range, otherwise as on a linear axis."""
    low, high = bare.low, bare.high
    places = {
        (e, m): (e + math.log10(m) - low) / (high - low)
        for e in range(math.floor(low), math.ceil(high) + 1)
        for m in range(1, 10)
    }
    places = {k: p for k, p in places.items() if -1e-9 <= p <= 1.0 + 1e-9}
    ticks = tuple((p, number(float(f"{m}e{e}"), 6)) for (e, m), p in places.items() if m in (1, 2, 5))
    if len(ticks) >= 2:
        return Axis(low, high, True, ticks, tuple(p for (_, m), p in places.items() if m not in (1, 2, 5)))
    values = 10.0 ** max(low, -307.0), 10.0 ** min(high, 307.0)
    linear = _linear(Axis(*values, False), wanted)
    back = [(bare.place(values[0] + p * (values[1] - values[0])), label) for p, label in linear.ticks]
    return Axis(low, high, True, tuple(t for t in back if not math.isnan(t[0])), (), linear.scale)


def _linear(bare: Axis, wanted: int) -> Axis:
    low, high = bare.low, bare.high
    span = high - low
    step = _round_step(span / max(wanted, 2))
    counts = range(math.ceil(low / step - 1e-9), math.floor(high / step + 1e-9) + 1)
    values = [k * step for k in counts]
    labels, scale = _labels(values, step)
    return Axis(low, high, False, tuple(zip(((v - low) / span for v in values), labels, strict=True)), (), scale)


def _round_step(rough: float) -> float:
    """The least 1, 2 or 5 times a power of ten that is not below ``rough``."""
    e = math.floor(math.log10(rough))
    m = rough / 10.0**e
    return next(k for k in (1, 2, 5, 10) if m <= k * (1.0 + 1e-9)) * 10.0**e


def _labels(values: list[float], step: float) -> tuple[list[str], str]:
    """Short labels of ``values``, with the power of ten and the offset that they omit."""
    largest = max((abs(v) for v in values), default=0.0)
    offset = 0.0
    if largest / step > 1e5:  # labels would differ only after the fifth digit
        offset = values[0]
        largest = max(abs(v - offset) for v in values)
    e = math.floor(math.log10(largest) + 1e-9) if largest else 0
    e = e if not -4 < e < 5 else 0
    decimals = max(0, e - math.floor(math.log10(step) + 1e-9))
    scale = f"× {power(e)}" if e else ""
    if offset:
        scale += f" {'+' if offset > 0 else '−'} {number(abs(offset), 15)}"
    return [_minus(f"{(v - offset) / 10.0**e:.{decimals}f}") for v in values], scale.strip()


def _minus(text: str) -> str:
    return text[1:] if text.startswith("-") and not text.strip("-0.") else text.replace("-", "−")


def power(exponent: int) -> str:
    """10⁻³ and the like."""
    return "10" + str(exponent).translate(SUPERSCRIPTS)


def number(value: float, digits: int = 5) -> str:
    """A number as text: 0.0125, 1.25·10⁻⁷."""
    mantissa, _, exponent = f"{value:.{digits}g}".partition("e")
    if not exponent:
        return mantissa.replace("-", "−")
    return power(int(exponent)) if mantissa == "1" else f"{mantissa.replace('-', '−')}·{power(int(exponent))}"
