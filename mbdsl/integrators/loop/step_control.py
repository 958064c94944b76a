"""Step size control: the local error of a step, the error that it may have, and the size of the next step.

A method declares the local errors of q and v (``local_error``) as functions of jerk q''' and snap q'''', which are
divided differences of the accelerations of this step and the two before. Errors along constraint normals do not count,
and neither do errors that a stiff force removes within a step. The iteration matrix, already factorised, removes both:

    [[M + ..., Phi_q^T], [Phi_q, 0]] [e; .] = [M e_raw; 0].

Velocity constraints remove the part along their normals from the error in v, but not from the error in q.

The error of a step is the largest entry of e: positions relative to the mechanism's size, angles in radians, and
velocities also relative to the largest velocity so far. With the tolerance tol, the error of the n-th step may be

    tol (h / (stop - start) + SHARE / n).

The first term adds up to tol over the run, so that the error at its end is proportional to tol for any step sizes. The
second allows steps to grow after a transient that takes a tiny part of the run; it adds up to tol SHARE log(steps).

The history of a method depends on the step size; ``change`` converts it to another step size.
"""

from math import ceil

from numpy import floor, inf

from mbdsl.integrators.loop import loop_state as S
from mbdsl.integrators.loop.error_projection import (
    are_dampers_stiff,
    damping_matrix,
    forget,
    tangential,
    tangential_position,
)
from mbdsl.integrators.loop.linear_solve import larger
from mbdsl.integrators.loop.step_times import representable
from mbdsl.kernels import buffer_layout as L
from mbdsl.kernels.marks import kernel, rare

#: additional allowed error of steps n to e n together (e = 2.718...), relative to tol
SHARE = 0.05
#: error that the next step aims at, relative to the allowed error
AIM = 0.5
#: the step size is kept if it would change by a factor between these: the iteration matrix can then be kept as well
KEPT_FROM, KEPT_TO = 0.9, 1.2
#: largest and smallest factor by which the step size changes
MOST, LEAST = 2.0, 0.2
#: the effect of stiff dampers on the error is evaluated in every step if it reduces the error below the factor USEFUL,
#: and otherwise once in SELDOM steps
USEFUL, SELDOM = 0.9, 20
#: change of a velocity within a step, relative to the largest velocity, above which the step contains an impact
BLOW = 0.5
#: number of steps after a complete estimate whose raw error may be reduced as in that estimate; largest ratio of the
#: raw errors; largest error estimated in this way, relative to the allowed one
TRUST, ALIKE, CALM = 7, 1.25, 0.75
#: number of steps that stands for infinitely many
LONG_AGO = 1 << 20


@kernel
def even(run):
    """Whether the last steps had equal sizes, so that extrapolation has constant weights."""
    integers = run.integers
    return integers[S.SAME] >= 3


# -- extrapolation from unequal steps ----------------------------------------------------------------------------------


@kernel
def weight(k, order, x, at, run):
    """The Lagrange weight at time x of the k-th newest of order + 1 values, at times reals[at], reals[at + 1], ..."""
    reals = run.reals
    w = 1.0
    for j in range(order + 1):
        if j != k:
            w *= (x - reals[at + j]) / (reals[at + k] - reals[at + j])
    return w


@kernel
def ends(h, run):
    """The times of the accelerations and of the multipliers of a step of size h that starts at NOW."""
    reals = run.reals
    return reals[S.NOW] + reals[S.NODE] * h, reals[S.NOW] + h


@rare
def predict_uneven(unknown, order, h, run):
    """UNKNOWN (unknown 0) or UNKNOWN2 (unknown 1) <- polynomial extrapolation of the last steps."""
    vectors, layout = run.vectors, run.layout
    x, a, n = L.UNKNOWN + unknown, L.UNKNOWN0 + L.PAST * unknown, layout[L.N_Q]
    for part in range(2):
        first, last, at, end = (
            (0, n, S.NODES, ends(h, run)[0]) if part == 0 else (n, layout[L.N_ALL], S.TIMES, ends(h, run)[1])
        )
        for i in range(first, last):
            vectors[x, i] = 0.0
        for k in range(order + 1):
            w = weight(k, order, end, at, run)
            for i in range(first, last):
                vectors[x, i] += w * vectors[a + k, i]


