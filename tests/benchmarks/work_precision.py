"""Run time over error: every method of mbdsl, and Exudyn if it is installed, on the same axes.

    python tests/benchmarks/work_precision.py [--only NAME] [--repeats 5] [--output FOLDER] [--redraw]

The work-precision study of the slider crank and of the seven body mechanism, with Exudyn's runs beside it: the same
model and start, the same times of comparison, the same reference, and runs that are timed in turn with ours in one
process. Exudyn solves by its generalised-alpha method and by its trapezoidal rule of index 2, with all options that
``against_exudyn.py`` tries, with its default tolerances of Newton's iteration and with tighter ones. Its curve consists
of the runs that no other run of Exudyn beats in both error and time. Its times begin with the second step, as described
there.

Nothing is asserted: times belong to a machine and an hour. With ``--output`` the pictures, pages and numbers are
written; with ``--output docs/work-precision`` the tables of docs/work-precision.md, too.
"""

from __future__ import annotations

import argparse
import importlib.util
import json
import math
import os
import warnings
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from statistics import median
from typing import Any

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # idle BLAS threads spin, which counts as processor time

import against_exudyn
import numpy as np
from against_exudyn import JUDGED, MODELS, WAYS, Ours, Theirs
from doc_parts import ROOT, markdown, put

from mbdsl.messages import duration
from mbdsl.plotting.figure_layout import looks_of
from mbdsl.plotting.figures import Figure, Page, Series, TextTable
from mbdsl.plotting.pages import write
from mbdsl.plotting.pictures import draw
from mbdsl.plotting.sheets import sheet
from mbdsl.studies.figure_parts import on_front, parts
from mbdsl.studies.report import as_text, number
from mbdsl.studies.runner import SHORT, TRIES
from mbdsl.studies.survey import Asked, SurveyRow, measure, prepare
from mbdsl.studies.work_precision import WorkPrecision

CASES = ("slider_crank", "seven_body")
PAGE = ROOT / "docs" / "work-precision.md"
DECADES = tuple(range(3, 11))  #: errors 1e-3 ... 1e-10
TIGHTER = (1.0, 1e-2)  #: factors on Exudyn's tolerances
SOLVERS = ("GeneralizedAlpha", "TrapezoidalIndex2")
PATIENCE = 20.0  #: seconds of one run of Exudyn, at most
LEVELS = 16  #: halvings of its step, at most


@dataclass
class Their:
    """Runs of Exudyn at one setting: its error (scaled, in positions) and the seconds that it took, each time."""

    label: str
    way: str
    solver: str
    tighter: float
    steps: int
    error: float
    seconds: list[float] = field(default_factory=list)


class Exudyn:
    """The model in Exudyn, with the output times of a study."""

    def __init__(self, study: Any) -> None:
        s = study.survey
        case = against_exudyn.Case(Path(s.setting.path).stem, s.setting.stop, s.setting.points, 1.0)
        self.exu, ours = against_exudyn.load(), Ours(case, s.setting.stop)
        self.program = Theirs(self.exu, ours, s.setting.points)
        self.true, self.scale, self.points = s.reference.solution.q[1:], ours.system.tables.scale, s.setting.points

    def run(self, solver: str, way: str, tighter: float, steps: int) -> tuple[float, float]:
        """Error and seconds; the error is infinite if the run fails."""
        self.program.solver = getattr(self.exu.DynamicSolverType, solver)
        seen = self.program.run(way, steps, tighter)
        error = float((np.abs(seen.states - self.true) * self.scale).max()) if seen.whole else math.inf
        return error if math.isfinite(error) else math.inf, seen.seconds

    def time(self, run: Their) -> float:
        """Seconds: the least of three runs if they are short, as for our methods."""
        tries: list[float] = []
        while len(tries) < TRIES and (not tries or sum(tries) < SHORT):
            tries.append(self.run(run.solver, run.way, run.tighter, run.steps)[1])
        return min(tries)

    def explore(self, least: float) -> list[Their]:
        """Halve the step until the error is ``least``, with all solvers and tolerances; return the runs that no other
        beats."""
        found = []
        for solver in SOLVERS:
            seconds = {way: self.run(solver, way, 1.0, 8 * self.points)[1] for way in WAYS}
            best = min(seconds, key=seconds.__getitem__)
            near = [way for way in WAYS if seconds[way] <= 1.3 * seconds[best] + JUDGED]
            for tighter in TIGHTER:
                for way in near if tighter == 1.0 else [best]:
                    for k in range(LEVELS):
                        steps = self.points * 2**k
                        error, spent = self.run(solver, way, tighter, steps)
                        label = f"{solver}, {way}, {steps} steps, tolerances x {tighter:g}"
                        if math.isfinite(error):
                            found.append(Their(label, way, solver, tighter, steps, error, [spent]))
                        stuck = k > 2 and len(found) > 1 and found[-1].error > 0.7 * found[-2].error and error < 1e-3
                        if error < least or stuck or spent > PATIENCE / 2:
                            break
        kept = front(found)
        for run in kept:
            run.seconds = []
        return kept


