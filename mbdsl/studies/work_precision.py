"""Work and precision: error as a function of the run time for every method, and the least time for each error."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from os import PathLike
from statistics import median
from typing import Any

import numpy as np

from mbdsl.mechanism.scene import Scene
from mbdsl.messages import duration
from mbdsl.plotting.figures import Figure, Series, TextTable
from mbdsl.studies.convergence import BRACKETS, cell, trusted
from mbdsl.studies.error_measures import ErrorQuantity
from mbdsl.studies.figure_parts import on_front
from mbdsl.studies.report import Study, number, outcomes, ratio, size, troubles
from mbdsl.studies.survey import Asked, Survey, SurveyRow, survey

SHOWN = ("q", "v", "reactions", "energy")
CHOICES = 3  #: number of methods listed for an error


class WorkPrecision(Study):
    """``front(key)`` are the rows that no other row beats in both error and time."""

    kind = "work-precision"
    timed = True
    score = staticmethod(on_front)

    def points(self, key: str) -> list[SurveyRow]:
        """Rows with a time and an error; errors below the reference's resolution are set to it."""
        q = self.survey.quantity(key)
        if q is None:
            return []
        floor = self.survey.reference.floor(q)
        found = []
        for row in self.survey.rows:
            if row.run.done and row.seconds:
                e = row.errors[key]
                known = floor if e.scaled < floor.scaled else e
                if known.scaled > 0.0:
                    found.append(replace(row, errors={**row.errors, key: known}))
        return found

    def front(self, key: str) -> list[SurveyRow]:
        return front(self.points(key), key)

    def shown(self) -> list[ErrorQuantity]:
        return [q for q in self.survey.quantities if q.key in SHOWN or (not q.itself and q.key == q.label)]

    def summary(self) -> list[str]:
        s = self.survey
        lines = [
            *self._answer(),
            trusted(s),
            f"Times are of the step loops alone: medians of {rounds(s.rows)} in which methods alternate, "
            "in each the least of three short runs; the spread is that of the middle half.",
        ]
        untimed = sum(row.run.done and not row.seconds for row in s.rows)
        if untimed:
            lines.append(f"{untimed} cases were not timed, as the budget was spent; shorter runs are timed first.")
        return lines + troubles(s)

    def _answer(self) -> list[str]:
        """The fastest method for each error, in a sentence, and how many cases it was chosen from."""
        found: list[tuple[str, list[int]]] = []
        key = next((q.key for q in self._read()), "")
        for k, best in self._decades(key):
            if found and found[-1][0] == best[0].case.series:
                found[-1][1].append(k)
            else:
                found.append((best[0].case.series, [k]))
        if not found:
            return []
        label = next(q.label for q in self._read())
        each = (f"{name} for {f'1e-{ks[0]}' if len(ks) == 1 else f'1e-{ks[0]} to 1e-{ks[-1]}'}" for name, ks in found)
        rows = self.survey.rows
        timed, every = sum(bool(row.seconds) for row in rows), len(rows)
        which = "" if timed == every else f", of the {timed} of {every} cases that were run and timed"
        return [f"Least time for an error in {label}: {', '.join(each)}{which}."]

    def tables(self) -> list[TextTable]:
        return [*(self._read_out(q) for q in self._read()), self._all()]

    def answers(self) -> int:
        return min(1, len(self._read()))

    def _read(self) -> list[ErrorQuantity]:
        """The quantities for whose errors the least times are listed."""
        return [q for q in self.shown() if q.key in ("q", "reactions") or q.key == q.label]

    def _decades(self, key: str) -> list[tuple[int, list[SurveyRow]]]:
        """(k, the fastest row of each series with an error of 10^-k), where there is one."""
        points = self.points(key)
        found = ((k, cheapest(points, key, 10.0**-k)) for k in range(1, 13))
        return [(k, best) for k, best in found if best]

    def _all(self) -> TextTable:
        shown = self.shown()
        rows = []
        for r in self.survey.rows:
            if r.run.problem:
                rows.append((r.case.series, size(r), "", "", "", *[r.run.word] * len(shown)))
                continue
            time, spread = (duration(median(r.seconds)), _spread(r.seconds)) if r.seconds else ("", "")
            errors = (cell(self.survey, q, r) for q in shown)
            rows.append((r.case.series, size(r), str(r.run.stats["steps"]), time, spread, *errors))
        columns = ("method", "step or tol", "steps", "time", "spread", *(q.key for q in shown))
        return TextTable("Error and time", columns, rows, f"Errors: {BRACKETS}")

    def _read_out(self, q: ErrorQuantity) -> TextTable:
        rows = []
        for k, best in self._decades(q.key):
            first, others = best[0], best[1:CHOICES]
            ratios = [f"{o.case.series} {ratio(median(o.seconds), median(first.seconds))}" for o in others]
            rows.append((f"1e-{k}", first.case.series, size(first), duration(median(first.seconds)), ", ".join(ratios)))
        columns = ("error", "cheapest", "with", "takes", "then, and how many times as long")
        return TextTable(f"Least time for an error in {q.label}", columns, rows)

    def figures(self) -> list[Figure]:
        return [self._figure(q) for q in self.shown()]

    def _figure(self, q: ErrorQuantity) -> Figure:
        points, series = self.points(q.key), []
        best = self.front(q.key)
        if len(best) > 1:
            x, y = [r.errors[q.key].scaled for r in best], [median(r.seconds) for r in best]
            series.append(Series("least time", x, y, style="front", hover=[str(r.case) for r in best]))
        for name, rows in self.survey.series().items():
            cases = {row.case for row in rows}
            own = [r for r in points if r.case in cases]
            if own:
                series.append(
                    Series(
                        name,
                        [r.errors[q.key].scaled for r in own],
                        [median(r.seconds) for r in own],
                        [quartiles(r.seconds)[0] for r in own],
                        [quartiles(r.seconds)[1] for r in own],
                        [
                            f"{r.case}: {number(r.errors[q.key].scaled, 3)} in {duration(median(r.seconds))}"
                            for r in own
                        ],
                    )
                )
        floor = self.survey.reference.floor(q).scaled
        times = [median(r.seconds) for r in points]
        note = "Further left is more accurate, further down is faster."
        if any(r.errors[q.key].scaled == floor for r in points):
            note += " Points on the line have errors below the resolution of the reference."
            series.append(Series("the references differ", [floor, floor], [min(times), max(times)], style="guide"))
        problems = [type(o)(o.name, None, f"{o.x:g}: {o.text}") for o in outcomes(self.survey.rows)]
        key = q.key.replace("[", "").replace("]", "").replace(".", "_")
        return Figure(
            key,
            f"Work and precision: {q.label}",
            f"error in {q.label}, largest over time, scaled",
            "time [s]",
            series,
            outcomes=problems,
            note=note,
        )