@rare
def best_order_uneven(history, h, n, run):
    """The order of extrapolation with the smallest error for the accelerations of the step just done.

    In Newton's form, the error of an order is that of the order below without one divided difference.
    """
    reals, vectors = run.reals, run.vectors
    t, t0, t1, t2, t3 = ends(h, run)[0], reals[S.NODES], reals[S.NODES + 1], reals[S.NODES + 2], reals[S.NODES + 3]
    w1, w2, w3 = 0.0, 0.0, 0.0  # of the first, second and third divided difference
    r01, r12, r23, r02, r13, r03 = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    if history > 1:
        w1, r01 = t - t0, 1.0 / (t0 - t1)
    if history > 2:
        w2, r12, r02 = w1 * (t - t1), 1.0 / (t1 - t2), 1.0 / (t0 - t2)
    if history > 3:
        w3, r23, r13, r03 = w2 * (t - t2), 1.0 / (t2 - t3), 1.0 / (t1 - t3), 1.0 / (t0 - t3)
    e0, e1, e2, e3 = 0.0, 0.0, 0.0, 0.0
    for i in range(n):
        y0, y1, y2, y3 = (
            vectors[L.UNKNOWN0, i],
            vectors[L.UNKNOWN0 + 1, i],
            vectors[L.UNKNOWN0 + 2, i],
            vectors[L.UNKNOWN0 + 3, i],
        )
        f01, f12, f23 = (y0 - y1) * r01, (y1 - y2) * r12, (y2 - y3) * r23
        f02, f13 = (f01 - f12) * r02, (f12 - f23) * r13
        d0 = vectors[L.UNKNOWN, i] - y0
        d1 = d0 - w1 * f01
        d2 = d1 - w2 * f02
        d3 = d2 - w3 * (f02 - f13) * r03
        s = vectors[L.SCALE, i]
        e0, e1, e2, e3 = max(e0, s * abs(d0)), max(e1, s * abs(d1)), max(e2, s * abs(d2)), max(e3, s * abs(d3))
    best, error = 0, e0
    if history > 1 and e1 < error:
        best, error = 1, e1
    if history > 2 and e2 < error:
        best, error = 2, e2
    if history > 3 and e3 < error:
        best = 3
    return best


@rare
def bend_uneven(h, n, run):
    """h^2 times the largest scaled second derivative of the accelerations."""
    reals, vectors = run.reals, run.vectors
    largest, d0, d1 = 0.0, reals[S.NODES] - reals[S.NODES + 1], reals[S.NODES + 1] - reals[S.NODES + 2]
    r0, r1 = 1.0 / d0, 1.0 / d1
    for i in range(n):
        d = (vectors[L.UNKNOWN0, i] - vectors[L.UNKNOWN0 + 1, i]) * r0
        d -= (vectors[L.UNKNOWN0 + 1, i] - vectors[L.UNKNOWN0 + 2, i]) * r1
        largest = max(largest, abs(d) * vectors[L.SCALE, i])
    return 2.0 * h * h / (d0 + d1) * largest


