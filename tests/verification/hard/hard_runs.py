"""Runs of hard cases: models with independent answers, run by every method, and a verdict for every run.

A folder contains models, ``NAME.mbd``, and the cases of each, ``NAME.json``: parameters, a step, a tolerance, and
either the expected signals (values at times, or a constant, from a closed form or another program) or the time and the
words of the expected error. A run is ``WRONG`` if it ends with exit code 0 and an error that is larger than its
tolerance allows, or larger than a run with a shorter step explains.
"""

from __future__ import annotations

import json
import time
from collections.abc import Iterator, Sequence
from fnmatch import fnmatchcase
from os import PathLike
from pathlib import Path

import numpy as np
from hard_case import Case, Cell, Check, Stop
from numpy.typing import NDArray

from mbdsl.errors import IntegrationError, MbdslError
from mbdsl.integrators import available
from mbdsl.lang.load import load
from mbdsl.simulation.simulate import simulated
from mbdsl.simulation.trajectory import Trajectory

BUDGET = 20.0  #: default time limit of a run [s]
POINTS = 100  #: times at which constants are compared
CLAIMED = 3.0  #: largest error, relative to the tolerance
PARTS = (2, 64)  #: shorter steps that may show an error: parts of the step
SHOWN = 10.0  #: largest error, relative to the difference from a run with a shorter step
OFF = 1e-8  #: largest violation of joints, relative to the mechanism's size

Array = NDArray[np.float64]


def read(folder: str | PathLike, only: str = "*") -> list[Case]:
    """The cases of a folder or of one model, in the order of their groups; ``only`` is a glob of their names."""
    place = Path(folder)
    files = [place.with_suffix(".json")] if place.suffix else sorted(place.glob("*.json"))
    found = [case for file in files for case in _cases(file)]
    found = [case for case in found if fnmatchcase(str(case), only) or fnmatchcase(case.model.stem, only)]
    return sorted(found, key=lambda case: int(case.group.split(".")[0]))


def _cases(file: Path) -> Iterator[Case]:
    """The cases in a file of answers."""
    said = json.loads(file.read_text(encoding="utf-8"))
    for case in said["cases"]:
        checks = tuple(Check(**check) for check in case.pop("checks", ()))
        stops = Stop(**case.pop("stops")) if "stops" in case else None
        case = {"group": said["group"], "answer": said["answer"], **case}
        yield Case(file.with_suffix(".mbd"), checks=checks, stops=stops, **case)


def measure(case: Case, method: str, tol: bool = False, budget: float = BUDGET) -> Cell | None:
    """Run a case by a method, at its step or with its tolerance; None if that is impossible."""
    size = case.tol if tol else case.step
    if size is None or ("controlled" if tol else "fixed") not in available()[method].steps:
        return None
    try:
        found = _run(case, method, size, tol, budget)
    except MbdslError as problem:
        return _stopped(case, problem)
    if found.status == "interrupted":
        return Cell("slow", f"not done in {budget:g} s (t = {found.t[-1]:.3g} s)")
    if case.stops is not None:
        return Cell("WRONG", "ran to its end")
    open_ = max((float(np.abs(found[name]).max()) for name in found.names if ".Phi[" in name), default=0.0)
    if not open_ <= max(OFF, size if tol else 0.0) * found.system.tables.size:
        return Cell("WRONG", f"joints open by {open_:.1e}")
    errors = [check.error(found) for check in case.checks]
    text = _told(case.checks, errors)
    beyond = [c for c, e in zip(case.checks, errors, strict=True) if not _passes(c, e, size if tol else None)]
    if not beyond:
        return Cell("right", text)
    if tol:
        return Cell("WRONG", text)
    for part in PARTS:
        try:
            finer = _run(case, method, size / part, False, 2 * budget)
        except MbdslError:
            return Cell("step", text)
        if finer.status == "interrupted":
            return Cell("slow", f"{text}; 1/{part} of the step: not done in {2 * budget:g} s")
        if all(_explained(c, found, finer) for c in beyond):
            return Cell("step", text)
    return Cell("WRONG", text)


