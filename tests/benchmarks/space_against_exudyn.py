"""mbdsl against Exudyn and MuJoCo on models in space, at equal step and at equal error, in one process and one thread.

    python tests/benchmarks/space_against_exudyn.py [--only NAME] [--repeats 3] [--write]

Exudyn runs its generalised-alpha solver with its default settings on nodes with rotation vectors (Lie group) and with
Euler parameters, with dense and sparse matrices and full and modified Newton iteration; the fastest counts. Of mbdsl
the fastest of hht-si2, hht-i3 and generalized-alpha-i3, which is Exudyn's method, counts, with the same damping. On the
chains of ball joints MuJoCo runs RK4, and of mbdsl dop853 counts, too. Times are processor times of the step loops
without the first step, alternately, the least of all repeats. The error is that of a point at the end, relative to the
size of the mechanism, against dop853 with small steps, which a run with half as many steps confirms. At equal error,
times are interpolated, both as logarithms. With ``--write`` the table of docs/space.md is written. Nothing is asserted:
times belong to a machine and an hour.
"""

from __future__ import annotations

import argparse
import os
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import numpy as np
from doc_parts import ROOT, markdown, put, spread
from numpy.typing import NDArray
from spatial_programs import CASES, WAYS, Case, Exudyn, mujoco_runs

Array = NDArray[np.float64]
Rows = dict[int, tuple[float, float]]  #: number of steps -> (error, seconds)
#: methods and their options: the damping of high frequencies is that of Exudyn's spectral radius of 0.9
METHODS = {"hht-si2": {"alpha": -1 / 19}, "hht-i3": {"alpha": -1 / 19}, "generalized-alpha-i3": {"rho": 0.9}}
#: a combination of nodes and solvers that is slower than the best at the largest step by this factor is not run again
HOPELESS = 1.5
SAME = 1e-3  #: error above which a program with its smallest step does not simulate the same mechanism
#: numbers of steps relative to those of Exudyn: of dop853, and of MuJoCo
LONG, SHORT = (1 / 8, 1 / 4, 1 / 2), (1 / 4, 1 / 2, 1, 2, 4)
PAGE = ROOT / "docs" / "space.md"


def ours(case: Case, steps: int, method: str = "hht-si2") -> tuple[Array, float]:
    """The point at the end, and seconds."""
    return case.ours(steps, method, METHODS.get(method, {}))


@dataclass
class Comparison:
    """The measurements of one case."""

    case: Case
    doubt: float  #: difference of two references, relative to the size
    rows: dict[str, Rows] = field(default_factory=dict)  #: program -> its rows
    failed: list[str] = field(default_factory=list)

    def others(self, program: str) -> dict[str, Rows]:
        """The runs of another program that come to the same motion."""
        found = {name: rows for name, rows in self.rows.items() if name.startswith(program)}
        return {name: rows for name, rows in found.items() if any(error < SAME for error, _ in rows.values())}

    def equal_step(self) -> float:
        """The part of Exudyn's time that its method takes with the smallest step."""
        steps, theirs = self.case.steps[-1], self.others("Exudyn").values()
        own = self.rows["generalized-alpha-i3"][steps][1]
        return own / min(rows[steps][1] for rows in theirs) if theirs else np.nan

    def equal_error(self) -> list[float]:
        """Parts of Exudyn's time at errors that both have."""
        return at_equal_error([self.rows[method] for method in METHODS], list(self.others("Exudyn").values()))

    def against_mujoco(self) -> list[float]:
        """Parts of MuJoCo's time at errors that both have."""
        own = [self.rows[method] for method in (*METHODS, "dop853")]
        return at_equal_error(own, list(self.others("MuJoCo").values()), 4)

    def lines(self) -> list[str]:
        lines = [f"{self.case.name}: microseconds a step, and error; references differ by {self.doubt:.0e}"]
        for name, rows in self.rows.items():
            cells = [f"{1e6 * s / n:8.2f} {e:8.1e}" for n, (e, s) in rows.items()]
            lines.append(f"  {name:42} {'   '.join(cells)}")
        lines += [f"  {text}" for text in self.failed]
        lines.append(f"  Exudyn, equal step: {self.equal_step():.3f}; equal error: {parts(self.equal_error())}")
        if self.case.links:
            lines.append(f"  MuJoCo, equal error: {parts(self.against_mujoco())}")
        return lines

    def cells(self) -> list[str]:
        """A row of the table of the page."""
        own = [1e6 * seconds / n for method in METHODS for n, (_, seconds) in self.rows[method].items()]
        mujoco = parts(self.against_mujoco()) if self.case.links else ""
        return [self.case.name, spread(own, 2), f"{self.equal_step():.2f}", parts(self.equal_error()), mujoco]


