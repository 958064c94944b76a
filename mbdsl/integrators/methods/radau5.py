"""RADAU5: Radau IIA with three stages on the stabilised index-2 equations, order 5, with error-controlled steps.

The equations and how they are solved: :mod:`mbdsl.integrators.methods.radau5_stages`. The end of a step is its third
stage, where both levels of constraints hold. Lengths of steps follow from an embedded formula of order 3, and a digital
filter.

Source: Hairer, Wanner, Solving Ordinary Differential Equations II (1996), section IV.8, on the equations of Gear,
Gupta, Leimkuhler, J. Comput. Appl. Math. 12 & 13 (1985) 77-90; controller: Soederlind, ACM Trans. Math. Softw. 29
(2003) 1-26. The splitting is ours.
"""

from mbdsl.compilation.buffer_layout import F0, FP, N_ALL, N_PHI, N_Q, NEW_MASS, Q0, SCALE, SOLVER, V0, XA, Q, V
from mbdsl.compilation.marks import kernel, rare
from mbdsl.integrators.loop.linear_solve import SPARSE_LU
from mbdsl.integrators.loop.loop_state import (
    CUT,
    DIVERGED,
    DONE,
    EVENT,
    EVERY,
    FACTORISATIONS,
    FRESH,
    HISTORY,
    ITERATIONS,
    LAST_H,
    LAST_STEP,
    LEAST_H,
    LOOK,
    MATRICES,
    MOST_H,
    NEXT_EVENT,
    NODES,
    NOT_FINITE,
    NOTES,
    NOW,
    OUTPUT,
    REJECTED,
    RUNNING,
    SIGNATURE,
    SINGULAR,
    START,
    STEP,
    STOP,
    TOL,
    TOO_SMALL,
    UNCUT,
    UNSEEN,
    WATCHING,
    ZONES,
    H,
    T,
)
from mbdsl.integrators.loop.newton import EPS, SINGULAR_NOISE, finite
from mbdsl.integrators.loop.switch_location import SHORT_OF, until_switch
from mbdsl.integrators.loop.turn_counting import count_turns
from mbdsl.integrators.loop.zone_landing import note, until_zone
from mbdsl.integrators.method import Method
from mbdsl.integrators.methods.radau5_stages import (
    MATRICES as MATRIX_COUNT,
)
from mbdsl.integrators.methods.radau5_stages import (
    NODES as STAGES,
)
from mbdsl.integrators.methods.radau5_stages import (
    OWN_ROWS,
    PAST,
    PAST2,
    QB,
    RESIDUAL,
    STAGE,
    STAGE2,
    VB,
    correct,
    estimate,
    matrices,
    motion,
    predict,
    residual,
    set_metric,
)
from mbdsl.system.switches import signature

# -- c: floats that the steps hand on: the last step, and its error; the one of the matrices; the contraction last seen;
# the largest scaled speed so far
LAST, ERROR, OF_MATRICES, CONTRACTION, SPEED = range(5)

METHOD = Method(
    "radau5",
    doc="Radau IIA of order 5, stabilised: positions and velocities on their constraints",
    order=5,
    index=2,
    enforces=("Phi", "dPhi"),
    family="Radau IIA",
    source="Hairer, Wanner (1996)",
    coefficients=lambda options: (0.0,) * 5,
    begin=lambda c, start: {XA: [*start.a, *start.lam]},
    sets=2,
    matrices=MATRIX_COUNT,
    own_reactions=False,
    steps=("controlled", "fixed"),
    rows=OWN_ROWS,
)

MAX_ITERATIONS = 25
#: contraction assumed of a first iteration, at least, where it has not been seen for so many steps
ASSUMED, OFTEN = 0.05, 4
#: contraction above which matrices are made anew
SLOW = 0.02
#: the tolerance of the embedded formula, of order 3, is this times the power 4/5 of that of the result
STRICT = 0.1
#: what Newton's iteration may leave, relative to the tolerance over the whole time
LEFT = 0.2
#: where that is rounding: what it may leave relative to what a step may err
STALLED = 1e-3
#: the largest error that may be rounding, relative to what is allowed
NOISE = 100.0
#: the error, relative to what is allowed, up to which a corner of a force is passed
UNNOTICED = 0.05
#: the error that is aimed at; how much shorter, or longer, the next step may be
AIM, SHRINK, GROW = 0.5, 0.15, 6.0


