"""mbdsl beside MuJoCo and Exudyn on the pendulum chain: least time for an error in angles.

    python tests/benchmarks/against_mujoco.py [--only LINKS] [--repeats 5] [--methods radau5,...] [--output FOLDER]

The default, ``METHODS``, takes some minutes; ``--methods all`` compares every installed method of mbdsl and takes much
longer. The table of methods has the time of each of them relative to MuJoCo's, and that of the run that ``--accuracy``
chooses, without the runs of its search and its check.

Chains of 2, 8 and 64 links swing for 1 s. Every program runs with all its settings (:mod:`chain_programs`), with steps
halved, or tolerances reduced, until the error in angles is below 1e-10. Then the runs that are not much slower than
another run of the same program, or method of mbdsl, with a smaller error are timed in rounds, in which all programs
alternate in one process and one thread; the least time of all rounds counts. Of each setting, time is interpolated over
error, both as logarithms, and the fastest setting at an error counts. Times of mbdsl with ``--tol`` include the
calibration runs.

All errors are against one reference, which none of the programs made. A program describes the same mechanism if its
errors fall below ``SAME``; Exudyn's implicit solvers, of order 2, do not come so far within ``PATIENCE``, and where
errors are not reached, the time of the most accurate run is a lower bound.

Nothing is asserted: times belong to a machine and an hour. With ``--output docs/work-precision`` the pictures and
numbers are written, and the tables of docs/work-precision.md.
"""

from __future__ import annotations

import argparse
import json
import math
import os
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # idle BLAS threads spin, which counts as processor time

from chain_programs import PROGRAMS, Reference, Series, all_series, chosen, mbdsl_run, missing
from doc_parts import ROOT, markdown, put
from work_precision import at

from mbdsl.messages import duration
from mbdsl.plotting.figures import Figure, TextTable
from mbdsl.plotting.figures import Series as Drawn
from mbdsl.plotting.pictures import draw
from mbdsl.plotting.sheets import sheet
from mbdsl.studies.report import as_text, number
from mbdsl.studies.runner import SHORT, TRIES

LINKS = (2, 8, 64)
METHODS = ("dop853", "radau13", "radau9", "radau5", "hht-si2")
PAGE = ROOT / "docs" / "work-precision.md"
DECADES = tuple(range(4, 11))  #: errors 1e-4 ... 1e-10
CHOSEN = (4, 7, 10)  #: accuracies for which ``--accuracy`` chooses
TARGET = 1.0 / 3.0  #: of the time of another program
#: seconds of a run, above which a program is not refined further
PATIENCE = {**dict.fromkeys(PROGRAMS, 1.5), "Exudyn implicit": 0.4}
SAME = 1e-10  #: error below which a program has solved the same equations
LONG = 0.2  #: seconds above which a run is timed in the first round only
WORSE = 2.0  #: runs that take more than this times the time of a more accurate run are not timed


@dataclass
class Run:
    """One run of a setting: its error, and its seconds in each round."""

    series: Series
    size: float
    error: float
    seconds: list[float] = field(default_factory=list)

    @property
    def least(self) -> float:
        return min(self.seconds)


@dataclass
class Choice:
    """The run that ``--accuracy`` chooses for an accuracy: its setting, seconds and error."""

    name: str
    seconds: float
    error: float


@dataclass
class Chain:
    """The measurements of one chain."""

    links: int
    floor: float  #: difference of two references
    runs: list[Run]
    choices: dict[int, Choice] = field(default_factory=dict)  #: decade -> choice

    def of(self, program: str) -> list[Run]:
        return [run for run in self.runs if run.series.program == program]

    def at(self, program: str, error: float) -> tuple[float, str]:
        """The least seconds of a program for an error, and its setting; not a number if no run reaches it."""
        found = (math.nan, "")
        for name in dict.fromkeys(run.series.name for run in self.of(program)):
            own = front([run for run in self.of(program) if run.series.name == name])
            seconds = at(error, [run.error for run in own], [run.least for run in own])
            if not seconds >= found[0] and math.isfinite(seconds):
                found = (seconds, name)
        return found

    def longest(self, program: str) -> float:
        """Seconds of the most accurate run."""
        return min(self.of(program), key=lambda run: run.error).least

    @property
    def void(self) -> list[str]:
        """Programs that did not come to the reference."""
        least = {name: min((run.error for run in self.of(name)), default=math.nan) for name in PROGRAMS[:3]}
        return [f"{name} differs by {error:.0e}" for name, error in least.items() if error > SAME]


