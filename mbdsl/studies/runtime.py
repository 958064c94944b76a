"""Run time: time of a step and of a simulated second with every method, relative to HHT-I3."""

from __future__ import annotations

from collections.abc import Sequence
from os import PathLike
from statistics import median
from typing import Any

import numpy as np

from mbdsl.mechanism.scene import Scene
from mbdsl.messages import count, duration
from mbdsl.plotting.figures import Bar, Bars, Figure, Series, TextTable
from mbdsl.studies.reference_solution import ReferenceSolution
from mbdsl.studies.report import Study, outcomes, size, troubles
from mbdsl.studies.survey import TIMING, Asked, Survey, SurveyRow, begin
from mbdsl.studies.work_precision import quartiles, rounds, time_rows

BASE = "hht-i3"
TOLS = (1e-6,)


class Runtime(Study):
    """Ratios are medians over rounds; in each round every method is run once."""

    kind = "runtime"
    timed = True

    def summary(self) -> list[str]:
        s = self.survey
        lines = []
        if any(row.seconds for row in s.rows):
            lines.append(f"Times of the step loops alone, medians of {rounds(s.rows)} in which methods alternate.")
        untimed = sum(row.run.done and not row.seconds for row in s.rows)
        if untimed:
            cases = count(untimed, "case was", "cases were")
            lines.append(f"{cases} not timed, as the budget of {s.asked.budget:g} s was spent.")
        return lines + troubles(s)

    def ratios(self, row: SurveyRow) -> list[float]:
        """Times relative to HHT-I3 at the same step, round by round; at its first step if it has no such step."""
        others = [r for r in self.survey.rows if r.case.method == BASE and r.seconds]
        base = next((r for r in others if r.case.step == row.case.step), others[0] if others else None)
        return [] if base is None else [a / b for a, b in zip(row.seconds, base.seconds, strict=False)]

    def records(self) -> list[dict]:
        found = super().records()
        for record, row in zip(found, self.survey.rows, strict=True):
            if row.seconds:
                seconds, ratios = median(row.seconds), self.ratios(row)
                record["seconds a step"] = seconds / max(1, row.run.stats["steps"])
                record["seconds a simulated second"] = seconds / self.survey.setting.span
                record[f"relative to {BASE}"] = median(ratios) if ratios else None
        return found

    def tables(self) -> list[TextTable]:
        rows = []
        for row in self.survey.rows:
            if not row.seconds:
                word = "not timed" if row.run.done else row.run.word
                rows.append((row.case.series, size(row), "", word, "", "", "", ""))
                continue
            stats, seconds, ratios = row.run.stats, median(row.seconds), self.ratios(row)
            steps = max(1, stats["steps"])
            relative = spread = ""
            if ratios:
                low, high = np.percentile(ratios, (25, 75))
                relative, spread = f"{median(ratios):.2f}", f"{low:.2f} to {high:.2f}"
            rows.append(
                (
                    row.case.series,
                    size(row),
                    str(stats["steps"]),
                    duration(seconds / steps),
                    duration(seconds / self.survey.setting.span),
                    relative,
                    spread,
                    f"{stats['iterations'] / steps:.2f}",
                )
            )
        columns = ("method", "step or tol", "steps", "a step", "a second", f"to {BASE}", "middle half", "iterations")
        return [TextTable("Run time", columns, rows, "`a second`: of simulated time; `iterations`: a step.")]

    def figures(self) -> Sequence[Figure | Bars]:
        timed = [row for row in self.survey.rows if row.seconds]
        if len({row.case.series for row in timed}) == len(timed) > 1:
            return [self._bars(sorted(timed, key=lambda row: median(row.seconds)))]
        series = []
        for name, rows in self.survey.series().items():
            done = [row for row in rows if row.seconds]
            span = self.survey.setting.span
            y = [median(row.seconds) / span for row in done]
            low, high = ([quartiles(row.seconds)[k] / span for row in done] for k in (0, 1))
            counts = [row.run.stats["steps"] for row in done]
            hover = [f"{row.case}: {duration(t)} a second" for row, t in zip(done, y, strict=True)]
            series.append(Series(name, counts, y, low, high, hover))
        problems = [type(o)(o.name, None, o.text) for o in outcomes(self.survey.rows)]
        return [Figure("time", "Run time", "steps", "time of a simulated second [s]", series, outcomes=problems)]

    def _bars(self, rows: Sequence[SurveyRow]) -> Bars:
        """One time for each series, the shortest first."""
        span, bars = self.survey.setting.span, []
        for row in rows:
            low, high = (x / span for x in quartiles(row.seconds))
            t = median(row.seconds) / span
            bars.append(Bar(row.case.series, t, f"{duration(t)} ({size(row)})", low, high))
        note = "Hollow bars are runs with a tolerance, solid bars are runs with fixed steps."
        return Bars("time", "Run time", "time of a simulated second [s]", bars, note)


def runtime(model: Scene | str | PathLike, **asked: Any) -> Runtime:
    """Measure the run times of methods, by default at the model's own step.

    No reference solution is computed.

    Parameters
    ----------
    model, **asked
        As for ``convergence``.

    Returns
    -------
    Runtime

    Raises
    ------
    MbdslError
        If the model or the arguments are invalid.
    """
    given = Asked(**asked)
    runner, every, refused = begin(model, given, few=((1.0,), TOLS))
    with runner.reserving(TIMING * runner.budget):
        runs = runner.compute(every)
    rows = [SurveyRow(case, runs[case]) for case in every]
    found = Survey(runner.setting, given, runner, rows, refused, ReferenceSolution.none(), [])
    time_rows(found)
    return Runtime(found)
