"""Units and dimensions: ``N.m/rad``, ``kg.m2``, ``m/s^2`` to a factor and exponents of the SI base units.

A unit is written as in Modelica: symbols joined by ``.`` and ``/`` without spaces, exponents after the symbol with
or without ``^``. The radian is dimensionless.
"""

from __future__ import annotations

import math
import re
from dataclasses import dataclass
from fractions import Fraction
from functools import cache

BASE = ("kg", "m", "s", "A", "K", "mol", "cd")

#: exponents of ``BASE``
Dimension = tuple[Fraction | int, ...]
NUMBER: Dimension = (0,) * len(BASE)


@dataclass(frozen=True, slots=True)
class Unit:
    """A factor to SI and a dimension; ``text`` as it was written."""

    text: str
    factor: float
    dimension: Dimension


def _dim(**exponents: int) -> Dimension:
    return tuple(exponents.get(b, 0) for b in BASE)


_FORCE, _ENERGY = _dim(kg=1, m=1, s=-2), _dim(kg=1, m=2, s=-2)
_LENGTH, _MASS, _TIME = _dim(m=1), _dim(kg=1), _dim(s=1)

#: symbols that take SI prefixes
_PREFIXED: dict[str, tuple[float, Dimension]] = {
    "m": (1.0, _LENGTH),
    "g": (1e-3, _MASS),
    "s": (1.0, _TIME),
    "A": (1.0, _dim(A=1)),
    "K": (1.0, _dim(K=1)),
    "mol": (1.0, _dim(mol=1)),
    "cd": (1.0, _dim(cd=1)),
    "rad": (1.0, NUMBER),
    "N": (1.0, _FORCE),
    "Pa": (1.0, _dim(kg=1, m=-1, s=-2)),
    "J": (1.0, _ENERGY),
    "W": (1.0, _dim(kg=1, m=2, s=-3)),
    "Hz": (1.0, _dim(s=-1)),
    "V": (1.0, _dim(kg=1, m=2, s=-3, A=-1)),
    "C": (1.0, _dim(A=1, s=1)),
    "Ohm": (1.0, _dim(kg=1, m=2, s=-3, A=-2)),
    "F": (1.0, _dim(kg=-1, m=-2, s=4, A=2)),
    "H": (1.0, _dim(kg=1, m=2, s=-2, A=-2)),
    "T": (1.0, _dim(kg=1, s=-2, A=-1)),
    "bar": (1e5, _dim(kg=1, m=-1, s=-2)),
    "t": (1e3, _MASS),
}
_PLAIN: dict[str, tuple[float, Dimension]] = {
    "deg": (math.pi / 180, NUMBER),
    "rev": (2 * math.pi, NUMBER),
    "rpm": (2 * math.pi / 60, _dim(s=-1)),
    "min": (60.0, _TIME),
    "h": (3600.0, _TIME),
    "in": (0.0254, _LENGTH),
    "inch": (0.0254, _LENGTH),
    "ft": (0.3048, _LENGTH),
    "yd": (0.9144, _LENGTH),
    "mi": (1609.344, _LENGTH),
    "lb": (0.45359237, _MASS),
    "lbm": (0.45359237, _MASS),
    "oz": (0.45359237 / 16, _MASS),
    "slug": (14.593902937206364, _MASS),
    "lbf": (4.4482216152605, _FORCE),
    "kp": (9.80665, _FORCE),
    "kgf": (9.80665, _FORCE),
    "psi": (6894.757293168361, _dim(kg=1, m=-1, s=-2)),
    "hp": (745.6998715822702, _dim(kg=1, m=2, s=-3)),
    "mph": (0.44704, _dim(m=1, s=-1)),
}
_PREFIX = {
    "p": 1e-12, "n": 1e-9, "u": 1e-6, "µ": 1e-6, "m": 1e-3, "c": 1e-2, "d": 1e-1,
    "da": 1e1, "h": 1e2, "k": 1e3, "M": 1e6, "G": 1e9, "T": 1e12,
}  # fmt: skip
#: only these are usual with centi, deci, deca and hecto; "dt" or "cT" would be mistyped names
_SMALL_STEPS = {"c": ("m", "N", "s"), "d": ("m",), "da": ("N",), "h": ("Pa",)}
_SYMBOL = re.compile(r"[A-Za-zµ]+")
#: a whole number or half of one: ``m2``, ``m^2``, ``s^-1``, ``s^(-1)``, ``Pa^0.5``, ``m^(3/2)``
EXPONENT = r"\^\(-?[1-9](?:/2)?\)|\^-?[0-9]\.5|\^-?[1-9]|[2-9](?![0-9])"
_EXPONENT = re.compile(rf"{EXPONENT}|(?=[^0-9])|$")


@cache
def symbol(name: str) -> tuple[float, Dimension] | None:
    """Factor and dimension of one unit symbol, with or without a prefix."""
    if name in _PLAIN:
        return _PLAIN[name]
    if name in _PREFIXED:
        return _PREFIXED[name]
    for prefix, scale in _PREFIX.items():
        rest = name[len(prefix) :]
        if name.startswith(prefix) and rest in _PREFIXED and rest in _SMALL_STEPS.get(prefix, (rest,)):
            factor, dimension = _PREFIXED[rest]
            return scale * factor, dimension
    return None


def symbols() -> list[str]:
    """All unit symbols, those with prefixes included."""
    found = [*_PREFIXED, *_PLAIN]
    found += (prefix + name for prefix in _PREFIX for name in _PREFIXED)
    return sorted({name for name in found if symbol(name) is not None})