def front(runs: Sequence[Run]) -> list[Run]:
    """The runs that no other run beats in both error and time, large errors first."""
    kept: list[Run] = []
    for run in sorted(runs, key=lambda run: (run.least, run.error)):
        if not kept or run.error < kept[-1].error:
            kept.append(run)
    return kept


def explore(every: Sequence[Series], least: float) -> list[Run]:
    """Refine every setting until its error is ``least``, or until it takes longer than another one for that."""
    found: list[Run] = []
    enough = dict(PATIENCE)
    for series in sorted(every, key=lambda series: -series.order):
        errors: list[float] = []
        for size in series.sizes:
            seconds, error = series.run(size)
            if math.isfinite(error):
                found.append(Run(series, size, error, [seconds]))
            if error < least:
                enough[series.program] = min(enough[series.program], seconds)
            errors.append(error)
            stuck = len(errors) > 3 and 0.7 * errors[-2] < error < 1e-3
            if error < least or stuck or seconds > enough[series.program]:
                break
    return found


def worth(runs: Sequence[Run]) -> list[Run]:
    """Without the runs that are much slower than a more accurate run of the same program, or method of mbdsl."""

    def of(run: Run) -> str:
        return run.series.name if run.series.program == "mbdsl" else run.series.program

    def beaten(run: Run) -> bool:
        same = (other for other in runs if of(other) == of(run))
        return any(other.error <= run.error and WORSE * other.least < run.least for other in same)

    return [run for run in runs if not beaten(run)]


def choices(reference: Reference, decades: Sequence[int], repeats: int) -> dict[int, Choice]:
    """The choices of ``--accuracy``; without those accuracies that it does not reach."""
    found = {}
    for k in (k for k in decades if k in CHOSEN):
        case = chosen(reference, 10.0**-k)
        if case is not None:
            runs = [mbdsl_run(reference, *case) for _ in range(repeats)]
            name = case[0] if case[2] is None else f"{case[0]} --tol"
            found[k] = Choice(name, min(seconds for seconds, _ in runs), runs[0][1])
    return found


def compare(
    links: int, repeats: int, methods: Sequence[str] | None = METHODS, decades: Sequence[int] = DECADES
) -> Chain:
    """All programs on one chain."""
    reference = Reference(links)
    floor = reference.error(Reference(links, 10.0 * reference.tol).angles)
    runs = worth(explore(list(all_series(reference, methods)), 10.0 ** -max(decades)))
    long = {id(run) for run in runs if run.least > LONG}
    for run in runs:
        run.seconds = []
    for k in range(repeats):
        for run in runs:
            if k > 0 and id(run) in long:
                continue
            tries: list[float] = []
            while len(tries) < TRIES and (not tries or sum(tries) < SHORT):
                tries.append(run.series.run(run.size)[0])
            run.seconds.append(min(tries))
    return Chain(links, floor, runs, choices(reference, decades, repeats))


def table(chain: Chain, decades: Sequence[int] = DECADES) -> TextTable:
    """The table: times of mbdsl, and of the other programs with their ratios to these."""
    rows = []
    others = [name for name in PROGRAMS[1:] if chain.of(name)]
    for error in (10.0**-k for k in decades):
        own, name = chain.at("mbdsl", error)
        cells = [number(error, 1), name, duration(own) if math.isfinite(own) else ""]
        for program in others:
            seconds, _ = chain.at(program, error)
            bound = "" if math.isfinite(seconds) else "> "
            seconds = seconds if bound == "" else chain.longest(program)
            ratio = f" ({bound}{float(f'{seconds / own:.2g}'):,.4g})" if math.isfinite(own) else ""
            cells.append(f"{bound}{duration(seconds)}{ratio}")
        rows.append(tuple(cells))
    title = f"Least time for an error in angles, chain of {chain.links} links, 1 s (in brackets: relative to mbdsl)"
    return TextTable(title, ("error", "mbdsl, by", "takes", *others), rows)


def methods_table(chain: Chain, decades: Sequence[int] = DECADES) -> TextTable:
    """Times of the settings of mbdsl, and of the choices of ``--accuracy``, relative to MuJoCo's."""
    names = list(dict.fromkeys(run.series.name for run in chain.of("mbdsl")))
    columns = {name: front([run for run in chain.of("mbdsl") if run.series.name == name]) for name in names}
    rows = []
    for k in decades:
        error = 10.0**-k
        other = chain.at("MuJoCo", error)[0] if chain.of("MuJoCo") else math.nan
        cells = []
        for runs in columns.values():
            ratio = at(error, [run.error for run in runs], [run.least for run in runs]) / other
            cells.append(f"{ratio:.2g}" if math.isfinite(ratio) else "")
        choice = chain.choices.get(k)
        cells.append("" if choice is None else f"{choice.seconds / other:.2g}, {choice.name}, {choice.error:.0e}")
        rows.append((number(error, 1), *cells))
    title = f"Chain of {chain.links} links: time of mbdsl relative to MuJoCo's at equal error"
    return TextTable(title, ("error", *names, "--accuracy: time, choice, error"), rows)


