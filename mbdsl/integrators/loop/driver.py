"""The step loop of every method: history, prediction, Newton's iteration, controlled steps, events, output.

A method gives the formulas, and all else is here, so that a comparison of methods compares methods and nothing else:

    motion(h, run)               POSITION and VELOCITY from UNKNOWN (and UNKNOWN2)
    residual(h, run)             RESIDUAL (and RESIDUAL2), from FORCE and FORCE2, as evaluated
    matrix(t, h, run)            the iteration matrices, factorised; False where that failed
    correct(k, h, run)           the corrections solved for and applied; how far positions moved
    finish(h, run)               what the method keeps of the step, in rows and memory that are its own

Rows of ``run.vectors`` are in capitals; ``run`` is a :class:`mbdsl.integrators.loop.run_data.RunData`.
Compiled once a method; allocates nothing.
"""

from __future__ import annotations

from mbdsl.compilation.buffer_layout import (
    FORCE,
    FORCE0,
    N_ALL,
    N_Q,
    PAST,
    POSITION,
    POSITION0,
    SCALE,
    SOLVER,
    UNKNOWN,
    UNKNOWN0,
    VELOCITY,
    VELOCITY0,
)
from mbdsl.compilation.marks import kernel, rare
from mbdsl.integrators.loop.linear_solve import DENSE
from mbdsl.integrators.loop.loop_state import (
    CONTROLLED,
    CUT,
    DIVERGED,
    DONE,
    EVENT,
    EVERY,
    FRESH,
    HISTORY,
    IN_A_ROW,
    LAST_STEP,
    LOOK,
    NEXT_EVENT,
    NOTES,
    NOW,
    ORDER,
    OUTPUT,
    REJECTED,
    RUNNING,
    SAME,
    SINCE,
    SINGULAR,
    SPEED,
    STABILISED,
    START,
    STEP,
    STEP_END,
    STEP_SIZE,
    STOP,
    TOO_LARGE,
    TOO_SMALL,
    UNCUT,
    UNIT,
    WATCHING,
    WILD,
    ZONES,
)
from mbdsl.integrators.loop.newton import newton
from mbdsl.integrators.loop.step_control import (
    after,
    best_order_uneven,
    change,
    even,
    is_short,
    next_trial,
    predict_uneven,
    remember,
)
from mbdsl.integrators.loop.switch_location import SHORT_OF, until_switch
from mbdsl.integrators.loop.turn_counting import count_turns
from mbdsl.integrators.loop.zone_landing import note, until_zone

#: steps after which it is asked again which extrapolation is best: which does not change from one step to the next
RECONSIDER = 4


@kernel
def predict(unknown, order, n, run):
    """UNKNOWN (unknown 0) or UNKNOWN2 (unknown 1) by polynomial extrapolation of the last steps."""
    vectors = run.vectors
    x, a = UNKNOWN + unknown, UNKNOWN0 + PAST * unknown
    for i in range(n):
        if order == 0:
            vectors[x, i] = vectors[a, i]
        elif order == 1:
            vectors[x, i] = 2.0 * vectors[a, i] - vectors[a + 1, i]
        elif order == 2:
            vectors[x, i] = 3.0 * (vectors[a, i] - vectors[a + 1, i]) + vectors[a + 2, i]
        else:
            vectors[x, i] = 4.0 * (vectors[a, i] + vectors[a + 2, i]) - 6.0 * vectors[a + 1, i] - vectors[a + 3, i]


@kernel
def best_order(history, n, run):
    """Which extrapolation would have met the step just done best: smooth motion likes high orders, ringing none."""
    vectors = run.vectors
    x, a = UNKNOWN, UNKNOWN0
    e0, e1, e2, e3 = 0.0, 0.0, 0.0, 0.0
    for i in range(n):
        d0 = vectors[x, i] - vectors[a, i]
        d1 = d0 - (vectors[a, i] - vectors[a + 1, i])
        d2 = d1 - (vectors[a, i] - 2.0 * vectors[a + 1, i] + vectors[a + 2, i])
        d3 = d2 - (vectors[a, i] - 3.0 * (vectors[a + 1, i] - vectors[a + 2, i]) - vectors[a + 3, i])
        s = vectors[SCALE, i]
        e0, e1, e2, e3 = max(e0, s * abs(d0)), max(e1, s * abs(d1)), max(e2, s * abs(d2)), max(e3, s * abs(d3))
    best, error = 0, e0
    if history > 1 and e1 < error:
        best, error = 1, e1
    if history > 2 and e2 < error:
        best, error = 2, e2
    if history > 3 and e3 < error:
        best, error = 3, e3
    return best