def scan(text: str, start: int = 0) -> tuple[Unit, int] | None:
    """The longest unit that begins at ``start``, and where it ends; None where there is none."""
    found = _factor(text, start, 0)
    if found is None:
        return None
    factor, dimension, at = found
    while at < len(text) and text[at] in "./":
        sign = 1 if text[at] == "." else -1
        following = _factor(text, at + 1, 0)
        if following is None or (sign < 0 and _is_name(text, at + 1, following[2])):
            break
        scale, more, at = following
        factor *= scale**sign
        dimension = tuple(a + sign * b for a, b in zip(dimension, more, strict=True))
    return Unit(text[start:at], factor, dimension), at


def _is_name(text: str, start: int, end: int) -> bool:
    """Whether what looks like a unit is the name of a component, as A in `50 W/A.w` and `50 W/A[2].w`."""
    if not text[start:end].isidentifier():
        return False
    behind = text[end : end + 2]
    member = behind[:1] == "." and (behind[1:].isalpha() or behind[1:] == "_") and _factor(text, end + 1, 0) is None
    return behind[:1] == "[" or member


def _factor(text: str, at: int, depth: int) -> tuple[float, Dimension, int] | None:
    """A symbol with its exponent, or a product in parentheses (as in ``kg/(m.s)``)."""
    if text[at : at + 1] == "(" and depth < 3:
        inner = scan(text, at + 1)
        if inner is None or text[inner[1] : inner[1] + 1] != ")":
            return None
        return inner[0].factor, inner[0].dimension, inner[1] + 1
    match = _SYMBOL.match(text, at)
    known = symbol(match.group()) if match else None
    if match is None or known is None:
        return None
    end = match.end()
    exponent = _EXPONENT.match(text, end)
    # A symbol that continues like a name ("m1", "m_a") is a name, not a unit.
    if exponent is None or text[exponent.end() : exponent.end() + 1].isalnum() or text[exponent.end() :][:1] == "_":
        return None
    exact = Fraction(exponent.group().strip("^()") or 1)
    factor = known[0] ** (int(exact) if exact.denominator == 1 else float(exact))
    return factor, power(known[1], exact), exponent.end()


@cache
def parse(text: str) -> Unit | None:
    """The unit written in ``text`` ("1" or "" is a pure number); None if it is not one."""
    if text in ("1", ""):
        return Unit(text, 1.0, NUMBER)
    source = text[2:] if (inverse := text.startswith("1/")) else text
    if len(source) > 60:
        return None
    found = scan(source)
    if found is None or found[1] != len(source):
        return None
    unit = found[0]
    if inverse:
        return Unit(text, 1.0 / unit.factor, power(unit.dimension, -1))
    return unit


_WORDS = {
    "degree": "deg", "radian": "rad", "metre": "m", "meter": "m", "millimetre": "mm", "millimeter": "mm",
    "second": "s", "sec": "s", "millisecond": "ms", "minute": "min", "hour": "h", "kilogram": "kg", "gram": "g",
    "newton": "N", "joule": "J", "watt": "W", "pascal": "Pa", "hertz": "Hz", "pound": "lb", "foot": "ft", "feet": "ft",
    "Nms": "N.m.s", "kgs": "kg", "turn": "rev", "D": "deg", "kph": "km/h", "kmh": "km/h",
}  # fmt: skip


def meant(word: str) -> str | None:
    """The unit that ``word``, which is none, may stand for: ``Nm`` for N.m, ``degrees`` for deg, ``Kg`` for kg."""
    if len(word) > 12:
        return None
    for spelt in (word, word.lower(), word.lower().removesuffix("s")):
        if spelt in _WORDS:
            return _WORDS[spelt]
    joined = (f"{word[:i]}.{word[i:]}" for i in range(1, min(len(word), 5)) if word[:i].endswith(("N", "kg")))
    letters = (word.lower(), word.capitalize(), word[:1].lower() + word[1:])
    return next((text for text in (*joined, *letters) if parse(text) is not None), None)


@cache
def valid(text: str) -> Unit:
    """A unit that is known to be valid (from a declaration)."""
    unit = parse(text)
    if unit is None:
        raise ValueError(f"no unit: {text!r}")
    return unit


def dimension(text: str) -> Dimension:
    """Dimension of a unit that is known to be valid."""
    return valid(text).dimension


def multiply(a: Dimension, b: Dimension, sign: int = 1) -> Dimension:
    return tuple(x + sign * y for x, y in zip(a, b, strict=True))


def power(a: Dimension, exponent: Fraction | int) -> Dimension:
    result = (e * exponent for e in a)
    return tuple(int(e) if e == int(e) else e for e in result)


_NUMBER = re.compile(r"\s*([+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?)\s*(.*?)\s*")


def measure(text: str, unit: str) -> float:
    """The number in ``text``, in ``unit``; bare numbers are in ``unit`` already.

    Raises
    ------
    ValueError
        No number, no unit, or a unit of another dimension.
    """
    match = _NUMBER.fullmatch(text)
    if match is None:
        raise ValueError(
            f"`{text}` is not a number" + ("" if unit == "1" else f", with or without a unit, such as 1.5{unit}")
        )
    number, written = float(match[1]), match[2]
    if not written:
        return number
    found, wanted = parse(written), parse(unit)
    if found is None:
        raise ValueError(f"unknown unit `{written}` in `{text}`; expected {unit}, or a multiple of it")
    if wanted is None or found.dimension != wanted.dimension:
        expected = "no unit" if unit == "1" else unit
        raise ValueError(f"`{text}` has the wrong unit: expected {expected}, found {written}")
    return number * found.factor / wanted.factor
