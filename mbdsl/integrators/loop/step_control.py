"""Steps of controlled size: the local error of a step, what it may be, and the step that follows.

A step's local errors in q and v are those that its method declares (``local_error``), with jerk q''' and snap q''''
from divided differences of the accelerations of this step and the two before. What constraints do not leave free is no
error, nor is what a stiff force brings back within a step: both are taken out by the iteration matrix, which is at
hand,

    [[M + ..., Phi_q^T], [Phi_q, 0]] [e; .] = [M e_raw; 0].

Velocity constraints remove the part along their normals from the error in v, but not from the error in q.

The error of a step is the largest entry of e, positions in the mechanism's size and angles in radians, velocities
moreover relative to the largest velocity so far. With the tolerance tol and the n-th step since the start, it may be

    tol (h / (stop - start) + SHARE / n).

The first part adds up to tol over the run, so that the error at its end goes with tol, whatever the steps are. The
second lets steps grow out of a transient that takes a tiny part of the time; it adds up to SHARE log(steps).

What is carried from step to step belongs to a step of some length; ``change`` turns it into what belongs to another.
"""

from __future__ import annotations

from math import ceil

from mbdsl.compilation.buffer_layout import (
    ACCELERATION,
    E_Q,
    E_V,
    E_X,
    FP,
    GD,
    MASS,
    MASS_KIND,
    N_ALL,
    N_PHI,
    N_Q,
    PAST,
    Q0,
    SCALE,
    T1,
    V0,
    XA,
    Q,
    V,
    X,
)
from mbdsl.compilation.buffer_layout import TIMES as TIMES_TASK
from mbdsl.compilation.marks import kernel, rare
from mbdsl.integrators.loop.linear_solve import compress, factor, larger, multiply, solve
from mbdsl.integrators.loop.loop_state import (
    DAMPED,
    DAMPING,
    EXPONENT,
    FACTORISATIONS,
    FORGOTTEN,
    FRESH,
    IN_A_ROW,
    LANDING,
    LAST_H,
    LEAST_H,
    MASS_WEIGHT,
    MATRICES,
    MOST_H,
    NEXT_EVENT,
    NODE,
    NODES,
    NOW,
    OUTPUT,
    SAME,
    SINCE,
    SPEED,
    START,
    STOP,
    TIMES,
    TOL,
    UNIT,
    UNSEEN,
    H,
)
from mbdsl.integrators.loop.split_correction import stiff

#: what steps since the start may err in addition, as a part of tol, all that differ by a factor e in number
SHARE = 0.05
#: part of what a step may err that the next one aims at
AIM = 0.5
#: the step is kept where it would change by less: the iteration matrix can then be kept, too
KEPT_FROM, KEPT_TO = 0.9, 1.2
#: by how much it changes at most
MOST, LEAST = 2.0, 0.2
#: what that has to make of the error to be looked at every step; else every so many of them
USEFUL, SELDOM = 0.9, 20
#: change of a velocity within a step, relative to the largest, that is a blow
BLOW = 0.5
#: steps after which a contraction that was measured means nothing any more
LONG_AGO = 1 << 20


@kernel
def even(J):
    """Whether the last steps were of one size, so that extrapolation has constant weights."""
    return J[SAME] >= 3


# -- extrapolation from steps that differ ------------------------------------------------------------------------------


@kernel
def weight(k, order, x, at, K):
    """Of the k-th newest of order + 1 values that belong to K[at], K[at + 1], ..., at x (Lagrange)."""
    w = 1.0
    for j in range(order + 1):
        if j != k:
            w *= (x - K[at + j]) / (K[at + k] - K[at + j])
    return w


@kernel
def ends(h, K):
    """What the step's own accelerations and multipliers belong to."""
    return K[NOW] + K[NODE] * h, K[NOW] + h


@rare
def predict_uneven(unknown, order, h, I, K, Y):
    """X (unknown 0) or X2 (unknown 1) by polynomial extrapolation of the last steps."""
    x, a, n = X + unknown, XA + PAST * unknown, I[N_Q]
    for part in range(2):
        first, last, at, end = (0, n, NODES, ends(h, K)[0]) if part == 0 else (n, I[N_ALL], TIMES, ends(h, K)[1])
        for i in range(first, last):
            Y[x, i] = 0.0
        for k in range(order + 1):
            w = weight(k, order, end, at, K)
            for i in range(first, last):
                Y[x, i] += w * Y[a + k, i]