@rare
def record(t0, h, times, out, run):
    """Output times passed by this step: q, v by cubic Hermite interpolation, multipliers linearly."""
    integers, vectors, layout = run.integers, run.vectors, run.layout
    n, size = layout[N_Q], layout[N_ALL]
    while integers[OUTPUT] < times.size and times[integers[OUTPUT]] <= t0 + h + 1e-9 * h:
        k = integers[OUTPUT]
        x = (times[k] - t0) / h
        if x > 1.0 - 1e-9:
            x = 1.0
        for i in range(n):
            q0, v0, q1, v1 = (
                vectors[POSITION0, i],
                h * vectors[VELOCITY0, i],
                vectors[POSITION, i],
                h * vectors[VELOCITY, i],
            )
            if x == 1.0:
                out[k, i], out[k, n + i] = q1, vectors[VELOCITY, i]
            else:
                c2, c3 = 3.0 * (q1 - q0) - 2.0 * v0 - v1, 2.0 * (q0 - q1) + v0 + v1
                out[k, i] = q0 + x * (v0 + x * (c2 + x * c3))
                out[k, n + i] = (v0 + x * (2.0 * c2 + x * 3.0 * c3)) / h
        for i in range(n, size):
            out[k, n + i] = vectors[UNKNOWN0, i] + x * (vectors[UNKNOWN, i] - vectors[UNKNOWN0, i])
        integers[OUTPUT] += 1


@kernel
def shift(unknowns, n, size, run):
    """The step becomes history."""
    vectors = run.vectors
    for i in range(n):
        vectors[POSITION0, i], vectors[VELOCITY0, i], vectors[FORCE0, i] = (
            vectors[POSITION, i],
            vectors[VELOCITY, i],
            vectors[FORCE, i],
        )
    for k in range(unknowns):
        a = UNKNOWN0 + PAST * k
        for i in range(size):
            vectors[a + 3, i], vectors[a + 2, i], vectors[a + 1, i], vectors[a, i] = (
                vectors[a + 2, i],
                vectors[a + 1, i],
                vectors[a, i],
                vectors[UNKNOWN + k, i],
            )


@rare
def reject(new, status, formulas, run):
    """The step is tried again with another length; a status."""
    integers = run.integers
    if is_short(new, run):
        return TOO_SMALL if status == RUNNING else status
    integers[REJECTED] += 1
    integers[IN_A_ROW] += 1
    integers[CUT] = 0
    change(new, formulas, run)
    return RUNNING


@rare
def cut(part, formulas, run):
    """The step is tried again up to shortly before a switch changes; a status."""
    reals, integers = run.reals, run.integers
    if integers[CUT] == 0:
        reals[UNCUT] = reals[STEP_SIZE]
    new = part * (1.0 - min(0.5, SHORT_OF * 10.0 ** integers[CUT])) * reals[STEP_SIZE]
    if is_short(new, run):
        return EVENT
    integers[REJECTED] += 1
    integers[CUT] += 1
    change(new, formulas, run)
    return RUNNING


@rare
def go_on(error, h, times, formulas, run):
    """After a controlled step was accepted: its end is now, and how long the next one is."""
    reals, integers, vectors, layout = run.reals, run.integers, run.vectors, run.layout
    remember(h, run)
    reals[NOW] = reals[STEP_END]
    for i in range(layout[N_Q]):
        reals[SPEED] = max(reals[SPEED], abs(vectors[VELOCITY0, i]) * vectors[SCALE, i])
    integers[SAME] += 1
    new = after(error, times, run)
    integers[SINCE] += 1
    integers[IN_A_ROW] = 0
    if new != h or integers[SAME] < 3:
        change(new, formulas, run)