@kernel
def newton(evaluate, tangent, t, h, size, unit, tolerance, stalled, c, J, Y, Z, C, F, I, A, P):
    """Solve the stages; a status."""
    # What every step leaves undone adds up: not much more than half of the last digit is good enough.
    floor = 0.5 * EPS * size
    # The first change has nothing to be compared with.
    contraction, former = min(max(c[CONTRACTION], ASSUMED if J[UNSEEN] >= OFTEN else 1e-3), 0.9), 0.0
    J[UNSEEN] += 1
    fresh = False
    for k in range(MAX_ITERATIONS):
        # the middle one last: matrices are made there
        for stage in (0, 2, 1):
            motion(stage, h, Y, I)
            I[NEW_MASS] = 1
            evaluate(t + STAGES[stage] * h, Y, Z, C, F, I)
            residual(stage, Y, F, I)
        J[ITERATIONS] += 1
        if J[FRESH] == 0:
            J[MATRICES] += 1
            J[FACTORISATIONS] += 1
            still = max(1e3 * floor, stalled) / unit
            if not matrices(tangent, t + STAGES[1] * h, h, still, Y, Z, C, F, I, A, P):
                return SINGULAR if finite(A) else NOT_FINITE
            J[FRESH], c[OF_MATRICES], fresh = 1, h, True
        held = k > 4 and constraint_size(Y, I) <= 1e3 * floor
        change = correct(h, unit, Y, I, A, P)
        if not change < 1e100:
            return NOT_FINITE
        if k > 0:
            contraction = change / former if former > 0.0 else 0.0
            if former > 100.0 * floor:
                c[CONTRACTION], J[UNSEEN] = contraction, 0
        left = change * contraction / (1.0 - contraction) if contraction < 0.9 else change
        if (
            left <= tolerance
            or change <= floor
            or (k > 2 and contraction > 0.3 and change <= max(1e3 * floor, stalled))
        ):
            return RUNNING
        if held and contraction > 0.3 and change <= SINGULAR_NOISE * size:
            return RUNNING  # close to a singular pose, where rounding is magnified; the constraints hold
        if k > 0 and contraction > 0.3 and former > 100.0 * floor and (not fresh or k % 3 == 0):
            J[FRESH] = 0
        if k > 2 and contraction > 0.9 and tolerance > 0.0 and change > SINGULAR_NOISE * size:
            return DIVERGED  # with a shorter step it will be better
        former = change
    return DIVERGED


@rare
def constraint_size(Y, I):
    """Largest violation of the constraints on positions, in all stages."""
    value = 0.0
    for k in range(3):
        for i in range(I[N_Q], I[N_Q] + I[N_PHI]):
            value = max(value, abs(Y[RESIDUAL + k, i]))
    return value


@kernel
def sizes(c, length, Y, I):
    """The size of the mechanism and its motion; c[SPEED] follows the largest scaled velocity, and is not less than that
    which makes this way in the time that there is."""
    size, speed = 1.0, 0.0
    for i in range(I[N_Q]):
        size = max(size, abs(Y[Q0, i]) * Y[SCALE, i])
        speed = max(speed, abs(Y[V0, i]) * Y[SCALE, i])
    c[SPEED] = max(c[SPEED], speed, 1.0 / length)
    return size


@rare
def first_step(length, strict, Y, I):
    """A step in which the motion that is known at the start changes little."""
    speed, force = 0.0, 0.0
    for i in range(I[N_Q]):
        speed = max(speed, abs(Y[V0, i]) * Y[SCALE, i])
        force = max(force, abs(Y[XA, i]) * Y[SCALE, i])
    rate = max(speed, force**0.5)
    return min(0.01 * length, strict**0.25 / rate) if rate > 0.0 else 0.01 * length


@kernel
def next_step(h, error, c):
    """The digital filter H211b of Soederlind, which does not answer to what changes from one step to the next; where
    the error is far from what is aimed at, what that alone says."""
    now = AIM / max(error, 1e-8)
    ratio = now**0.25
    if c[ERROR] > 0.0 and ratio < 2.0:
        ratio = (now * AIM / max(c[ERROR], 1e-8)) ** (1.0 / 16.0) * (h / c[LAST]) ** -0.25
    return h * min(max(ratio, SHRINK), GROW)