@rare
def missed(order, h, n, K, Y):
    """By how much that extrapolation of the accelerations has missed the step just done."""
    error = 0.0
    for i in range(n):
        y = Y[X, i]
        for k in range(order + 1):
            y -= weight(k, order, K[NOW] + K[NODE] * h, NODES, K) * Y[XA + k, i]
        error = max(error, abs(y) * Y[SCALE, i])
    return error


@rare
def best_order_uneven(history, h, n, K, Y):
    best, error = 0, missed(0, h, n, K, Y)
    for order in range(1, min(history, 4)):
        other = missed(order, h, n, K, Y)
        if other < error:
            best, error = order, other
    return best


@rare
def bend_uneven(h, n, K, Y):
    """h^2 times the second derivative of the accelerations."""
    largest, d0, d1 = 0.0, K[NODES] - K[NODES + 1], K[NODES + 1] - K[NODES + 2]
    for i in range(n):
        d = ((Y[XA, i] - Y[XA + 1, i]) / d0 - (Y[XA + 1, i] - Y[XA + 2, i]) / d1) * 2.0 * h * h / (d0 + d1)
        largest = max(largest, abs(d) * Y[SCALE, i])
    return largest


# -- errors ------------------------------------------------------------------------------------------------------------


@rare
def tangential(row, matrix, inertia, K, Y, F, I, A, P):
    """Y[row], a displacement or velocity, as far as constraints and stiff forces leave it."""
    if I[MASS_KIND] > 0:
        inertia(TIMES_TASK, row, T1, Y, F, I)
    else:
        for i in range(I[N_Q]):
            Y[T1, i] = 0.0
    for i in range(I[N_Q]):
        Y[row, i] = K[MASS_WEIGHT] * (F[I[MASS] + i] * Y[row, i] + Y[T1, i])
    for i in range(I[N_Q], I[N_ALL]):
        Y[row, i] = 0.0
    solve(A[matrix], P[matrix], I, Y, row)


@rare
def other_matrices(tangent, t, h, K, J, Y, Z, C, F, I, A, P):
    """What errors are judged by beside the iteration matrix, in the last rows of A: that matrix without K, to be
    multiplied with; and, where dampers are stiff, without K and for a step as long as outputs are apart, factorised."""
    last, w = A.shape[0] - 1, K[MASS_WEIGHT]
    tangent(t, w, 0.0, K[DAMPING] * h, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, Y, Z, C, F, I, A[last])
    compress(A[last], P[last], I)
    d = K[DAMPING] * K[FORGOTTEN]
    tangent(t, w, 0.0, d, 0.0, 1.0, 0.0, 1.0, 0.0, 0.0, Y, Z, C, F, I, A[last - 1])
    damped, J[DAMPED] = J[DAMPED], 0
    if h < K[FORGOTTEN] and stiff(0.5, w, A[last - 1 :], F, I) and factor(A[last - 1], P[last - 1], I):
        J[DAMPED] = max(1, damped)


@rare
def forget(inertia, K, Y, F, I, A, P):
    """Y[E_V] as far as dampers leave it, and where it ends, in Y[E_X]."""
    last = A.shape[0] - 1
    for i in range(I[N_ALL]):
        Y[E_X, i] = Y[E_V, i]
    tangential(E_V, last - 1, inertia, K, Y, F, I, A, P)
    for i in range(I[N_Q]):
        Y[E_X, i] = K[FORGOTTEN] * (Y[E_X, i] - Y[E_V, i])
    tangential(E_X, last - 1, inertia, K, Y, F, I, A, P)


