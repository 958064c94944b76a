"""The rounding error of a calibration run, as the motion amplifies it: a floor of the error that no step goes below.

The growth (:mod:`mbdsl.simulation.error_growth`) is computed at the outputs of a run first. If it exceeds the
tolerance, it is computed again at the steps, until two spacings of samples agree.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable
from dataclasses import replace

import numpy as np

from mbdsl.integrators.loop import loop_state as S
from mbdsl.kernels.arrays import Array
from mbdsl.numerics.tolerance import rounding
from mbdsl.simulation.calibration_runs import Trial
from mbdsl.simulation.error_growth import SAMPLES, Growth, along
from mbdsl.simulation.ladder_constants import LADDER
from mbdsl.simulation.mechanism_run import Kept, MechanismRun
from mbdsl.simulation.plan import Plan
from mbdsl.system.state_sizes import weights

#: the reason for a horizon where rounding exceeds the tolerance
AMPLIFIED = "the motion amplifies errors, rounding included,"


class AmplifiedRounding(ABC):
    """The part of the calibration runs that examines the growth of errors; its attributes are those of the runs."""

    motion: MechanismRun
    tol: float
    span: float
    integrate: Callable[..., int]
    growth: Growth | None
    longest: float
    reason: str
    lost: int
    interrupted: bool

    @abstractmethod
    def _held_to(self, eps: float) -> Plan:
        """The plan of a run whose steps are held to ``eps``."""

    @property
    def rounds(self) -> bool:
        """Whether the motion amplifies rounding errors beyond the tolerance, with any method."""
        return self.reason.startswith(AMPLIFIED)

    @property
    def amplifies(self) -> bool:
        """Whether the motion is known to amplify errors so much that steps have to resolve the rate of that."""
        return self.growth is not None and bool(self.growth.log.max() > LADDER.grown)

    def _look_at_growth(self, last: Trial) -> float | None:
        """For a run within the tolerance: whether its steps resolve the growth of errors, and the growth of
        rounding."""
        if self.growth is None:
            if self._hopeless(last):
                self.reason = self._of_rounding()
                return None
            assert self.growth is not None
            rate = self.growth.rate
            limit = max(LADDER.resolved / rate, LADDER.shortest * self.span) if rate > 0.0 else np.inf
            if self.amplifies and limit < self._held_to(last.eps).longest:
                self.longest = limit
                return last.eps / LADDER.nearest
        return None

    def _hopeless(self, last: Trial) -> bool:
        """Whether amplified rounding alone exceeds the tolerance."""
        found = self._growth(last, last.kept)
        self.growth = found[0]
        if float(self._rounding(last)[-1]) > self.tol:
            self._refine(last, *found)
        return float(self._rounding(last)[-1]) > self.tol

    def _refine(self, last: Trial, coarse: Growth, known: int) -> None:
        """Compute the growth again, at the steps of the run; a growth that finer samples do not confirm is not known.

        Between outputs, rates may be large for a short time, as in a contact, or swing, as in a pendulum. Taken as
        constant until the next output, they give far too much growth.
        """
        if not self._is_confirmed(last, coarse, known) and float(self._rounding(last)[-1]) > self.tol:
            self.growth = Growth(coarse.t, np.zeros_like(coarse.log), 0.0)

    def _is_confirmed(self, last: Trial, coarse: Growth, known: int) -> bool:
        """Whether two spacings of samples give the same growth; the growth becomes that of the finest samples."""
        motion = self.motion
        if last.steps * sum(p.system.n + p.system.unknowns for p in motion.parts) > LADDER.most_numbers:
            return False
        present, held = motion.keep(), self._held_to(last.eps)
        longest = min(held.longest, self.span / (LADDER.finer[0] * SAMPLES))
        motion.restart(replace(held, times=np.zeros(0), every=True, longest=longest))
        status = self.integrate()
        self.interrupted = status == S.RUNNING and not motion.invalid()
        steps, kept, before, samples = motion.steps, motion.keep(), coarse.log[-1], SAMPLES
        self.lost += steps
        motion.recall(present)
        found = [coarse]
        for finer in LADDER.finer if status == S.DONE else ():
            fine, examined = self._growth(last, kept, finer)
            if examined < known:
                return False  # some steps have no tangent equations
            assert self.growth is not None
            if fine.log[-1] < self.growth.log[-1]:
                self.growth = fine
            more = min(steps, finer * SAMPLES)
            if more < 2 * samples:
                break
            found.append(fine)
            if abs(fine.log[-1] - before) < LADDER.settled * before:
                return True
            if more == steps or float(self._rounding(last)[-1]) <= self.tol:
                break
            before, samples = fine.log[-1], more
        if len(found) < 3:
            return False
        # not known, but bounded from below, if further samples changed it as much as the last ones have
        *_, former, fine = found
        least = np.maximum(0.0, fine.log - np.maximum.accumulate(np.abs(fine.log - former.log)))
        if rounding(1.0) * np.exp(min(float(least.max()), 700.0)) <= self.tol:
            return False
        self.growth = Growth(fine.t, least, fine.rate)
        return True

    def _growth(self, last: Trial, kept: Kept, finer: float = 1.0) -> tuple[Growth, int]:
        """The growth at the times of a run, from the states in ``kept``, and the number of parts with a known growth to
        the end."""
        motion, t = self.motion, last.t
        speed = weights(motion.system.tables, last.v, self.span).speed
        return along(motion.parts_of(kept), t, speed, finer)

    def _rounding(self, trial: Trial) -> Array:
        """The rounding error (N,) along a run, amplified by the growth if that is known."""
        unit = rounding(1.0)
        if self.growth is None:
            return np.full(len(trial.t), unit)
        return unit * np.exp(np.minimum(self.growth.at(trial.t), 700.0))

    def _of_rounding(self) -> str:
        assert self.growth is not None
        factor = np.exp(min(self.growth.log.max(), 700.0))
        return f"{AMPLIFIED} by a factor of {factor:.0e}"

    def _of_times(self, trial: Trial) -> Array:
        """The error (N,) along a run because times and places of its events are rounded, as decimals of a model are:
        the width of a short window is a difference of two of them."""
        found = np.zeros(len(trial.t))
        speed = weights(self.motion.system.tables, trial.v, self.span).speed
        for run in trial.kept.integrations:
            if (events := getattr(run, "events", None)) is not None and events.times:
                sums = np.append(0.0, np.cumsum(events.rounding)) / speed
                found = np.maximum(found, sums[np.searchsorted(events.times, trial.t)])
        return found
