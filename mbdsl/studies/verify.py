"""A second opinion on a run: another family of methods, at half the step or a tenth of the tolerance."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

import numpy as np

from mbdsl.errors import MbdslError
from mbdsl.plotting.figures import Table
from mbdsl.simulation import Progress, simulate
from mbdsl.studies.families import of_another_family
from mbdsl.studies.report import as_text, number
from mbdsl.trajectory import Trajectory

FEW = 3.0  #: digits: who agrees to fewer does not agree
SHOWN = 12  #: signals in a text, the worst ones
SMALL = 1e-6  #: part of the largest range of its unit below which a signal's own range is none


@dataclass(frozen=True)
class Agreement:
    """Digits to which a signal agrees, relative to its range, and the largest difference."""

    signal: str
    unit: str
    digits: float
    difference: float


@dataclass(frozen=True)
class Verification:
    """``agreements`` of every signal, the worst first; ``problem`` where the second run did not come to its end."""

    method: str
    step: float | None
    tol: float | None
    agreements: tuple[Agreement, ...] = ()
    problem: str = ""
    stats: dict = field(default_factory=dict)

    @property
    def doubtful(self) -> list[Agreement]:
        return [a for a in self.agreements if a.digits < FEW]

    @property
    def how(self) -> str:
        return f"{self.method}, {f'h = {self.step:g} s' if self.tol is None else f'tol = {self.tol:g}'}"

    def facts(self) -> dict:
        """For the stats of a run."""
        digits = {a.signal: round(a.digits, 2) for a in self.agreements}
        return {"problem": self.problem or None, "run": self.stats, "digits": digits}

    def __str__(self) -> str:
        if self.problem:
            return f"not verified: {self.how}: {self.problem}"
        rows = [(a.signal, f"{a.digits:.1f}", f"{number(a.difference)} {a.unit}") for a in self.agreements[:SHOWN]]
        hidden = len(self.agreements) - len(rows)
        note = f"{hidden} more agree to {self.agreements[SHOWN].digits:.1f} digits or better" if hidden else ""
        return as_text(Table(f"verified by {self.how}", ("signal", "digits", "differs by"), rows, note))


def verify(
    trajectory: Trajectory,
    names: Sequence[str],
    interval: float | None = None,
    general: bool = False,
    progress: Callable[[Progress], None] | None = None,
    announce: Callable[[str], None] | None = None,
) -> Verification:
    """Run the model of ``trajectory`` again, otherwise, and compare the signals ``names``.

    ``interval`` is that of the trajectory's output.

    Raises
    ------
    KeyboardInterrupt
    """
    stats = trajectory.stats
    h, tol = stats["h"], stats["tol"]
    method = of_another_family(stats["method"], "fixed" if tol is None else "controlled") or stats["method"]
    step, tol = (h / 2.0, None) if tol is None else (None, tol / 10.0)
    start, stop = float(trajectory.t[0]), float(trajectory.t[-1])
    if interval == 0.0:
        # every step of the one run is none of the other: compare at even times, which both come by
        interval = h
    try:
        other = simulate(
            trajectory.scene,
            method=method,
            step=step,
            tol=tol,
            start=start,
            stop=stop,
            interval=interval,
            general=general,
            progress=progress,
            announce=announce,
        )
    except MbdslError as problem:
        return Verification(method, step, tol, problem=problem.message)
    if other.status == "interrupted":
        raise KeyboardInterrupt
    facts = {key: other.stats[key] for key in ("method", "h", "tol", "steps", "iterations", "seconds")}
    return Verification(method, step, tol, tuple(agree(trajectory, other, names)), stats=facts)


def agree(one: Trajectory, other: Trajectory, names: Sequence[str]) -> list[Agreement]:
    """How far two trajectories with the same times agree, the worst first."""
    ranges = {name: _range(one[name]) for name in names}
    largest: dict[str, float] = {}
    for name in names:
        unit = one.unit(name)
        largest[unit] = max(largest.get(unit, 0.0), ranges[name])
    rows = np.minimum(np.searchsorted(other.t, one.t - 1e-9 * np.ptp(one.t)), len(other.t) - 1)
    found = []
    for name in names:
        unit = one.unit(name)
        D = np.abs(one[name] - other[name][rows])
        difference = float(D.max(initial=0.0, where=np.isfinite(D)))
        scale = max(ranges[name], SMALL * largest[unit]) or float(np.abs(one[name]).max(initial=0.0)) or 1.0
        digits = -np.log10(max(difference / scale, 1e-16))
        found.append(Agreement(name, unit, max(0.0, float(digits)), difference))
    return sorted(found, key=lambda a: a.digits)


def _range(x: np.ndarray) -> float:
    kept = x[np.isfinite(x)]
    return float(np.ptp(kept)) if len(kept) else 0.0
