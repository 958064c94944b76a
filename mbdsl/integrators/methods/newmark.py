"""NEWMARK: Newmark's method on the index-3 equations, order 1.

Unknowns a_{n+1}, lam_{n+1}; f = Q - Phi_q^T lam:

    q_{n+1} = q_n + h v_n + h^2/2 [(1 - 2 beta) a_n + 2 beta a_{n+1}]                                    (4a)
    v_{n+1} = v_n + h [(1 - gamma) a_n + gamma a_{n+1}]                                                   (4b)
    M a_{n+1} - f_{n+1} = 0
    1/(beta h^2) Phi(q_{n+1}, t_{n+1}) = 0
    1/(gamma h) Gam(v_{n+1}, q_{n+1}, t_{n+1}) = 0     of nonholonomic constraints, with -Gam_v^T nu in f

K = -f_q and D = -f_v. M is split into the constant part of its diagonal (``mass``) and the rest (``Ma`` is the rest
times a).

Local errors: h^3 (1/6 - beta) q''' in q, h^2 (1/2 - gamma) v'' in v.

gamma > 1/2 damps high frequencies. The trapezoidal rule, gamma = 1/2 with beta = 1/4, has order 2, but does not damp
oscillations of the multipliers at all.

If the start is stiff, a_0 belongs to a transient and not to the motion after it. The first two steps are then backward
Euler steps (beta = gamma = 1 without a_n): the first passes the transient, the second determines a after it.

Source: Negrut, Jay, Khude, A discussion of low order numerical integration formulas for rigid and flexible multibody
dynamics, J. Comput. Nonlinear Dyn. 4 (2009) 021008, eqs. (4)-(6).
"""

from mbdsl.integrators.loop import loop_state as S
from mbdsl.integrators.loop.error_projection import set_velocity
from mbdsl.integrators.loop.linear_solve import factor
from mbdsl.integrators.loop.split_correction import correct_one, residual_one
from mbdsl.integrators.loop.tangent_matrices import iteration_matrix
from mbdsl.integrators.method import Method, Option
from mbdsl.kernels import buffer_layout as L
from mbdsl.kernels.marks import kernel


def beta_of(options):
    """The given beta; by default the smallest for which the method is stable."""
    gamma, beta = options["gamma"], options["beta"]
    return (gamma + 1 / 2) ** 2 / 4 if beta is None else beta


def coefficients(options):
    """beta, gamma and alpha; methods that share these kernels have an alpha other than 0."""
    return beta_of(options), options["gamma"], 0.0


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


def memory(c, start):
    """The number of remaining backward Euler steps of a stiff start."""
    return (2.0 if start.stiff else 0.0,)


def begin(c, start):
    return {L.UNKNOWN0: [*(0.0 * start.a if start.stiff else start.a), *start.lam]}


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
    memory=memory,
    begin=begin,
    damping_weight=lambda c: c[1],
    steps=("fixed", "controlled"),
    relative_step=0.5,
)


@kernel
def weights(run):
    """beta, gamma, alpha, and the factor on a_n in this step."""
    if run.memory[0] > 0.0:
        return 1.0, 1.0, 0.0, 0.0  # backward Euler
    c = run.coefficients
    return c[0], c[1], c[2], 1.0


@kernel
def motion(h, run):
    """POSITION and VELOCITY from POSITION0, VELOCITY0, UNKNOWN0 and UNKNOWN."""
    beta, gamma, _alpha, past = weights(run)
    y = run.vectors
    q, v, q0, v0, a, a0 = y[L.POSITION], y[L.VELOCITY], y[L.POSITION0], y[L.VELOCITY0], y[L.UNKNOWN], y[L.UNKNOWN0]
    for i in range(run.layout[L.N_Q]):
        a_n = past * a0[i]
        q[i] = q0[i] + h * v0[i] + h * h / 2 * ((1 - 2 * beta) * a_n + 2 * beta * a[i])  # (4a)
        v[i] = v0[i] + h * ((1 - gamma) * a_n + gamma * a[i])  # (4b)


@kernel
def local_error(h, last, c, jerk, snap):
    """Local errors of q and v in a step of size h after one of size ``last``."""
    beta, gamma = c[0], c[1]
    return h * h * h * (1 / 6 - beta) * jerk, h * h * (1 / 2 - gamma) * jerk


@kernel
def velocity_error(h, last, c):
    """The error of v along the normals of the constraints, relative to the jerk."""
    return h * h * (1 / 6 - c[0] - (1 / 2 - c[1]) / 2)


@kernel
def change_step(h, run):
    """Convert v_n along the normals to the step size h. Changes VELOCITY0."""
    if h != run.reals[S.STEP_SIZE]:
        set_velocity(velocity_error(h, h, run.coefficients), h, matrix, run)


@kernel
def residual(h, run):
    """RESIDUAL from UNKNOWN, MX and FORCE."""
    beta, gamma, _alpha, _past = weights(run)
    residual_one(beta * h * h, gamma * h, run)


@kernel
def matrix(t, h, run):
    """Matrix 0 <- [[M + beta h^2 K' + gamma h D, Phi_q^T], [Phi_q, 0]] with K' = K + (M a)_q, factorised."""
    beta, gamma, _alpha, _past = weights(run)
    k = beta * h * h
    iteration_matrix(0, t, run, M=1.0, K=k, D=gamma * h, Mx_q=k, Gam_q=beta * h / gamma)
    return factor(0, run)


@kernel
def correct(k, h, run):
    """Solve for the corrections and apply them to UNKNOWN; return the largest scaled change of a position."""
    beta, _gamma, _alpha, _past = weights(run)
    return beta * h * h * correct_one(run)


@kernel
def finish(h, run):
    """The history consists of q, v and a only; count the steps of a stiff start."""
    settle(run)


@kernel
def settle(run):
    """Count down the remaining steps of a stiff start in ``memory``."""
    run.memory[0] = max(0.0, run.memory[0] - 1.0)
