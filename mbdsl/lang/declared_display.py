"""The attribute ``displayUnit``: of parameters and variables, and of signals of components in their modifiers."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING

from mbdsl.errors import ModelError
from mbdsl.lang import display_units, quantities, units, values
from mbdsl.lang.modifiers import Modifier
from mbdsl.lang.values import Quantity

if TYPE_CHECKING:
    from mbdsl.lang.entities import Slot
    from mbdsl.lang.flat_component import FlatComponent

HINT = 'e.g. displayUnit = "deg"'


def read(modifier: Modifier, contexts: tuple = ()) -> str:
    """The unit that an attribute ``displayUnit`` gives; "" for none, as Modelica's tools write it.

    Raises
    ------
    ModelError
        If it is not a text, or not a unit.
    """
    found = modifier.pick(modifier.evaluate(), 0, contexts) if modifier.value is not None else None
    text = found.value if isinstance(found, Quantity) else None
    if not isinstance(text, str):
        said = "nothing" if found is None else values.describe(found)
        raise ModelError(f"`displayUnit` is a text, found {said}", modifier.value_span(), HINT)
    if text and units.parse(text) is None:
        nearest = units.meant(text)
        hint = f'did you mean "{nearest}"?' if nearest else "units are e.g. deg, rpm, mm, kN, N.mm"
        raise ModelError(f'unknown unit "{text}"', modifier.value_span(), hint)
    return text


def of_value(slot: Slot, unit: str) -> tuple[str, str]:
    """The SI unit of a parameter or variable, which follows from its display unit if it has none, and that unit.

    Raises
    ------
    ModelError
        If the display unit has another dimension.
    """
    if slot.display is None:
        return unit, ""
    modifier, shown = slot.display
    if unit in ("", "1"):
        unit = "rad" if display_units.is_angle(shown) else unit
    _check(modifier, slot.name, shown, unit)
    return unit, shown


def of_signals(parts: Iterable[FlatComponent]) -> dict[str, str]:
    """Signal -> its display unit, of modifiers such as ``phi(displayUnit = "deg")``."""
    found = {}
    for part in parts:
        for signal in part.kind.signals if part.template.modifiers else ():
            modifier = part.template.modifiers.get(signal.name)
            attribute = modifier.inner.get("displayUnit") if modifier is not None and modifier.inner else None
            if attribute is None or not (shown := read(attribute, part.contexts)):
                continue
            name = f"{part.name}.{signal.name}"
            if units.parse(signal.unit) is not None:
                _check(attribute, name, shown, signal.unit)
            found[name] = shown
    return found


def _check(modifier: Modifier, name: str, shown: str, unit: str) -> None:
    dimension, own = units.dimension(shown), units.dimension(unit or "1")
    if dimension == own:
        return
    raise ModelError(
        f"`displayUnit` of `{name}` is {quantities.words(dimension, shown)}, expected a unit of "
        f"{quantities.words(own, unit)}",
        modifier.value_span(),
    )