@rare
def record(t0, h, J, c, Y, I, times, out):
    """Output times passed by this step: q and v by the polynomial of degree 5 that both have at three ends of steps (in
    the first step: with the accelerations at both ends), multipliers linearly."""
    n, r = I[N_Q], c[LAST] / h
    while J[OUTPUT] < times.size and times[J[OUTPUT]] <= t0 + h + 1e-9 * h:
        k = J[OUTPUT]
        x = min((times[k] - t0) / h, 1.0)
        if x > 1.0 - 1e-9:
            x = 1.0
        for i in range(n):
            q0, v0, q1, v1 = Y[Q0, i], h * Y[V0, i], Y[Q, i], h * Y[V, i]
            c2, c3 = 3.0 * (q1 - q0) - 2.0 * v0 - v1, 2.0 * (q0 - q1) + v0 + v1
            if J[HISTORY] > 1:
                g, dg = (r * (1.0 + r)) ** 2, -2.0 * r * (1.0 + r) * (1.0 + 2.0 * r)
                off = Y[QB, i] - (q0 - r * (v0 - r * (c2 - r * c3)))
                slope = h * Y[VB, i] - (v0 - r * (2.0 * c2 - r * 3.0 * c3))
                b1 = (slope - dg * off / g) / g
                b0 = off / g + b1 * r
            else:
                b0 = h * h / 2.0 * Y[XA, i] - c2
                b1 = h * h / 2.0 * Y[STAGE + 2, i] - c2 - 3.0 * c3 - b0
            g, dg, b = (x * (1.0 - x)) ** 2, 2.0 * x * (1.0 - x) * (1.0 - 2.0 * x), b0 + b1 * x
            out[k, i] = q0 + x * (v0 + x * (c2 + x * c3)) + g * b
            out[k, n + i] = (v0 + x * (2.0 * c2 + x * 3.0 * c3) + dg * b + g * b1) / h
            if x == 1.0:
                out[k, i], out[k, n + i] = q1, Y[V, i]
        for i in range(n, I[N_ALL]):
            out[k, n + i] = Y[XA, i] + x * (Y[STAGE + 2, i] - Y[XA, i])
        J[OUTPUT] += 1


@kernel
def shift(Y, I):
    """The step becomes history."""
    for i in range(I[N_Q]):
        Y[QB, i], Y[VB, i], Y[Q0, i], Y[V0, i] = Y[Q0, i], Y[V0, i], Y[Q, i], Y[V, i]
    for i in range(I[N_ALL]):
        Y[XA + 1, i] = Y[STAGE + 1, i]
        Y[XA, i] = Y[STAGE + 2, i]
        for k in range(3):
            Y[PAST + k, i], Y[PAST2 + k, i] = Y[STAGE + k, i], Y[STAGE2 + k, i]


@rare
def before_switch(status, error, evaluate, h, K, J, Y, Z, C, F, I):
    """The part of the step just tried after which a switch changes that makes a difference; 1 if none does."""
    if status == RUNNING:
        evaluate(K[T], Y, Z, C, F, I)
    return until_switch(status, status == RUNNING and error <= UNNOTICED, evaluate, h, K, J, Y, Z, C, F, I)


@rare
def see(t, evaluate, J, Y, Z, C, F, I):
    """Switches and forces at the end of a step that is accepted."""
    evaluate(t, Y, Z, C, F, I)
    J[SIGNATURE] = signature(F, I)
    for i in range(I[N_Q]):
        Y[F0, i] = Y[FP, i]