@kernel
def advance(formulas, steps, times, out, run):
    """At most ``steps`` steps, rejected ones included; a status. Everything needed to go on is in the buffers."""
    reals, integers, vectors, layout = run.reals, run.integers, run.vectors, run.layout
    n, size, unknowns, controlled = layout[N_Q], layout[N_ALL], 1 + integers[STABILISED], integers[CONTROLLED] > 0
    error = 0.0
    for _ in range(steps):
        if integers[ZONES] > 0:
            h = until_zone(reals[STEP_SIZE], run)
            if h == 0.0:
                return LOOK
            if h < reals[STEP_SIZE]:
                change(h, formulas, run)
        step, h = integers[STEP], reals[STEP_SIZE]
        if controlled:
            t0 = reals[NOW]
            if t0 >= reals[STOP]:
                return DONE
            # the stop time is hit exactly, not by adding up
            end = min(reals[STOP], reals[NEXT_EVENT])
            t = end if t0 + h >= end - 1e-9 * h else t0 + h
            if integers[EVERY]:
                times[integers[OUTPUT]] = t
        else:
            if step >= integers[LAST_STEP]:
                return DONE
            t0 = reals[START] + step * h
            t = reals[STOP] if step == integers[LAST_STEP] - 1 else reals[START] + (step + 1) * h
            t = min(t, reals[NEXT_EVENT])
        reals[STEP_END] = t
        status = DIVERGED
        for attempt in range(3):
            for k in range(unknowns):
                if even(run):
                    predict(k, integers[ORDER], size, run)
                else:
                    predict_uneven(k, integers[ORDER], h, run)
            status = newton(attempt == 2, t, h, formulas, run)
            if status == RUNNING or (controlled and attempt == 1):
                break
            integers[FRESH], integers[ORDER] = 0, 0  # once more, from the last step and with a new matrix
        if status == RUNNING:
            formulas.motion(h, run)
            if controlled:
                error = formulas.estimate(h, formulas, run)
        accepted = status == RUNNING and (not controlled or error <= 1.0)
        searching = status != SINGULAR or layout[SOLVER] == DENSE  # else somebody goes on with the other solver
        if integers[WATCHING] and searching:
            part = until_switch(status, accepted, h, run)
            if part < 1.0:
                status = cut(part, formulas, run)
                if status == RUNNING:
                    continue
                return status
        if controlled and searching and not accepted:
            new = next_trial(error if status == RUNNING else 1e300, h, run)
            status = reject(new, status, formulas, run)
            if status == RUNNING:
                continue
        if status != RUNNING:
            return status
        formulas.finish(h, run)
        if not controlled:
            jump = 0.0
            for i in range(n):
                jump = max(jump, abs(vectors[UNKNOWN, i] - vectors[UNKNOWN0, i]) * vectors[SCALE, i])
            if reals[UNIT] * jump > reals[WILD]:
                return TOO_LARGE
        if step % RECONSIDER == 0 or integers[HISTORY] < 4 or integers[ORDER] == 0:
            integers[ORDER] = (
                best_order(integers[HISTORY], n, run) if even(run) else best_order_uneven(integers[HISTORY], h, n, run)
            )
        if integers[OUTPUT] < times.size and times[integers[OUTPUT]] <= t0 + h + 1e-9 * h:
            record(t0, h, times, out, run)
        shift(unknowns, n, size, run)
        count_turns(run)
        if integers[NOTES] > 0:
            note(run)
        integers[HISTORY] = min(integers[HISTORY] + 1, 4)
        integers[STEP] = step + 1
        if controlled:
            go_on(error, h, times, formulas, run)
            if integers[CUT] > 0 or reals[NOW] >= reals[NEXT_EVENT]:
                return EVENT
        elif t >= reals[NEXT_EVENT]:
            return EVENT
    if controlled:
        return DONE if reals[NOW] >= reals[STOP] else RUNNING
    return DONE if integers[STEP] >= integers[LAST_STEP] else RUNNING
