"""Mistakes with units: values of a wrong dimension, a missing unit, ``3 kg*m^2``, and units with two readings.

Inside a unit there are no blanks: ``1 N/g`` is a newton per gram, and ``1 N / g`` is divided by the parameter ``g``. If
the symbol after ``/`` is also a name of the model, a wrong dimension reveals most mistakes: in a model with a mass
``m``, ``100 N/m`` is a stiffness. Cases that no dimension reveals are refused: a parameter with the dimension of the
symbol itself, and symbols that are unusual after ``/``.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence
from functools import cache

from mbdsl.errors import ModelError
from mbdsl.lang import syntax as s
from mbdsl.lang import units
from mbdsl.lang.mistakes.tokens import text_of
from mbdsl.lang.units import NUMBER, Dimension, Unit
from mbdsl.lang.unparse import inner, write
from mbdsl.lang.values import Value

_TIME = units.dimension("s")
#: symbols that are common after the `/` of units
USUAL = frozenset("m mm cm km in ft s ms us min h rad deg rev kg lb".split())
_BEHIND = re.compile(r"/([A-Za-z]+)(?=[./]|$)")


def remedy(found: Dimension, expected: Dimension, unit: str, e: s.Expression | None) -> str | None:
    """What to write instead of ``e``, whose dimension is not that of ``unit``; None if that cannot be guessed."""
    if e is None:
        return None
    if (written := one_word(e)) is not None and units.valid(written[1]).dimension == expected:
        return f"a unit is one word without `*`: write `{written[0]}`"
    if isinstance(e, s.Number) or not unit:
        return None
    if found == NUMBER:
        return f"give it a unit: `1 {unit}*{inner(e)}`"
    if found == _TIME and expected != _TIME and "time" in write(e):
        return f"multiply the time by a rate: `1 {unit}/s*{inner(e)}`"
    return None


def one_word(e: s.Expression) -> tuple[str, str] | None:
    """``3 kg*m^2`` as ``3 kg.m2`` and its unit; None if ``e`` is not a number with such a unit."""
    factors = []
    while isinstance(e, s.Binary) and e.operator in ("*", "/"):
        factor, exponent = e.right, ""
        match factor:
            case s.Binary("^", base, s.Number(int() as power, None)):
                factor, exponent = base, str(power)
        match factor:
            case s.Reference((s.NamePart(name, ()),)) if units.symbol(name) is not None:
                factors.append((e.operator, name + exponent))
            case _:
                return None
        e = e.left
    if not factors or not isinstance(e, s.Number) or (e.unit is None and factors[-1][0] == "/"):
        return None
    unit = e.unit.text if e.unit is not None else ""
    for operator, factor in reversed(factors):
        unit += ("/" if operator == "/" else "." if unit else "") + factor
    number = text_of(s.Number(e.value)) if e.unit is None else text_of(e).removesuffix(e.unit.text).strip()
    return (f"{number} {unit}", unit) if units.parse(unit) is not None else None


def of_elements(items: Sequence[s.Expression], found: Value, unit: Unit) -> str | None:
    """What to write instead of an array with a unit behind it, if an element is not a plain number."""
    values = found if isinstance(found, tuple) else (found,)
    written = [_element(item, x, unit) for item, x in zip(items, values, strict=False)]
    plain = [x for x in written if x is not None]
    if len(plain) < len(written):
        return f"the unit {unit.text} is for plain numbers: give each element its own unit"
    return f"write `{{{', '.join(plain)}}}`"


def _element(e: s.Expression, value: Value, unit: Unit) -> str | None:
    """An element that has a unit of its own; None if it has another dimension."""
    if isinstance(e, s.ArrayNode) and e.unit is None and isinstance(value, tuple):
        inner_ones = [_element(item, x, unit) for item, x in zip(e.items, value, strict=True)]
        plain = [x for x in inner_ones if x is not None]
        return f"{{{', '.join(plain)}}}" if len(plain) == len(inner_ones) else None
    if isinstance(value, tuple) or not value.number:
        return None
    if value.dimension == unit.dimension and unit.dimension != NUMBER:
        return write(e)
    if value.dimension not in (None, NUMBER):
        return None
    if isinstance(e, s.Number):
        return write(s.Number(e.value, unit)) if e.value else "0"
    factor = _first_factor(e, unit)
    return write(factor) if factor is not None else f"1 {unit.text}*{inner(e)}"


def _first_factor(e: s.Expression, unit: Unit) -> s.Expression | None:
    """A product that begins with a number, which gets the unit; None for other expressions."""
    match e:
        case s.Number(value, None):
            return s.Number(value, unit)
        case s.Binary("*" | "/" as operator, left, right):
            first = _first_factor(left, unit)
            return s.Binary(operator, first, right) if first is not None else None
    return None


@cache
def _behind(text: str) -> tuple[tuple[str, Dimension], ...]:
    """Symbols after a `/` of a unit, which may be names as well, and their dimensions."""
    return tuple((name, known[1]) for name in _BEHIND.findall(text) if (known := units.symbol(name)) is not None)


def check_readings(unit: Unit, declared: Callable[[str], str | None]) -> None:
    """Refuse a unit that may be meant as a division by a value of the model.

    ``declared(name)`` is the unit of the value of that name, "" if it has none, and None if there is no such value.

    Raises
    ------
    ModelError
        If the unit is ambiguous; the message names both readings.
    """
    if "/" not in unit.text:
        return
    for name, dimension in _behind(unit.text):
        own = declared(name)
        if own is None or (name in USUAL and (not own or units.dimension(own) != dimension)):
            continue
        before = unit.text.partition(f"/{name}")[0]
        raise ModelError(
            f"`{unit.text}` has two readings: the unit {unit.text}, and {before} divided by `{name}` of this model",
            None,
            f"to divide, write blanks: `{before} / {name}`; to have the unit, give `{name}` another name",
        )
