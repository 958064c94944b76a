"""Convergence: errors as functions of the step or the tolerance, and their slopes."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from os import PathLike
from typing import Any

from mbdsl.integrators import available
from mbdsl.mechanism.scene import Scene
from mbdsl.messages import duration
from mbdsl.plotting.figures import Figure, Series, TextTable
from mbdsl.studies.error_measures import ErrorQuantity
from mbdsl.studies.report import Study, number, outcomes, size, troubles
from mbdsl.studies.slopes import Fit, verdict
from mbdsl.studies.survey import Asked, Survey, SurveyRow, error_in, survey

#: quantities whose slopes are fitted; constraints and energy may have other orders or no error at all
FITTED = ("q", "v", "reactions")
ABOVE = 0.04  #: height of the line of an order above the error at the longest step, relative to the figure
BRACKETS = "largest over time, scaled; in brackets if below the resolution of the reference."


class Convergence(Study):
    """``fits[series][quantity]`` are the slopes; None if the errors do not lie on a line."""

    kind = "convergence"

    def __init__(self, survey: Survey) -> None:
        super().__init__(survey)
        self.fits: dict[str, dict[str, Fit | None]] = {}
        for name, rows in survey.series().items():
            self.fits[name] = {
                q.key: survey.fitted(rows, error_in(q.key, "scaled"), survey.reference.floor(q).scaled)
                for q in survey.quantities
            }

    def verdict(self, series: str, key: str) -> str:
        """The verdict on a slope: "" if it agrees with the order of the method."""
        rows, q = self.survey.series()[series], self.survey.quantity(key)
        assert q is not None
        errors = [row.errors[key].scaled for row in rows if row.run.done]
        order = available()[rows[0].case.method].order
        return verdict(self.fits[series][key], order, errors, self.survey.reference.floor(q).scaled)

    def summary(self) -> list[str]:
        s = self.survey
        lines = [trusted(s)]
        fixed = {name: rows for name, rows in s.series().items() if rows[0].case.tol is None}
        for name in fixed:
            wrong = {key: v for key in FITTED if s.quantity(key) and (v := self.verdict(name, key)) and "tell" not in v}
            if wrong:
                lines.append(f"{name}: " + ", ".join(f"{key} {v}" for key, v in wrong.items()))
        return lines + troubles(s)

    def tables(self) -> list[TextTable]:
        return [errors_table(self.survey), *self._slopes()]

    def data(self) -> dict:
        fits = {
            name: {key: vars(found) if found else None for key, found in of.items()} for name, of in self.fits.items()
        }
        return {**super().data(), "slopes": fits}

    def _slopes(self) -> list[TextTable]:
        """A row for every series, and one for every slope, with its range."""
        short, long = [], []
        shown = [q for q in self.survey.quantities if not q.itself]
        for name, series in self.survey.series().items():
            controlled = series[0].case.tol is not None
            order = "" if controlled else str(available()[series[0].case.method].order)
            slopes = [self.fits[name][q.key] for q in shown]
            says = {} if controlled else {q.key: self.verdict(name, q.key) for q in shown if q.key in FITTED}
            verdicts = dict.fromkeys(f"{key} {verdict}" for key, verdict in says.items() if verdict)
            short.append((name, order, *(str(f) if f else "-" for f in slopes), "; ".join(verdicts)))
            for q, f in zip(shown, slopes, strict=True):
                if f is not None:
                    where = (_size(f.high, controlled), _size(f.low, controlled))
                    long.append((name, q.key, str(f), *where, str(f.count), f.below))
        note = "With half of the 95 % interval; fitted where the errors lie on a line."
        return [
            TextTable("Slopes", ("series", "order", *(q.key for q in shown), ""), short, note),
            TextTable("Ranges of the slopes", ("series", "error in", "slope", "from", "to", "points", "below"), long),
        ]

    def figures(self) -> list[Figure]:
        return [figure for q in self.survey.quantities for figure in error_figures(self.survey, q)]


def convergence(model: Scene | str | PathLike, **asked: Any) -> Convergence:
    """Measure the errors of methods as functions of the step size or the tolerance.

    Parameters
    ----------
    model : Scene or path
        The mechanism.
    **asked
        Fields of ``Asked``: methods, steps, tols, signals, ...

    Returns
    -------
    Convergence

    Raises
    ------
    MbdslError
        If the model or the arguments are invalid, or no reference solution is found.
    """
    return Convergence(survey(model, Asked(**asked)))


def trusted(s: Survey) -> str:
    """A sentence on the accuracy of the reference."""
    if s.reference.check is None:
        return f"Reference: {s.reference.how}; its accuracy is not known."
    digits = {q.key: s.reference.digits(q) for q in s.quantities if not q.itself}
    said = ", ".join(f"{key} {d:.1f}" for key, d in digits.items() if d is not None)
    return f"Reference: {s.reference}; digits in which they agree: {said}."


def errors_table(s: Survey) -> TextTable:
    """Scaled errors of every case; those below the resolution of the reference in brackets."""
    columns = ("method", "step or tol", "steps", *(q.key for q in s.quantities))
    rows = []
    for row in s.rows:
        cells = (
            [cell(s, q, row) for q in s.quantities] if row.run.done else [row.run.word] + [""] * (len(s.quantities) - 1)
        )
        rows.append((row.case.series, size(row), str(row.run.stats.get("steps", "")), *cells))
    return TextTable("Errors", columns, rows, f"{BRACKETS[0].upper()}{BRACKETS[1:]}")


def cell(s: Survey, q: ErrorQuantity, row: SurveyRow) -> str:
    """A scaled error as text, with brackets as ``BRACKETS`` explains."""
    e, floor = row.errors[q.key].scaled, s.reference.floor(q).scaled
    return number(e) if e >= floor or q.itself else f"({number(e)})"


def error_figures(s: Survey, q: ErrorQuantity, scaled: bool = True) -> list[Figure]:
    """Errors of a quantity as functions of the step and of the tolerance; errors below the floor are not points.

    They are scaled, or else in the unit of the quantity.
    """
    found = []
    floor = s.reference.floor(q).scaled if scaled else s.reference.floor(q).largest
    for key, label, controlled in (("", "step [s]", False), ("-tol", "tolerance", True)):
        of_kind = {name: rows for name, rows in s.series().items() if (rows[0].case.tol is not None) == controlled}
        if not of_kind:
            continue
        series = []
        for name, rows in of_kind.items():
            done = [row for row in rows if row.run.done]
            errors = [row.errors[q.key] for row in done]
            y = [e.scaled if scaled else e.largest for e in errors]
            y = [e if e > 0.0 and (q.itself or e >= floor) else math.nan for e in y]
            series.append(Series(name, [row.case.size for row in done], y, hover=[_hover(q, row) for row in done]))
        if controlled:
            sizes = sorted({row.case.size for rows in of_kind.values() for row in rows})
            series.append(Series("error = tolerance", sizes, sizes, style="guide"))
        elif q.key in FITTED:
            series += _orders(series, {name: available()[rows[0].case.method].order for name, rows in of_kind.items()})
        floors = [(floor, "the references differ")] if floor > 0.0 else []
        what = q.label if q.itself else f"error in {q.label}"
        problems = outcomes(row for rows in of_kind.values() for row in rows)
        file = q.key.replace("[", "").replace("]", "").replace(".", "_")
        found.append(
            Figure(
                f"{file}{key}",
                f"{what[0].upper()}{what[1:]}",
                label,
                f"largest over time{', scaled' if scaled else f' [{q.unit}]'}",
                series,
                outcomes=problems,
                floors=floors,
            )
        )
    return found


def _orders(series: Sequence[Series], orders: Mapping[str, int]) -> list[Series]:
    """A line for every order of the methods, above the points with the largest steps."""
    found = []
    errors = [y for s in series for y in s.y if y > 0.0]
    above = (max(errors) / min(errors)) ** ABOVE if errors else 1.0
    for order in sorted({p for p in orders.values() if p}):
        points = [(x, y) for s in series if orders[s.name] == order for x, y in zip(s.x, s.y, strict=True) if y > 0.0]
        sizes = sorted({x for x, _ in points}, reverse=True)
        if len(sizes) > 1:
            top = above * max(y for x, y in points if x == sizes[0])
            found.append(Series(f"order {order}", sizes, [top * (x / sizes[0]) ** order for x in sizes], style="guide"))
    return found


def _hover(q: ErrorQuantity, row: SurveyRow) -> str:
    e = row.errors[q.key]
    return f"{row.case}: {number(e.largest, 3)} {q.unit}, {row.run.stats.get('steps')} steps"


def _size(x: float, controlled: bool) -> str:
    return f"{x:.0e}".replace("e-0", "e-") if controlled else duration(x)
