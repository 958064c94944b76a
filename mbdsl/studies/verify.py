"""Verification of a run by a method of another family, at half the step or a tenth of the tolerance."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

import numpy as np

from mbdsl.errors import MbdslError, UsageError
from mbdsl.lang.given_values import seconds
from mbdsl.messages import OWN, UnitsOfSignals
from mbdsl.plotting.figures import TextTable
from mbdsl.simulation.progress import Progress
from mbdsl.simulation.trajectory import Trajectory
from mbdsl.studies.error_measures import late_events, scaled_motion
from mbdsl.studies.families import of_another_family
from mbdsl.studies.report import as_text, number
from mbdsl.studies.scales import Scales, scales
from mbdsl.studies.time_limits import TooLong, allowance, limited

FEW = 3.0  #: signals that agree to fewer digits are doubtful
SHOWN = 12  #: number of signals in a text, those with the fewest digits
SMALL = 2e-5  #: smallest range of a signal, relative to the largest of its unit on its bodies, that serves as its scale


@dataclass(frozen=True)
class Agreement:
    """Number of digits to which a signal agrees, relative to its range, and the largest difference.

    The difference is infinite if only one run has a value, and nan if none has; the number of digits is then 0.
    """

    signal: str
    unit: str
    digits: float
    difference: float


@dataclass(frozen=True)
class Verification:
    """Comparison of a run with a second one; ``str()`` returns a table.

    Attributes
    ----------
    method : str
        Method of the second run.
    step : float or None [s]
    tol : float or None
        Step size or tolerance of the second run.
    agreements : tuple of Agreement
        One for each signal, that with the fewest digits first.
    problem : str
        The reason if the second run did not reach its end, else "".
    stats : dict
        Settings and counts of the second run.
    until : float or None [s]
        Time up to which the runs were compared.
    display : UnitsOfSignals
        The units of the table.
    """

    method: str
    step: float | None
    tol: float | None
    agreements: tuple[Agreement, ...] = ()
    problem: str = ""
    stats: dict = field(default_factory=dict)
    until: float | None = None
    display: UnitsOfSignals = OWN

    @property
    def doubtful(self) -> list[Agreement]:
        """Signals that agree to fewer than three digits."""
        return [a for a in self.agreements if a.digits < FEW]

    @property
    def how(self) -> str:
        """Method and step or tolerance of the second run."""
        return f"{self.method}, {f'h = {self.step:g} s' if self.tol is None else f'tol = {self.tol:g}'}"

    def facts(self) -> dict:
        """Return a summary for the ``stats`` of the run.

        Returns
        -------
        dict
        """
        digits = {a.signal: round(a.digits, 2) for a in self.agreements}
        return {"problem": self.problem or None, "until": self.until, "run": self.stats, "digits": digits}

    def __str__(self) -> str:
        return as_text(self._table()) if self.agreements else self._failure()

    def __repr__(self) -> str:
        least = f", at least {self.agreements[0].digits:.1f} digits" if self.agreements else f": {self.problem}"
        return f"<Verification by {self.how}{least}>"

    def _repr_html_(self) -> str:
        from mbdsl.plotting.html_tables import fragment, table

        return table(self._table()) if self.agreements else fragment(self._failure())

    def _failure(self) -> str:
        return f"not verified: {self.how}: {self.problem or 'there are no signals'}"

    def _table(self) -> TextTable:
        rows = [(a.signal, f"{a.digits:.1f}", _differs(a, self.display)) for a in self.agreements[:SHOWN]]
        hidden = len(self.agreements) - len(rows)
        note = f"{hidden} more agree to {self.agreements[SHOWN].digits:.1f} digits or better" if hidden else ""
        title = f"verified by {self.how}" + (f", up to t = {self.until:.4g} s only" if self.problem else "")
        return TextTable(title, ("signal", "digits", "differs by"), rows, note)


def verify(
    trajectory: Trajectory,
    names: Sequence[str],
    general: bool = False,
    progress: Callable[[Progress], None] | None = None,
    announce: Callable[[str], None] | None = None,
    budget: float | str | None = None,
) -> Verification:
    """Repeat a run with another method and compare signals at the output times.

    Parameters
    ----------
    trajectory : Trajectory
        The run to verify.
    names : sequence of str
        Names of signals.
    general, progress, announce : optional
        As for ``mbdsl.simulate``.
    budget : float or str, optional [s]
        Time limit of the second run. Default: ten times that of the first, and at least 10 s. A run with fixed steps
        that reaches the limit is compared up to there.

    Returns
    -------
    Verification

    Raises
    ------
    UsageError
        If the trajectory does not begin at the start of its run.
    KeyboardInterrupt
        If the second run is interrupted.
    """
    budget = seconds(budget, "budget")
    if not trajectory._from_start:
        raise UsageError("a part of a run cannot be repeated", hint="verify the whole trajectory")
    stats = trajectory.stats
    h, tol = stats["h"], stats["tol"]
    kind = "fixed" if tol is None else "controlled"
    method = of_another_family(stats["method"], kind, trajectory.scene.spatial) or stats["method"]
    step, tol = (h / 2.0, None) if tol is None else (None, tol / 10.0)
    start, stop = float(trajectory.t[0]), float(trajectory.t[-1])
    times = np.unique(trajectory.t)[1:]  # controlled steps may be output as well
    how = {"method": method, "step": step, "tol": tol, "general": general, "announce": announce}
    due = {"start": start, "stop": stop, "times": times if stop > start else None}
    problem, until = "", stop
    try:
        limit = allowance(stats["seconds"]["integrate"], budget)
        other = limited(trajectory.scene, limit, progress, f"verification by {method}", **how, **due)
    except TooLong as late:
        problem, part = f"{late.message}; more time: --budget", late.trajectory
        if part is None or tol is not None or not len(part.t) > 1:  # an incomplete run may be a calibration run
            return Verification(method, step, tol, problem=problem)
        other, until = part, float(part.t[-1])
    except MbdslError as failed:
        return Verification(method, step, tol, problem=failed.message)
    if other.stats.get("terminated") and other.t[-1] < until:  # at the same event, at another time
        until = float(other.t[-1])
        if np.count_nonzero(trajectory.t > until) > 1:
            problem = f"it ended by terminate: {other.stats['terminated']}"
    facts = {key: other.stats[key] for key in ("method", "h", "tol", "steps", "iterations", "seconds")}
    known = scales(trajectory, min(_step(trajectory), _step(other)))
    found = agree(trajectory, other, names, until, known, max(SMALL, stats["tol"] or 0.0))
    return Verification(method, step, tol, tuple(found), problem, facts, until, trajectory.display)


#: coordinates of a body by their units
MOTIONS = {"m": ("x", "y", "z"), "m/s": ("vx", "vy", "vz"), "rad": ("phi",), "rad/s": ("w", "wx", "wy", "wz")}


def _of_bodies(run: Trajectory, name: str, unit: str) -> float | None:
    """The largest range of a motion of the bodies that a signal belongs to: the body itself, or those that a joint or
    force connects; None if they do not move, or of signals that are no motions."""
    owner = run.scene.components.get(name.partition(".")[0])
    if owner is None or unit not in MOTIONS or ".Phi[" in name or ".dPhi[" in name or ".Gam[" in name:
        return None
    found = [owner.name, *(run.scene.frames[frame].body for frame in owner.ports.values())]
    bodies = [body for body in dict.fromkeys(found) if run.scene.components[body].coordinates]
    signals = [f"{body}.{key}" for body in bodies for key in MOTIONS[unit] if f"{body}.{key}" in run]
    return max((_range(run[x]) for x in signals), default=0.0) or None


def agree(
    one: Trajectory,
    other: Trajectory,
    names: Sequence[str],
    until: float = np.inf,
    known: Scales | None = None,
    small: float = SMALL,
) -> list[Agreement]:
    """The agreement of two trajectories by signal, the worst first; ``other`` has all times of ``one`` up to ``until``.

    Digits are relative to the range of a signal, but at least to ``small`` times the largest range of such a motion on
    the bodies that it belongs to; of forces and other quantities, to the largest value of the unit here and in such a
    mechanism (with the scales ``known``). Differences that rounding can cause do not count.
    """
    count = int(np.searchsorted(one.t, until, side="right"))
    rows = np.minimum(np.searchsorted(other.t, one.t[:count]), len(other.t) - 1)
    assert np.array_equal(other.t[rows], one.t[:count]), "what is compared is of one time"
    ranges = {name: _range(one[name]) for name in names}
    late = late_events(other, one)
    speed = 1.0 if late is None else scaled_motion(one, one)[1]
    largest: dict[str, float] = {}
    for name in names:
        unit = one.unit(name)
        largest[unit] = max(largest.get(unit, 0.0), ranges[name])
    found = []
    for name in names:
        unit = one.unit(name)
        most = np.inf if late is None else np.where(late > 0.0, late * speed * ranges[name], np.inf)[:count]
        difference = _difference(one[name][:count], other[name][rows], most)
        usual = known.of(name, unit) if known is not None else 0.0
        own = _of_bodies(one, name, unit) if known is not None else None
        least = small * (max(largest[unit], usual) if own is None else own)
        if known is not None and known.whole(name):
            least = usual
        scale = max(ranges[name], least) or _largest(one[name]) or 1.0
        digits = -np.log10(max(difference / scale, 1e-16)) if np.isfinite(difference) else 0.0
        if known is not None and difference <= known.rounding(name, unit):
            digits = 16.0
        found.append(Agreement(name, unit, max(0.0, float(digits)), difference))
    return sorted(found, key=lambda a: a.digits)


def _step(trajectory: Trajectory) -> float:
    """The step, or the mean step [s]."""
    span = float(trajectory.t[-1] - trajectory.t[0])
    return trajectory.stats["h"] or span / max(1, trajectory.stats["steps"]) or 1.0


def _difference(x: np.ndarray, y: np.ndarray, most: float | np.ndarray) -> float:
    """The largest difference over time, at most ``most``, without times at which neither run has a value."""
    there = np.isfinite(x) | np.isfinite(y)
    D = np.minimum(np.abs(x - y), most)[there]
    return float(np.where(np.isfinite(D), D, np.inf).max()) if len(D) else np.nan


def _differs(a: Agreement, display: UnitsOfSignals) -> str:
    if np.isfinite(a.difference):
        unit = display.of(a.unit, a.signal)
        return f"{number(a.difference / unit.factor)} {unit.symbol}"
    return "no value in either run" if np.isnan(a.difference) else "a value in one run alone"


def _range(x: np.ndarray) -> float:
    kept = x[np.isfinite(x)]
    return float(np.ptp(kept)) if len(kept) else 0.0


def _largest(x: np.ndarray) -> float:
    return float(np.abs(x).max(initial=0.0, where=np.isfinite(x)))
