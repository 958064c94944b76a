"""HHT-I3: the Hilber-Hughes-Taylor method on the index-3 equations, order 2.

Unknowns a_{n+1}, lam_{n+1}; a_n ~ q''(t_n + alpha h); f = Q - Phi_q^T lam. Newmark's formulas (4a), (4b) with
gamma = 1/2 - alpha, beta = (1 - alpha)^2/4, and

    1/(1+alpha) M a_{n+1} - f_{n+1} + alpha/(1+alpha) f_n = 0                                             (8c)
    1/(beta h^2) Phi(q_{n+1}, t_{n+1}) = 0                                                                (8d)

Where M depends on q, it is that of the predictor q_n + (1+alpha) h v_n, once a step, as HHT-SI2 has it: a_{n+1} belongs
to t_{n+1} + alpha h. With M(q_{n+1}), as (8c) reads, the method is of first order, by alpha h dM/dt a.

Local errors: -h^3 (1/12 + alpha^2/4) q''' in q, h^3 (-1/12 + alpha/2 + alpha^2) v''' in v, where the alpha/2 and half
of alpha^2 are what (8c) gets wrong in a.

Steps that differ: a_n, found for t_n + alpha h_{n-1}, is shifted by alpha (h_n - h_{n-1}) times its rate. Along the
constraints' normals v_n has the error that makes q_{n+1} right, -h^2 (1/12 + alpha^2/4) q'''; as it is found with
h_{n-1}, it is changed, too, without which a, and reactions, would jump by O(h) with every change of the step.

Source: Negrut, Jay, Khude, A discussion of low order numerical integration formulas for rigid and flexible multibody
dynamics, J. Comput. Nonlinear Dyn. 4 (2009) 021008, eq. (8).
"""

from mbdsl.compilation.buffer_layout import (
    F0,
    FP,
    MASS,
    MASS_KIND,
    MX,
    N_ALL,
    N_PHI,
    N_Q,
    NEW_MASS,
    Q0,
    Q_MASS,
    TIMES,
    V0,
    XA,
    R,
    X,
)
from mbdsl.compilation.marks import kernel
from mbdsl.integrators.loop.linear_solve import factor
from mbdsl.integrators.loop.loop_state import H
from mbdsl.integrators.loop.split_correction import correct_one as correct
from mbdsl.integrators.loop.step_control import set_velocity
from mbdsl.integrators.method import Method, Option
from mbdsl.integrators.methods.newmark import carried, settle, start_stiff
from mbdsl.integrators.methods.newmark import motion as newmark_motion

__all__ = ["correct"]

ALPHA = Option(-0.1, -1 / 3, 0.0, "numerical damping of high frequencies: 0 none, -1/3 most")


def coefficients(options):
    alpha = options["alpha"]
    return carried((1 - alpha) ** 2 / 4, 1 / 2 - alpha, alpha)


def begin(c, start):
    """a_0 is the acceleration at t_0 + alpha h: started with q''(t_0), the reactions would ring for tens of steps."""
    if start.stiff:
        start_stiff(c)
        return {XA: [*(0.0 * start.a), *start.lam]}
    return {XA: [*(start.a + c[2] * start.h * start.jerk), *start.lam]}


METHOD = Method(
    "hht-i3",
    doc="Hilber-Hughes-Taylor on the index-3 equations",
    order=2,
    index=3,
    enforces=("Phi",),
    family="Newmark",
    source="Negrut, Jay, Khude (2009), eq. (8)",
    parameters={"alpha": ALPHA},
    coefficients=coefficients,
    begin=begin,
    mass_row=Q_MASS,
    node=lambda c: 1 + c[2],
    mass_weight=lambda c: 1 / (1 + c[2]),
    damping_weight=lambda c: c[1],
    steps=("fixed", "controlled"),
)


@kernel
def hold_mass(h, c, Y, I):
    """The coordinates that M is evaluated at, at the beginning of a step."""
    if I[NEW_MASS] and I[MASS_KIND] > 1:
        for i in range(I[N_Q]):
            Y[Q_MASS, i] = Y[Q0, i] + (1 + c[2]) * h * Y[V0, i]


@kernel
def motion(h, c, Y, I):
    hold_mass(h, c, Y, I)
    newmark_motion(h, c, Y, I)


@kernel
def local_error(h, last, c, jerk, snap):
    """Errors of q and v in a step of length h behind one of length ``last``."""
    alpha = c[2]
    h3 = h * h * h
    return -(1 / 12 + alpha * alpha / 4) * h3 * jerk, (-1 / 12 + alpha / 2 + alpha * alpha) * h3 * snap


@kernel
def velocity_error(h, last, c):
    """What v is wrong by along the constraints' normals, relative to the jerk."""
    return -(1 / 12 + c[2] * c[2] / 4) * h * h


@kernel
def change_step(h, evaluate, tangent, inertia, c, K, J, Y, Z, C, F, I, A, P):
    """v_n along the normals, for a step of length h in place of K[H]; a_n is shifted by the driver."""
    if h != K[H]:
        set_velocity(velocity_error(h, h, c), h, matrix, evaluate, tangent, inertia, c, K, J, Y, Z, C, F, I, A, P)


@kernel
def residual(h, c, Y, F, I):
    beta, gamma, alpha = c[0], c[1], c[2]
    n, m = I[N_Q], I[N_PHI]
    for i in range(n):
        Ma = F[I[MASS] + i] * Y[X, i] + Y[MX, i]
        Y[R, i] = Ma / (1 + alpha) - Y[FP, i] + alpha / (1 + alpha) * Y[F0, i]
    for i in range(n, n + m):
        Y[R, i] = Y[FP, i] / (beta * h * h)
    for i in range(n + m, I[N_ALL]):
        Y[R, i] = Y[FP, i] / (gamma * h)


@kernel
def matrix(tangent, t, h, c, Y, Z, C, F, I, A, P):
    """[[M/(1+alpha) + beta h^2 K + gamma h D, Phi_q^T], [Phi_q, 0]]."""
    beta, gamma, alpha = c[0], c[1], c[2]
    m, k, d = 1 / (1 + alpha), beta * h * h, gamma * h
    tangent(t, m, k, d, 1.0, 1.0, 0.0, 1.0, beta * h / gamma, 0.0, Y, Z, C, F, I, A[0])
    return factor(A[0], P[0], I)


@kernel
def finish(inertia, h, c, Y, F, I, A, P):
    """f at the accepted unknowns, from (8c), which saves an evaluation."""
    alpha = c[2]
    if I[MASS_KIND] > 0:
        inertia(TIMES, X, MX, Y, F, I)
    for i in range(I[N_Q]):
        Y[FP, i] = (F[I[MASS] + i] * Y[X, i] + Y[MX, i] + alpha * Y[F0, i]) / (1 + alpha)
    settle(c)
