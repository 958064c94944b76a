"""The step of the methods with one system of equations per step: Newmark, HHT, generalized-alpha, BDF, kinematic.

Prediction from the steps before, Newton's iteration, error estimate, search for switches, rejection. The methods differ
in their formulas only, so that a comparison of methods compares nothing else:

    motion(h, run)               POSITION and VELOCITY from UNKNOWN (and UNKNOWN2)
    residual(h, run)             RESIDUAL (and RESIDUAL2), from FORCE and FORCE2 as evaluated
    matrix(t, h, run)            the iteration matrices, factorised; False if that failed
    correct(k, h, run)           solves for the corrections and applies them; the largest change of a position
    finish(h, run)               the method's own history, in rows and memory of its own

A method with controlled steps has in addition ``local_error`` and, where its history depends on the length of a step,
``change_step``; see :mod:`mbdsl.integrators.loop.step_control`. Rows of ``run.vectors`` are in capitals.
"""

from mbdsl.integrators.loop import loop_state as S
from mbdsl.integrators.loop.coupled_correction import FAR
from mbdsl.integrators.loop.linear_solve import DENSE
from mbdsl.integrators.loop.newton import newton
from mbdsl.integrators.loop.rotation_chart import from_rates
from mbdsl.integrators.loop.run_data import evaluate
from mbdsl.integrators.loop.step_control import (
    after,
    best_order_uneven,
    change,
    even,
    is_short,
    next_trial,
    predict_uneven,
    remember,
    to_grid,
)
from mbdsl.integrators.loop.step_times import end_of_step, in_reach
from mbdsl.integrators.loop.switch_location import (
    BEHIND,
    REACTIONS,
    TURNING,
    evaluate_behind,
    length_before_switch,
    until_switch,
)
from mbdsl.kernels import buffer_layout as L
from mbdsl.kernels.marks import kernel, rare
from mbdsl.numerics.rotation import half, turn, untangled

#: steps after which the order of extrapolation is chosen again, since it seldom changes
RECONSIDER = 4
#: orders above 3 amplify the remaining error of the iteration: they are chosen only if they reduce the error of the
#: prediction to this fraction
CLEARLY = 0.1


# -- prediction --------------------------------------------------------------------------------------------------------


@kernel
def older_rows(unknown, run):
    """The first of the rows with UNKNOWN (unknown 0) or UNKNOWN2 (unknown 1) of the steps before the last four."""
    return run.vectors.shape[0] - (2 - unknown) * run.integers[S.OLDER]


@kernel
def older_differences(unknown, i, run):
    """The fourth and fifth difference of the last steps, which raise the order of an extrapolation to 4 and to 5."""
    y, a, b = run.vectors, L.UNKNOWN0 + L.PAST * unknown, older_rows(unknown, run)
    fourth = y[a, i] - 4.0 * (y[a + 1, i] + y[a + 3, i]) + 6.0 * y[a + 2, i] + y[b, i]
    before = y[a + 1, i] - 4.0 * (y[a + 2, i] + y[b, i]) + 6.0 * y[a + 3, i] + y[b + 1, i]
    return fourth, fourth - before


@kernel
def predict(unknown, order, n, run):
    """UNKNOWN (unknown 0) or UNKNOWN2 (unknown 1) by polynomial extrapolation of the last steps."""
    vectors = run.vectors
    x, a = L.UNKNOWN + unknown, L.UNKNOWN0 + L.PAST * unknown
    for i in range(n):
        if order == 0:
            vectors[x, i] = vectors[a, i]
        elif order == 1:
            vectors[x, i] = 2.0 * vectors[a, i] - vectors[a + 1, i]
        elif order == 2:
            vectors[x, i] = 3.0 * (vectors[a, i] - vectors[a + 1, i]) + vectors[a + 2, i]
        else:
            vectors[x, i] = 4.0 * (vectors[a, i] + vectors[a + 2, i]) - 6.0 * vectors[a + 1, i] - vectors[a + 3, i]
    if order > 3:
        for i in range(n):
            d4, d5 = older_differences(unknown, i, run)
            vectors[x, i] += d4 if order == 4 else d4 + d5


