"""Generalised-alpha on the index-3 equations, order 2.

Unknowns a_{n+1} = q''(t_{n+1}), lam_{n+1}. A is carried from step to step; A_n belongs to the time
t_n + (alpha_m - alpha_f) h. f = Q - Phi_q^T lam:

    (1 - alpha_m) A_{n+1} + alpha_m A_n = (1 - alpha_f) a_{n+1} + alpha_f a_n
    q_{n+1} = q_n + h v_n + h^2 [(1/2 - beta) A_n + beta A_{n+1}]
    v_{n+1} = v_n + h [(1 - gamma) A_n + gamma A_{n+1}]
    M(q_{n+1}) a_{n+1} - f_{n+1} = 0
    1/(s h^2) Phi(q_{n+1}, t_{n+1}) = 0,   s h^2 = dq_{n+1}/da_{n+1}

All parameters follow from rho, the spectral radius at infinite frequency:

    alpha_m = (2 rho - 1)/(rho + 1),  alpha_f = rho/(rho + 1),  gamma = 1/2 + alpha_f - alpha_m,
    beta = (gamma + 1/2)^2/4

The equations of motion hold at t_{n+1}; therefore the method has order 2 for any M(q). The start value is
A_0 = a_0 + (alpha_m - alpha_f) h q'''; with A_0 = a_0 the first reactions would have order 1.

Local errors, with D = alpha_m - alpha_f, k = (1 - alpha_f)/2 - (1 - alpha_m) (1/2 + D) and
A_n = q''(t_n) + D h q''' + k h^2 q'''': h^3 (1/6 - beta - D/2) q''' in q, h^3 (1/6 - k - gamma (1/2 + D)) v''' in v.

Unequal steps: A_n is shifted by D (h_n - h_{n-1}) q''', and v_n along the normals of the constraints is converted as in
HHT-I3.

Source: Chung, Hulbert, A time integration algorithm for structural dynamics with improved numerical dissipation: the
generalized-alpha method, J. Appl. Mech. 60 (1993) 371-375; Arnold, Bruels, Convergence of the generalized-alpha scheme
for constrained mechanical systems, Multibody Syst. Dyn. 18 (2007) 185-202.
"""

from mbdsl.integrators.loop import loop_state as S
from mbdsl.integrators.loop.error_projection import set_velocity
from mbdsl.integrators.loop.linear_solve import factor
from mbdsl.integrators.loop.split_correction import correct_one, residual_one
from mbdsl.integrators.loop.tangent_matrices import iteration_matrix
from mbdsl.integrators.method import Method, Option
from mbdsl.integrators.methods.newmark import memory, settle
from mbdsl.kernels import buffer_layout as L
from mbdsl.kernels.marks import kernel

CARRIED = L.KEPT  #: row with A_n
RHO = Option(0.8, 0.0, 1.0, "spectral radius for high frequencies: 1 no damping, 0 most")


def coefficients(options):
    """Weights of a_{n+1} in q and in v; of A_n, a_n in q; of A_n, a_n in v; of a_{n+1}, a_n, A_n in A_{n+1}."""
    rho = options["rho"]
    alpha_m, alpha_f = (2 * rho - 1) / (rho + 1), rho / (rho + 1)
    gamma = 1 / 2 + alpha_f - alpha_m
    beta = (gamma + 1 / 2) ** 2 / 4
    new, old, past = (x / (1 - alpha_m) for x in (1 - alpha_f, alpha_f, -alpha_m))
    of_q = (1 / 2 - beta + beta * past, beta * old)
    of_v = (1 - gamma + gamma * past, gamma * old)
    return beta * new, gamma * new, *of_q, *of_v, new, old, past


def check_constrained(options):
    if options["rho"] > 1 - 1e-12:
        return (
            "rho = 1 does not damp the multipliers of a constrained model, whose oscillations grow until the results "
            "mean nothing; take rho < 1"
        )
    return None


def begin(c, start):
    if start.stiff:
        return {L.UNKNOWN0: [*(0.0 * start.a), *start.lam], CARRIED: 0.0 * start.a}
    D = 1 / 2 - c[1] / c[6]  # gamma = (weight of a_{n+1} in v) / (weight of a_{n+1} in A_{n+1})
    return {L.UNKNOWN0: [*start.a, *start.lam], CARRIED: start.a + D * start.h * start.jerk}


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
    memory=memory,
    begin=begin,
    damping_weight=lambda c: c[1],
    steps=("fixed", "controlled"),
)


