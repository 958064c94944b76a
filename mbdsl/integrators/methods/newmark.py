"""NEWMARK: Newmark's method on the index-3 equations, order 1.

Unknowns a_{n+1}, lam_{n+1}; f = Q - Phi_q^T lam:

    q_{n+1} = q_n + h v_n + h^2/2 [(1 - 2 beta) a_n + 2 beta a_{n+1}]                                    (4a)
    v_{n+1} = v_n + h [(1 - gamma) a_n + gamma a_{n+1}]                                                   (4b)
    M a_{n+1} - f_{n+1} = 0
    1/(beta h^2) Phi(q_{n+1}, t_{n+1}) = 0

Local errors: h^3 (1/6 - beta) q''' in q, h^2 (1/2 - gamma) v'' in v.

gamma > 1/2 damps high frequencies. gamma = 1/2 with beta = 1/4, the trapezoidal rule, has order 2, but does not damp
the multipliers' oscillations at all.

Where the start is so stiff that a_0 says nothing about the motion behind a transient, the first two steps are of the
backward Euler method, which is beta = gamma = 1 without a_n: one to pass the transient, one to find the a behind it.

Source: Negrut, Jay, Khude, A discussion of low order numerical integration formulas for rigid and flexible multibody
dynamics, J. Comput. Nonlinear Dyn. 4 (2009) 021008, eqs. (4)-(6).
"""

from mbdsl.compilation.buffer_layout import FP, MASS, MX, N_ALL, N_PHI, N_Q, Q0, V0, XA, Q, R, V, X
from mbdsl.compilation.marks import kernel
from mbdsl.integrators.loop.linear_solve import factor
from mbdsl.integrators.loop.loop_state import H
from mbdsl.integrators.loop.split_correction import correct_one as correct
from mbdsl.integrators.loop.step_control import set_velocity
from mbdsl.integrators.method import Method, Option

__all__ = ["correct"]


def beta_of(options):
    """beta as given, else the smallest that is stable."""
    gamma, beta = options["gamma"], options["beta"]
    return (gamma + 1 / 2) ** 2 / 4 if beta is None else beta


def carried(beta, gamma, alpha=0.0):
    """c: beta, gamma, alpha, the weight of a_n; the first three again, for behind a stiff start; steps till then."""
    return beta, gamma, alpha, 1.0, beta, gamma, alpha, 0.0


def coefficients(options):
    return carried(beta_of(options), options["gamma"])


def start_stiff(c):
    """Set c for two steps of the backward Euler method."""
    c[:4], c[7] = (1.0, 1.0, 0.0, 0.0), 2.0


def check(options):
    gamma, beta = options["gamma"], beta_of(options)
    if beta < (gamma + 1 / 2) ** 2 / 4 - 1e-12:
        return (
            f"beta = {beta:g} is below (gamma + 1/2)^2/4 = {(gamma + 1 / 2) ** 2 / 4:g}: the method is then unstable "
            "for high frequencies"
        )
    return None


def check_constrained(options):
    if options["gamma"] < 1 / 2 + 1e-12:
        return (
            "gamma = 1/2 (the trapezoidal rule) does not damp the multipliers of a constrained model, whose "
            "oscillations grow until the results mean nothing; take gamma > 1/2"
        )
    return None


def begin(c, start):
    if start.stiff:
        start_stiff(c)
    return {XA: [*(0.0 * start.a if start.stiff else start.a), *start.lam]}


METHOD = Method(
    "newmark",
    doc="Newmark on the index-3 equations",
    order=1,
    index=3,
    enforces=("Phi",),
    family="Newmark",
    source="Negrut, Jay, Khude (2009), eqs. (4)-(6)",
    parameters={
        "gamma": Option(0.6, 0.5, 1.5, "numerical damping of high frequencies: 1/2 none"),
        "beta": Option(None, 0.25, 1.0, "at least (gamma + 1/2)^2/4, which is the default"),
    },
    check=check,
    check_constrained=check_constrained,
    coefficients=coefficients,
    begin=begin,
    damping_weight=lambda c: c[1],
    steps=("fixed", "controlled"),
    relative_step=0.5,
)


@kernel
def motion(h, c, Y, I):
    beta, gamma = c[0], c[1]
    for i in range(I[N_Q]):
        a0, a = c[3] * Y[XA, i], Y[X, i]
        Y[Q, i] = Y[Q0, i] + h * Y[V0, i] + h * h / 2 * ((1 - 2 * beta) * a0 + 2 * beta * a)
        Y[V, i] = Y[V0, i] + h * ((1 - gamma) * a0 + gamma * a)


@kernel
def local_error(h, last, c, jerk, snap):
    """Errors of q and v in a step of length h behind one of length ``last``."""
    beta, gamma = c[0], c[1]
    return h * h * h * (1 / 6 - beta) * jerk, h * h * (1 / 2 - gamma) * jerk


@kernel
def velocity_error(h, last, c):
    """What v is wrong by along the constraints' normals, relative to the jerk."""
    return h * h * (1 / 6 - c[0] - (1 / 2 - c[1]) / 2)


@kernel
def change_step(h, evaluate, tangent, inertia, c, K, J, Y, Z, C, F, I, A, P):
    """v_n along the normals, for a step of length h in place of K[H]."""
    if h != K[H]:
        set_velocity(velocity_error(h, h, c), h, matrix, evaluate, tangent, inertia, c, K, J, Y, Z, C, F, I, A, P)


@kernel
def residual(h, c, Y, F, I):
    beta, gamma = c[0], c[1]
    n, m = I[N_Q], I[N_PHI]
    for i in range(n):
        Y[R, i] = F[I[MASS] + i] * Y[X, i] + Y[MX, i] - Y[FP, i]
    for i in range(n, n + m):
        Y[R, i] = Y[FP, i] / (beta * h * h)
    for i in range(n + m, I[N_ALL]):
        Y[R, i] = Y[FP, i] / (gamma * h)


@kernel
def matrix(tangent, t, h, c, Y, Z, C, F, I, A, P):
    """[[M + beta h^2 K' + gamma h D, Phi_q^T], [Phi_q, 0]] with K' = K + (M a)_q."""
    beta, gamma = c[0], c[1]
    tangent(t, 1.0, beta * h * h, gamma * h, 1.0, 1.0, 0.0, 1.0, beta * h / gamma, beta * h * h, Y, Z, C, F, I, A[0])
    return factor(A[0], P[0], I)


@kernel
def finish(inertia, h, c, Y, F, I, A, P):
    """Nothing but q, v and a is kept."""
    settle(c)


@kernel
def settle(c):
    """One of the steps of a stiff start is done."""
    if c[7] > 0.0:
        c[7] -= 1.0
        if c[7] == 0.0:
            c[0], c[1], c[2], c[3] = c[4], c[5], c[6], 1.0