@kernel
def best_order(history, n, run):
    """The order of the extrapolation closest to the step just done: high for smooth motion, 0 for oscillations."""
    vectors = run.vectors
    x, a = L.UNKNOWN, L.UNKNOWN0
    e0, e1, e2, e3 = 0.0, 0.0, 0.0, 0.0
    for i in range(n):
        d0 = vectors[x, i] - vectors[a, i]
        d1 = d0 - (vectors[a, i] - vectors[a + 1, i])
        d2 = d1 - (vectors[a, i] - 2.0 * vectors[a + 1, i] + vectors[a + 2, i])
        d3 = d2 - (vectors[a, i] - 3.0 * (vectors[a + 1, i] - vectors[a + 2, i]) - vectors[a + 3, i])
        s = vectors[L.SCALE, i]
        e0, e1, e2, e3 = max(e0, s * abs(d0)), max(e1, s * abs(d1)), max(e2, s * abs(d2)), max(e3, s * abs(d3))
    best, error = 0, e0
    if history > 1 and e1 < error:
        best, error = 1, e1
    if history > 2 and e2 < error:
        best, error = 2, e2
    if history > 3 and e3 < error:
        best, error = 3, e3
    return best_of_older(best, error, history, n, run) if history > 4 else best


@kernel
def best_of_older(best, error, history, n, run):
    """``best``, or order 4 or 5 if its error is below ``error``."""
    vectors, e4, e5 = run.vectors, 0.0, 0.0
    x, a = L.UNKNOWN, L.UNKNOWN0
    for i in range(n):
        fourth, fifth = older_differences(0, i, run)
        third = 4.0 * (vectors[a, i] + vectors[a + 2, i]) - 6.0 * vectors[a + 1, i] - vectors[a + 3, i]
        d4, s = vectors[x, i] - third - fourth, vectors[L.SCALE, i]
        e4, e5 = max(e4, s * abs(d4)), max(e5, s * abs(d4 - fifth))
    if e4 < CLEARLY * error:
        best, error = 4, e4
    if history > 5 and e5 < CLEARLY * error:
        best = 5
    return best


# -- prediction for bodies that turn far in a step ---------------------------------------------------------------------


@kernel
def turns(h, run):
    """Whether the history has to be turned for a prediction: a body turns by more than FAR in a step of a stabilised
    method, whose tolerance for velocities takes the iteration close to rounding."""
    layout, v, most = run.layout, run.vectors[L.VELOCITY0], 0.0
    for r in range(layout[L.N_ROTATIONS] if run.integers[S.STABILISED] else 0):
        d = layout[layout[L.ROTATIONS] + 2 * r]
        most = max(most, v[d] * v[d] + v[d + 1] * v[d + 1] + v[d + 2] * v[d + 2])
    return h * h * most > FAR * FAR


@rare
def turn_history(way, rows, h, run):
    """Turn the unknowns of the last steps, of bodies that turn far, from body axes of their time to those expected at
    the end of the step (``way`` 1), or back (-1).

    In body axes, the vectors of a body on a moving axle oscillate with its spin. In axes of one time, they are as
    smooth as the motion of the axle.
    """
    reals, integers, layout, y = run.reals, run.integers, run.layout, run.vectors
    rows = rows if even(run) else min(rows, L.PAST)  # unequal steps have the times of these alone
    for r in range(layout[L.N_ROTATIONS]):
        d = layout[layout[L.ROTATIONS] + 2 * r]
        a, b, c = y[L.VELOCITY0, d], y[L.VELOCITY0, d + 1], y[L.VELOCITY0, d + 2]
        for k in range(rows if h * h * (a * a + b * b + c * c) > FAR * FAR else 0):
            s = -way * ((k + 1) * h if even(run) else reals[S.NOW] + h - reals[S.TIMES + k])
            w, p = half(s * a, s * b, s * c)
            p *= s
            for unknown in range(1 + integers[S.STABILISED]):
                row = L.UNKNOWN0 + L.PAST * unknown + k if k < L.PAST else older_rows(unknown, run) + k - L.PAST
                turn(w, p * a, p * b, p * c, y[row, d:])


# -- one attempt -------------------------------------------------------------------------------------------------------


