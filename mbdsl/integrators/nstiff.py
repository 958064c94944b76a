"""NSTIFF: the backward differentiation formula of order 2 on the index-3 equations.

Unknowns a_{n+1}, lam_{n+1}; f = Q - Phi_q^T lam:

    q_{n+1} = 4/3 q_n - 1/3 q_{n-1} + h (8/9 v_n - 2/9 v_{n-1}) + 4/9 h^2 a_{n+1}
    v_{n+1} = 4/3 v_n - 1/3 v_{n-1} + 2/3 h a_{n+1}
    M a_{n+1} - f_{n+1} = 0
    9/(4 h^2) Phi(q_{n+1}, t_{n+1}) = 0

The step before the start is made up, from the motion's Taylor expansion. Without its last term (where a start is too
stiff for one) the first step is one of Newmark's method with gamma = 2/3, beta = 4/9, and order 2 is kept as well.

Source: Negrut, Jay, Khude, J. Comput. Nonlinear Dyn. 4 (2009) 021008, section on NSTIFF; after Orlandea's stiff
integrator in ADAMS. The start is ours.
"""

from mbdsl.integrators.corrections import correct_one as correct
from mbdsl.integrators.linear import factor
from mbdsl.integrators.method import Method
from mbdsl.kernels import kernel
from mbdsl.layout import FP, MASS, N_ALL, N_PHI, N_Q, Q0, Q1, V0, V1, XA, Q, R, V, X

__all__ = ["correct"]


def before(start):
    """q and v one step before the start."""
    h, q, v, a, j = start.h, start.q, start.v, start.a, start.jerk
    return {Q1: q - h * v + h**2 / 2 * a - h**3 / 6 * j, V1: v - h * a + h**2 / 2 * j}


def begin(c, start):
    return {XA: [*start.a, *start.lam], **before(start)}


METHOD = Method(
    "nstiff",
    doc="BDF of order 2 on the index-3 equations",
    order=2,
    index=3,
    enforces=("Phi",),
    source="Negrut, Jay, Khude (2009), NSTIFF",
    coefficients=lambda options: (4 / 9,),
    begin=begin,
)


@kernel
def motion(h, c, Y, I):
    for i in range(I[N_Q]):
        q0, q1, v0, v1, a = Y[Q0, i], Y[Q1, i], Y[V0, i], Y[V1, i], Y[X, i]
        Y[Q, i] = q0 + (q0 - q1) / 3 + h * (8 / 9 * v0 - 2 / 9 * v1) + 4 / 9 * h * h * a
        Y[V, i] = v0 + (v0 - v1) / 3 + 2 / 3 * h * a


@kernel
def residual(h, c, Y, F, I):
    n, m = I[N_Q], I[N_PHI]
    for i in range(n):
        Y[R, i] = F[I[MASS] + i] * Y[X, i] - Y[FP, i]
    for i in range(n, n + m):
        Y[R, i] = 9 / (4 * h * h) * Y[FP, i]
    for i in range(n + m, I[N_ALL]):
        Y[R, i] = 3 / (2 * h) * Y[FP, i]


@kernel
def matrix(tangent, t, h, c, Y, Z, C, F, I, A, P):
    """[[M + s^2 K + s D, Phi_q^T], [Phi_q, 0]] with s = 2/3 h."""
    s = 2 / 3 * h
    tangent(t, 1.0, s * s, s, 1.0, 1.0, 0.0, 1.0, s, Y, Z, C, F, I, A[0])
    return factor(A[0], P[0], I)


@kernel
def finish(h, c, Y, F, I):
    """The step's start becomes the past."""
    for i in range(I[N_Q]):
        Y[Q1, i], Y[V1, i] = Y[Q0, i], Y[V0, i]
