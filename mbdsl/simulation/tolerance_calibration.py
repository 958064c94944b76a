"""Calibration runs, which estimate the global error of controlled steps and bring it below the tolerance.

The tolerance of a method, eps, limits the local error of its steps (:mod:`mbdsl.integrators.loop.step_control`). The
global error depends on the model as well: a damped model forgets local errors, a chaotic one amplifies them. Therefore
the model is run several times with decreasing eps. The error estimate of a run, the *claim*, follows from its
difference from the run before, whose eps is about 8 times as large, and from the order p in eps that the last three
runs show:

    error = difference/(8^p - 1),   1/3 <= p <= 1,

or is the difference itself while there are fewer than three runs. The error counts as reduced by at most the factor
that the numbers of steps allow, as of a method of its order. With methods of order above 5 and forces given by
expressions, the error counts as reduced by at most a factor of 8 from one run to the next, and of 2 with backends,
because their steps are so long that errors decrease irregularly. If a run differs from the run before by more than the
claim of the latter, this difference replaces that claim. The claim is at least the rounding error as the motion
amplifies it (:mod:`mbdsl.simulation.error_growth`), because runs may agree although the motion is sensitive.

The first runs have a large eps and are cheap; they show which eps is needed. The run whose claim is within the
tolerance is the result. If runs with a small eps fail, values of eps between those of the failed runs and of the last
complete run are tried, and the complete run with the smallest claim is the result.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from mbdsl.integrators import declared
from mbdsl.integrators.loop import loop_state as S
from mbdsl.integrators.run import MethodRun, longest_part
from mbdsl.numerics import error_norm
from mbdsl.simulation.calibration_growth import AmplifiedRounding
from mbdsl.simulation.calibration_runs import COSTLY, Calibrated, Trial, observed_order
from mbdsl.simulation.event_sequences import Compared, between, compared
from mbdsl.simulation.ladder_constants import LADDER
from mbdsl.simulation.mechanism_run import MechanismRun
from mbdsl.simulation.plan import Plan
from mbdsl.simulation.result_checks import TOO_MANY_STEPS
from mbdsl.simulation.undecided_contacts import undecided_effect
from mbdsl.system.state_sizes import weights

#: reasons for a horizon
NO_CONVERGENCE = "runs with shorter steps do not converge"
CONTACT = "the path comes so close to a condition of a law that its error decides whether the condition changes"
#: the same of events
OTHER_EVENTS = "runs with different errors have different events: {} occurs in one of them only"


def calibrated(motion: MechanismRun, tol: float, integrate: Callable[..., int]) -> tuple[int, Calibrated]:
    """Run ``motion`` so that its error is below ``tol``, or as small as possible; return a status and the estimate.

    ``integrate()`` runs the present plan to its end. The error is the largest over all outputs, in the norm of
    :mod:`mbdsl.numerics.error_norm`.
    """
    ladder = CalibrationLadder(motion, tol, integrate, motion.plan)
    while ladder.eps is not None:
        ladder.run()
        if ladder.interrupted:
            return ladder.stopped()
    return ladder.finish()


class CalibrationLadder(AmplifiedRounding):
    """The calibration runs of one method.

    Attributes
    ----------
    eps : float or None
        Tolerance of the method in the next run; None if no further run is needed or possible.
    trials : list of Trial
        The runs so far, without those that failed although one with a larger eps was complete.
    reason : str
        Why a smaller error was not reached.
    interrupted : bool
        Whether the last run was interrupted.
    """

    def __init__(self, motion: MechanismRun, tol: float, integrate: Callable[..., int], plan: Plan) -> None:
        self.motion, self.tol, self.integrate, self.plan = motion, tol, integrate, plan
        method = declared(plan.method)
        self.order, self.chance = max(1, method.order), LADDER.chance_of_backends if method.searches else LADDER.chance
        self.few = self.order > 5 and not method.searches  #: our methods with few, long steps
        #: whether errors decrease irregularly: such a step passes a peak, or a corner of a force, that a slightly
        #: shorter one resolves
        self.irregular = (self.order > 5 or method.searches) and any(p.system.tables.has_tape for p in motion.parts)
        self.span = plan.stop - plan.start
        self.first = max(LADDER.first * tol, LADDER.strictest) if self.order <= 2 else LADDER.first_of_high_order * tol
        self.first = min(self.first, LADDER.loosest)
        self.eps: float | None = self.first
        self.part = min((longest_part(p.system, plan.method) for p in motion.parts), default=1.0)
        self.times, self.shown = plan.times, None
        #: whether the best run is repeated with all its outputs, of which the calibration runs have a part or none
        self.again = plan.every or plan.count > LADDER.most_compared
        #: longest step: methods interpolate, so that a very long one would have very many outputs
        self.dense = LADDER.dense * self.span / plan.count if plan.count > LADDER.most_compared else np.inf
        if plan.count > LADDER.most_compared:
            rows = np.arange(0, plan.count, -(-plan.count // LADDER.most_compared))
            rows = np.append(rows, plan.count - 1) if rows[-1] < plan.count - 1 else rows
            self.times = plan.times[rows] if plan.rows is None else plan.rows.at(rows)
        elif plan.every or len(plan.times) < LADDER.points:
            even = np.linspace(plan.start, plan.stop, LADDER.points + 1)[1:]
            self.times = even if plan.every else np.union1d(even, plan.times)
            self.shown = None if plan.every else np.isin(self.times, plan.times)
        self.trials: list[Trial] = []
        #: runs that failed although one with a larger eps was complete; not among ``trials``
        self.failed: list[Trial] = []
        self.longest = np.inf  #: the longest step that resolves the growth of errors
        self.growth = None
        self.reason = ""
        self.lost = 0  #: steps of runs that are not among the trials: repeated with another size, or every step output
        self.interrupted = False

    def run(self, most: int | None = None) -> int:
        """Make the next run; its status. A run of more than ``most`` steps is ended as COSTLY and does not count."""
        assert self.eps is not None
        last = self._run(self.eps, most)
        self.interrupted = last.status == S.RUNNING and not self.motion.invalid()
        if self.interrupted or last.status == COSTLY:
            return last.status
        if self.motion.outgrown():
            self.lost += self.trials.pop().steps
        else:
            self.eps = self._next(last)
        return last.status

    @property
    def steps(self) -> int:
        """Number of steps of all runs."""
        return self.lost + sum(x.steps for x in [*self.trials, *self.failed])

    def stopped(self) -> tuple[int, Calibrated]:
        """The status and the estimate after a run that was interrupted."""
        last = self.trials[-1]
        self.motion.trial_steps = self.steps - last.steps
        return S.RUNNING, Calibrated(last.error if np.isfinite(last.error) else None)

    # -- runs --------------------------------------------------------------------------------------------------
    def _held_to(self, eps: float) -> Plan:
        # the longest step depends on eps, so that errors decrease with eps where steps have that length, too
        longest = self.part * self.span * (eps / self.first) ** (1.0 / self.order)
        longest = min(longest, self.longest, self.dense)
        return replace(self.plan, tol=eps, longest=longest, times=self.times, every=False, streamed=False, rows=None)

    def _run(self, eps: float, most: int | None) -> Trial:
        motion = self.motion
        motion.restart(replace(self._held_to(eps), shown=self.shown))
        motion.purpose = f"calibration run {1 + self._runs}"
        status = self.integrate() if most is None else self.integrate(most)
        t, q, v = motion.states()
        trial = Trial(eps, status, motion.steps, t, q, v, motion.keep())
        if status == COSTLY:
            self.lost += motion.steps
            return trial
        if self.trials:
            self._judge(trial)
        self.trials.append(trial)
        return trial

    def _judge(self, last: Trial) -> None:
        """The claim, from the run before and the one before that."""
        before = self.trials[-1]
        n, norm = min(len(before.t), len(last.t)), weights(self.motion.system.tables, last.v, self.span)
        dq = self.motion.system.difference(before.q[:n], last.q[:n])
        dv = before.v[:n] - last.v[:n]
        found = error_norm.differences(norm.q, norm.speed, dq, dv, norm.v)
        events = self._compared(last, before, norm.speed)
        if events is not None and len(events.times):
            late = norm.speed * between(last.t[:n], events.times)
            of_q = error_norm.differences(norm.q, norm.speed, dq, np.zeros_like(dv), norm.v)
            found = np.where(late > 0.0, np.maximum(late, of_q), found)
        beyond = np.full(len(last.t) - n, np.inf)  # the error after the failure of the previous run is not known
        last.difference = np.maximum.accumulate(np.append(found, beyond))
        ratio, p = before.eps / last.eps, observed_order([*self.trials, last])
        fall = self._fall(before, last, ratio**p if p else 2.0, events is not None)
        last.claim = last.difference / (fall - 1.0)
        if p and fall < 2.0 and len(before.claim):
            last.claim = np.maximum(last.claim, np.append(before.claim[:n], beyond) / fall)
        if p:  # two runs may agree by chance: the error should not fall much faster than eps
            former = before.difference[:n] / (self.trials[-2].eps / before.eps - 1.0) / ratio
            last.claim = np.clip(former, last.claim, self.chance * last.claim)
        last.hoped = last.error
        if self.irregular:
            if p:
                # backends pass corners, with errors that depend on eps by chance
                fall = LADDER.ratio if self.few else 2.0
                last.claim = np.maximum(last.claim, last.difference / (fall - 1.0))
            elif len(before.difference):
                former = np.append(before.difference[:n], beyond) / LADDER.ratio
                last.claim = np.clip(former, last.claim, LADDER.chance_of_backends * last.claim)
        if len(before.claim):  # the difference is due to the error of the run before, unless this run is worse
            before.claim[:n] = np.maximum(before.claim[:n], last.difference[:n])
        last.contacts = undecided_effect(self.motion.parts, last, before, norm.speed, self.span)
        if events is not None and events.first is not None:
            last.contacts[last.t >= events.end] = np.inf
            last.event = events.first
        last.claim = np.maximum(last.claim, last.contacts)

    def _compared(self, last: Trial, before: Trial, speed: float) -> Compared | None:
        """The events of both runs; None if the model has none."""
        for one, other in zip(last.kept.integrations, before.kept.integrations, strict=True):
            pair = [x.events.set for x in (one, other) if isinstance(x, MethodRun)]
            if len(pair) == 2 and pair[0] is not None and pair[1] is not None:  # events make a scene one part
                return compared(pair[0], pair[1], self.tol / speed, min(last.t[-1], before.t[-1]))
        return None

    def _fall(self, before: Trial, last: Trial, fall: float, events: bool) -> float:
        """The factor by which the error falls from one run to the next, which is not larger than the steps allow.

        Where both runs take the same steps, because stability or a condition limits them, they have the same error. If
        events cut the steps, both may be far from the motion.
        """
        if not declared(self.plan.method).searches:
            fall = min(fall, (last.steps / max(1, before.steps)) ** self.order)
        return max(fall, LADDER.least_fall_with_events if events else LADDER.least_fall)

    # -- the next run --------------------------------------------------------------------------------------
    def _next(self, last: Trial) -> float | None:
        """The eps of the next run; None if no further run is needed or possible."""
        trials, tol = self.trials, self.tol
        if len(trials) == 1:
            return last.eps / LADDER.ratio
        if not last.done:
            return self._after_failure(last)
        if last.error <= tol:
            return self._look_at_growth(last)
        if last.differs > LADDER.saturated and self.growth is None and self._hopeless(last):
            self.reason = self._of_rounding()
        enough = LADDER.aim * tol
        if self._differ_again():
            self.reason = self.reason or NO_CONVERGENCE
            return None
        if self.reason and last.eps <= enough:
            return None
        # a contact with another outcome in another run changes the motion once; the motion after it converges again
        decided = all(x.contacts[-1] <= tol for x in trials[-3:] if len(x.contacts))
        three = len(trials) > 3 and all(x.done for x in trials[-3:])
        # long steps may still be too large for a motion that amplifies errors, but not rounding, beyond the tolerance
        growing = self.few and last.differs > LADDER.saturated and self.amplifies
        # nor do errors of backends fall steadily, which pass corners
        growing = growing or (self.irregular and not self.few)
        stays = three and last.differs > LADDER.falls * trials[-3].differs
        if decided and stays and not growing and trials[-2].eps < enough:
            self.reason = NO_CONVERGENCE
            if last.differs < LADDER.saturated:
                return None
        goal: float | None = None  # eps that the tolerance needs, if the runs show it
        if self.reason:
            eps = enough if last.eps < 16.0 * enough else 8.0 * enough
        elif last.differs > LADDER.saturated or not decided:
            eps = last.eps / LADDER.ratio
        else:
            p, wanted = self._wanted(last)
            ratio = max(last.eps / max(wanted, 1e-300), LADDER.ratio if self.irregular else 1.0)
            steps = np.ceil(np.log(ratio) / np.log(LADDER.ratio) - 0.1)
            eps = last.eps / ratio ** (1.0 / steps) if steps <= 2 else LADDER.ratio * wanted
            eps = min(last.eps / LADDER.nearest, eps)
            eps = max(eps, last.eps / self._leap(p))
            goal = wanted if p > LADDER.doubtful and not self.few else None
        if self.failed:
            if last.eps < LADDER.nearest * self.failed[-1].eps:
                return None
            eps = max(eps, self._between(last))
        return self._within_reach(last, eps, goal or eps)

    def _differ_again(self) -> bool:
        """Whether the last four runs have had other events than the run before, from the same time on."""
        times = [x.event.t if x.done and x.event is not None else np.inf for x in self.trials[-4:]]
        return len(times) == 4 and max(times) - min(times) <= LADDER.together * self.span

    def _within_reach(self, last: Trial, eps: float, goal: float) -> float | None:
        """The next eps, neither below the least one nor with more steps than can be afforded; None if it is of no use.

        The order that a few runs show may be far too low, and the ``goal`` orders of magnitude too small: the rung
        between is tried, unless errors that decrease as fast as eps would not become small enough.
        """
        # what a touch may do falls with the root of the error, if it is no `when`, whose effect has no bound
        touches = self.order > 2 and self.tol < last.contacts[-1] < np.inf
        least = (LADDER.least_of_high_order if self.few or self.irregular or touches else LADDER.least) * self.tol
        afforded = last.eps * (last.steps / LADDER.most_steps) ** self.order
        if self._runs >= LADDER.most_runs or min(eps, goal) < afforded:
            # two runs alone do not show the order: their difference is stated, which may be much larger than the error
            error = last.error if observed_order(self.trials) else min(last.error, last.differs / (LADDER.ratio - 1.0))
            hoped = last.eps * min(1.0, self.tol / max(error, 1e-300))
            if self._runs >= LADDER.most_runs or hoped < afforded or last.eps < LADDER.nearest * afforded:
                self.reason = self.reason or TOO_MANY_STEPS
                return None
        if eps < least and last.eps < LADDER.nearest * least:
            self.reason = self.reason or NO_CONVERGENCE
            return None
        return max(eps, least, afforded)

    def _wanted(self, last: Trial) -> tuple[float, float]:
        """The order in which errors decrease with eps, and the eps with which the error would be LADDER.aim of the
        tolerance."""
        p = observed_order(self.trials) or 1.0
        error = max(last.hoped, 1e-300) if self.irregular else last.error
        return p, last.eps * min(1.0, LADDER.aim * self.tol / error) ** (1.0 / p)

    def _leap(self, p: float) -> float:
        """The largest ratio of eps of successive runs, if errors decrease with the order p.

        The order of a few runs may be far too low, and the needed eps orders of magnitude too small: a run that
        resolves much more than the tolerance would cost more than all those before it. With the methods of low order,
        a run has at most eight times as many steps as the one before.
        """
        if self.few:
            return LADDER.ratio**3
        if p < LADDER.doubtful:
            return LADDER.ratio if self.order <= 2 else LADDER.ratio**2
        return LADDER.ratio ** min(self.order, 3)

    def needed(self) -> float:
        """The eps that the tolerance needs, as the runs so far show it; that of a typical model without such runs."""
        last, typical = self.trials[-1], min(self.trials[-1].eps / LADDER.ratio, LADDER.aim * self.tol)
        if last.error <= self.tol or last.differs > LADDER.saturated:
            return last.eps if last.error <= self.tol else typical
        return max(self._wanted(last)[1], last.eps / self._leap(0.0))

    @staticmethod
    def acts_without_end(last: Trial) -> bool:
        """Whether when-equations have ended a run: they do the same with smaller errors."""
        own = [x for x in last.kept.integrations if isinstance(x, MethodRun)]
        return last.status == S.SLIDING and any(x.events is not None and x.events.of_whens for x in own)

    def _after_failure(self, last: Trial) -> float | None:
        """The next eps after a failed run.

        A run with a smaller eps may still be complete, so two runs have to fail at the same time. The best eps then
        lies between that of the failed runs and that of the last complete run.
        """
        trials, before, enough = self.trials, self.trials[-2], LADDER.aim * self.tol
        alike = not before.done and abs(before.t[-1] - last.t[-1]) <= LADDER.together * self.span
        last_one = self._runs >= LADDER.most_runs
        over = last_one or (before.done and last.eps <= self.tol) or (alike and self.acts_without_end(last))
        over = over or (last.eps <= enough and (alike or last.eps <= enough / LADDER.ratio))
        if not over:
            return max(last.eps / LADDER.ratio, enough) if last.eps > enough else last.eps / LADDER.ratio
        if any(x.done for x in trials):
            while not trials[-1].done:
                self.failed.append(trials.pop())
        near = trials[-1].eps < LADDER.nearest * self.failed[-1].eps if self.failed else False
        if not trials[-1].done or self.reason or near or last_one:
            return None
        return self._between(trials[-1])

    def _between(self, passed: Trial) -> float:
        """An eps between the last complete run and the failed run next to it: their geometric mean."""
        return float(np.sqrt(passed.eps * self.failed[-1].eps))

    @property
    def _runs(self) -> int:
        """The number of runs so far."""
        return len(self.trials) + len(self.failed)

    def _why(self, failed: Trial) -> str | None:
        """The reason why the tolerance is not reached, if a run failed because of short steps; None if the model is the
        reason."""
        if failed.status == S.TOO_SMALL:
            return "with shorter steps rounding dominates the error of a step"
        if failed.status == S.DIVERGED and any(x is failed for x in self.failed):
            return f"with shorter steps Newton's iteration does not converge at t = {failed.t[-1]:.6g} s"
        return None

    # -- the result --------------------------------------------------------------------------------------------
    def finish(self) -> tuple[int, Calibrated]:
        """The status and the estimate of the best run, which becomes the present one of the motion."""
        trials, motion = self.trials, self.motion
        best = trials[-1]
        whole = [x for x in trials if x.done and len(x.claim)]
        if self.failed and not best.error <= self.tol:
            best = self.failed[-1]
        if not best.done and whole and (why := self._why(best)):
            self.reason = why
            best = min(reversed(whole), key=lambda x: x.error)
        elif best.done and best.error > self.tol and (best.differs < LADDER.saturated or not np.isfinite(best.differs)):
            best = min(reversed(whole), key=lambda x: x.error, default=best)
        status = best.status
        motion.recall(best.kept)
        others = [x for x in [*trials, *self.failed] if x is not best or self.again]
        motion.trial_steps = self.lost + sum(x.steps for x in others)
        if self.again:
            plan, held = self.plan, self._held_to(best.eps)
            motion.restart(replace(plan, tol=held.tol, longest=held.longest))
            motion.purpose = "the last run again, with all outputs"
            status = self.integrate()
        if not len(best.claim):
            return status, Calibrated()
        if self.growth is None and best.done:
            lost = self.lost
            self._hopeless(best)
            motion.trial_steps += self.lost - lost
            status = S.RUNNING if self.interrupted else status
        n = min(len(best.claim), len(best.t))
        claim = np.maximum(best.claim[:n], np.maximum(self._rounding(best), self._of_times(best))[:n])
        if claim[-1] <= self.tol:
            return status, Calibrated(float(claim[-1]))
        kept = np.flatnonzero(~(claim <= self.tol))[0]
        horizon = float(best.t[max(0, kept - 1)])
        if best.contacts[kept] > self.tol:
            self.reason = CONTACT if best.event is None else OTHER_EVENTS.format(best.event.text)
        if not self.reason and self.growth is not None:
            self.reason = self._of_rounding()
        error = float(claim[-1]) if np.isfinite(claim[-1]) else None
        return status, Calibrated(error, horizon, self.reason)  # a run that failed has its own reason