@kernel
def estimate(h, formulas, run):
    """The error of the step just tried, relative to the allowed error. Writes E_Q, E_V and E_X.

    If a force stops a motion within the step (BLOW), the step has not resolved it, and no part of the error is removed.
    To find the part that constraints and forces remove, two or more linear systems have to be solved. This part changes
    slowly: the estimate is complete in one of eight steps of equal size, and in the others the raw error is reduced by
    the same factor.
    """
    reals, integers, vectors, layout = run.reals, run.integers, run.vectors, run.layout
    n, x = layout[L.N_Q], layout[L.ACCELERATION]
    a = L.UNKNOWN0 + L.PAST * (x - L.UNKNOWN)
    d0, d1 = reals[S.NOW] + reals[S.NODE] * h - reals[S.NODES], reals[S.NODES] - reals[S.NODES + 1]
    speed, jump, r0, r1, r2 = reals[S.SPEED], 0.0, 1.0 / d0, 1.0 / d1, 2.0 / (d0 + d1)
    for i in range(n):
        jerk = (vectors[x, i] - vectors[a, i]) * r0
        snap = (jerk - (vectors[a, i] - vectors[a + 1, i]) * r1) * r2
        vectors[L.E_Q, i], vectors[L.E_V, i] = formulas.local_error(h, reals[S.LAST_H], run.coefficients, jerk, snap)
        speed = larger(abs(vectors[L.VELOCITY, i]) * vectors[L.SCALE, i], speed)
        jump = larger(abs(vectors[L.VELOCITY, i] - vectors[L.VELOCITY0, i]) * vectors[L.SCALE, i], jump)
    for i in range(n):
        vectors[L.E_X, i] = h * vectors[L.E_V, i]
    raw, most = largest_error(speed, n, run), allowed(h, run)
    if jump > BLOW * speed:
        return raw / most
    if integers[S.TRUSTED] > 0 and even(run) and reals[S.RAW] <= ALIKE * raw and raw <= ALIKE * reals[S.RAW]:
        integers[S.TRUSTED] -= 1
        if reals[S.REDUCED] * raw <= CALM * most:
            return reals[S.REDUCED] * raw / most
    damping_matrix(reals[S.STEP_END], h, run)
    tangential_position(run)
    tangential(L.E_V, 0, run)
    for i in range(n):
        vectors[L.E_X, i] = h * vectors[L.E_V, i]
    error = largest_error(speed, n, run)
    integers[S.DAMPED] = max(0, integers[S.DAMPED] - 1)
    if integers[S.DAMPED] == 0 and are_dampers_stiff(reals[S.STEP_END], h, run):
        forget(run)
        less = largest_error(speed, n, run)
        integers[S.DAMPED] = 1 if less < USEFUL * error else SELDOM
        error = min(error, less) if less == less else less
    reals[S.RAW], reals[S.REDUCED], integers[S.TRUSTED] = raw, error / raw if raw > 0.0 else 1.0, TRUST
    return error / most


@kernel
def largest_error(speed, n, run):
    """The largest scaled entry of |E_Q| + |E_X|, and of |E_V| relative to ``speed``."""
    vectors = run.vectors
    error = 0.0
    for i in range(n):
        error = larger((abs(vectors[L.E_Q, i]) + abs(vectors[L.E_X, i])) * vectors[L.SCALE, i], error)
        error = larger(abs(vectors[L.E_V, i]) * vectors[L.SCALE, i] / speed, error)
    return error


@kernel
def local_error(h, last, coefficients, jerk, snap):
    """Default for methods that declare no local errors: zero."""
    return 0.0, 0.0


@kernel
def change_step(h, run):
    """Default for methods whose own history does not depend on the step size: nothing is changed."""


# -- steps -------------------------------------------------------------------------------------------------------------


@kernel
def allowed(h, run):
    """The allowed error of a step of size h."""
    reals, integers = run.reals, run.integers
    return reals[S.TOL] * (h / (reals[S.STOP] - reals[S.START]) + SHARE / (integers[S.SINCE] + 1))


@rare
def next_trial(error, h, run):
    """The step size to be tried after a rejected step with this ``error``, which may be nan."""
    reals = run.reals
    ratio = LEAST
    if error < 1e10:
        ratio = max(LEAST, min(KEPT_FROM, (AIM / error) ** reals[S.EXPONENT]))
    return ratio * h


