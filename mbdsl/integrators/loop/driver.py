"""The step loop of every method: history, prediction, Newton's iteration, controlled steps, events, output.

A method gives the formulas, and all else is here, so that a comparison of methods compares methods and nothing else:

    motion(h, c, Y, I)                 q and v at the end of the step from the unknowns X (and X2)
    residual(h, c, Y, F, I)            R (and R2), from what evaluate left in FP and GD
    matrix(tangent, ..., A, P)         the iteration matrices, factorised; False where that failed
    correct(k, h, c, Y, I, A, P)       the corrections solved for and applied; how far positions moved
    finish(inertia, h, c, Y, F, I, A, P)       what the method keeps of the step, in the rows that are its own

Compiled once a method; allocates nothing.
"""

from __future__ import annotations

from mbdsl.compilation.buffer_layout import F0, FP, N_ALL, N_Q, PAST, Q0, SCALE, SOLVER, V0, XA, Q, V, X
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
    STOP,
    TOO_LARGE,
    TOO_SMALL,
    UNCUT,
    UNIT,
    WATCHING,
    WILD,
    ZONES,
    H,
    T,
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
def predict(unknown, order, n, Y):
    """X (unknown 0) or X2 (unknown 1) by polynomial extrapolation of the last steps."""
    x, a = X + unknown, XA + PAST * unknown
    for i in range(n):
        if order == 0:
            Y[x, i] = Y[a, i]
        elif order == 1:
            Y[x, i] = 2.0 * Y[a, i] - Y[a + 1, i]
        elif order == 2:
            Y[x, i] = 3.0 * (Y[a, i] - Y[a + 1, i]) + Y[a + 2, i]
        else:
            Y[x, i] = 4.0 * (Y[a, i] + Y[a + 2, i]) - 6.0 * Y[a + 1, i] - Y[a + 3, i]


@kernel
def best_order(history, n, Y):
    """Which extrapolation would have met the step just done best: smooth motion likes high orders, ringing none."""
    x, a = X, XA
    e0, e1, e2, e3 = 0.0, 0.0, 0.0, 0.0
    for i in range(n):
        d0 = Y[x, i] - Y[a, i]
        d1 = d0 - (Y[a, i] - Y[a + 1, i])
        d2 = d1 - (Y[a, i] - 2.0 * Y[a + 1, i] + Y[a + 2, i])
        d3 = d2 - (Y[a, i] - 3.0 * (Y[a + 1, i] - Y[a + 2, i]) - Y[a + 3, i])
        s = Y[SCALE, i]
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
def record(t0, h, K, J, Y, I, times, out):
    """Output times passed by this step: q, v by cubic Hermite interpolation, multipliers linearly."""
    n, size = I[N_Q], I[N_ALL]
    while J[OUTPUT] < times.size and times[J[OUTPUT]] <= t0 + h + 1e-9 * h:
        k = J[OUTPUT]
        x = (times[k] - t0) / h
        if x > 1.0 - 1e-9:
            x = 1.0
        for i in range(n):
            q0, v0, q1, v1 = Y[Q0, i], h * Y[V0, i], Y[Q, i], h * Y[V, i]
            if x == 1.0:
                out[k, i], out[k, n + i] = q1, Y[V, i]
            else:
                c2, c3 = 3.0 * (q1 - q0) - 2.0 * v0 - v1, 2.0 * (q0 - q1) + v0 + v1
                out[k, i] = q0 + x * (v0 + x * (c2 + x * c3))
                out[k, n + i] = (v0 + x * (2.0 * c2 + x * 3.0 * c3)) / h
        for i in range(n, size):
            out[k, n + i] = Y[XA, i] + x * (Y[X, i] - Y[XA, i])
        J[OUTPUT] += 1


@kernel
def shift(unknowns, n, size, Y):
    """The step becomes history."""
    for i in range(n):
        Y[Q0, i], Y[V0, i], Y[F0, i] = Y[Q, i], Y[V, i], Y[FP, i]
    for k in range(unknowns):
        a = XA + PAST * k
        for i in range(size):
            Y[a + 3, i], Y[a + 2, i], Y[a + 1, i], Y[a, i] = Y[a + 2, i], Y[a + 1, i], Y[a, i], Y[X + k, i]


@rare
def reject(new, status, change_step, evaluate, tangent, inertia, c, K, J, Y, Z, C, F, I, A, P):
    """The step is tried again with another length; a status."""
    if is_short(new, K):
        return TOO_SMALL if status == RUNNING else status
    J[REJECTED] += 1
    J[IN_A_ROW] += 1
    J[CUT] = 0
    change(change_step, evaluate, tangent, inertia, new, c, K, J, Y, Z, C, F, I, A, P)
    return RUNNING


@rare
def cut(part, change_step, evaluate, tangent, inertia, c, K, J, Y, Z, C, F, I, A, P):
    """The step is tried again up to shortly before a switch changes; a status."""
    if J[CUT] == 0:
        K[UNCUT] = K[H]
    new = part * (1.0 - min(0.5, SHORT_OF * 10.0 ** J[CUT])) * K[H]
    if is_short(new, K):
        return EVENT
    J[REJECTED] += 1
    J[CUT] += 1
    change(change_step, evaluate, tangent, inertia, new, c, K, J, Y, Z, C, F, I, A, P)
    return RUNNING


