"""Generalised-alpha, stabilised index 2; both constraint levels hold, order 2 in q, v, a and lam.

Unknowns a_{n+1} = q''(t_{n+1}), lam_{n+1} and, local to the step, abar, mu; A, its weights and its start are those of
generalized-alpha-i3:

    (1 - alpha_m) A_{n+1} + alpha_m A_n = (1 - alpha_f) a_{n+1} + alpha_f a_n
    q_{n+1} = q_n + h v_n + h^2 [(1/2 - beta) A_n + beta A_{n+1}] + h^2/2 abar
    v_{n+1} = v_n + h [(1 - gamma) A_n + gamma A_{n+1}]
    R1:  M a_{n+1} - f_{n+1} = 0
    R2:  M abar + Phi_q^T mu = 0
    R3:  1/h^2 Phi(q_{n+1}, t_{n+1}) = 0
    R4:  1/h (Phi_q v + Phi_t)_{n+1} = 0

with M and Phi_q at q_{n+1}. The corrections are those of hht-si2, where beta and gamma are what q and v have of
a_{n+1}: a projection with the mass matrix, and the index-3 system. What (M abar)_q adds to R2 is, as (Phi_q^T mu)_q,
left to the next iteration: abar vanishes with the error of the discretisation.

Local errors, and the shift of A_n where steps differ, are those of generalized-alpha-i3; abar and mu are predicted in
proportion to the step.

Source: Chung, Hulbert (1993); Arnold, Bruels, Cardona, Error analysis of generalized-alpha Lie group time integration
methods for constrained mechanical systems, Numer. Math. 129 (2015) 149-179, for the stabilised index-2 form; its
projection is here the one of Negrut, Jay, Khude (2009), eq. (12), with masses.
"""

from mbdsl.compilation.buffer_layout import FP, GD, MASS, MX, MX2, N_ALL, N_PHI, N_Q, PAST, R2, X2, XA, Q, R, X
from mbdsl.compilation.marks import kernel
from mbdsl.integrators.loop.linear_solve import factor
from mbdsl.integrators.loop.loop_state import H
from mbdsl.integrators.loop.split_correction import couple, couples
from mbdsl.integrators.method import Method
from mbdsl.integrators.methods.generalized_alpha_i3 import (
    RHO,
    begin,
    check_constrained,
    coefficients,
    finish,
    local_error,
    shift,
)
from mbdsl.integrators.methods.generalized_alpha_i3 import motion as index_3_motion
from mbdsl.integrators.methods.hht_si2 import correct

__all__ = ["correct", "finish", "local_error"]

METHOD = Method(
    "generalized-alpha",
    doc="generalised-alpha, stabilised: positions and velocities on their constraints",
    order=2,
    index=2,
    enforces=("Phi", "dPhi"),
    family="Newmark",
    source="Arnold, Bruels, Cardona (2015)",
    parameters={"rho": RHO},
    check_constrained=check_constrained,
    coefficients=coefficients,
    begin=begin,
    damping_weight=lambda c: c[1],
    steps=("fixed", "controlled"),
    sets=2,
    matrices=3,
)


@kernel
def motion(h, c, Y, I):
    index_3_motion(h, c, Y, I)
    for i in range(I[N_Q]):
        Y[Q, i] += h * h / 2 * Y[X2, i]


@kernel
def change_step(h, evaluate, tangent, inertia, c, K, J, Y, Z, C, F, I, A, P):
    """A_n, and abar and mu of the past, for a step of length h in place of K[H]."""
    if h != K[H]:
        shift(h, c, K, Y, I)
        for k in range(PAST):
            for i in range(I[N_ALL]):
                Y[XA + PAST + k, i] *= h / K[H]


@kernel
def residual(h, c, Y, F, I):
    n, m = I[N_Q], I[N_PHI]
    for i in range(n):
        mass = F[I[MASS] + i]
        Y[R, i] = mass * Y[X, i] + Y[MX, i] - Y[FP, i]  # R1
        Y[R2, i] = mass * Y[X2, i] + Y[MX2, i] + Y[GD, i]  # R2
    for i in range(n, n + m):
        Y[R, i] = Y[FP, i] / (h * h)  # R3
        Y[R2, i] = Y[GD, i] / h  # R4
    for i in range(n + m, I[N_ALL]):
        Y[R, i], Y[R2, i] = Y[FP, i] / h, 0.0


@kernel
def matrix(tangent, t, h, c, Y, Z, C, F, I, A, P):
    """[[S, Phi_q^T], [Phi_q, 0]], [[2 M, Phi_q^T], [Phi_q, 0]] and -h^2 K', with S and K' of generalized-alpha-i3."""
    k, d = c[0] * h * h, c[1] * h
    tangent(t, 1.0, k, d, 1.0, 1.0, 0.0, 1.0, k / d, k, Y, Z, C, F, I, A[0])
    tangent(t, 2.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, Y, Z, C, F, I, A[1])
    P[2, P.shape[1] - 1] = 0
    if couples(1.0, A, F, I):
        tangent(t, 0.0, -h * h, 0.0, 0.0, 0.0, 0.0, 0.0, -h / c[1], -h * h, Y, Z, C, F, I, A[2])
        couple(A, P, I, Y)
    return factor(A[0], P[0], I) and factor(A[1], P[1], I)
