"""Drift: violation of the constraints of positions and velocities, as a function of time and of the step."""

from __future__ import annotations

from os import PathLike
from typing import Any

from mbdsl.errors import IntegrationError, UsageError
from mbdsl.mechanism.scene import Scene
from mbdsl.plotting.figures import Figure, Series, TextTable
from mbdsl.studies.convergence import error_figures
from mbdsl.studies.error_measures import error, over_time, quantities
from mbdsl.studies.reference_solution import ReferenceSolution
from mbdsl.studies.report import Study, number, size, troubles
from mbdsl.studies.survey import Asked, Survey, begin, error_in, finite, rows_of

PARTS = (4.0, 2.0, 1.0, 0.5)  #: relative to the step of the model
TOLS = (1e-4, 1e-6, 1e-8)


class Drift(Study):
    """The errors are the residuals of the constraints at the ends of steps."""

    kind = "drift"

    def summary(self) -> list[str]:
        s = self.survey
        lines = ["Largest violation of the constraints, in their own units [m, rad; m/s, rad/s]."]
        return lines + troubles(s)

    def tables(self) -> list[TextTable]:
        s = self.survey
        keys = [q.key for q in s.quantities]
        rows = []
        for name, series in s.series().items():
            for row in series:
                cells = [number(row.errors[key].largest) for key in keys] if row.run.done else [row.run.word]
                rows.append((name, size(row), *cells, *[""] * (2 * len(keys) - len(cells))))
            if any(row.run.done for row in series):
                slopes = [s.fitted(series, error_in(key, "largest")) for key in keys]
                rows.append((*rows.pop()[: 2 + len(keys)], *(str(f) if f else "" for f in slopes)))
        columns = ("method", "step or tol", *keys, *(f"slope of {key}" for key in keys))
        return [TextTable("Drift", columns, rows, "A slope is in the last row of its method.")]

    def figures(self) -> list[Figure]:
        s, found = self.survey, []
        for q in s.quantities:
            series = []
            for name, rows in s.series().items():
                row = next((r for r in rows if r.own is not None), None)
                if row is not None and row.own is not None:
                    y = over_time(q, row.own, row.own, scaled=False)
                    series.append(Series(f"{name}, {size(row)}", row.own.t.tolist(), finite(y.tolist()), style="line"))
            found.append(
                Figure(
                    f"{q.key}-time",
                    f"{q.label[0].upper()}{q.label[1:]} over time",
                    "t [s]",
                    f"largest violation [{q.unit}]",
                    series,
                    x_log=False,
                )
            )
            found += error_figures(s, q, scaled=False)
        return found


def drift(model: Scene | str | PathLike, **asked: Any) -> Drift:
    """Measure the constraint violations of methods, by default at a few steps around the model's own.

    No reference solution is computed.

    Parameters
    ----------
    model, **asked
        As for ``convergence``.

    Returns
    -------
    Drift

    Raises
    ------
    MbdslError
        If the model or the arguments are invalid.
    UsageError
        If the model has no constraints.
    IntegrationError
        If no run reaches its end.
    """
    given = Asked(**asked)
    runner, every, refused = begin(model, given, few=(PARTS, TOLS))
    reference = ReferenceSolution.none()
    if not quantities(runner.blank(), reference.solution):
        raise UsageError(
            f"{runner.setting.scene.name} has no constraints that a motion could leave",
            hint="`mbdsl study energy` and `convergence` measure errors without constraints",
        )
    rows = rows_of(runner, every)
    finest = next((row.own for row in reversed(rows) if row.own is not None), None)
    if finest is None:
        raise IntegrationError(f"no run was completed; {rows[0].case}: {rows[0].run.problem}")
    # the speed of the reference scales velocities
    found = Survey(runner.setting, given, runner, rows, refused, reference, [])
    found.quantities = [q for q in quantities(finest, finest) if q.itself]
    for row in rows:
        row.errors = {q.key: error(q, row.own, row.own) for q in found.quantities if row.own is not None}
    return Drift(found)