@rare
def tangential_position(inertia, Y, I, A, P):
    """Y[E_Q] without the part that position constraints and stiff springs remove.

    Dampers and velocity constraints do not bring positions back: the error along the normals of velocity constraints
    stays, Gam_v e = Gam_v e_raw.
    """
    last = A.shape[0] - 1
    for i in range(I[N_ALL]):
        Y[T1, i] = 0.0
    for i in range(I[N_Q], I[N_ALL]):
        Y[E_Q, i] = 0.0
    multiply(A[last], P[last], Y, E_Q, T1)
    for i in range(I[N_ALL]):
        Y[E_Q, i] = Y[T1, i]
    solve(A[0], P[0], I, Y, E_Q)


@rare
def set_velocity(error, h, matrix, evaluate, tangent, inertia, c, K, J, Y, Z, C, F, I, A, P):
    """v at the start of a step of length h brought onto the constraints, but for ``error`` times the jerk along the
    normals of the holonomic ones; what it has been changed by is left in Y[E_Q].

    The matrix is evaluated there: the normals of steps ago would not do. A method of index 3 holds nonholonomic
    constraints by velocities themselves, which have no such error: what it has along their normals is taken out again.
    """
    n, m = I[N_Q], I[N_PHI]
    a, d = XA + PAST * (I[ACCELERATION] - X), K[NODES] - K[NODES + 1]
    for i in range(n):
        Y[Q, i], Y[V, i] = Y[Q0, i], Y[V0, i]
    evaluate(K[NOW], Y, Z, C, F, I)
    J[MATRICES] += 1
    J[FACTORISATIONS] += 1
    J[FRESH] = 1 if matrix(tangent, K[NOW], h, c, Y, Z, C, F, I, A, P) else 0
    other_matrices(tangent, K[NOW], h, K, J, Y, Z, C, F, I, A, P)
    for i in range(n):
        Y[E_V, i] = (Y[a, i] - Y[a + 1, i]) / d
        Y[E_Q, i] = error * Y[E_V, i]
    tangential(E_V, 0, inertia, K, Y, F, I, A, P)
    for i in range(n):
        Y[E_Q, i] -= error * Y[E_V, i]
    for i in range(I[N_ALL]):
        Y[E_V, i] = -Y[GD, i] if n <= i < n + m else 0.0
    solve(A[0], P[0], I, Y, E_V)
    for i in range(n):
        e = Y[E_Q, i] + Y[E_V, i]
        Y[E_Q, i] = e if J[FRESH] and abs(e) < 1e300 else 0.0
        Y[V0, i] += Y[E_Q, i]
    for _ in range(2 if n + m < I[N_ALL] and J[FRESH] else 0):  # the rows of the matrix have Gam_q, too: O(h) is left
        for i in range(n):
            Y[V, i] = Y[V0, i]
        evaluate(K[NOW], Y, Z, C, F, I)
        for i in range(I[N_ALL]):
            Y[E_V, i] = -Y[FP, i] if i >= n + m else 0.0
        solve(A[0], P[0], I, Y, E_V)
        for i in range(n):
            if abs(Y[E_V, i]) < 1e300:
                Y[E_Q, i] += Y[E_V, i]
                Y[V0, i] += Y[E_V, i]


@kernel
def estimate(local_error, inertia, h, c, K, J, Y, F, I, A, P):
    """The error of the step just tried, relative to what it may be.

    A force so stiff that it stops a motion within one step has not been followed: there, nothing is taken out.
    """
    n, x = I[N_Q], I[ACCELERATION]
    a = XA + PAST * (x - X)
    d0, d1 = K[NOW] + K[NODE] * h - K[NODES], K[NODES] - K[NODES + 1]
    speed, jump = K[SPEED], 0.0
    for i in range(n):
        jerk = (Y[x, i] - Y[a, i]) / d0
        snap = 2.0 * (jerk - (Y[a, i] - Y[a + 1, i]) / d1) / (d0 + d1)
        Y[E_Q, i], Y[E_V, i] = local_error(h, K[LAST_H], c, jerk, snap)
        speed = larger(abs(Y[V, i]) * Y[SCALE, i], speed)
        jump = larger(abs(Y[V, i] - Y[V0, i]) * Y[SCALE, i], jump)
    if jump > BLOW * speed:
        for i in range(n):
            Y[E_X, i] = h * Y[E_V, i]
        return largest_error(speed, n, Y) / allowed(h, K, J)
    tangential_position(inertia, Y, I, A, P)
    tangential(E_V, 0, inertia, K, Y, F, I, A, P)
    for i in range(n):
        Y[E_X, i] = h * Y[E_V, i]
    error = largest_error(speed, n, Y)
    if J[DAMPED] > 0:
        J[DAMPED] -= 1
        if J[DAMPED] == 0:
            forget(inertia, K, Y, F, I, A, P)
            less = largest_error(speed, n, Y)
            J[DAMPED] = 1 if less < USEFUL * error else SELDOM
            error = min(error, less) if less == less else less
    return error / allowed(h, K, J)


