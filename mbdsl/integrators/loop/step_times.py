"""When a step starts and ends, and when the run is finished.

Steps of fixed length start at START + step h, which sums up no rounding errors. A controlled step starts at the time
reached, and ends exactly at the stop time or at the next known event if it reaches that.
"""

from numpy import floor, inf

from mbdsl.integrators.loop import loop_state as S
from mbdsl.kernels.marks import kernel


@kernel
def finished(run):
    """Whether the stop time is reached."""
    reals, integers = run.reals, run.integers
    if reals[S.TOL] > 0.0:
        return reals[S.NOW] >= reals[S.STOP]
    return integers[S.STEP] >= integers[S.LAST_STEP]


@kernel
def start_of_step(run):
    """The time at which the next step starts [s]."""
    reals = run.reals
    if reals[S.TOL] > 0.0:
        return reals[S.NOW]
    return reals[S.START] + run.integers[S.STEP] * reals[S.STEP_SIZE]


@kernel
def end_in_reach(run):
    """The stop time or the next known event, to which a controlled step may be lengthened [s].

    Infinite if a zone around a peak lies before it: a lengthened step would pass over the peak.
    """
    reals, integers = run.reals, run.integers
    end = min(reals[S.STOP], reals[S.NEXT_EVENT])
    if integers[S.NEXT_ZONE] < integers[S.ZONES] and reals[S.ZONE + 2 * integers[S.NEXT_ZONE] + 1] < end:
        return inf
    return end


@kernel
def in_reach(h, run):
    """The length h of a controlled step, or a shorter one that ends at the stop time or at the next known event [s].

    The length was chosen before a clock ticked, or before a change from outside: the next event was not yet known.
    """
    reals = run.reals
    if reals[S.TOL] > 0.0:
        left = max(min(reals[S.STOP], reals[S.NEXT_EVENT]) - reals[S.NOW], reals[S.LEAST_H])
        if h > left + 1e-9 * h:
            return left
    return h


@kernel
def at_stop(run):
    """Whether only the rounding error of times is left of a run behind an event; it then ends."""
    reals = run.reals
    if reals[S.TOL] > 0.0 and reals[S.STOP] - reals[S.NOW] <= 4.0 * reals[S.LEAST_H]:
        reals[S.NOW] = max(reals[S.NOW], reals[S.STOP])
        return True
    return False


@kernel
def passed(t0, h, run):
    """The time up to which a step of length h from t0 has output: a last step that ends at an event has that of the
    stop time, too [s]."""
    reals = run.reals
    if reals[S.TOL] > 0.0 and reals[S.STOP] - (t0 + h) <= 4.0 * reals[S.LEAST_H]:
        return max(t0 + h + 1e-9 * h, reals[S.STOP])
    return t0 + h + 1e-9 * h


@kernel
def representable(h, run):
    """A length of about h whose multiples can be added to the time without rounding; h if it is below rounding [s].

    Otherwise the time would gain or lose up to half a unit in the last place in every step: late in time, a clock that
    is wrong.
    """
    latest = max(abs(run.reals[S.START]), abs(run.reals[S.STOP]))
    rounded = (latest + h) - latest
    return rounded if rounded > 0.0 else h


@kernel
def end_of_step(t0, h, run):
    """The end of a step of length h from t0 [s], which is also stored in STEP_END."""
    reals, integers = run.reals, run.integers
    if reals[S.TOL] > 0.0:
        end = end_in_reach(run)
        if reals[S.GRID] > 0.0:
            there = reals[S.START] + floor((t0 + h - reals[S.START]) / reals[S.GRID] + 0.5) * reals[S.GRID]
            if there < end - 1e-9 * h and abs(t0 + h - there) <= 1e-9 * h:
                end = there
        t = end if t0 + h >= end - 1e-9 * h else t0 + h
    else:
        last = integers[S.STEP] == integers[S.LAST_STEP] - 1
        t = reals[S.STOP] if last else reals[S.START] + (integers[S.STEP] + 1) * h
        t = min(t, reals[S.NEXT_EVENT])
    reals[S.STEP_END] = t
    return t
