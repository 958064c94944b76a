"""Generalised-alpha on the index-3 equations, order 2.

Unknowns a_{n+1} = q''(t_{n+1}), lam_{n+1}; A, which is carried from step to step, belongs to the times
t_n + (alpha_m - alpha_f) h; f = Q - Phi_q^T lam:

    (1 - alpha_m) A_{n+1} + alpha_m A_n = (1 - alpha_f) a_{n+1} + alpha_f a_n
    q_{n+1} = q_n + h v_n + h^2 [(1/2 - beta) A_n + beta A_{n+1}]
    v_{n+1} = v_n + h [(1 - gamma) A_n + gamma A_{n+1}]
    M(q_{n+1}) a_{n+1} - f_{n+1} = 0
    1/(s h^2) Phi(q_{n+1}, t_{n+1}) = 0,   s h^2 a_{n+1} being what q_{n+1} has of a_{n+1}

The spectral radius for infinite frequencies, rho, gives all else:

    alpha_m = (2 rho - 1)/(rho + 1),  alpha_f = rho/(rho + 1),  gamma = 1/2 + alpha_f - alpha_m,
    beta = (gamma + 1/2)^2/4

The equations of motion hold at t_{n+1}, so that the method is of order 2 with any M(q). A_0 = a_0 + (alpha_m - alpha_f)
h q''': with A_0 = a_0 reactions would be of order 1 at first.

Local errors, with D = alpha_m - alpha_f and k = (1 - alpha_f)/2 - (1 - alpha_m) (1/2 + D), A_n being
q''(t_n) + D h q''' + k h^2 q'''': h^3 (1/6 - beta - D/2) q''' in q, h^3 (1/6 - k - gamma (1/2 + D)) v''' in v.

Steps that differ: A_n is shifted by D (h_n - h_{n-1}) q''', and v_n along the constraints' normals set anew, as HHT-I3
has it.

Source: Chung, Hulbert, A time integration algorithm for structural dynamics with improved numerical dissipation: the
generalized-alpha method, J. Appl. Mech. 60 (1993) 371-375; Arnold, Bruels, Convergence of the generalized-alpha scheme
for constrained mechanical systems, Multibody Syst. Dyn. 18 (2007) 185-202.
"""

from mbdsl.compilation.buffer_layout import FP, MASS, MX, N_ALL, N_PHI, N_Q, Q0, V0, XA, Q, R, V, X
from mbdsl.compilation.buffer_layout import Q1 as CARRIED
from mbdsl.compilation.marks import kernel
from mbdsl.integrators.loop.linear_solve import factor
from mbdsl.integrators.loop.loop_state import NODES, H
from mbdsl.integrators.loop.split_correction import correct_one as correct
from mbdsl.integrators.loop.step_control import set_velocity
from mbdsl.integrators.method import Method, Option

__all__ = ["correct"]

RHO = Option(0.8, 0.0, 1.0, "spectral radius for high frequencies: 1 no damping, 0 most")

#: backward Euler in the same terms: q_{n+1} = q_n + h v_{n+1}, v_{n+1} = v_n + h a_{n+1}, A_{n+1} = a_{n+1}
EULER = (1.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0)
#: where in c the steps that are left of a stiff start stand; behind them, the coefficients for after it
LEFT = len(EULER)


def weights(rho):
    """What q and v have of a_{n+1}; q of A_n and a_n; v of A_n and a_n; A_{n+1} of a_{n+1}, a_n and A_n."""
    alpha_m, alpha_f = (2 * rho - 1) / (rho + 1), rho / (rho + 1)
    gamma = 1 / 2 + alpha_f - alpha_m
    beta = (gamma + 1 / 2) ** 2 / 4
    new, old, past = (x / (1 - alpha_m) for x in (1 - alpha_f, alpha_f, -alpha_m))
    of_q = (1 / 2 - beta + beta * past, beta * old)
    of_v = (1 - gamma + gamma * past, gamma * old)
    return beta * new, gamma * new, *of_q, *of_v, new, old, past


def coefficients(options):
    found = weights(options["rho"])
    return *found, 0.0, *found


def check_constrained(options):
    if options["rho"] > 1 - 1e-12:
        return (
            "rho = 1 does not damp the multipliers of a constrained model, whose oscillations grow until the results "
            "mean nothing; take rho < 1"
        )
    return None