def work_precision(model: Scene | str | PathLike, **asked: Any) -> WorkPrecision:
    """Measure the errors and run times of methods as functions of the step size and the tolerance.

    Parameters
    ----------
    model, **asked
        As for ``convergence``.

    Returns
    -------
    WorkPrecision

    Raises
    ------
    MbdslError
        If the model or the arguments are invalid, or no reference solution is found.
    """
    found = survey(model, Asked(**asked), both=True, timed=True)
    time_rows(found)
    return WorkPrecision(found)


def time_rows(found: Survey) -> None:
    """Measure the times of all complete runs."""
    rows = {row.case: row for row in found.rows if row.run.done}
    times = found.runner.time(
        list(rows), found.asked.repeats, lambda case: rows[case].run.stats["seconds"]["integrate"]
    )
    for case, seconds in times.items():
        rows[case].seconds = seconds


def rounds(rows: Sequence[SurveyRow]) -> str:
    """The number of rounds with times as text; smaller than requested if time was short."""
    counts = {len(row.seconds) for row in rows if row.seconds} or {0}
    text = f"{min(counts)} to {max(counts)}" if len(counts) > 1 else f"{max(counts)}"
    return f"{text} round{'' if counts == {1} else 's'}"


def front(rows: Sequence[SurveyRow], key: str) -> list[SurveyRow]:
    """Rows that no other row beats in both error and time, in the order of decreasing error."""
    found, least = [], math.inf
    for row in sorted(rows, key=lambda r: (median(r.seconds), r.errors[key].scaled)):
        if row.errors[key].scaled < least:
            least = row.errors[key].scaled
            found.append(row)
    return found


def cheapest(rows: Sequence[SurveyRow], key: str, error: float) -> list[SurveyRow]:
    """The row of each series that takes the least time for an error, the fastest first."""
    best: dict[str, SurveyRow] = {}
    for row in rows:
        if row.errors[key].scaled <= error:
            own = best.setdefault(row.case.series, row)
            if median(row.seconds) < median(own.seconds):
                best[row.case.series] = row
    return sorted(best.values(), key=lambda r: median(r.seconds))


def quartiles(seconds: Sequence[float]) -> tuple[float, float]:
    """Lower and upper quartile."""
    low, high = np.percentile(seconds, (25, 75))
    return float(low), float(high)


def _spread(seconds: Sequence[float]) -> str:
    """The interquartile range relative to the median."""
    low, high = quartiles(seconds)
    return f"{100 * (high - low) / median(seconds):.0f} %" if len(seconds) > 1 else ""