@kernel
def solve_step(t, h, formulas, run):
    """Predict and solve for the unknowns at t; a status.

    After a failure, the iteration starts again from the unknowns of the last step with a new matrix; with fixed steps
    a third time, damped.
    """
    integers, layout, controlled = run.integers, run.layout, run.integers[S.CONTROLLED] > 0
    status = S.DIVERGED
    for attempt in range(3):
        turned, rows = turns(h, run), min(integers[S.ORDER] + 1, integers[S.HISTORY])
        if turned:
            turn_history(1, rows, h, run)
        for k in range(1 + integers[S.STABILISED]):
            if even(run):
                predict(k, min(integers[S.ORDER], integers[S.SAME]), layout[L.N_ALL], run)
            else:
                predict_uneven(k, min(integers[S.ORDER], 3), h, run)
        if turned:
            turn_history(-1, rows, h, run)
        status = newton(attempt == 2, t, h, formulas, run)
        if status == S.RUNNING or (controlled and attempt == 1):
            break
        integers[S.FRESH], integers[S.ORDER] = 0, 0
    return status


@rare
def reject(error, status, h, formulas, run):
    """The next attempt is shorter; RETRY, or the status of the failure if it would be too short."""
    integers = run.integers
    new = next_trial(error if status == S.RUNNING else 1e300, h, run)
    if is_short(new, run):
        return S.TOO_SMALL if status == S.RUNNING else status
    integers[S.REJECTED] += 1
    integers[S.IN_A_ROW] += 1
    integers[S.CUT] = 0
    change(new, formulas, run)
    return S.RETRY


@rare
def cut(part, h, formulas, run):
    """The next attempt ends shortly before a switch changes; RETRY, or EVENT if that leaves no room for a step."""
    new = length_before_switch(part, h, run)
    if new == 0.0:
        if run.reals[S.GRID] > 0.0:
            run.integers[S.CUT] = 0  # no step was done: the switch is at a distance that is left to the event
        return S.EVENT
    change(new, formulas, run)
    return S.RETRY


@kernel
def leaps(run):
    """Whether the unknowns change by more from step to step than any motion worth following; of states, whose size may
    not be known, nothing is said."""
    vectors, jump = run.vectors, 0.0
    for i in range(run.layout[L.N_Q] - run.layout[L.N_STATES]):
        jump = max(jump, abs(vectors[L.UNKNOWN, i] - vectors[L.UNKNOWN0, i]) * vectors[L.SCALE, i])
    return run.reals[S.UNIT] * jump > run.reals[S.WILD]


# -- the step, as the loop calls it ------------------------------------------------------------------------------------


@kernel
def trial_length(run):
    """The length to try [s]."""
    if run.reals[S.GRID] > 0.0 and run.integers[S.CUT] == 0:
        return to_grid(run)
    return in_reach(run.reals[S.STEP_SIZE], run)


@kernel
def take(t0, h, formulas, run):
    """Try a step of length h from t0; a status, h, and the error relative to what is allowed."""
    integers, layout, controlled, error = run.integers, run.layout, run.integers[S.CONTROLLED] > 0, 0.0
    if h < run.reals[S.STEP_SIZE] or (h > run.reals[S.STEP_SIZE] and run.reals[S.GRID] > 0.0):  # to a zone, to the grid
        change(h, formulas, run)
    status = solve_step(end_of_step(t0, h, run), h, formulas, run)
    if status == S.RUNNING:
        formulas.motion(h, run)
        if controlled and run.reals[S.GRID] == 0.0:
            error = formulas.estimate(h, formulas, run)
    accepted = status == S.RUNNING and (not controlled or error <= 1.0)
    if status != S.SINGULAR or layout[L.SOLVER] == DENSE:  # otherwise the run continues with the dense solver
        if integers[S.WATCHING]:
            if integers[S.WATCHING] >= REACTIONS and status == S.RUNNING:
                evaluate(end_of_step(t0, h, run), run)
            elif integers[S.WATCHING] == BEHIND and status == S.RUNNING:
                evaluate_behind(end_of_step(t0, h, run), run)
            part = until_switch(status, accepted, h, run)
            if part < 1.0:
                return cut(part, h, formulas, run), h, error
            if integers[S.WATCHING] == TURNING and status == S.DIVERGED and (not controlled or run.reals[S.GRID] > 0.0):
                integers[S.CUT] = 0
                return S.EVENT, h, error  # the direction of sliding turns ever faster where a joint stops
        if controlled and not accepted and run.reals[S.GRID] == 0.0:
            return reject(error, status, h, formulas, run), h, error
    if status != S.RUNNING:
        return status, h, error
    formulas.finish(h, run)
    if not controlled and leaps(run):
        return S.TOO_LARGE, h, error
    if integers[S.STEP] % RECONSIDER == 0 or integers[S.HISTORY] < L.PAST + integers[S.OLDER] or integers[S.ORDER] == 0:
        history, n, turned = min(integers[S.HISTORY], integers[S.SAME] + 1), layout[L.N_Q], turns(h, run)
        if turned:
            turn_history(1, integers[S.HISTORY], h, run)
        integers[S.ORDER] = (
            best_order(history, n, run) if even(run) else best_order_uneven(integers[S.HISTORY], h, n, run)
        )
        if turned:
            turn_history(-1, integers[S.HISTORY], h, run)
    return S.RUNNING, h, error


