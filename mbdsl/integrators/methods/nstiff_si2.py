"""NSTIFF-SI2: the backward differentiation formula of order 2 on the stabilised index-2 equations.

Unknowns a = v'_{n+1}, lam_{n+1} and q'_{n+1}, mu, which vanishes with the error of the discretisation (Gear, Gupta,
Leimkuhler); f = Q - Phi_q^T lam, s = 2/3 h. Iterated on is q' - v, which is as small and smooth as mu:

    q_{n+1} = 4/3 q_n - 1/3 q_{n-1} + s q'_{n+1}
    v_{n+1} = 4/3 v_n - 1/3 v_{n-1} + s a_{n+1}
    R1:  M a_{n+1} - f_{n+1} = 0
    R2:  v_{n+1} - q'_{n+1} + Phi_q^T mu = 0
    R3:  1/s Phi(q_{n+1}, t_{n+1}) = 0
    R4:  1/s (Phi_q v + Phi_t)_{n+1} = 0

The system of twice the size is not solved as one. With u = dq'/s - da (how far positions are to be corrected beyond
what velocities make of them), S = M + s^2 K + s D and K with (M a)_q, Newton's equations read

    R2:           u - Phi_q^T dmu/s = R2/s + ...
    R4 - R3/s:    Phi_q u = R4 - R3/s + ...
    R1:           S da + Phi_q^T dlam = -R1 - s^2 K u
    R4:           Phi_q da = -R4 + ...

The dots are s N q and s^2 (Phi_q^T mu)_q: a power of h times a correction, left to the next iteration. The converged
solution is that of the full system.

Steps that differ, and local errors: as with NSTIFF. q' - v and mu, which vanish with h^2, are predicted in proportion.

Source: Negrut, Jay, Khude, J. Comput. Nonlinear Dyn. 4 (2009) 021008, section on NSTIFF-SI2; the splitting is ours.
"""

from mbdsl.compilation.buffer_layout import (
    D2,
    FP,
    GD,
    MASS,
    MASS_SLOTS,
    MX,
    N_ALL,
    N_PHI,
    N_Q,
    PAST,
    Q0,
    Q1,
    R2,
    SCALE,
    SLOTS,
    V0,
    V1,
    X2,
    XA,
    D,
    Q,
    R,
    V,
    X,
)
from mbdsl.compilation.marks import kernel
from mbdsl.integrators.loop.linear_solve import factor, larger
from mbdsl.integrators.loop.loop_state import LAST_H, H
from mbdsl.integrators.loop.split_correction import couple, couples, solve_two
from mbdsl.integrators.method import Method
from mbdsl.integrators.methods.nstiff import BDF2, begin, finish, local_error, set_ratio

__all__ = ["begin", "finish", "local_error"]


METHOD = Method(
    "nstiff-si2",
    doc="BDF of order 2, stabilised: positions and velocities on their constraints",
    order=2,
    index=2,
    enforces=("Phi", "dPhi"),
    family="BDF2",
    source="Negrut, Jay, Khude (2009), NSTIFF-SI2",
    coefficients=lambda options: (*BDF2, 0.0),
    begin=begin,
    sets=2,
    matrices=3,
    steps=("fixed", "controlled"),
    relative_step=0.5,
)


@kernel
def motion(h, c, Y, I):
    s, p = c[1] * h, c[2]
    for i in range(I[N_Q]):
        v = Y[V0, i] + p * (Y[V0, i] - Y[V1, i]) + s * Y[X, i]
        Y[Q, i] = Y[Q0, i] + p * (Y[Q0, i] - Y[Q1, i]) + s * (v + Y[X2, i])
        Y[V, i] = v


@kernel
def change_step(h, evaluate, tangent, inertia, c, K, J, Y, Z, C, F, I, A, P):
    """Coefficients of a step of length h in place of K[H]; q' - v and mu of the past, as with steps of that length."""
    set_ratio(h / K[LAST_H], c)
    for k in range(PAST if h != K[H] else 0):
        for i in range(I[N_ALL]):
            Y[XA + PAST + k, i] *= (h / K[H]) ** 2


@kernel
def residual(h, c, Y, F, I):
    s = c[1] * h
    n, m = I[N_Q], I[N_PHI]
    for i in range(n):
        Y[R, i] = F[I[MASS] + i] * Y[X, i] + Y[MX, i] - Y[FP, i]  # R1
        Y[R2, i] = Y[GD, i] - Y[X2, i]  # R2
    for i in range(n, n + m):
        Y[R, i] = Y[FP, i] / s  # R3
        Y[R2, i] = Y[GD, i] / s  # R4
    for i in range(n + m, I[N_ALL]):
        Y[R, i], Y[R2, i] = Y[FP, i] / s, 0.0


@kernel
def matrix(tangent, t, h, c, Y, Z, C, F, I, A, P):
    """[[S, Phi_q^T], [Phi_q, 0]], [[1, Phi_q^T], [Phi_q, 0]] and -s^2 K."""
    s = c[1] * h
    tangent(t, 1.0, s * s, s, 1.0, 1.0, 0.0, 1.0, s, s * s, Y, Z, C, F, I, A[0])
    tangent(t, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, Y, Z, C, F, I, A[1])
    for i in range(I[N_Q]):
        A[1, I[I[SLOTS] + I[MASS_SLOTS] + i]] += 1.0
    P[2, P.shape[1] - 1] = 0
    if couples(1.0, A, F, I):
        tangent(t, 0.0, -s * s, 0.0, 0.0, 0.0, 0.0, 0.0, -s, -s * s, Y, Z, C, F, I, A[2])
        couple(A, P, I, Y)
    return factor(A[0], P[0], I) and factor(A[1], P[1], I)


@kernel
def correct(k, h, c, Y, I, A, P):
    """Solve for the corrections, apply them; the largest scaled change of a position (or of h times a velocity)."""
    s = c[1] * h
    n, m = I[N_Q], I[N_PHI]
    for i in range(n):
        Y[D, i], Y[D2, i] = -Y[R, i], Y[R2, i] / s
    for i in range(n, n + m):
        Y[D, i], Y[D2, i] = -Y[R2, i], Y[R2, i] - Y[R, i] / s
    for i in range(n + m, I[N_ALL]):
        Y[D, i], Y[D2, i] = -Y[R, i], 0.0
    solve_two(k, A, P, I, Y)
    change = 0.0
    for i in range(n):
        a, u = Y[D, i], Y[D2, i]
        Y[X, i] += a
        Y[X2, i] += s * u
        change = larger((abs(a) + abs(u)) * Y[SCALE, i], change)
    for i in range(n, I[N_ALL]):
        Y[X, i] += Y[D, i]
        Y[X2, i] -= s * Y[D2, i]
    return s * s * change