def begin(c, start):
    if start.stiff:
        c[:LEFT], c[LEFT] = EULER, 2.0
        return {XA: [*(0.0 * start.a), *start.lam], CARRIED: 0.0 * start.a}
    D = 1 / 2 - c[1] / c[6]  # gamma is (weight of a_{n+1} in v) / (that in A)
    return {XA: [*start.a, *start.lam], CARRIED: start.a + D * start.h * start.jerk}


METHOD = Method(
    "generalized-alpha-i3",
    doc="generalised-alpha on the index-3 equations",
    order=2,
    index=3,
    enforces=("Phi",),
    family="Newmark",
    source="Arnold, Bruels (2007)",
    parameters={"rho": RHO},
    check_constrained=check_constrained,
    coefficients=coefficients,
    begin=begin,
    damping_weight=lambda c: c[1],
    steps=("fixed", "controlled"),
)


@kernel
def local_error(h, last, c, jerk, snap):
    """Errors of q and v in a step of length h behind one of length ``last``."""
    h3, beta, gamma = h * h * h, c[0] / c[6], c[1] / c[6]
    D = 1 / 2 - gamma
    k = (c[6] / 2 - 1 / 2 - D) / (c[6] + c[7])
    return (1 / 6 - beta - D / 2) * h3 * jerk, (1 / 6 - k - gamma * (1 / 2 + D)) * h3 * snap


@kernel
def velocity_error(h, last, c):
    """What v is wrong by along the constraints' normals, relative to the jerk."""
    return h * h * (1 / 6 - c[0] / c[6] - (1 / 2 - c[1] / c[6]) / 2)


@kernel
def shift(h, c, K, Y, I):
    """A_n for a step of length h in place of K[H]."""
    D = 1 / 2 - c[1] / c[6]
    for i in range(I[N_Q]):
        Y[CARRIED, i] += D * (h - K[H]) * (Y[XA, i] - Y[XA + 1, i]) / (K[NODES] - K[NODES + 1])


@kernel
def change_step(h, evaluate, tangent, inertia, c, K, J, Y, Z, C, F, I, A, P):
    """A_n, and v_n along the normals, for a step of length h in place of K[H]."""
    if h != K[H]:
        shift(h, c, K, Y, I)
        set_velocity(velocity_error(h, h, c), h, matrix, evaluate, tangent, inertia, c, K, J, Y, Z, C, F, I, A, P)


@kernel
def motion(h, c, Y, I):
    for i in range(I[N_Q]):
        a, a0, A0 = Y[X, i], Y[XA, i], Y[CARRIED, i]
        Y[Q, i] = Y[Q0, i] + h * Y[V0, i] + h * h * (c[0] * a + c[2] * A0 + c[3] * a0)
        Y[V, i] = Y[V0, i] + h * (c[1] * a + c[4] * A0 + c[5] * a0)


@kernel
def residual(h, c, Y, F, I):
    n, m = I[N_Q], I[N_PHI]
    for i in range(n):
        Y[R, i] = F[I[MASS] + i] * Y[X, i] + Y[MX, i] - Y[FP, i]
    for i in range(n, n + m):
        Y[R, i] = Y[FP, i] / (c[0] * h * h)
    for i in range(n + m, I[N_ALL]):
        Y[R, i] = Y[FP, i] / (c[1] * h)


@kernel
def matrix(tangent, t, h, c, Y, Z, C, F, I, A, P):
    """[[M + s h^2 K' + r h D, Phi_q^T], [Phi_q, 0]], K' = K + (M a)_q; s and r are what q and v have of a_{n+1}."""
    k, d = c[0] * h * h, c[1] * h
    tangent(t, 1.0, k, d, 1.0, 1.0, 0.0, 1.0, k / d, k, Y, Z, C, F, I, A[0])
    return factor(A[0], P[0], I)


@kernel
def finish(inertia, h, c, Y, F, I, A, P):
    """A_{n+1}; and one of the steps of a stiff start is done."""
    for i in range(I[N_Q]):
        Y[CARRIED, i] = c[6] * Y[X, i] + c[7] * Y[XA, i] + c[8] * Y[CARRIED, i]
    if c[LEFT] > 0.0:
        c[LEFT] -= 1.0
        if c[LEFT] == 0.0:
            for i in range(LEFT):
                c[i] = c[LEFT + 1 + i]
