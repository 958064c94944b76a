"""The units that an editor offers after a number."""

from __future__ import annotations

from collections.abc import Iterator
from functools import cache

from mbdsl.editor import descriptions
from mbdsl.elements import kinds
from mbdsl.lang import quantities, units


def proposals(expected: str) -> Iterator[tuple[str, str, str, str, int]]:
    """All units, those of the expected dimension first.

    Parameters
    ----------
    expected : str
        A unit of this dimension; "" if the dimension is not known.

    Yields
    ------
    tuple
        The fields of a :class:`~mbdsl.editor.completion.Proposal`.
    """
    wanted = units.dimension(expected) if expected else None
    angles = wanted == units.NUMBER and expected != "rad"
    for name in dict.fromkeys((*([expected] if expected not in ("", "1") else ()), *_usual(), *units.symbols())):
        found = units.parse(name)
        if found is not None:
            fits = wanted is not None and found.dimension == wanted and not angles
            rank = (0 if name == expected else 1 if name in _usual() else 3) if fits else 4 if name in _usual() else 8
            yield name, "unit", quantities.words(found.dimension, name), descriptions.of_unit(name), rank


@cache
def _usual() -> tuple[str, ...]:
    """Units of the parameters of all kinds and of the types, and others that are common."""
    declared = (p.unit for kind in kinds().values() for p in kind.parameters)
    common = "mm cm km g t ms us min h deg rev rpm kN N/mm MPa GPa kPa kJ kW in ft lb lbf Hz"
    found = (*quantities.TYPES.values(), *declared, *common.split())
    return tuple(dict.fromkeys(x for x in found if x[:1].isalpha()))  # 1/s cannot follow a number