@kernel
def cubic(x, q0, v0, q1, v1):
    """The cubic with values q0, q1 and derivatives v0, v1 at 0 and 1, at x; and its derivative."""
    c2, c3 = 3.0 * (q1 - q0) - 2.0 * v0 - v1, 2.0 * (q0 - q1) + v0 + v1
    return q0 + x * (v0 + x * (c2 + x * c3)), v0 + x * (2.0 * c2 + x * 3.0 * c3)


@kernel
def interpolate(k, x, h, out, run):
    """q and v at the part x of the step by cubic Hermite interpolation; of rotations, psi, whose rate at the end of the
    step is T(psi)^{-1} Omega."""
    vectors, layout, n = run.vectors, run.layout, run.layout[L.N_Q]
    for i in range(n):
        q0, v0 = vectors[L.POSITION0, i], h * vectors[L.VELOCITY0, i]
        q1, v1 = vectors[L.POSITION, i], h * vectors[L.VELOCITY, i]
        q, v = cubic(x, q0, v0, q1, v1)
        out[k, i] = q
        out[k, n + i] = v / h
    for r in range(layout[L.N_ROTATIONS]):
        d = layout[layout[L.ROTATIONS] + 2 * r]
        psi, end = vectors[L.POSITION, d:], vectors[L.VELOCITY, d:]
        w = untangled(psi, end[0], end[1], end[2])
        for j in range(3):
            q, v = cubic(x, vectors[L.POSITION0, d + j], h * vectors[L.VELOCITY0, d + j], psi[j], h * w[j])
            out[k, d + j] = q
            out[k, n + d + j] = v / h
    from_rates(out[k], out[k, n:], run)


@kernel
def store(h, run):
    """The step becomes history."""
    integers, vectors, layout = run.integers, run.vectors, run.layout
    for i in range(layout[L.N_Q]):
        vectors[L.POSITION0, i], vectors[L.VELOCITY0, i], vectors[L.FORCE0, i] = (
            vectors[L.POSITION, i],
            vectors[L.VELOCITY, i],
            vectors[L.FORCE, i],
        )
    for k in range(1 + integers[S.STABILISED]):
        a = L.UNKNOWN0 + L.PAST * k
        if integers[S.OLDER] > 0:
            b = older_rows(k, run)
            for i in range(layout[L.N_ALL]):
                vectors[b + 1, i], vectors[b, i] = vectors[b, i], vectors[a + 3, i]
        for i in range(layout[L.N_ALL]):
            vectors[a + 3, i], vectors[a + 2, i], vectors[a + 1, i], vectors[a, i] = (
                vectors[a + 2, i],
                vectors[a + 1, i],
                vectors[a, i],
                vectors[L.UNKNOWN + k, i],
            )
    if integers[S.CONTROLLED]:
        remember(h, run)


@kernel
def next_length(error, h, times, formulas, run):
    """Controlled steps: set the length of the next step from the error of this one."""
    if run.integers[S.CONTROLLED]:
        control(error, h, times, formulas, run)


@rare
def control(error, h, times, formulas, run):
    """Set the length of the next step; the iteration matrix and the extrapolation are kept where h is."""
    reals, integers, vectors = run.reals, run.integers, run.vectors
    for i in range(run.layout[L.N_Q]):
        reals[S.SPEED] = max(reals[S.SPEED], abs(vectors[L.VELOCITY0, i]) * vectors[L.SCALE, i])
    integers[S.SAME] += 1
    new = after(error, times, run)
    integers[S.SINCE] += 1
    integers[S.IN_A_ROW] = 0
    if new != h or integers[S.SAME] < 3:
        change(new, formulas, run)
