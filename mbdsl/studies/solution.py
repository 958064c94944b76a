"""The answers of ``solve``: values of parameters that meet conditions, and what was reached without an answer."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from mbdsl.errors import UsageError
from mbdsl.kernels.arrays import Array
from mbdsl.lang.display_units import factor, only_asked
from mbdsl.messages import DisplayUnit, count
from mbdsl.studies.measures import Measure
from mbdsl.studies.sweep_results import Sweep
from mbdsl.studies.sweep_values import Varied


@dataclass(frozen=True)
class Condition:
    """A measure and the value that it should have, as ``max(shaft.w) = 160 rpm``.

    Attributes
    ----------
    measure : Measure
        The measure.
    value : float
        The value, in the SI unit of the measure.
    unit : str
        The unit in which the value was given; "" if it has none.
    """

    measure: Measure
    value: float
    unit: str = ""

    def shown(self, value: float, digits: int = 6) -> str:
        """Return a value of the measure in the unit of the condition.

        Parameters
        ----------
        value : float
            The value in the SI unit of the measure.
        digits : int, optional
            Significant digits.

        Returns
        -------
        str
        """
        return DisplayUnit(self.unit, factor(self.unit, self.measure.unit)).text(value, digits)

    def __str__(self) -> str:
        return f"{self.measure} = {self.shown(self.value)}"


@dataclass(frozen=True)
class Answer:
    """Values of the parameters that meet all conditions.

    Attributes
    ----------
    values, errors : tuple of float
        Values of the parameters and estimates of their errors, in the units of their ranges; an error is nan if the run
        that it is estimated by has failed.
    measures : tuple of float
        Values of the measures, in SI units.
    """

    values: tuple[float, ...]
    errors: tuple[float, ...]
    measures: tuple[float, ...]


@dataclass(frozen=True, eq=False, repr=False)
class Solution:
    """The answers of ``solve``. ``print(solution)`` shows them; without an answer, what was reached.

    ``solution["m"]`` is the value of a parameter in the first answer, in the unit of its range.

    Attributes
    ----------
    name : str
        Name of the model.
    parameters : tuple of Varied
        Parameters and the ends of their ranges.
    conditions : tuple of Condition
        Conditions.
    answers : tuple of Answer
        Those that were found, by ascending values; empty if there is none.
    sweep : Sweep
        All runs that were made, by ascending values of the first parameter.
    notes : tuple of str
        Remarks, such as a jump of the measure over its value.
    """

    name: str
    parameters: tuple[Varied, ...]
    conditions: tuple[Condition, ...]
    answers: tuple[Answer, ...]
    sweep: Sweep
    notes: tuple[str, ...] = ()

    def __bool__(self) -> bool:
        return bool(self.answers)

    def __getitem__(self, name: str) -> float:
        return self._of(name, [answer.values for answer in self.answers[:1]])

    def error(self, name: str) -> float:
        """Return the estimated error of a parameter in the first answer.

        Parameters
        ----------
        name : str
            The parameter.

        Returns
        -------
        float
            In the unit of its range.
        """
        return self._of(name, [answer.errors for answer in self.answers[:1]])

    def _of(self, name: str, found: Sequence[tuple[float, ...]]) -> float:
        names = [p.name for p in self.parameters]
        if name not in names:
            raise UsageError(f"`{name}` was not sought", hint=f"sought: {', '.join(names)}")
        if not found:
            title, *reached = self._lacking()
            raise UsageError(title, hint="; ".join(line.strip() for line in reached))
        return found[0][names.index(name)]

    def __repr__(self) -> str:
        return f"<Solution of {self.name}: {count(len(self.answers), 'answer')}>"

    def __str__(self) -> str:
        if not self.answers:
            lines = self._lacking()
        else:
            lines = [self._line(answer) for answer in self.answers]
        runs = count(len(self.sweep), "run")
        failed = f", {len(self.sweep.failed)} of them failed" if self.sweep.failed else ""
        return "\n".join(
            [f"{self.name}: {lines[0]}", *lines[1:], *(f"note: {x}" for x in self.notes), f"{runs}{failed}"]
        )

    def _line(self, answer: Answer) -> str:
        found = zip(self.parameters, answer.values, answer.errors, strict=True)
        display = only_asked(self.sweep.display)
        units = [display.of(p.unit, p.name) for p in self.parameters]
        shown = zip(units, found, strict=True)
        values = ", ".join(
            f"{p.name} = {_with_error(x / unit.factor, error / unit.factor, unit.symbol)}"
            for unit, (p, x, error) in shown
        )
        reached = zip(self.conditions, answer.measures, strict=True)
        return f"{values}, where {' and '.join(f'{c.measure} = {c.shown(self._reached(c, y))}' for c, y in reached)}"

    def _reached(self, c: Condition, y: float) -> float:
        """The value of a measure in an answer; the required one but for the width of the last bracket."""
        extent = spread(self.sweep[str(c.measure)], c.value)
        return c.value if math.isclose(y, c.value, rel_tol=0.0, abs_tol=1e-6 * extent) else y

    def _lacking(self) -> list[str]:
        """That there is no answer, and what the measures reach over the range."""
        limits = [p.displayed(only_asked(self.sweep.display)) for p in self.parameters]
        ranges = " and ".join(f"{p.said(0)} to {p.shown(1)}{f' {p.unit}' if p.unit else ''}" for p in limits)
        lines = [f"no answer for {' and '.join(map(str, self.conditions))} from {ranges}"]
        columns = [self.sweep[str(c.measure)] for c in self.conditions]
        for c, y in zip(self.conditions, columns, strict=True):
            known = np.flatnonzero(np.isfinite(y))
            low, high = (known[int(of(y[known]))] for of in (np.argmin, np.argmax))
            ends = [f"{c.shown(y[k])} ({self.sweep.point(k)})" for k in (low, high)]
            same = math.isclose(y[low], y[high], rel_tol=1e-9)
            reached = f"{c.shown(y[low])} at all of these values" if same else f"from {ends[0]} to {ends[1]}"
            lines.append(f"  {c.measure} is {reached}")
        if len(columns) > 1:
            far = [np.abs(y - c.value) / spread(y, c.value) for c, y in zip(self.conditions, columns, strict=True)]
            k = int(np.nanargmin(np.sum(np.square(far), axis=0)))
            both = " and ".join(f"{c.measure} = {c.shown(y[k])}" for c, y in zip(self.conditions, columns, strict=True))
            lines.append(f"  closest: {both} ({self.sweep.point(k)})")
        return lines


def _with_error(x: float, error: float, unit: str) -> str:
    """``431.72 kg +- 0.03 kg``, with the digits that the error leaves."""
    after = f" {unit}" if unit else ""
    if not math.isfinite(error):
        return f"{x:.6g}{after} (error not known)"
    places = math.floor(math.log10(abs(x))) - math.floor(math.log10(error)) + 1 if error and x else 6
    digits = min(12, max(2, places))
    return f"{x:.{digits}g}{after} +- {error:.1g}{after}"


def spread(y: Array, target: float) -> float:
    """The differences of a measure over the range and to its target, as a scale."""
    known = y[np.isfinite(y)]
    return float(max(np.ptp(np.append(known, target)), 1e-12 * abs(target), 1e-300))