@rare
def go_on(error, h, change_step, evaluate, tangent, inertia, c, K, J, Y, Z, C, F, I, A, P, times):
    """After a controlled step was accepted: its end is now, and how long the next one is."""
    remember(h, K)
    K[NOW] = K[T]
    for i in range(I[N_Q]):
        K[SPEED] = max(K[SPEED], abs(Y[V0, i]) * Y[SCALE, i])
    J[SAME] += 1
    new = after(error, K, J, times)
    J[SINCE] += 1
    J[IN_A_ROW] = 0
    if new != h or J[SAME] < 3:
        change(change_step, evaluate, tangent, inertia, new, c, K, J, Y, Z, C, F, I, A, P)


@kernel
def advance(
    motion,
    residual,
    matrix,
    correct,
    finish,
    estimate,
    local_error,
    change_step,
    evaluate,
    tangent,
    inertia,
    steps,
    c,
    K,
    J,
    Y,
    Z,
    C,
    F,
    I,
    A,
    P,
    times,
    out,
):
    """At most ``steps`` steps, rejected ones included; a status. Everything needed to go on is in the buffers."""
    n, size, unknowns, controlled = I[N_Q], I[N_ALL], 1 + J[STABILISED], J[CONTROLLED] > 0
    error = 0.0
    for _ in range(steps):
        if J[ZONES] > 0:
            h = until_zone(K[H], K, J)
            if h == 0.0:
                return LOOK
            if h < K[H]:
                change(change_step, evaluate, tangent, inertia, h, c, K, J, Y, Z, C, F, I, A, P)
        step, h = J[STEP], K[H]
        if controlled:
            t0 = K[NOW]
            if t0 >= K[STOP]:
                return DONE
            # the stop time is hit exactly, not by adding up
            end = min(K[STOP], K[NEXT_EVENT])
            t = end if t0 + h >= end - 1e-9 * h else t0 + h
            if J[EVERY]:
                times[J[OUTPUT]] = t
        else:
            if step >= J[LAST_STEP]:
                return DONE
            t0 = K[START] + step * h
            t = K[STOP] if step == J[LAST_STEP] - 1 else K[START] + (step + 1) * h
            t = min(t, K[NEXT_EVENT])
        K[T] = t
        status = DIVERGED
        for attempt in range(3):
            for k in range(unknowns):
                if even(J):
                    predict(k, J[ORDER], size, Y)
                else:
                    predict_uneven(k, J[ORDER], h, I, K, Y)
            status = newton(
                attempt == 2, motion, residual, matrix, correct, evaluate, tangent, t, h, c, K, J, Y, Z, C, F, I, A, P
            )
            if status == RUNNING or (controlled and attempt == 1):
                break
            J[FRESH], J[ORDER] = 0, 0  # once more, from the last step and with a new matrix
        if status == RUNNING:
            motion(h, c, Y, I)
            if controlled:
                error = estimate(local_error, inertia, h, c, K, J, Y, F, I, A, P)
        accepted = status == RUNNING and (not controlled or error <= 1.0)
        searching = status != SINGULAR or I[SOLVER] == DENSE  # else somebody goes on with the other solver
        if J[WATCHING] and searching:
            part = until_switch(status, accepted, evaluate, h, K, J, Y, Z, C, F, I)
            if part < 1.0:
                status = cut(part, change_step, evaluate, tangent, inertia, c, K, J, Y, Z, C, F, I, A, P)
                if status == RUNNING:
                    continue
                return status
        if controlled and searching and not accepted:
            new = next_trial(error if status == RUNNING else 1e300, h, K)
            status = reject(new, status, change_step, evaluate, tangent, inertia, c, K, J, Y, Z, C, F, I, A, P)
            if status == RUNNING:
                continue
        if status != RUNNING:
            return status
        finish(inertia, h, c, Y, F, I, A, P)
        if not controlled:
            jump = 0.0
            for i in range(n):
                jump = max(jump, abs(Y[X, i] - Y[XA, i]) * Y[SCALE, i])
            if K[UNIT] * jump > K[WILD]:
                return TOO_LARGE
        if step % RECONSIDER == 0 or J[HISTORY] < 4 or J[ORDER] == 0:
            J[ORDER] = best_order(J[HISTORY], n, Y) if even(J) else best_order_uneven(J[HISTORY], h, n, K, Y)
        if J[OUTPUT] < times.size and times[J[OUTPUT]] <= t0 + h + 1e-9 * h:
            record(t0, h, K, J, Y, I, times, out)
        shift(unknowns, n, size, Y)
        count_turns(Y, F, I)
        if J[NOTES] > 0:
            note(K, J, Y, I)
        J[HISTORY] = min(J[HISTORY] + 1, 4)
        J[STEP] = step + 1
        if controlled:
            go_on(error, h, change_step, evaluate, tangent, inertia, c, K, J, Y, Z, C, F, I, A, P, times)
            if J[CUT] > 0 or K[NOW] >= K[NEXT_EVENT]:
                return EVENT
        elif t >= K[NEXT_EVENT]:
            return EVENT
    if controlled:
        return DONE if K[NOW] >= K[STOP] else RUNNING
    return DONE if J[STEP] >= J[LAST_STEP] else RUNNING
