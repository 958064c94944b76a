"""The unit in which a value is displayed: numbers are kept in SI units, and texts, tables and plots convert them."""

from __future__ import annotations

from dataclasses import dataclass


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