def _explained(check: Check, found: Trajectory, finer: Trajectory) -> bool:
    """Whether a run with a shorter step reduces the error, unlike an error due to rounding."""
    error, shown = abs(check.error(found)), float(np.abs(check.differences(found) - check.differences(finer)).max())
    return error <= SHOWN * shown and abs(check.error(finer)) <= 2.0 * error


def _passes(check: Check, error: float, tol: float | None) -> bool:
    """Whether the error is small enough at any step."""
    if not np.isfinite(error):
        return False
    if tol is not None:
        return not check.controlled or abs(error) <= CLAIMED * tol
    return abs(error) <= check.within and (check.grows is None or error <= check.grows)


def _run(case: Case, method: str, size: float, tol: bool, budget: float) -> Trajectory:
    # hard cases extend models of the parent folder
    scene = load(case.model, dict(case.parameters), allow_imports=case.model.absolute().parent.parent)
    even = np.linspace(scene.experiment.start, case.stop, POINTS + 1)[1:]
    if not tol:  # at ends of steps, because output between them is interpolated
        even = np.unique(np.maximum(np.round(even / size), 1.0)) * size
        even = np.append(even[even < case.stop * (1 - 1e-9)], case.stop)
    asked = [t for check in case.checks for t in check.times if t > scene.experiment.start]
    begun: list[float] = []  # from the first steps on: compilation does not count

    def progress(_):
        begun.append(time.process_time())
        if begun[-1] - begun[0] > budget:
            raise KeyboardInterrupt

    return simulated(
        scene,
        method=method,
        step=None if tol else size,
        tol=size if tol else None,
        stop=case.stop,
        times=_union(asked, even, case.stop),
        progress=progress,
    )


def _union(asked: Sequence[float], even: Array, stop: float) -> Array:
    """Both sequences merged in order; values that differ by rounding only once."""
    both = np.union1d(asked, even)
    both = both[np.append(np.diff(both) > 1e-9 * stop, True)]
    both[-1] = stop
    return both


def _stopped(case: Case, problem: MbdslError) -> Cell:
    """A run that stopped with a reason, compared with the expected one."""
    trajectory = problem.trajectory if isinstance(problem, IntegrationError) else None
    t = float(trajectory.t[-1]) if trajectory is not None and len(trajectory.t) else None
    text = f"exit {problem.exit_code}" + (f" at {t:.3g} s" if t is not None else "")
    said, reason = problem.render(), _reason(problem)
    if case.stops is None:
        return Cell("stops", text, reason)
    want = case.stops
    missing = [words for words in want.says if words not in said]
    if missing and any(words in said for words in want.own) and (t or 0.0) <= (want.before or np.inf):
        return Cell("stops", text, reason)
    if problem.exit_code != want.code or missing:
        return Cell("WRONG", f"{text}, {'not ' + repr(missing[0]) if missing else f'not {want.code}'}", reason)
    if t is not None and not (want.after or -np.inf) <= t <= (want.before or np.inf):
        return Cell("WRONG", f"{text}, not {want.after} to {want.before} s", reason)
    return Cell("right", text, reason)


def _reason(problem: MbdslError) -> str:
    """The reason of a failed run, without times and sizes, which differ from run to run."""
    first, *rest = problem.message.split("; ")
    parts = [first.split(" in the step to")[0].split(" at t =")[0]]
    parts += [f"singular pose of {part.split('): ')[1].split(' depend')[0]}" for part in rest if "the pose is" in part]
    named = sorted(text.split(" is ")[0].split(" = ")[0] for text, _span in problem.notes)
    parts += [", ".join(named)] if named else []
    return ": ".join(parts)


def _told(checks: Sequence[Check], errors: Sequence[float]) -> str:
    """The largest error of signals with values, and those of energies."""
    plain = [e for c, e in zip(checks, errors, strict=True) if c.grows is None]
    energy = [e for c, e in zip(checks, errors, strict=True) if c.grows is not None]
    parts = [f"{max(plain):.1e}"] if plain else []
    return ", ".join(parts + ([f"E {max(energy, key=abs):+.1e}"] if energy else []))