def front(runs: list[Their]) -> list[Their]:
    """The runs that no other run beats in both error and time, large errors first."""
    kept: list[Their] = []
    for run in sorted(runs, key=lambda r: (median(r.seconds), r.error)):
        if not kept or run.error < kept[-1].error:
            kept.append(run)
    return kept


def at(error: float, errors: list[float], seconds: list[float]) -> float:
    """Seconds at an error, along straight lines between logarithms; not a number outside; large errors come first."""
    if not errors or not min(errors) <= error:
        return math.nan
    if error >= max(errors):
        return seconds[0]
    x, y = np.log(errors[::-1]), np.log(seconds[::-1])
    return float(np.exp(np.interp(math.log(error), x, y)))


def compare(
    name: str, repeats: int, budget: float, stop: float | None = None, longest: float = math.inf, **asked: Any
) -> tuple[WorkPrecision, list[Their]]:
    """The study of one model, and Exudyn's runs, timed in turn; runs longer than ``longest`` [s] are timed once."""
    study = WorkPrecision(
        measure(
            prepare(
                MODELS / f"{name}.mbd", Asked(repeats=repeats, budget=budget, stop=stop, fresh=True, **asked), both=True
            )
        )
    )
    theirs, program = [], None
    if importlib.util.find_spec("exudyn") is not None:
        program = Exudyn(study)
        theirs = program.explore(10.0 ** -DECADES[-1])
    survey = study.survey
    done = [row for row in survey.rows if row.run.done]
    survey.runner.budget = math.inf  # the budget limits the runs, not the timing
    for k in range(repeats):
        timed = [row for row in done if k == 0 or median(row.seconds) <= longest]
        times = survey.runner.time([row.case for row in timed], k + 1, lambda case: 0.0)
        for row in timed:
            row.seconds = times.get(row.case, [])
        for run in theirs:
            if k == 0 or run.seconds[0] <= longest:
                run.seconds.append(program.time(run))
    return study, front(theirs)


def ratios(study: WorkPrecision, theirs: list[Their]) -> list[tuple[float, float, SurveyRow | None, float]]:
    """For each decade: the error, Exudyn's seconds, our cheapest run and its seconds there."""
    rows = study.front("q")
    errors, seconds = [r.errors["q"].scaled for r in rows], [median(r.seconds) for r in rows]
    found = []
    for k in DECADES:
        error = 10.0**-k
        near = next((r for r in rows if r.errors["q"].scaled <= error), None)
        other = at(error, [r.error for r in theirs], [median(r.seconds) for r in theirs])
        found.append((error, other, near, at(error, errors, seconds)))
    return found


def table(study: WorkPrecision, theirs: list[Their]) -> TextTable:
    """The read-out; where Exudyn's runs end earlier, its longest run is a lower bound."""
    cells, longest = [], median(theirs[-1].seconds) if theirs else math.nan
    for error, other, row, own in ratios(study, theirs):
        bound = "" if math.isfinite(other) else "> "
        other = other if math.isfinite(other) else longest
        times = [duration(own) if math.isfinite(own) else "", f"{bound}{duration(other)}" if theirs else ""]
        ratio = other / own
        times.append(f"{bound}{float(f'{ratio:.3g}'):,.4g}" if math.isfinite(ratio) else "")
        cells.append((number(error, 1), "" if row is None else row.case.series, *times))
    columns = ("error", "mbdsl, by", "takes", "Exudyn takes", "times as long")
    return TextTable("Least time for an error in positions", columns, cells)


