"""HHT-I3: the Hilber-Hughes-Taylor method on the index-3 equations, order 2.

Unknowns a_{n+1}, lam_{n+1}; a_n ~ q''(t_n + alpha h); f = Q - Phi_q^T lam:

    q_{n+1} = q_n + h v_n + h^2/2 [(1 - 2 beta) a_n + 2 beta a_{n+1}]                                    (8a)
    v_{n+1} = v_n + h [(1 - gamma) a_n + gamma a_{n+1}]                                                   (8b)
    1/(1+alpha) M a_{n+1} - f_{n+1} + alpha/(1+alpha) f_n = 0                                             (8c)
    1/(beta h^2) Phi(q_{n+1}, t_{n+1}) = 0                                                                (8d)

Source: Negrut, Jay, Khude, A discussion of low order numerical integration formulas for rigid and flexible multibody
dynamics, J. Comput. Nonlinear Dyn. 4 (2009) 021008, eq. (8).
"""

from mbdsl.integrators.linear import factor, larger, solve
from mbdsl.integrators.method import Method, Option
from mbdsl.kernels import kernel
from mbdsl.layout import F0, FP, MASS, N_ALL, N_Q, Q0, SCALE, V0, XA, D, Q, R, V, X

ALPHA = Option(-0.1, -1 / 3, 0.0, "numerical damping of high frequencies: 0 none, -1/3 most")


def coefficients(options):
    """(alpha, beta, gamma)."""
    alpha = options["alpha"]
    return alpha, (1 - alpha) ** 2 / 4, 1 / 2 - alpha


def lag(c):
    """a_n is the acceleration at t_n + lag h."""
    return c[0]


METHOD = Method(
    "hht-i3",
    doc="Hilber-Hughes-Taylor on the index-3 equations",
    order=2,
    index=3,
    enforces=("Phi",),
    source="Negrut, Jay, Khude (2009), eq. (8)",
    parameters={"alpha": ALPHA},
    coefficients=coefficients,
    lag=lag,
)


@kernel
def residual(evaluate, t, h, c, Y, Z, C, F, I):
    alpha, beta, gamma = c[0], c[1], c[2]
    n = I[N_Q]
    for i in range(n):
        a0, a = Y[XA, i], Y[X, i]
        Y[Q, i] = Y[Q0, i] + h * Y[V0, i] + h * h / 2 * ((1 - 2 * beta) * a0 + 2 * beta * a)
        Y[V, i] = Y[V0, i] + h * ((1 - gamma) * a0 + gamma * a)
    evaluate(t, Y, Z, C, F, I)
    for i in range(n):
        Y[R, i] = F[I[MASS] + i] * Y[X, i] / (1 + alpha) - Y[FP, i] + alpha / (1 + alpha) * Y[F0, i]
    for i in range(n, I[N_ALL]):
        Y[R, i] = Y[FP, i] / (beta * h * h)


@kernel
def matrix(tangent, t, h, c, Y, Z, C, F, I, A, P):
    """[[M/(1+alpha) + beta h^2 K + gamma h D, Phi_q^T], [Phi_q, 0]]."""
    alpha, beta, gamma = c[0], c[1], c[2]
    tangent(t, 1 / (1 + alpha), beta * h * h, gamma * h, 1.0, 0.0, Y, Z, C, F, I, A[0])
    return factor(A[0], P[0], I)


@kernel
def correct(h, c, Y, I, A, P):
    """Solve for the correction, apply it; the largest scaled change of a position."""
    beta = c[1]
    for i in range(I[N_ALL]):
        Y[D, i] = -Y[R, i]
    solve(A[0], P[0], I, Y, D)
    for i in range(I[N_ALL]):
        Y[X, i] += Y[D, i]
    change = 0.0
    for i in range(I[N_Q]):
        change = larger(abs(Y[D, i]) * Y[SCALE, i], change)
    return beta * h * h * change


@kernel
def finish(h, c, Y, F, I):
    """q, v and f at the accepted unknowns; f from (8c), which saves an evaluation."""
    alpha, beta, gamma = c[0], c[1], c[2]
    for i in range(I[N_Q]):
        a0, a = Y[XA, i], Y[X, i]
        Y[Q, i] = Y[Q0, i] + h * Y[V0, i] + h * h / 2 * ((1 - 2 * beta) * a0 + 2 * beta * a)
        Y[V, i] = Y[V0, i] + h * ((1 - gamma) * a0 + gamma * a)
        Y[FP, i] = (F[I[MASS] + i] * a + alpha * Y[F0, i]) / (1 + alpha)
