"""Newton's iteration of a step: when the matrix is renewed, and when an iterate is accepted."""

from __future__ import annotations

from mbdsl.compilation.buffer_layout import BEFORE, N_ALL, N_GAM, N_Q, NEW_MASS, Q0, SCALE, V0, XA, R, X
from mbdsl.compilation.marks import kernel, rare
from mbdsl.integrators.loop.loop_state import (
    CONTRACTION,
    CONTROLLED,
    DIVERGED,
    FACTORISATIONS,
    FRESH,
    HISTORY,
    ITERATIONS,
    LOOSEST,
    MATRICES,
    NOT_FINITE,
    RELATIVE_TOL,
    ROUNDING,
    RUNNING,
    SINGULAR,
    SPEED,
    STABILISED,
    UNIT,
    UNSEEN,
    VELOCITY_TOL,
)
from mbdsl.integrators.loop.step_control import allowed, bend_uneven, even, other_matrices

MAX_ITERATIONS = 25
#: smallest part of a correction that is taken where whole ones do not get anywhere
SHORTEST = 1.0 / 32.0
#: contraction above which the next step starts with a new matrix
SLOW = 0.05
#: contraction assumed of a first iteration, at least, where it has not been seen for so many steps; and else
UNMEASURED, OFTEN, MEASURED = 0.05, 8, 1e-3
#: largest noise in a position that is put down to a singular pose
SINGULAR_NOISE = 1e-9
#: part of what a controlled step may err that its iteration may
NOISE = 0.3
#: steps before a new matrix is tried again against corrections of the size of rounding
LONG = 100
EPS = 2.220446049250313e-16


@kernel
def residual_size(unknowns, size, Y):
    """Sum of the residuals' magnitudes, in four lanes that do not wait for one another; not a number if one is none."""
    a, b, c, d = 0.0, 0.0, 0.0, 0.0
    for k in range(unknowns):
        y, whole = Y[R + k], size - size % 4
        for i in range(0, whole, 4):
            a, b, c, d = a + abs(y[i]), b + abs(y[i + 1]), c + abs(y[i + 2]), d + abs(y[i + 3])
        for i in range(whole, size):
            a += abs(y[i])
    return (a + b) + (c + d)


@rare
def constraint_size(unknowns, n, size, Y):
    """Largest residual among the constraints."""
    value = 0.0
    for k in range(unknowns):
        for i in range(n, size):
            value = max(value, abs(Y[R + k, i]))
    return value


@rare
def finite(A):
    """Whether a matrix holds numbers only: a derivative may be infinite where the force itself is not."""
    for k in range(A.shape[0]):
        for i in range(A.shape[1]):
            if not abs(A[k, i]) < 1e300:
                return False
    return True


@rare
def keep_unknowns(unknowns, size, Y):
    for k in range(unknowns):
        for i in range(size):
            Y[BEFORE + k, i] = Y[X + k, i]


@rare
def take_back(part, unknowns, size, Y):
    """Leave only a part of the last correction."""
    for k in range(unknowns):
        for i in range(size):
            Y[X + k, i] = Y[BEFORE + k, i] + part * (Y[X + k, i] - Y[BEFORE + k, i])


