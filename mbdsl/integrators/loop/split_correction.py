"""How Newton's corrections are solved for: in one system, or in two that follow each other."""

from __future__ import annotations

from mbdsl.compilation.buffer_layout import (
    D2,
    DIAGONAL,
    MASS,
    MASS_SLOTS,
    N_ALL,
    N_GAM,
    N_LAWS,
    N_Q,
    SCALE,
    SLOTS,
    T2,
    D,
    R,
    X,
)
from mbdsl.compilation.marks import kernel, rare
from mbdsl.integrators.loop.linear_solve import compress, larger, multiply, solve, solve_both

#: how large the effect of the second system's solution on the first's may be, relative to that, to be taken into
#: account an iteration late: in the first two iterations of a step, and afterwards
EARLY, LATE = 0.3, 0.02


@kernel
def correct_one(k, h, c, Y, I, A, P):
    """X += A^{-1} (-R); the largest scaled change of a position, which moves with c[0] h^2 a."""
    for i in range(I[N_ALL]):
        Y[D, i] = -Y[R, i]
    solve(A[0], P[0], I, Y, D)
    for i in range(I[N_ALL]):
        Y[X, i] += Y[D, i]
    change = 0.0
    for i in range(I[N_Q]):
        change = larger(abs(Y[D, i]) * Y[SCALE, i], change)
    return c[0] * h * h * change


@kernel
def solve_two(k, A, P, I, Y):
    """D2 <- A1^{-1} D2 and D <- A0^{-1} (D + A2 D2), in iteration k = 0, 1, ... of a step.

    Both are solved side by side, which takes little longer than one. What A2 adds comes afterwards, and only where it
    matters: D2 is the smaller, for smooth motion by a power of h, and then an iteration later is soon enough.
    """
    solve_both(A, P, I, Y)
    if P[2, P.shape[1] - 1] > 0:
        add_coupling(k, A, P, I, Y)


@rare
def add_coupling(k, A, P, I, Y):
    for i in range(I[N_ALL]):
        Y[T2, i] = 0.0
    multiply(A[2], P[2], Y, D2, T2)
    change, added = 0.0, 0.0
    for i in range(I[N_Q]):
        change = max(change, abs(Y[D, i]) * Y[SCALE, i])
        added = max(added, abs(Y[T2, i]) * Y[DIAGONAL, i])
    if added > (EARLY if k < 2 else LATE) * change:
        solve(A[0], P[0], I, Y, T2)
        for i in range(I[N_ALL]):
            Y[D, i] += Y[T2, i]


@rare
def stiff(limit, cM, A, F, I):
    """Whether forces make up more than this share of A0's diagonal (not factorised yet) beside cM M."""
    for i in range(I[N_Q]):
        a = A[0, I[I[SLOTS] + I[MASS_SLOTS] + i]]
        if abs(a - cM * F[I[MASS] + i]) > limit * abs(a):
            return True
    return False


@kernel
def couples(cM, A, F, I):
    """Whether A2 may matter: forces are stiff, or depend on coordinates in ways that no diagonal shows."""
    return I[N_LAWS] + I[N_GAM] > 0 or stiff(LATE, cM, A, F, I)


@rare
def couple(A, P, I, Y):
    """Prepare A2 for ``multiply``; beside A0, which is not factorised yet, it may be as good as zero."""
    ratio, last = 0.0, P.shape[1] - 1
    for i in range(I[N_Q]):
        slot = I[I[SLOTS] + I[MASS_SLOTS] + i]
        d = abs(A[0, slot])
        Y[DIAGONAL, i] = Y[SCALE, i] / d if d > 0.0 else 0.0
        ratio = max(ratio, abs(A[2, slot]) / max(d, 1e-300))
    if ratio <= LATE and I[N_LAWS] + I[N_GAM] == 0:
        return
    compress(A[2], P[2], I)
    ratio = 0.0
    for k in range(P[2, last]):
        r, c = P[2, 2 * k], P[2, 2 * k + 1]
        if r < I[N_Q]:
            ratio = max(ratio, abs(A[2, k]) * Y[DIAGONAL, r] / Y[SCALE, c])
    if ratio <= LATE:
        P[2, last] = 0