@rare
def after(error, times, run):
    """The step size after an accepted step with this ``error``."""
    reals, integers = run.reals, run.integers
    if reals[S.GRID] > 0.0:
        return reals[S.STEP_SIZE]
    if reals[S.GOOD] < error < reals[S.BAD]:
        return fitted(min(reals[S.STEP_SIZE], reals[S.MOST_H]), times, run)
    ratio = min(MOST if reals[S.EXPONENT] < 1.0 else 1e3, max(LEAST, (AIM / max(error, 1e-30)) ** reals[S.EXPONENT]))
    if integers[S.IN_A_ROW] > 0:
        ratio = min(ratio, 1.0)
    return fitted(min(ratio * reals[S.STEP_SIZE], reals[S.MOST_H]), times, run)


@kernel
def to_grid(run):
    """The length to the next end of a fixed step, or to the next known event; longer than a step by a sliver at most.

    A shorter step than a sliver would magnify rounding.
    """
    reals = run.reals
    now, grid, sliver = reals[S.NOW], reals[S.GRID], reals[S.SLIVER] * reals[S.GRID]
    k = floor((now - reals[S.START] + sliver) / grid) + 1.0
    stop = reals[S.STOP] if reals[S.STOP] > now else inf  # the caller of single steps moves the stop on
    end = min(reals[S.START] + k * grid, stop)
    if now < reals[S.NEXT_EVENT] < end + sliver and reals[S.NEXT_EVENT] <= stop:
        end = reals[S.NEXT_EVENT]
    elif stop < end + sliver:
        end = stop
    h = end - now
    return grid if abs(h - grid) <= 1e-9 * grid else h


@rare
def fitted(h, times, run):
    """A step size near h with which a whole number of steps ends at the stop time, the next known event, or, with
    LANDING, the next output; h itself if these are far."""
    reals, integers = run.reals, run.integers
    left = min(reals[S.STOP], reals[S.NEXT_EVENT]) - reals[S.NOW]
    if integers[S.LANDING] and integers[S.OUTPUT] < times.size:
        left = min(left, times[integers[S.OUTPUT]] - reals[S.NOW])
    if not left > 0.0 or left > 4.0 * h:
        return h
    new = left / max(1.0, ceil(left / h - 0.05))
    return h if abs(new - h) <= 1e-9 * h else new


@rare
def change(new, formulas, run):
    """Set the step size to ``new``, and convert the history of the method to it."""
    reals, integers, vectors, layout = run.reals, run.integers, run.vectors, run.layout
    new = representable(new, run)
    h, a = reals[S.STEP_SIZE], L.UNKNOWN0 + L.PAST * (layout[L.ACCELERATION] - L.UNKNOWN)
    moved, d = (reals[S.NODE] - 1.0) * (new - h), reals[S.NODES] - reals[S.NODES + 1]
    if new != h:
        integers[S.FRESH] = 0  # with the old matrix, the iteration would contract slowly, and then renew it
    formulas.change_step(new, run)
    if moved != 0.0:
        for i in range(layout[L.N_Q]):
            vectors[a, i] += moved * (vectors[a, i] - vectors[a + 1, i]) / d
        reals[S.NODES] += moved
    if new != h:
        integers[S.SAME], integers[S.UNSEEN] = 0, LONG_AGO
    reals[S.STEP_SIZE] = new
    if reals[S.EXPONENT] < 1.0:
        reals[S.UNIT] = new * new


@rare
def remember(h, run):
    """Add the times of the step of size h to NODES and TIMES."""
    reals = run.reals
    for k in range(3, 0, -1):
        reals[S.NODES + k], reals[S.TIMES + k] = reals[S.NODES + k - 1], reals[S.TIMES + k - 1]
    reals[S.NODES], reals[S.TIMES] = ends(h, run)
    reals[S.LAST_H] = h


@kernel
def is_short(h, run):
    """Whether h is below the smallest allowed step size, or nan."""
    reals = run.reals
    return not h >= reals[S.LEAST_H]