def verdicts(chain: Chain, decades: Sequence[int] = DECADES) -> list[str]:
    """For each other program, whether mbdsl takes at most ``TARGET`` of its time at every error."""
    lines = [f"VOID: {text}" for text in chain.void]
    for program in PROGRAMS[1:]:
        if not chain.of(program):
            continue
        ratios, unknown = {}, []
        for k in decades:
            own, other = chain.at("mbdsl", 10.0**-k)[0], chain.at(program, 10.0**-k)[0]
            ratio = own / (other if math.isfinite(other) else chain.longest(program))
            if math.isfinite(ratio):
                ratios[k] = ratio
            else:
                unknown.append(k)
        if ratios:
            worst = max(ratios, key=ratios.__getitem__)
            met = "met" if ratios[worst] <= TARGET and not unknown else "MISSED"
            text = ", ".join(f"1e-{k} {ratio:.2g}" for k, ratio in ratios.items() if ratio > TARGET)
            more = f"; above it at {text}" if text else ""
            lines.append(f"time over {program}'s: at most {ratios[worst]:.2g}, at 1e-{worst}; {TARGET:.2f} {met}{more}")
        if unknown:
            lines.append(f"mbdsl does not reach {', '.join(f'1e-{k}' for k in unknown)}")
    return lines


def points(chain: Chain) -> list[dict]:
    """All timed runs, for the picture and its page."""
    return [
        {
            "program": run.series.program,
            "series": run.series.name,
            "size": run.size,
            "error": run.error,
            "seconds": run.least,
        }
        for run in chain.runs
    ]


def picture(links: int, points: Sequence[dict]) -> Figure:
    """Run time over error: the fastest runs of each program."""
    series = []
    for program in PROGRAMS:
        best: list[dict] = []
        for point in sorted((p for p in points if p["program"] == program), key=lambda p: (p["seconds"], p["error"])):
            if not best or point["error"] < best[-1]["error"]:
                best.append(point)
        if best:
            name = " of ".join(program.split()[::-1])  # the first word decides the mark
            series.append(Drawn(name, [p["error"] for p in best], [p["seconds"] for p in best]))
    note = "Further left is more accurate, further down is faster."
    return Figure(f"chain_{links}", f"Chain of {links} links", "error in angles [rad]", "time [s]", series, note=note)


def written(chain: Chain, folder: Path) -> dict[str, str]:
    """Write the picture and the numbers; the part of the page."""
    folder.mkdir(parents=True, exist_ok=True)
    read_out, name = table(chain), f"chain_{chain.links}"
    figure = picture(chain.links, points(chain))
    draw(sheet(figure.title, [figure]), folder / f"{name}.png")
    cells = [list(row) for row in read_out.rows]
    numbers = {"columns": list(read_out.columns), "table": cells, "points": points(chain)}
    (folder / f"{name}.json").write_text(json.dumps(numbers, indent=1) + "\n", encoding="utf-8")
    return {name: markdown(read_out.columns, read_out.rows)}


def report(chain: Chain, decades: Sequence[int] = DECADES) -> str:
    """Everything about one chain as text."""
    closest = (f"{name} {min(run.error for run in own):.0e}" for name in PROGRAMS if (own := chain.of(name)))
    least = f"references differ by {chain.floor:.0e}; least errors: {', '.join(closest)}"
    own = as_text(methods_table(chain, decades))
    return "\n".join([as_text(table(chain, decades)), least, *verdicts(chain, decades), "", own])


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--only", metavar="LINKS", type=int, help="one chain")
    parser.add_argument("--repeats", type=int, default=5)
    parser.add_argument("--methods", default=",".join(METHODS), help="methods of mbdsl, or all; default: %(default)s")
    parser.add_argument("--output", metavar="FOLDER", type=Path, help="where pictures and numbers go")
    given = parser.parse_args()
    for package, command in missing().items():
        print(f"{package} is not installed and left out: {command}")
    for links in LINKS if given.only is None else (given.only,):
        chain = compare(links, given.repeats, None if given.methods == "all" else given.methods.split(","))
        print(f"\n{report(chain)}", flush=True)
        if given.output is not None:
            made = written(chain, given.output)
            if given.output.resolve() == PAGE.with_suffix(""):
                put(PAGE, made)