@kernel
def newton(damped, motion, residual, matrix, correct, evaluate, tangent, t, h, c, K, J, Y, Z, C, F, I, A, P):
    """Solve the step for the unknowns X (and X2); a status. ``damped``: with parts of corrections and new matrices.

    An iterate is accepted when the error that the contraction leaves is below what the step itself gets wrong by
    discretisation, or at rounding; in position units, and with a residual that has not grown.
    """
    n, unknowns = I[N_Q], 1 + J[STABILISED]
    size, speed, bend = 1.0, 0.0, 0.0
    for i in range(n):
        size = max(size, abs(Y[Q0, i]) * Y[SCALE, i])
        speed = max(speed, abs(Y[V0, i]) * Y[SCALE, i])
        # at the start, where nothing is known of how a changes, a thousandth of a itself
        d = Y[XA, i] - 2.0 * Y[XA + 1, i] + Y[XA + 2, i] if J[HISTORY] > 2 else 1e-3 * Y[XA, i]
        bend = max(bend, abs(d) * Y[SCALE, i])
    if J[HISTORY] > 2 and not even(J):
        bend = bend_uneven(h, n, K, Y)
    floor, rounding = 16.0 * EPS * size, EPS * size
    if J[CONTROLLED]:  # errors of velocities are seen in accelerations, where rounding of positions is 1/h^2 times it
        rounding = min(rounding, NOISE * allowed(h, K, J) * K[SPEED] * h)
    # The local error is about h^2/12 times the second difference of a; constraints on velocities are to be kept, too.
    tolerance = min(K[RELATIVE_TOL] * h * h * bend, K[LOOSEST] * size)
    velocity_tolerance = K[LOOSEST] * size
    if J[STABILISED] or I[N_GAM] > 0:
        velocity_tolerance = max(K[VELOCITY_TOL] * h * speed, 4.0 * EPS * size)
    fresh = J[FRESH] == 0
    # The first change has nothing to be compared with; an old matrix may have become worse than it was when last seen.
    contraction = max(K[CONTRACTION], MEASURED)
    if J[UNSEEN] >= OFTEN:
        contraction = max(contraction, UNMEASURED)
    contraction = min(contraction, 0.9)
    J[UNSEEN] += 1
    J[ROUNDING] = max(0, J[ROUNDING] - 1)
    former, former_residual, worn, renewed, part = 0.0, 0.0, False, False, 1.0
    I[NEW_MASS] = 1
    for k in range(4 * MAX_ITERATIONS if damped else MAX_ITERATIONS):
        motion(h, c, Y, I)
        evaluate(t, Y, Z, C, F, I)
        I[NEW_MASS] = 0
        residual(h, c, Y, F, I)
        J[ITERATIONS] += 1
        remaining = residual_size(unknowns, I[N_ALL], Y)
        if not remaining < 1e300:
            return NOT_FINITE
        renewed = k > 0 and J[FRESH] == 0
        if J[FRESH] == 0:
            J[MATRICES] += 1
            J[FACTORISATIONS] += 1
            if not matrix(tangent, t, h, c, Y, Z, C, F, I, A, P):
                if k > 1 and former <= 1e3 * floor and finite(A) and not J[CONTROLLED]:
                    return RUNNING  # the pose is singular, and what the former matrix left is rounding
                return SINGULAR if finite(A) else NOT_FINITE
            J[FRESH] = 1
            if J[CONTROLLED]:
                other_matrices(tangent, t, h, K, J, Y, Z, C, F, I, A, P)
        if damped:
            keep_unknowns(unknowns, I[N_ALL], Y)
        change = correct(k, h, c, Y, I, A, P)
        if not change < 1e300:
            return NOT_FINITE
        if damped:
            # Friction that turns round within less than a step makes whole corrections jump to and fro.
            part = max(0.5 * part, SHORTEST) if k > 0 and change > 0.7 * former else min(1.4 * part, 1.0)
            J[FRESH] = 0
            if part < 1.0:
                take_back(part, unknowns, I[N_ALL], Y)
                former, former_residual = change, remaining
                continue
        if k > 0:
            contraction = change / former if former > 0.0 else 0.0
            if renewed and change > 100.0 * floor:  # corrections by two matrices say nothing of each other
                contraction = max(contraction, UNMEASURED)
            if former > 100.0 * floor:  # below that it measures rounding
                K[CONTRACTION] = contraction
                J[UNSEEN] = 0
                worn = contraction > SLOW
        grown = k > 0 and remaining > 10.0 * former_residual and change > 100.0 * floor
        # What every step leaves undone adds up over many small ones: rounding is an excuse from the second change on.
        left = change * contraction / (1.0 - contraction) if contraction < 0.9 else change
        done = left <= tolerance or change <= rounding or (k > 0 and left <= rounding)
        # That v stays on the constraints is a promise, for which no contraction is good enough that was only assumed.
        if max(left, UNMEASURED * change if k == 0 else 0.0) > velocity_tolerance:
            done = False
        if k > 2 and contraction > 0.5 and change <= 1e3 * floor:
            done = True  # rounding keeps it from getting better
        last_digit = k > 0 and contraction > 0.1 and change <= EPS * size
        if last_digit and not renewed and (fresh or J[ROUNDING] > 0):
            done = True  # the same: no new matrix would help
        held = k > 6 and K[UNIT] * constraint_size(unknowns, n, I[N_ALL], Y) <= 1e2 * floor
        if held and change <= SINGULAR_NOISE * size:
            done = True  # close to a singular pose, where rounding is magnified; the constraints hold
        if done and not grown:
            if worn:
                J[FRESH] = 0  # the next step starts with a new matrix
            return RUNNING
        if k > 0 and contraction > 0.3 and not fresh:
            J[FRESH] = 0  # an old matrix that contracts badly is renewed at once
            fresh = True
            if last_digit:
                J[ROUNDING] = LONG
        elif k > 2 and (contraction > 0.3 or (contraction > 0.1 and k % 3 == 0)):
            J[FRESH] = 0  # far from the solution: plain Newton, or nearly
        former, former_residual = change, remaining
    return DIVERGED