@kernel
def advance(evaluate, tangent, inertia, steps, c, K, J, Y, Z, C, F, I, A, P, times, out):
    """At most ``steps`` steps, not counting rejected ones; a status. Everything needed to go on is in the buffers."""
    tol, length = K[TOL], K[STOP] - K[START]
    strict = STRICT * tol**0.8
    if J[HISTORY] == 1:
        set_metric(Y, F, I)
        if tol > 0.0:
            c[CONTRACTION], c[ERROR] = 1.0, 0.0
            K[H] = min(K[H], first_step(length, strict, Y, I))
    for _ in range(steps):
        if (tol > 0.0 and K[NOW] >= K[STOP]) or (tol == 0.0 and J[STEP] >= J[LAST_STEP]):
            return DONE
        t0, h, end, tried, refused, error, former = K[START] + J[STEP] * K[H], K[H], K[STOP], 0, 0, 0.0, 0.0
        if tol > 0.0:
            t0, h, end = K[NOW], min(K[H], K[MOST_H]), min(K[STOP], K[NEXT_EVENT])
            if J[ZONES] > 0:
                h = until_zone(h, K, J)
                if h == 0.0:
                    return LOOK
        while True:
            t = t0 + h
            if tol > 0.0 and end - t < h:  # it is hit exactly, with no short step before it
                left = end - t0
                h = left if left <= 1.01 * h else min(h, 0.5 * left)
                t = t0 + h if h < left else end
            elif tol == 0.0 and J[STEP] == J[LAST_STEP] - 1:
                t = K[STOP]
            size = sizes(c, length, Y, I)
            if c[OF_MATRICES] != h:
                J[FRESH] = 0
            tolerance, unit, stalled = LEFT * tol * h / length, 1.0 / c[SPEED] if tol > 0.0 else h, STALLED * strict
            behind = J[HISTORY] - 1 if tried == 0 else 1 - tried
            predict(h / c[LAST] if J[HISTORY] > 1 else 1.0, behind, Y, I)
            early = max(0.0, t - K[NEXT_EVENT]) if tol == 0.0 else 0.0  # units in the last place
            K[T] = t - early
            status = newton(evaluate, tangent, t0 - early, h, size, unit, tolerance, stalled, c, J, Y, Z, C, F, I, A, P)
            if status == SINGULAR and I[SOLVER] == SPARSE_LU:
                return status  # once more with a search for pivots
            if tol == 0.0:
                if status == RUNNING:
                    break
                J[FRESH], tried = 0, tried + 1
                if tried > 2:
                    return status
                continue
            if status == RUNNING:
                motion(2, h, Y, I)
                error = estimate(inertia, h, c[SPEED], Y, F, I, A, P) / strict
            if J[WATCHING]:
                part = before_switch(status, error, evaluate, h, K, J, Y, Z, C, F, I)
                if part < 1.0:
                    if J[CUT] == 0:
                        K[UNCUT] = h
                    h *= part * (1.0 - min(0.5, SHORT_OF * 10.0 ** J[CUT]))
                    if not h >= K[LEAST_H]:
                        return EVENT
                    J[CUT], J[REJECTED] = J[CUT] + 1, J[REJECTED] + 1
                    continue
            if status == RUNNING:
                # A step that is shorter and errs no less errs by rounding.
                if error <= 1.0 or (refused > 1 and former <= error < NOISE):
                    break
                refused, former = refused + 1, error
                h *= max(SHRINK, (AIM / error) ** 0.25) if error < 1e300 else 0.1
            else:
                h *= 0.4 if status == DIVERGED else 0.25
                J[FRESH], tried = 0, tried + 1 if tried < 1 else 1
            J[REJECTED], J[CUT] = J[REJECTED] + 1, 0
            if h < K[LEAST_H]:
                return status if status != RUNNING else TOO_SMALL
        motion(2, h, Y, I)
        if J[WATCHING]:
            see(t, evaluate, J, Y, Z, C, F, I)
        if J[EVERY]:
            times[J[OUTPUT]] = t
        if J[OUTPUT] < times.size and times[J[OUTPUT]] <= t0 + h + 1e-9 * h:
            record(t0, h, J, c, Y, I, times, out)
        shift(Y, I)
        count_turns(Y, F, I)
        if J[NOTES] > 0:
            note(K, J, Y, I)
        if tol > 0.0:
            K[H], K[LAST_H] = next_step(h, error, c), h
            K[NODES], K[NODES + 1] = t, t0 + STAGES[1] * h
            if 0.95 <= K[H] / h <= 1.15 and c[CONTRACTION] < SLOW:
                K[H] = h  # and the matrices are good for another one
            c[ERROR] = error
        c[LAST] = h
        if c[CONTRACTION] > SLOW:
            J[FRESH] = 0
        J[HISTORY], J[STEP], K[NOW] = 2, J[STEP] + 1, t
        if tol > 0.0 and (J[CUT] > 0 or K[NOW] >= K[NEXT_EVENT]):
            return EVENT
        if tol == 0.0 and t > K[NEXT_EVENT]:
            return EVENT
    if tol > 0.0:
        return DONE if K[NOW] >= K[STOP] else RUNNING
    return DONE if J[STEP] >= J[LAST_STEP] else RUNNING
