"""Ambiguous units: ``1 N/g`` in a model with a parameter ``g`` may be meant as a division.

Inside a unit there are no blanks: ``1 N/g`` is a newton per gram, and ``1 N / g`` is divided by the parameter. If the
symbol after ``/`` is also a name of the model, a wrong dimension reveals most mistakes: in a model with a mass ``m``,
``100 N/m`` is a stiffness. Cases that no dimension reveals are refused: a parameter with the dimension of the symbol
itself, and symbols that are unusual after ``/``.
"""

from __future__ import annotations

import re
from collections.abc import Callable
from functools import cache

from mbdsl.errors import ModelError
from mbdsl.lang import units
from mbdsl.lang.units import Dimension, Unit

#: symbols that are common after the `/` of units
USUAL = frozenset("m mm cm km in ft s ms us min h rad deg rev kg lb".split())
_BEHIND = re.compile(r"/([A-Za-z]+)(?=[./]|$)")


@cache
def _behind(text: str) -> tuple[tuple[str, Dimension], ...]:
    """Symbols after a `/` of a unit, which may be names as well, and their dimensions."""
    return tuple((name, known[1]) for name in _BEHIND.findall(text) if (known := units.symbol(name)) is not None)


def check(unit: Unit, declared: Callable[[str], str | None]) -> None:
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