@kernel
def largest_error(speed, n, Y):
    error = 0.0
    for i in range(n):
        error = larger((abs(Y[E_Q, i]) + abs(Y[E_X, i])) * Y[SCALE, i], error)
        error = larger(abs(Y[E_V, i]) * Y[SCALE, i] / speed, error)
    return error


@kernel
def local_error(h, last, c, jerk, snap):
    """Of a method that has none, or whose steps are not controlled here."""
    return 0.0, 0.0


@kernel
def change_step(h, evaluate, tangent, inertia, c, K, J, Y, Z, C, F, I, A, P):
    """Of a method that keeps nothing that belongs to a step of some length."""


# -- steps -------------------------------------------------------------------------------------------------------------


@kernel
def allowed(h, K, J):
    """What a step of length h may err."""
    return K[TOL] * (h / (K[STOP] - K[START]) + SHARE / (J[SINCE] + 1))


@rare
def next_trial(error, h, K):
    """The step to be tried in place of one with that error, which may be no number."""
    ratio = LEAST
    if error < 1e10:
        ratio = max(LEAST, min(KEPT_FROM, (AIM / error) ** K[EXPONENT]))
    return ratio * h


@rare
def after(error, K, J, times):
    """The step after one with that error that was accepted."""
    ratio = min(MOST if K[EXPONENT] < 1.0 else 1e3, max(LEAST, (AIM / max(error, 1e-30)) ** K[EXPONENT]))
    if J[IN_A_ROW] > 0:
        ratio = min(ratio, 1.0)
    if KEPT_FROM < ratio < KEPT_TO:
        ratio = 1.0
    return fitted(min(ratio * K[H], K[MOST_H]), K, J, times)


@rare
def fitted(h, K, J, times):
    """About h, so that a whole number of steps leads to the stop time where that is near (or to the next output)."""
    left = min(K[STOP], K[NEXT_EVENT]) - K[NOW]
    if J[LANDING] and J[OUTPUT] < times.size:
        left = min(left, times[J[OUTPUT]] - K[NOW])
    if not left > 0.0 or left > 4.0 * h:
        return h
    new = left / max(1.0, ceil(left / h - 0.05))
    return h if abs(new - h) <= 1e-9 * h else new


@rare
def change(change_step, evaluate, tangent, inertia, new, c, K, J, Y, Z, C, F, I, A, P):
    """What belongs to a step of length K[H] becomes what belongs to one of length ``new``."""
    h, a = K[H], XA + PAST * (I[ACCELERATION] - X)
    moved, d = (K[NODE] - 1.0) * (new - h), K[NODES] - K[NODES + 1]
    change_step(new, evaluate, tangent, inertia, c, K, J, Y, Z, C, F, I, A, P)
    if moved != 0.0:
        for i in range(I[N_Q]):
            Y[a, i] += moved * (Y[a, i] - Y[a + 1, i]) / d
        K[NODES] += moved
    if new != h:
        J[SAME], J[UNSEEN] = 0, LONG_AGO
    K[H] = new
    if K[EXPONENT] < 1.0:
        K[UNIT] = new * new


@rare
def remember(h, K):
    """The step of length h becomes history."""
    for k in range(3, 0, -1):
        K[NODES + k], K[TIMES + k] = K[NODES + k - 1], K[TIMES + k - 1]
    K[NODES], K[TIMES] = ends(h, K)
    K[LAST_H] = h


@kernel
def is_short(h, K):
    return not h >= K[LEAST_H]