def page(study: WorkPrecision, theirs: list[Their]) -> Page:
    """The study's page, with Exudyn in its figures."""
    own = study.page()
    rest = [x for x in own.items if isinstance(x, TextTable)]
    drawn = pictures(numbers(study, theirs)["points"])
    return Page(own.title, own.paragraphs, [table(study, theirs), *drawn, *rest], own.fine_print, looks_of(drawn))


def pictures(points: Sequence[dict]) -> list[Figure]:
    """Run time over error: the best series of each family and Exudyn, then all families."""
    names = list(dict.fromkeys(point["series"] for point in points))
    best: list[dict] = []
    for point in sorted((p for p in points if p["series"] != "Exudyn"), key=lambda p: (p["seconds"], p["error"])):
        if not best or point["error"] < best[-1]["error"]:
            best.append(point)
    every = [("least time of mbdsl", best, "front")]
    every += [(name, [p for p in points if p["series"] == name], "both") for name in names]
    series = [
        Series(name, [p["error"] for p in own], [p["seconds"] for p in own], style=style,
               hover=[f"{p['with']}: {number(p['error'], 3)} in {duration(p['seconds'])}" for p in own])
        for name, own, style in every
    ]  # fmt: skip
    x_label = "error in positions, largest over time, scaled"
    note = "Further left is more accurate, further down is faster."
    return parts(Figure("q", "Work and precision", x_label, "time [s]", series, note=note), on_front)


def numbers(study: WorkPrecision, theirs: list[Their]) -> dict:
    """The numbers from which docs/work-precision.md is made."""
    points = [
        {"series": r.case.series, "with": r.case.arguments, "error": r.errors["q"].scaled, "seconds": median(r.seconds)}
        for r in study.points("q")
    ]
    points += [{"series": "Exudyn", "with": r.label, "error": r.error, "seconds": median(r.seconds)} for r in theirs]
    return {"table": [list(row) for row in table(study, theirs).rows], "points": points, "facts": study.facts()}


def draw_best(points: Sequence[dict], path: Path) -> None:
    """The picture of docs/work-precision.md."""
    drawn = pictures(points)
    draw(sheet(drawn[0].title, drawn[:1], looks_of(drawn)), path)


def main(arguments: argparse.Namespace) -> None:
    for name in CASES:
        if arguments.only not in (None, name):
            continue
        if arguments.redraw:
            kept = json.loads((PAGE.with_suffix("") / f"{name}.json").read_text(encoding="utf-8"))
            draw_best(kept["points"], PAGE.with_suffix("") / f"{name}.png")
            continue
        study, theirs = compare(name, arguments.repeats, arguments.budget)
        read_out = table(study, theirs)
        print(f"\n{study.title}\n\n{as_text(read_out)}\n\n{study}\n", flush=True)
        if arguments.output is None:
            continue
        folder = Path(arguments.output)
        folder.mkdir(parents=True, exist_ok=True)
        made = page(study, theirs)
        write(made, folder / f"{name}.html")
        draw_best(numbers(study, theirs)["points"], folder / f"{name}.png")
        (folder / f"{name}.json").write_text(json.dumps(numbers(study, theirs), indent=1) + "\n", encoding="utf-8")
        if folder.resolve() == PAGE.with_suffix(""):
            put(PAGE, {name: markdown(read_out.columns, read_out.rows)})


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--only", metavar="NAME", choices=CASES, help="one model")
    parser.add_argument("--repeats", type=int, default=5)
    parser.add_argument("--budget", type=float, default=600.0, help="seconds that our runs of one model may take")
    parser.add_argument("--output", metavar="FOLDER", help="where pages, pictures and numbers go")
    parser.add_argument("--redraw", action="store_true", help="the pictures of the page, from its numbers")
    warnings.simplefilter("ignore", DeprecationWarning)  # Exudyn renames its items from time to time
    main(parser.parse_args())