@kernel
def weights(run):
    """The coefficients of this step; in the first steps of a stiff start those of the backward Euler method,
    q_{n+1} = q_n + h v_{n+1}, v_{n+1} = v_n + h a_{n+1}, A_{n+1} = a_{n+1}."""
    if run.memory[0] > 0.0:
        return 1.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0
    c = run.coefficients
    return c[0], c[1], c[2], c[3], c[4], c[5], c[6], c[7], c[8]


@kernel
def new_weights(run):
    """Weights of a_{n+1} in q and in v in this step."""
    of_q, of_v, _qA, _qa, _vA, _va, _new, _old, _past = weights(run)
    return of_q, of_v


@kernel
def local_error(h, last, c, jerk, snap):
    """Local errors of q and v in a step of size h after one of size ``last``."""
    h3, beta, gamma = h * h * h, c[0] / c[6], c[1] / c[6]
    D = 1 / 2 - gamma
    k = (c[6] / 2 - 1 / 2 - D) / (c[6] + c[7])
    return (1 / 6 - beta - D / 2) * h3 * jerk, (1 / 6 - k - gamma * (1 / 2 + D)) * h3 * snap


@kernel
def velocity_error(h, last, c):
    """The error of v along the normals of the constraints, relative to the jerk."""
    return h * h * (1 / 6 - c[0] / c[6] - (1 / 2 - c[1] / c[6]) / 2)


@kernel
def shift(h, run):
    """Shift A_n (row CARRIED) to the step size h."""
    c, reals = run.coefficients, run.reals
    D = 1 / 2 - c[1] / c[6]
    A, a0, a1 = run.vectors[CARRIED], run.vectors[L.UNKNOWN0], run.vectors[L.UNKNOWN0 + 1]
    for i in range(run.layout[L.N_Q]):
        A[i] += D * (h - reals[S.STEP_SIZE]) * (a0[i] - a1[i]) / (reals[S.NODES] - reals[S.NODES + 1])


@kernel
def change_step(h, run):
    """Convert A_n, and v_n along the normals, to the step size h. Changes CARRIED and VELOCITY0."""
    if h != run.reals[S.STEP_SIZE]:
        shift(h, run)
        set_velocity(velocity_error(h, h, run.coefficients), h, matrix, run)


@kernel
def motion(h, run):
    """POSITION and VELOCITY from POSITION0, VELOCITY0, UNKNOWN0, CARRIED and UNKNOWN."""
    of_q, of_v, qA, qa, vA, va, _new, _old, _past = weights(run)
    y = run.vectors
    q, v, q0, v0 = y[L.POSITION], y[L.VELOCITY], y[L.POSITION0], y[L.VELOCITY0]
    a, a0, A = y[L.UNKNOWN], y[L.UNKNOWN0], y[CARRIED]
    for i in range(run.layout[L.N_Q]):
        q[i] = q0[i] + h * v0[i] + h * h * (of_q * a[i] + qA * A[i] + qa * a0[i])
        v[i] = v0[i] + h * (of_v * a[i] + vA * A[i] + va * a0[i])


@kernel
def residual(h, run):
    """RESIDUAL from UNKNOWN, MX and FORCE."""
    of_q, of_v = new_weights(run)
    residual_one(of_q * h * h, of_v * h, run)


@kernel
def matrix(t, h, run):
    """Matrix 0 <- [[M + s h^2 K' + r h D, Phi_q^T], [Phi_q, 0]], factorised; K' = K + (M a)_q, and s and r are the
    weights of a_{n+1} in q and v."""
    of_q, of_v = new_weights(run)
    k, d = of_q * h * h, of_v * h
    iteration_matrix(0, t, run, M=1.0, K=k, D=d, Mx_q=k, Gam_q=k / d)
    return factor(0, run)


@kernel
def correct(k, h, run):
    """Solve for the corrections and apply them to UNKNOWN; return the largest scaled change of a position."""
    of_q, _of_v = new_weights(run)
    return of_q * h * h * correct_one(run)


@kernel
def finish(h, run):
    """CARRIED <- A_{n+1}; count the steps of a stiff start."""
    _of_q, _of_v, _qA, _qa, _vA, _va, new, old, past = weights(run)
    A, a, a0 = run.vectors[CARRIED], run.vectors[L.UNKNOWN], run.vectors[L.UNKNOWN0]
    for i in range(run.layout[L.N_Q]):
        A[i] = new * a[i] + old * a0[i] + past * A[i]
    settle(run)
