"""The units in which values are displayed: those that the user asks for, then those of ``displayUnit`` in the model.

Numbers are kept in SI units. Every text, table, plot and page that shows a value asks :meth:`DisplayUnits.of` for the
unit. A unit that is asked for replaces that of all values of its quantity. Some quantities have the same
exponents of the SI base units; these are distinguished as follows:

- an angle [rad] and a pure number; an angular velocity [rad/s] and a frequency [Hz, 1/s]: by the exponent of angles;
- a torque [N.m] and an energy [J]: units of energies contain J or W.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping
from copy import copy
from dataclasses import dataclass, field
from functools import cache
from typing import TYPE_CHECKING

from mbdsl.errors import UsageError
from mbdsl.lang import quantities, units
from mbdsl.lang.units import Dimension
from mbdsl.messages import OWN, DisplayUnit, UnitsOfSignals, did_you_mean

if TYPE_CHECKING:
    from mbdsl.mechanism.scene import Scene

#: dimension, exponent of angles, and whether it is an energy
Kind = tuple[Dimension, int, bool]

EXAMPLE = '--units "deg, rpm, kN, mm"'
_ENERGY = units.dimension("J")
_ENERGIES = (_ENERGY, units.dimension("W"))
INDEX = re.compile(r"\[[^\[\]]*\]")  #: of elements; `joint[:].tau` is displayed as the elements are
_PART = re.compile(r"[./()]|([A-Za-zµ]+)(?:\^?\(?(-?\d)\)?)?")


@cache
def kind(text: str) -> Kind | None:
    """The quantity that a unit belongs to; None if the text is not a unit."""
    unit = units.parse(text)
    if unit is None:
        return None
    angles, sign, around, energy = 0, 1, [1], False
    for match in _PART.finditer(text):
        if match[1] is None:
            if match[0] == "(":
                around.append(around[-1] * sign)
            elif match[0] == ")" and len(around) > 1:
                around.pop()
            sign = -1 if match[0] == "/" else 1
            continue
        found = units.symbol(match[1])
        if found is not None:
            angle = match[1] == "rpm" or found[1] == units.NUMBER
            angles += around[-1] * sign * int(match[2] or 1) * angle
            energy = energy or found[1] in _ENERGIES
        sign = 1
    return unit.dimension, angles, energy and unit.dimension == _ENERGY


def factor(text: str, own: str) -> float:
    """The size of the unit ``text`` in the unit ``own`` of the same dimension; exactly 1 if they are equal."""
    shown, given = units.parse(text), units.parse(own)
    return 1.0 if shown is None or given is None or text == own else shown.factor / given.factor


@dataclass(frozen=True)
class DisplayUnits(UnitsOfSignals):
    """Units in which values are displayed."""

    asked: Mapping[Kind, str] = field(default_factory=dict)  #: quantity -> the unit for all of its values
    declared: Mapping[str, str] = field(default_factory=dict)  #: signal -> its own unit, unless one is asked for

    def of(self, unit: str, name: str = "") -> DisplayUnit:
        """The unit in which the signal ``name``, whose values are in ``unit``, is displayed."""
        own = kind(unit)
        if own is None:
            return DisplayUnit(unit)
        shown = self.asked.get(own) or self.declared.get(INDEX.sub("[:]", name) if ":" in name else name)
        if shown is None or units.dimension(shown) != own[0]:
            return DisplayUnit(unit)
        return DisplayUnit(shown, factor(shown, unit))


def asked(given: str | Iterable[str] | None, known: UnitsOfSignals | None = None) -> UnitsOfSignals:
    """The units that are asked for, in addition to those that are declared.

    Parameters
    ----------
    given : str or iterable of str, or None
        Units, separated by commas: "deg, rpm, kN, mm".
    known : UnitsOfSignals, optional
        The units until now.

    Raises
    ------
    UsageError
        If a text is not a unit, or two are units of the same quantity.
    """
    if given is not None and not isinstance(given, str):
        given = list(given)
        if wrong := [x for x in given if not isinstance(x, str)]:
            raise UsageError(f"units: found {wrong[0]!r}, expected a text", hint='e.g. units="deg, rpm, kN, mm"')
        given = ",".join(given)
    texts = [text.strip() for text in (given or "").split(",") if text.strip()]
    before = known or OWN
    if not texts:
        return before
    found: dict[Kind, str] = {}
    for text in texts:
        of = kind(text)
        if of is None:
            raise _unknown(text)
        if of == (units.NUMBER, 0, False):
            raise UsageError(f"units: `{text}` is not a unit: it is a pure number", hint=f"e.g. {EXAMPLE}")
        if found.setdefault(of, text) != text:
            raise UsageError(
                f"units: {found[of]} and {text} are both units of {words(text)}",
                hint=f"give one unit for each quantity: {EXAMPLE}",
            )
    if not isinstance(before, DisplayUnits):
        return DisplayUnits(found)
    return DisplayUnits({**before.asked, **found}, before.declared)


def words(text: str) -> str:
    """What a unit measures, for a message."""
    found = kind(text)
    assert found is not None
    if found == (units.NUMBER, 1, False):
        return "angles"
    if found[0] == _ENERGY:
        return "energies" if found[2] else "torques"
    said = quantities.words(found[0]).partition(" [")[0].removeprefix("a ").removeprefix("an ")
    return f"the quantity {said}" if said != "quantity" else f"the quantity [{quantities.unit_text(found[0])}]"


def _unknown(text: str) -> UsageError:
    nearest = units.meant(text)
    hint = f"did you mean `{nearest}`?" if nearest else did_you_mean(text, units.symbols())
    prefixed, plain = ", ".join(units._PREFIXED), ", ".join(units._PLAIN)
    known = f"units are, with prefixes such as k and m: {prefixed}; without: {plain}; products such as N.m, km/h"
    return UsageError(f"units: unknown unit `{text}`", hint=f"{hint} {known}" if hint else known)


def declare(declared: Mapping[str, str]) -> UnitsOfSignals:
    """The units of ``displayUnit`` by the names of signals and parameters."""
    along = {INDEX.sub("[:]", name): unit for name, unit in declared.items() if "[" in name}
    return DisplayUnits({}, {**along, **declared}) if declared else OWN


def declared_text(known: UnitsOfSignals, names: Iterable[str]) -> str:
    """The declared units of signals as one text, for a result file; "" if there are none."""
    if not isinstance(known, DisplayUnits):
        return ""
    return ", ".join(f"{name} {known.declared[name]}" for name in names if name in known.declared)


def of_text(text: str, names: Iterable[str]) -> dict[str, str]:
    """The inverse of ``declared_text``; entries that are not a signal of ``names`` and a unit are left out."""
    known, found = set(names), {}
    for entry in text.split(", "):
        name, _, unit = entry.rpartition(" ")
        if name in known and units.parse(unit) is not None:
            found[name] = unit
    return found


def is_angle(text: str) -> bool:
    """Whether a unit is one of angles."""
    return kind(text) == (units.NUMBER, 1, False)


def in_units(scene: Scene, given: str | Iterable[str] | None) -> Scene:
    """The scene, of which values are displayed in the units that are asked for; see :func:`asked`."""
    if not given:
        return scene
    found = copy(scene)
    object.__setattr__(found, "display", asked(given, scene.display))
    return found


def only_asked(display: UnitsOfSignals) -> UnitsOfSignals:
    """The units that were asked for, without those of ``displayUnit``, for files of numbers."""
    return DisplayUnits(display.asked) if isinstance(display, DisplayUnits) and display.asked else OWN


_SI = {kind(unit): unit for unit in reversed(quantities.TYPES.values())}


def si(text: str) -> str:
    """The SI unit of the quantity that a unit belongs to."""
    of = kind(text)
    if of is None or of in _SI:
        return text if of is None else _SI[of]
    own = quantities.unit_text(of[0])
    return f"{own}{'.rad' * of[1] if of[1] > 0 else '/rad' * -of[1]}"
