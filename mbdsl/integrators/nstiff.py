"""NSTIFF: the backward differentiation formula of order 2 on the index-3 equations.

Unknowns a_{n+1}, lam_{n+1}; f = Q - Phi_q^T lam:

    q_{n+1} = 4/3 q_n - 1/3 q_{n-1} + h (8/9 v_n - 2/9 v_{n-1}) + 4/9 h^2 a_{n+1}
    v_{n+1} = 4/3 v_n - 1/3 v_{n-1} + 2/3 h a_{n+1}
    M a_{n+1} - f_{n+1} = 0
    9/(4 h^2) Phi(q_{n+1}, t_{n+1}) = 0

The step before the start is made up, from the motion's Taylor expansion. Where the start is stiff, so that a says
nothing about the motion behind a transient, the first step is one of the backward Euler method instead: v_{n+1} = v_n +
h a_{n+1}, q_{n+1} = q_n + h v_{n+1}. Order 2 is kept, as it is one step.

Source: Negrut, Jay, Khude, J. Comput. Nonlinear Dyn. 4 (2009) 021008, section on NSTIFF; after Orlandea's stiff
integrator in ADAMS. The start is ours.
"""

from mbdsl.integrators.corrections import correct_one as correct
from mbdsl.integrators.linear import factor
from mbdsl.integrators.method import Method
from mbdsl.kernels import kernel
from mbdsl.layout import FP, MASS, MX, N_ALL, N_PHI, N_Q, Q0, Q1, V0, V1, XA, Q, R, V, X

__all__ = ["correct"]


#: (s/h)^2 and s/h: how q and v follow a
BDF2 = (4 / 9, 2 / 3)


def before(start):
    """q and v one step before the start."""
    h, q, v, a, j = start.h, start.q, start.v, start.a, start.jerk
    return {Q1: q - h * v + h**2 / 2 * a - h**3 / 6 * j, V1: v - h * a + h**2 / 2 * j}


def begin(c, start):
    c[0], c[1] = (1.0, 1.0) if start.stiff else BDF2
    return {XA: [*(0.0 * start.a if start.stiff else start.a), *start.lam], **before(start)}


METHOD = Method(
    "nstiff",
    doc="BDF of order 2 on the index-3 equations",
    order=2,
    index=3,
    enforces=("Phi",),
    source="Negrut, Jay, Khude (2009), NSTIFF",
    coefficients=lambda options: BDF2,
    begin=begin,
)


@kernel
def motion(h, c, Y, I):
    for i in range(I[N_Q]):
        q0, q1, v0, v1, a = Y[Q0, i], Y[Q1, i], Y[V0, i], Y[V1, i], Y[X, i]
        if c[1] < 1.0:
            Y[Q, i] = q0 + (q0 - q1) / 3 + h * (8 / 9 * v0 - 2 / 9 * v1) + 4 / 9 * h * h * a
            Y[V, i] = v0 + (v0 - v1) / 3 + 2 / 3 * h * a
        else:  # backward Euler
            Y[Q, i] = q0 + h * v0 + h * h * a
            Y[V, i] = v0 + h * a


@kernel
def residual(h, c, Y, F, I):
    s = c[1] * h
    n, m = I[N_Q], I[N_PHI]
    for i in range(n):
        Y[R, i] = F[I[MASS] + i] * Y[X, i] + Y[MX, i] - Y[FP, i]
    for i in range(n, n + m):
        Y[R, i] = Y[FP, i] / (s * s)
    for i in range(n + m, I[N_ALL]):
        Y[R, i] = Y[FP, i] / s


@kernel
def matrix(tangent, t, h, c, Y, Z, C, F, I, A, P):
    """[[M + s^2 (K + (M a)_q) + s D, Phi_q^T], [Phi_q, 0]] with s = 2/3 h."""
    s = c[1] * h
    tangent(t, 1.0, s * s, s, 1.0, 1.0, 0.0, 1.0, s, s * s, Y, Z, C, F, I, A[0])
    return factor(A[0], P[0], I)


@kernel
def finish(inertia, h, c, Y, F, I, A, P):
    """The step's start becomes the past, and what began with backward Euler goes on with BDF2."""
    c[0], c[1] = 4 / 9, 2 / 3
    for i in range(I[N_Q]):
        Y[Q1, i], Y[V1, i] = Y[Q0, i], Y[V0, i]
