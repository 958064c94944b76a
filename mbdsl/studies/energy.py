"""Energy: its loss or gain with every method, as a function of time and of the step.

If the model conserves energy, errors are relative to the initial value; else to the reference.
"""

from __future__ import annotations

from os import PathLike
from typing import Any

import numpy as np

from mbdsl.errors import UsageError
from mbdsl.kernels.arrays import Array
from mbdsl.mechanism.scene import Scene
from mbdsl.plotting.figures import Figure, Series, TextTable
from mbdsl.studies.convergence import trusted
from mbdsl.studies.error_measures import matching
from mbdsl.studies.report import Study, number, outcomes, size, troubles
from mbdsl.studies.slopes import Fit
from mbdsl.studies.survey import Asked, Survey, SurveyRow, finite, measure, prepare

PARTS = (4.0, 2.0, 1.0, 0.5, 0.25)  #: relative to the step of the model
TOLS = (1e-4, 1e-5, 1e-6, 1e-7, 1e-8)


class Energy(Study):
    """``conserved`` decides whether errors are relative to the initial energy or to the reference."""

    kind = "energy"

    def __init__(self, survey: Survey) -> None:
        super().__init__(survey)
        q = survey.quantity("energy")
        if q is None:
            raise UsageError(
                "the reference has no energies", hint="energy.kinetic, .potential and .total are looked at"
            )
        self.exchanged = 1.0 / q.weights[0]
        self.conserved = survey.conserved
        self.floor = 0.0 if self.conserved else survey.reference.floor(q).largest

    def error(self, row: SurveyRow) -> tuple[Array, Array]:
        """Times (N,) [s] and the error of the energy there (N,) [J], with its sign.

        The times are ends of steps if the energy is conserved, else those that all runs have in common.
        """
        if self.conserved:
            assert row.own is not None
            E = row.own["energy.total"]
            return row.own.t, E - E[0]
        assert row.trajectory is not None
        E, other = row.trajectory["energy.total"], self.survey.reference.solution
        return other.t, E[matching(row.trajectory.t, other.t)] - other["energy.total"]

    def mean(self, row: SurveyRow) -> float:
        """The mean over time of its absolute value [J], weighted by the step sizes."""
        t, e = self.error(row)
        if len(t) < 2:
            return float(np.abs(e).mean())
        return float(np.diff(t) @ (np.abs(e[1:]) + np.abs(e[:-1])) / (2.0 * (t[-1] - t[0])))

    def shown(self, error: float) -> str:
        """An error [J] as text; below the resolution of the reference in brackets."""
        return number(error) if error >= self.floor else f"({number(error)})"

    def slope(self, rows: list[SurveyRow]) -> Fit | None:
        return self.survey.fitted(rows, self.mean, self.floor)

    def records(self) -> list[dict]:
        found = super().records()
        for record, row in zip(found, self.survey.rows, strict=True):
            if row.run.done:
                _, e = self.error(row)
                record |= {"energy mean": self.mean(row), "energy lost at end": -float(e[-1])}
        return found

    def summary(self) -> list[str]:
        s = self.survey
        what = "Energy is conserved: errors are differences from its initial value."
        if not self.conserved:
            what = "Energy is not conserved: errors are differences from the reference."
        lines = [f"{what} Between kinds of energy, {self.exchanged:.4g} J are exchanged.", trusted(s)]
        return lines + troubles(s)

    def tables(self) -> list[TextTable]:
        rows = []
        for name, series in self.survey.series().items():
            slope = self.slope(series)
            for row in series:
                shown = str(slope) if slope and row is series[-1] else ""
                if row.run.problem:
                    rows.append((name, size(row), row.run.word, "", "", "", shown))
                    continue
                _, e = self.error(row)
                largest = float(np.abs(e).max())
                share = number(largest / self.exchanged)
                rows.append(
                    (
                        name,
                        size(row),
                        self.shown(self.mean(row)),
                        self.shown(largest),
                        share if largest >= self.floor else f"({share})",
                        f"{e[-1]:+.1e}".replace("e-0", "e-"),
                        shown,
                    )
                )
        columns = ("method", "step or tol", "mean [J]", "largest [J]", "of exchanged", "at end [J]", "slope of mean")
        note = "A slope is in the last row of its method."
        note += " In brackets: below the resolution of the reference." if self.floor else ""
        return [TextTable("Error in energy", columns, rows, note)]

    def figures(self) -> list[Figure]:
        over_time, over_size = [], {False: [], True: []}
        for name, rows in self.survey.series().items():
            done = [row for row in rows if row.run.done]
            if not done:
                continue
            t, e = self.error(done[0])
            over_time.append(Series(f"{name}, {size(done[0])}", t.tolist(), e.tolist(), style="line"))
            y = [mean if mean >= self.floor else float("nan") for mean in map(self.mean, done)]
            hover = [f"{row.case}: {number(self.mean(row), 3)} J" for row in done]
            controlled = rows[0].case.tol is not None
            over_size[controlled].append(Series(name, [row.case.size for row in done], finite(y), hover=hover))
        found = [
            Figure(
                "time",
                "Error in energy over time",
                "t [s]",
                "error of E(t) [J]",
                over_time,
                x_log=False,
                y_log=False,
            )
        ]
        floors = [(self.floor, "the references differ")] if self.floor > 0.0 else []
        for controlled, series in over_size.items():
            if series:
                problems = [
                    o for r in self.survey.rows if (r.case.tol is not None) == controlled for o in outcomes([r])
                ]
                found.append(
                    Figure(
                        "tol" if controlled else "step",
                        "Mean error in energy",
                        "tolerance" if controlled else "step [s]",
                        "mean over time [J]",
                        series,
                        outcomes=problems,
                        floors=floors,
                    )
                )
        return found


def energy(model: Scene | str | PathLike, **asked: Any) -> Energy:
    """Measure the energy errors of methods, by default at a few steps around the model's own.

    Parameters
    ----------
    model, **asked
        As for ``convergence``.

    Returns
    -------
    Energy

    Raises
    ------
    MbdslError
        If the model or the arguments are invalid, or no reference solution is found.
    """
    return Energy(measure(prepare(model, Asked(**asked), few=(PARTS, TOLS))))
