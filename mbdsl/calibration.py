"""From local errors to the error attained: how much a model magnifies what its steps get wrong.

Steps are controlled by their local errors, whose sum is kept below eps (:mod:`mbdsl.integrators.control`). What becomes
of them until the end of the run is the model's own: a damped one forgets them, in a chaotic one they grow. But the
error attained goes with eps, so that cheap runs, with eps much larger than what is asked for, tell the factor: two, or
more where these are too far apart to tell anything.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from mbdsl import error_norm
from mbdsl.integrators import declared, run, state
from mbdsl.motion import Motion, Plan

Array = NDArray[np.float64]

#: eps of the first trial run over the tolerance, and at most; of a trial run over that of the next one
FIRST, LOOSEST, NEXT = 1024.0, 4e-3, 4.0
#: part of the tolerance that is aimed at
AIM = 0.5
#: difference of two runs from which on it is no measure of their errors any more
SATURATED = 0.05
#: runs at most
MOST = 8
#: how often the factor may turn out to be larger than was thought, and the run be made again
CORRECTIONS = 3
#: outputs that trial runs are compared at, where fewer are asked for
POINTS = 200


@dataclass
class Trial:
    """A run that was made: its eps, q and v at the outputs."""

    eps: float
    q: Array
    v: Array


def calibrated(motion: Motion, tol: float, integrate: Callable[[], int]) -> int:
    """Run ``motion`` so that its error is about ``AIM * tol``; a status. ``integrate()`` runs it to its end.

    The error is the largest over outputs and coordinates, positions in the mechanism's size and angles in radians,
    velocities relative to the largest one of the run.
    """
    plan = motion.plan
    times = plan.times
    if len(times) < POINTS:
        times = np.linspace(plan.start, plan.stop, POINTS + 1)[1:]
    first = eps = min(FIRST * tol, LOOSEST)
    longest, order = run.LONGEST * (plan.stop - plan.start), max(1, declared(plan.method).order)

    def held_to(eps: float) -> Plan:
        # where steps are as long as they may be, errors are to go with eps, too
        return replace(plan, tol=eps, longest=longest * (eps / first) ** (1.0 / order))

    trials: list[Trial] = []
    factor, found = 0.0, 0.0
    for _ in range(MOST):
        motion.restart(replace(held_to(eps), times=times, every=False))
        status = integrate()
        if status != state.DONE:
            return status
        trials.append(_trial(motion, eps))
        motion.trial_steps += motion.steps
        if len(trials) > 1:
            coarse, fine = trials[-2:]
            found = distance(motion, coarse, fine)
            factor = found / (coarse.eps - fine.eps)
            # a trial run is the result where all that it differs by is small enough: errors may not go with eps yet;
            # or its steps are, where other outputs were asked for
            if found <= tol:
                motion.error = found
                if plan.times is times and not plan.every:
                    return status
                motion.restart(held_to(eps))
                return integrate()
            if found < SATURATED:
                break
        eps /= NEXT
    told = found < SATURATED
    factor = factor if told else 0.0  # runs that have nothing to do with each other tell none
    eps = min(eps / 2.0, AIM * tol / factor if factor else AIM * tol)
    for _ in range(CORRECTIONS):
        motion.restart(held_to(eps))
        status = integrate()
        if status != state.DONE or plan.times is not times or plan.every:
            break
        # the factor itself, now between errors further apart
        last = _trial(motion, eps)
        found = distance(motion, trials[-1], last)
        told = found < SATURATED
        factor = max(factor, found / (trials[-1].eps - eps))
        if factor * eps <= tol or not told:
            break
        trials.append(last)
        motion.trial_steps += motion.steps
        eps = AIM * tol / factor
    motion.error = factor * eps if told else max(found, SATURATED)
    return status


def _trial(motion: Motion, eps: float) -> Trial:
    _, q, v, *_ = motion.output(False)
    return Trial(eps, q, v)


def distance(motion: Motion, one: Trial, other: Trial) -> float:
    """What two runs of a scene differ by at its outputs."""
    scale, span = motion.system.tables.scale, motion.plan.stop - motion.plan.start
    return error_norm.distance(scale, span, (one.q, one.v), (other.q, other.v))