def parts(ratios: list[float]) -> str:
    return spread(ratios, 2) if ratios else "void"


def seconds_at(error: float, rows: Rows) -> float:
    """Interpolated, both as logarithms; above the errors of all runs the least time, below them infinity."""
    front: list[tuple[float, float]] = []
    for e, s in sorted(rows.values(), key=lambda row: row[1]):
        if np.isfinite(e) and (not front or e < front[-1][0]):
            front.append((e, s))
    if not front or error < front[-1][0] * (1 - 1e-9):
        return np.inf
    e, s = np.log(front[::-1]).T
    return float(np.exp(np.interp(np.log(error), e, s)))


def at_equal_error(own: list[Rows], theirs: list[Rows], order: int = 2) -> list[float]:
    """Ratios of the least times of two programs at errors that both have.

    If our least accurate run is more accurate than all of theirs, their time for its error is that of their most
    accurate run, extended by their order."""
    if not own or not theirs:
        return []
    (low, high), (their_low, their_high) = (
        [choose(e for rows in runs for e, _ in rows.values() if np.isfinite(e)) for choose in (min, max)]
        for runs in (own, theirs)
    )
    if high < their_low:
        seconds = min(seconds_at(their_low, rows) for rows in theirs) * (their_low / high) ** (1 / order)
        return [min(seconds_at(high, rows) for rows in own) / seconds]
    errors = np.geomspace(max(low, their_low), min(high, their_high), 9)
    return [min(seconds_at(e, rows) for rows in own) / min(seconds_at(e, rows) for rows in theirs) for e in errors]


def compare(exu: Any, case: Case, repeats: int, mujoco: bool = True) -> Comparison:
    fine = case.steps[-1] // 2
    true, other = (ours(case, n, "dop853")[0] for n in (2 * fine, fine))

    def error(found: Array) -> float:
        return float(np.abs(found - true).max()) / case.size

    result = Comparison(case, error(other))
    runs: dict[str, tuple[tuple[int, ...], Callable[[int], tuple[Array, float]]]] = {}
    for method in METHODS:
        runs[method] = case.steps, lambda n, method=method: ours(case, n, method)
    runs |= exudyn_runs(exu, case, result)
    if case.links:
        runs["dop853"] = tuple(int(case.steps[0] * part) for part in LONG), lambda n: ours(case, n, "dop853")
    if case.links and mujoco:
        counts = tuple(int(case.steps[0] * part) for part in SHORT)
        runs |= {name: (counts, run) for name, run in mujoco_runs(case).items()}
    for _ in range(repeats):
        for k in range(max(len(counts) for counts, _ in runs.values())):
            for name, (counts, run) in runs.items():
                if k < len(counts):
                    found, seconds = run(counts[k])
                    rows = result.rows.setdefault(name, {})
                    before = rows.get(counts[k], (0.0, np.inf))[1]
                    rows[counts[k]] = error(found), min(before, seconds)
    return result


def exudyn_runs(exu: Any, case: Case, result: Comparison) -> dict[str, tuple[tuple[int, ...], Callable]]:
    """The settings of Exudyn that are not much slower than the best with the largest step."""
    kinds = exu.NodeType
    nodes = {"rotation vectors": kinds.RotationRotationVector, "Euler parameters": kinds.RotationEulerParameters}
    first = {}
    for node, kind in nodes.items():
        program = Exudyn(exu, case, kind)
        for way in WAYS:
            seconds = program.time(way, case.steps[0])[1]
            if np.isfinite(seconds):
                first[node, way] = program, seconds
            else:
                result.failed.append(f"Exudyn, {node}, {way}: the solver fails")
    least = min((seconds for _, seconds in first.values()), default=np.inf)
    return {
        f"Exudyn, {node}, {way}": (case.steps, lambda n, program=program, way=way: program.time(way, n))
        for (node, way), (program, seconds) in first.items()
        if seconds <= HOPELESS * least
    }


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--only", help="name of a case")
    parser.add_argument("--repeats", type=int, default=3)
    parser.add_argument("--write", action="store_true", help="write the table of docs/space.md")
    given = parser.parse_args()
    import exudyn

    rows = []
    for case in CASES:
        if given.only in (None, case.name):
            found = compare(exudyn, case, given.repeats)
            print("\n".join(found.lines()), flush=True)
            rows.append(found.cells())
    if given.write and given.only is None:
        columns = ["model", "a step [us]", "Exudyn, equal step", "Exudyn, equal error", "MuJoCo RK4, equal error"]
        put(PAGE, {"times in space": markdown(columns, rows)})


if __name__ == "__main__":
    main()
