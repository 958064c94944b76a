"""Steps that end before a switch changes: where within a step it does, and how the step is cut short.

The force that an implicit step sees is that at its end: a step across a switch is as wrong as if the switch had changed
at its start, and its end tells little more than that it did. Where it did is therefore looked for on the motion as it
would go on from the start of the step, with the acceleration there and its rate; the step is tried again to shortly
before. What then is left is done by :mod:`mbdsl.integrators.events`, which begins anew behind the switch.

A step is not cut short where forces have a corner and no jump and its error is what it may be: for a method of order 2
a corner makes no difference. Where forces jump, a step across may have no solution: the same is done where Newton's
iteration has failed.
"""

from __future__ import annotations

from mbdsl.compilation.buffer_layout import (
    ACCELERATION,
    BEFORE,
    BEFORE2,
    E_Q,
    E_V,
    F0,
    FP,
    GD,
    LAW_ROW,
    N_ALL,
    N_Q,
    PAST,
    Q0,
    T2,
    V0,
    XA,
    Q,
    V,
    X,
)
from mbdsl.compilation.marks import rare
from mbdsl.integrators.loop.loop_state import CORNERS, LEAST_H, NODES, NOW, RUNNING, SIGNATURE
from mbdsl.system.switches import signature

#: how much of the way to a switch is left at the first attempt; at each further one ten times as much
SHORT_OF = 1e-4
#: how close a switch is looked for, as a part of the way
CLOSE = 1e-6
#: relative change of a force below which it has a corner and does not jump
JUMP = 1e-4
#: part of a step before a corner that is worth ending there
WORTH = 0.01
#: the motion that is looked at: as it goes on from the start, or between the start of the step and its end as found
ON, BETWEEN = 0, 1


@rare
def look(motion, x, evaluate, h, K, Y, Z, C, F, I):
    """The signature after a part x of the step, whose end as found stands in BEFORE and BEFORE2."""
    n, row, a, d = I[N_Q], I[LAW_ROW], XA + PAST * (I[ACCELERATION] - X), K[NODES] - K[NODES + 1]
    s = x * h
    for i in range(n):
        q0, v0, q1, v1 = Y[Q0, i], h * Y[V0, i], Y[BEFORE, i], h * Y[BEFORE2, i]
        c2, c3 = 3.0 * (q1 - q0) - 2.0 * v0 - v1, 2.0 * (q0 - q1) + v0 + v1
        if motion == ON:
            jerk = (Y[a, i] - Y[a + 1, i]) / d
            c2, c3 = h * h / 2.0 * (Y[a, i] + (K[NOW] - K[NODES]) * jerk), h * h * h / 6.0 * jerk
        Y[Q, i] = q0 + x * (v0 + x * (c2 + x * c3))
        Y[V, i] = (v0 + x * (2.0 * c2 + x * 3.0 * c3)) / h
    for i in range(n, I[N_ALL]):
        lam = Y[XA + PAST * (row - X), i]
        Y[row, i] = lam if motion == ON else lam + x * (Y[BEFORE, i] - lam)
    evaluate(K[NOW] + s, Y, Z, C, F, I)
    return signature(F, I)


@rare
def jumps(motion, low, high, evaluate, h, K, Y, Z, C, F, I):
    """Whether a force changes between two points of the step that are close to each other, compared with what it is
    there and at the ends of the step (F0 and E_V)."""
    n = I[N_Q]
    look(motion, low, evaluate, h, K, Y, Z, C, F, I)
    for i in range(n):
        Y[E_Q, i] = Y[FP, i]
    look(motion, high, evaluate, h, K, Y, Z, C, F, I)
    found = False
    for i in range(n):
        size = max(max(abs(Y[FP, i]), abs(Y[E_Q, i])), max(abs(Y[F0, i]), abs(Y[E_V, i])))
        found = found or not abs(Y[FP, i] - Y[E_Q, i]) <= JUMP * size
    return found


@rare
def until_switch(status, accepted, evaluate, h, K, J, Y, Z, C, F, I):
    """The part of the step just tried after which a switch changes; 1 if none does, or if that makes no difference.

    To be asked with the registers of the last evaluation. What a step that is ``accepted`` has found is left as it was,
    if it is to end where it does.
    """
    n, size, row, old, found = I[N_Q], I[N_ALL], I[LAW_ROW], J[SIGNATURE], status == RUNNING
    if found and signature(F, I) == old:
        return 1.0
    for i in range(size):
        Y[BEFORE, i], Y[BEFORE2, i] = Y[Q, i] if i < n else Y[row, i], Y[V, i]
        Y[E_V, i], Y[T2, i] = Y[FP, i], Y[GD, i]
    motion = ON
    if look(ON, 1.0, evaluate, h, K, Y, Z, C, F, I) == old:
        if not found:
            return 1.0
        motion = BETWEEN
    low, high = 0.0, 1.0
    while high - low > CLOSE * high and high * h > K[LEAST_H]:
        middle = 0.5 * (low + high)
        if look(motion, middle, evaluate, h, K, Y, Z, C, F, I) == old:
            low = middle
        else:
            high = middle
    corner = J[CORNERS] and not jumps(motion, low, high, evaluate, h, K, Y, Z, C, F, I)
    if not corner or (not accepted and low > WORTH):
        return low
    if not accepted:
        return 1.0
    J[SIGNATURE] = look(BETWEEN, 1.0, evaluate, h, K, Y, Z, C, F, I)
    for i in range(size):
        if i < n:
            Y[Q, i], Y[V, i] = Y[BEFORE, i], Y[BEFORE2, i]
        else:
            Y[row, i] = Y[BEFORE, i]
        Y[FP, i], Y[GD, i] = Y[E_V, i], Y[T2, i]
    return 1.0
