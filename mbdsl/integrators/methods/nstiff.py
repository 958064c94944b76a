"""NSTIFF: the backward differentiation formula of order 2 on the index-3 equations.

Unknowns a_{n+1}, lam_{n+1}; f = Q - Phi_q^T lam:

    q_{n+1} = 4/3 q_n - 1/3 q_{n-1} + h (8/9 v_n - 2/9 v_{n-1}) + 4/9 h^2 a_{n+1}
    v_{n+1} = 4/3 v_n - 1/3 v_{n-1} + 2/3 h a_{n+1}
    M a_{n+1} - f_{n+1} = 0
    9/(4 h^2) Phi(q_{n+1}, t_{n+1}) = 0

Steps that differ, with r = h_n/h_{n-1}, s = h_n (1 + r)/(1 + 2 r) and p = r^2/(1 + 2 r) (2/3 h and 1/3 for r = 1):

    v_{n+1} = (1 + p) v_n - p v_{n-1} + s a_{n+1}
    q_{n+1} = (1 + p) q_n - p q_{n-1} + s v_{n+1}

Local errors: -s h_n (h_n + h_{n-1})/6 times q''' in q, and times v''' in v (-2/9 h^3 for r = 1). Along the constraints'
normals v_n has the error that makes q_n right, -h_{n-1} (h_{n-1} + h_{n-2})/6 q'''; where steps differ, it is made that
of the step to come, without which a, and reactions, would jump by O(h).

The step before the start is made up, from the motion's Taylor expansion. Where the start is stiff, so that a says
nothing about the motion behind a transient, the first step is one of the backward Euler method instead: v_{n+1} = v_n +
h a_{n+1}, q_{n+1} = q_n + h v_{n+1}. Order 2 is kept, as it is one step.

Source: Negrut, Jay, Khude, J. Comput. Nonlinear Dyn. 4 (2009) 021008, section on NSTIFF; after Orlandea's stiff
integrator in ADAMS. The start is ours.
"""

from mbdsl.compilation.buffer_layout import E_Q, FP, MASS, MX, N_ALL, N_PHI, N_Q, Q0, Q1, V0, V1, XA, Q, R, V, X
from mbdsl.compilation.marks import kernel
from mbdsl.integrators.loop.linear_solve import factor
from mbdsl.integrators.loop.loop_state import LAST_H
from mbdsl.integrators.loop.split_correction import correct_one as correct
from mbdsl.integrators.loop.step_control import set_velocity
from mbdsl.integrators.method import Method

__all__ = ["correct"]


#: (s/h)^2 and s/h: how q and v follow a; p
BDF2 = (4 / 9, 2 / 3, 1 / 3)
EULER = (1.0, 1.0, 0.0)


def before(start):
    """q and v one step before the start."""
    h, q, v, a, j = start.h, start.q, start.v, start.a, start.jerk
    return {Q1: q - h * v + h**2 / 2 * a - h**3 / 6 * j, V1: v - h * a + h**2 / 2 * j}


def begin(c, start):
    c[:4] = *(EULER if start.stiff else BDF2), -(start.h**2) / 3
    return {XA: [*(0.0 * start.a if start.stiff else start.a), *start.lam], **before(start)}


METHOD = Method(
    "nstiff",
    doc="BDF of order 2 on the index-3 equations",
    order=2,
    index=3,
    enforces=("Phi",),
    family="BDF2",
    source="Negrut, Jay, Khude (2009), NSTIFF",
    coefficients=lambda options: (*BDF2, 0.0),
    begin=begin,
    steps=("fixed", "controlled"),
    relative_step=0.5,
)


@kernel
def motion(h, c, Y, I):
    s, p = c[1] * h, c[2]
    for i in range(I[N_Q]):
        v = Y[V0, i] + p * (Y[V0, i] - Y[V1, i])
        Y[Q, i] = Y[Q0, i] + p * (Y[Q0, i] - Y[Q1, i]) + s * (v + s * Y[X, i])
        Y[V, i] = v + s * Y[X, i]


@kernel
def local_error(h, last, c, jerk, snap):
    """Errors of q and v in a step of length h behind one of length ``last``."""
    k = -c[1] * h * h * (h + last) / 6
    return k * jerk, k * snap


@kernel
def velocity_error(h, last, c):
    """What v is wrong by along the constraints' normals, relative to the jerk."""
    return -h * (h + last) / 6


@kernel
def change_step(h, evaluate, tangent, inertia, c, K, J, Y, Z, C, F, I, A, P):
    """Coefficients of a step of length h; v_n and v_{n-1} along the normals."""
    set_ratio(h / K[LAST_H], c)
    error = velocity_error(h, K[LAST_H], c)
    if error != c[3]:
        set_velocity(error, h, matrix, evaluate, tangent, inertia, c, K, J, Y, Z, C, F, I, A, P)
        for i in range(I[N_Q]):
            Y[V1, i] += Y[E_Q, i]
    c[3] = error


@kernel
def set_ratio(r, c):
    s = (1 + r) / (1 + 2 * r)
    c[0], c[1], c[2] = s * s, s, r * r / (1 + 2 * r)


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
    c[0], c[1], c[2] = 4 / 9, 2 / 3, 1 / 3
    for i in range(I[N_Q]):
        Y[Q1, i], Y[V1, i] = Y[Q0, i], Y[V0, i]
