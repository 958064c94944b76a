"""NSTIFF: the backward differentiation formula of order 2 on the index-3 equations.

Unknowns a_{n+1}, lam_{n+1}; f = Q - Phi_q^T lam:

    q_{n+1} = 4/3 q_n - 1/3 q_{n-1} + h (8/9 v_n - 2/9 v_{n-1}) + 4/9 h^2 a_{n+1}
    v_{n+1} = 4/3 v_n - 1/3 v_{n-1} + 2/3 h a_{n+1}
    M a_{n+1} - f_{n+1} = 0
    9/(4 h^2) Phi(q_{n+1}, t_{n+1}) = 0

Unequal steps, with r = h_n/h_{n-1}, s = h_n (1 + r)/(1 + 2 r) and p = r^2/(1 + 2 r) (2/3 h and 1/3 for r = 1):

    v_{n+1} = (1 + p) v_n - p v_{n-1} + s a_{n+1}
    q_{n+1} = (1 + p) q_n - p q_{n-1} + s v_{n+1}

Local errors: -s h_n (h_n + h_{n-1})/6 times q''' in q, and times v''' in v (-2/9 h^3 for r = 1). Along the normals of
the constraints, v_n has the error -h_{n-1} (h_{n-1} + h_{n-2})/6 q''', for which q_n is exact. For unequal steps it is
converted to that of the next step; otherwise a and the reactions would jump by O(h).

The state one step before the start is computed by a Taylor expansion of the motion. If the start is stiff, a_0 belongs
to a transient, and the first step is a backward Euler step instead: v_{n+1} = v_n + h a_{n+1}, q_{n+1} = q_n +
h v_{n+1}. The method keeps order 2, because this is only one step.

Source: Negrut, Jay, Khude, J. Comput. Nonlinear Dyn. 4 (2009) 021008, section on NSTIFF; after Orlandea's stiff
integrator in ADAMS. The start is our own.
"""

from mbdsl.integrators.loop import loop_state
from mbdsl.integrators.loop.error_projection import set_velocity
from mbdsl.integrators.loop.linear_solve import factor
from mbdsl.integrators.loop.split_correction import correct_one, residual_one
from mbdsl.integrators.loop.tangent_matrices import iteration_matrix
from mbdsl.integrators.method import Method
from mbdsl.kernels import buffer_layout as L
from mbdsl.kernels.marks import kernel

POSITION1, VELOCITY1 = L.KEPT, L.KEPT2  #: rows with q and v one step before the start of the step
#: memory: (s/h)^2 and s/h, the weights of a in q and v; p; the error of v_n along the normals, relative to the jerk
S_SQUARED, S, P, ERROR = range(4)
BDF2 = (4 / 9, 2 / 3, 1 / 3)
EULER = (1.0, 1.0, 0.0)


def before(start):
    """q and v one step before the start, by Taylor expansion."""
    h, q, v, a, j = start.h, start.q, start.v, start.a, start.jerk
    return {POSITION1: q - h * v + h**2 / 2 * a - h**3 / 6 * j, VELOCITY1: v - h * a + h**2 / 2 * j}


def memory(c, start):
    return *(EULER if start.stiff else BDF2), -(start.h**2) / 3


def begin(c, start):
    return {L.UNKNOWN0: [*(0.0 * start.a if start.stiff else start.a), *start.lam], **before(start)}


METHOD = Method(
    "nstiff",
    doc="BDF of order 2 on the index-3 equations",
    order=2,
    index=3,
    enforces=("Phi",),
    family="BDF2",
    source="Negrut, Jay, Khude (2009), NSTIFF",
    memory=memory,
    begin=begin,
    steps=("fixed", "controlled"),
    past_positions=POSITION1,
    relative_step=0.5,
)


@kernel
def motion(h, run):
    """POSITION and VELOCITY from those of the last two steps and UNKNOWN."""
    s, p = run.memory[S] * h, run.memory[P]
    y = run.vectors
    q, v, a = y[L.POSITION], y[L.VELOCITY], y[L.UNKNOWN]
    q0, v0, q1, v1 = y[L.POSITION0], y[L.VELOCITY0], y[POSITION1], y[VELOCITY1]
    for i in range(run.layout[L.N_Q]):
        ahead = v0[i] + p * (v0[i] - v1[i])
        q[i] = q0[i] + p * (q0[i] - q1[i]) + s * (ahead + s * a[i])
        v[i] = ahead + s * a[i]


@kernel
def local_error(h, last, c, jerk, snap):
    """Local errors of q and v in a step of size h after one of size ``last``."""
    r = h / last
    k = -((1 + r) / (1 + 2 * r)) * h * h * (h + last) / 6
    return k * jerk, k * snap


@kernel
def velocity_error(h, last, c):
    """The error of v along the normals of the constraints, relative to the jerk."""
    return -h * (h + last) / 6


@kernel
def change_step(h, run):
    """Set the weights for the step size h in ``memory``, and convert v_n and v_{n-1} along the normals.

    Changes VELOCITY0 and VELOCITY1.
    """
    last, memory = run.reals[loop_state.LAST_H], run.memory
    set_ratio(h / last, run)
    error = velocity_error(h, last, run.coefficients)
    if error != memory[ERROR]:
        set_velocity(error, h, matrix, run)
        v1, change = run.vectors[VELOCITY1], run.vectors[L.E_Q]
        for i in range(run.layout[L.N_Q]):
            v1[i] += change[i]
    memory[ERROR] = error


@kernel
def set_ratio(r, run):
    """Set the weights in ``memory`` for a step r times as long as the last one."""
    s = (1 + r) / (1 + 2 * r)
    run.memory[S_SQUARED], run.memory[S], run.memory[P] = s * s, s, r * r / (1 + 2 * r)


@kernel
def residual(h, run):
    """RESIDUAL from UNKNOWN, MX and FORCE."""
    s = run.memory[S] * h
    residual_one(s * s, s, run)


@kernel
def matrix(t, h, run):
    """Matrix 0 <- [[M + s^2 (K + (M a)_q) + s D, Phi_q^T], [Phi_q, 0]], factorised; s = 2/3 h for equal steps."""
    s = run.memory[S] * h
    iteration_matrix(0, t, run, M=1.0, K=s * s, D=s, Mx_q=s * s, Gam_q=s)
    return factor(0, run)


@kernel
def correct(k, h, run):
    """Solve for the corrections and apply them to UNKNOWN; return the largest scaled change of a position."""
    return run.memory[S_SQUARED] * h * h * correct_one(run)


@kernel
def finish(h, run):
    """POSITION1 and VELOCITY1 <- the state at the start of the step; the next step is one of BDF2."""
    run.memory[S_SQUARED], run.memory[S], run.memory[P] = BDF2
    y = run.vectors
    q0, v0, q1, v1 = y[L.POSITION0], y[L.VELOCITY0], y[POSITION1], y[VELOCITY1]
    for i in range(run.layout[L.N_Q]):
        q1[i], v1[i] = q0[i], v0[i]
