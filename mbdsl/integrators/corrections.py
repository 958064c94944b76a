"""How Newton's corrections are solved for: in one system, or in two that follow each other."""

from __future__ import annotations

from mbdsl.integrators.linear import larger, multiply, solve, solve_both
from mbdsl.kernels import kernel, rare
from mbdsl.layout import D2, N_ALL, N_Q, SCALE, T2, D, R, X

#: the second system's solution, relative to the first's, that may be taken into account an iteration late
LATE = 0.02


@kernel
def correct_one(h, c, Y, I, A, P):
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
def solve_two(coupled, A, P, I, Y):
    """D2 <- A1^{-1} D2 and D <- A0^{-1} (D + A2 D2), A2 zero unless ``coupled``.

    Both are solved side by side, which takes little longer than one. What A2 adds comes afterwards, and only where D2
    is not small: for smooth motion it is by a power of h, and then an iteration later is soon enough.
    """
    solve_both(A, P, I, Y)
    if coupled:
        first, second = 0.0, 0.0
        for i in range(I[N_Q]):
            first = max(first, abs(Y[D, i]) * Y[SCALE, i])
            second = max(second, abs(Y[D2, i]) * Y[SCALE, i])
        if second > LATE * first:
            couple(A, P, I, Y)


@rare
def couple(A, P, I, Y):
    """D += A0^{-1} A2 D2."""
    for i in range(I[N_ALL]):
        Y[T2, i] = 0.0
    multiply(A[2], I, Y, D2, T2)
    solve(A[0], P[0], I, Y, T2)
    for i in range(I[N_ALL]):
        Y[D, i] += Y[T2, i]
