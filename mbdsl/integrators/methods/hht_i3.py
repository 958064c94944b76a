"""HHT-I3: the Hilber-Hughes-Taylor method on the index-3 equations, order 2.

Unknowns a_{n+1}, lam_{n+1}; a_n ~ q''(t_n + alpha h); f = Q - Phi_q^T lam. Newmark's formulas (4a), (4b) with
gamma = 1/2 - alpha, beta = (1 - alpha)^2/4, and

    1/(1+alpha) M a_{n+1} - f_{n+1} + alpha/(1+alpha) f_n = 0                                             (8c)
    1/(beta h^2) Phi(q_{n+1}, t_{n+1}) = 0                                                                (8d)

If M depends on q, it is evaluated once a step, at the predictor q_n + (1+alpha) h v_n, as in HHT-SI2, because a_{n+1}
belongs to t_{n+1} + alpha h. With M(q_{n+1}), as in (8c), the method has order 1, with the error alpha h dM/dt a.

Local errors: -h^3 (1/12 + alpha^2/4) q''' in q, h^3 (-1/12 + alpha/2 + alpha^2) v''' in v. The term alpha/2 and half of
alpha^2 are due to the error of a from (8c).

Unequal steps: a_n, which belongs to t_n + alpha h_{n-1}, is shifted by alpha (h_n - h_{n-1}) times its rate. Along the
normals of the constraints, v_n has the error -h^2 (1/12 + alpha^2/4) q''', for which q_{n+1} is exact. This error
belongs to h_{n-1} and is converted to h_n; otherwise a and the reactions would jump by O(h) at each change of the step
size.

Source: Negrut, Jay, Khude, A discussion of low order numerical integration formulas for rigid and flexible multibody
dynamics, J. Comput. Nonlinear Dyn. 4 (2009) 021008, eq. (8).
"""

from mbdsl.integrators.loop import loop_state as S
from mbdsl.integrators.loop.error_projection import set_velocity
from mbdsl.integrators.loop.linear_solve import factor
from mbdsl.integrators.loop.run_data import inertia
from mbdsl.integrators.loop.tangent_matrices import iteration_matrix
from mbdsl.integrators.method import Method, Option
from mbdsl.integrators.methods.newmark import correct, memory, settle, weights
from mbdsl.integrators.methods.newmark import motion as newmark_motion
from mbdsl.kernels import buffer_layout as L
from mbdsl.kernels.marks import kernel

__all__ = ["correct"]

ALPHA = Option(-0.1, -1 / 3, 0.0, "numerical damping of high frequencies: 0 none, -1/3 most")


def coefficients(options):
    """beta, gamma and alpha."""
    alpha = options["alpha"]
    return (1 - alpha) ** 2 / 4, 1 / 2 - alpha, alpha


def begin(c, start):
    """Start values; a_0 belongs to t_0 + alpha h. With q''(t_0), reactions would oscillate for tens of steps."""
    if start.stiff:
        return {L.UNKNOWN0: [*(0.0 * start.a), *start.lam]}
    return {L.UNKNOWN0: [*(start.a + c[2] * start.h * start.jerk), *start.lam]}


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
    memory=memory,
    begin=begin,
    mass_row=L.MASS_POSITION,
    node=lambda c: 1 + c[2],
    mass_weight=lambda c: 1 / (1 + c[2]),
    damping_weight=lambda c: c[1],
    steps=("fixed", "controlled"),
)


@kernel
def hold_mass(h, run):
    """MASS_POSITION <- the predictor, at the beginning of a step (NEW_MASS), if M depends on q."""
    _beta, _gamma, alpha, _past = weights(run)
    if run.layout[L.NEW_MASS] and run.layout[L.MASS_KIND] > 1:
        held, q0, v0 = run.vectors[L.MASS_POSITION], run.vectors[L.POSITION0], run.vectors[L.VELOCITY0]
        for i in range(run.layout[L.N_Q]):
            held[i] = q0[i] + (1 + alpha) * h * v0[i]


@kernel
def motion(h, run):
    """POSITION and VELOCITY as in NEWMARK, and MASS_POSITION."""
    hold_mass(h, run)
    newmark_motion(h, run)


@kernel
def local_error(h, last, c, jerk, snap):
    """Local errors of q and v in a step of size h after one of size ``last``."""
    alpha = c[2]
    h3 = h * h * h
    return -(1 / 12 + alpha * alpha / 4) * h3 * jerk, (-1 / 12 + alpha / 2 + alpha * alpha) * h3 * snap


@kernel
def velocity_error(h, last, c):
    """The error of v along the normals of the constraints, relative to the jerk."""
    return -(1 / 12 + c[2] * c[2] / 4) * h * h


@kernel
def change_step(h, run):
    """Convert v_n along the normals to the step size h. Changes VELOCITY0; ``change`` shifts a_n."""
    if h != run.reals[S.STEP_SIZE]:
        set_velocity(velocity_error(h, h, run.coefficients), h, matrix, run)


@kernel
def residual(h, run):
    """RESIDUAL from UNKNOWN, MX, FORCE and FORCE0."""
    beta, gamma, alpha, _past = weights(run)
    n, m, size = run.layout[L.N_Q], run.layout[L.N_PHI], run.layout[L.N_ALL]
    y, mass = run.vectors, run.numbers[run.layout[L.MASS] :]
    r, f, f0, a, Ma = y[L.RESIDUAL], y[L.FORCE], y[L.FORCE0], y[L.UNKNOWN], y[L.MX]
    for i in range(n):
        r[i] = (mass[i] * a[i] + Ma[i]) / (1 + alpha) - f[i] + alpha / (1 + alpha) * f0[i]  # (8c)
    for i in range(n, n + m):
        r[i] = f[i] / (beta * h * h)  # (8d)
    for i in range(n + m, size):
        r[i] = f[i] / (gamma * h)


@kernel
def matrix(t, h, run):
    """Matrix 0 <- [[M/(1+alpha) + beta h^2 K + gamma h D, Phi_q^T], [Phi_q, 0]], factorised."""
    beta, gamma, alpha, _past = weights(run)
    iteration_matrix(0, t, run, M=1 / (1 + alpha), K=beta * h * h, D=gamma * h, Gam_q=beta * h / gamma)
    return factor(0, run)


@kernel
def finish(h, run):
    """FORCE <- f at the accepted unknowns, computed from (8c) to save an evaluation. Writes MX."""
    _beta, _gamma, alpha, _past = weights(run)
    if run.layout[L.MASS_KIND] > 0:
        inertia(L.TIMES, L.UNKNOWN, L.MX, run)
    y, mass = run.vectors, run.numbers[run.layout[L.MASS] :]
    f, f0, a, Ma = y[L.FORCE], y[L.FORCE0], y[L.UNKNOWN], y[L.MX]
    for i in range(run.layout[L.N_Q]):
        f[i] = (mass[i] * a[i] + Ma[i] + alpha * f0[i]) / (1 + alpha)
    settle(run)
