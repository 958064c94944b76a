"""NSTIFF-SI2: the backward differentiation formula of order 2 on the stabilised index-2 equations.

Unknowns a = v'_{n+1}, lam_{n+1}, q'_{n+1}, and mu, which vanishes with the discretisation error (Gear, Gupta,
Leimkuhler); f = Q - Phi_q^T lam, s = 2/3 h. Newton's iteration solves for q' - v in place of q', because q' - v is as
small and smooth as mu:

    q_{n+1} = 4/3 q_n - 1/3 q_{n-1} + s q'_{n+1}
    v_{n+1} = 4/3 v_n - 1/3 v_{n-1} + s a_{n+1}
    R1:  M a_{n+1} - f_{n+1} = 0
    R2:  v_{n+1} - q'_{n+1} + Phi_q^T mu = 0
    R3:  1/s Phi(q_{n+1}, t_{n+1}) = 0
    R4:  1/s (Phi_q v + Phi_t)_{n+1} = 0

The system has twice the size of NSTIFF's, and is split into two. With u = dq'/s - da (the correction of positions in
addition to that by velocities), S = M + s^2 K + s D, and K including (M a)_q, Newton's equations are

    R2:           u - Phi_q^T dmu/s = R2/s + ...
    R4 - R3/s:    Phi_q u = R4 - R3/s + ...
    R1:           S da + Phi_q^T dlam = -R1 - s^2 K u
    R4:           Phi_q da = -R4 + ...

The dots stand for s N q and s^2 (Phi_q^T mu)_q. These terms, corrections times a power of h, are left to the next
iteration. The converged solution is that of the full system.

In space, these terms are of the order of the angle that a body turns by within the step. If this angle is not small,
Newton's equations are solved as one system (:mod:`mbdsl.integrators.loop.coupled_correction`), with chi = -dmu/s:

    R1:    S da + Phi_q^T dlam + s^2 K u = -R1
    R4:    (Phi_q + s N) da + s N u = -R4
    R2:    u + Phi_q^T chi - s (Phi_q^T mu)_q (da + u) = R2/s
    R3/s:  Phi_q (da + u) = -R3/s

Unequal steps and local errors: as for NSTIFF. q' - v and mu vanish with h^2; their predictions are proportional to h^2.

Source: Negrut, Jay, Khude, J. Comput. Nonlinear Dyn. 4 (2009) 021008, section on NSTIFF-SI2; the splitting is our own.
"""

from mbdsl.integrators.loop import loop_state
from mbdsl.integrators.loop.coupled_correction import block, copy_first, factor_coupled, solve_coupled, turns_far
from mbdsl.integrators.loop.linear_solve import clear, factor, larger
from mbdsl.integrators.loop.split_correction import couple, couples, scale_history, solve_two
from mbdsl.integrators.loop.tangent_matrices import stiffness_matrix, tangent_matrix, velocity_matrix
from mbdsl.integrators.method import Method
from mbdsl.integrators.methods.nstiff import POSITION1, VELOCITY1, P, S, begin, finish, local_error, memory, set_ratio
from mbdsl.kernels import buffer_layout as L
from mbdsl.kernels.marks import kernel

__all__ = ["begin", "finish", "local_error"]


METHOD = Method(
    "nstiff-si2",
    doc="BDF of order 2, stabilised: positions and velocities on their constraints",
    order=2,
    index=2,
    enforces=("Phi", "dPhi"),
    family="BDF2",
    source="Negrut, Jay, Khude (2009), NSTIFF-SI2",
    memory=memory,
    begin=begin,
    sets=2,
    matrices=3,
    coupled=True,
    steps=("fixed", "controlled"),
    past_positions=POSITION1,
    relative_step=0.5,
)


@kernel
def motion(h, run):
    """POSITION and VELOCITY from those of the last two steps, UNKNOWN and UNKNOWN2."""
    s, p = run.memory[S] * h, run.memory[P]
    y = run.vectors
    q, v, a, drift = y[L.POSITION], y[L.VELOCITY], y[L.UNKNOWN], y[L.UNKNOWN2]
    q0, v0, q1, v1 = y[L.POSITION0], y[L.VELOCITY0], y[POSITION1], y[VELOCITY1]
    for i in range(run.layout[L.N_Q]):
        ahead = v0[i] + p * (v0[i] - v1[i]) + s * a[i]
        q[i] = q0[i] + p * (q0[i] - q1[i]) + s * (ahead + drift[i])
        v[i] = ahead


@kernel
def change_step(h, run):
    """Set the weights for the step size h in ``memory``, and convert the history of q' - v and mu to it."""
    h0 = run.reals[loop_state.STEP_SIZE]
    set_ratio(h / run.reals[loop_state.LAST_H], run)
    if h != h0:
        scale_history(1, run.layout[L.N_ALL], (h / h0) ** 2, run)


@kernel
def residual(h, run):
    """RESIDUAL and RESIDUAL2 from UNKNOWN, UNKNOWN2, MX, FORCE and FORCE2."""
    s = run.memory[S] * h
    n, m, size = run.layout[L.N_Q], run.layout[L.N_PHI], run.layout[L.N_ALL]
    y, mass = run.vectors, run.numbers[run.layout[L.MASS] :]
    r, r2, f, mu_force = y[L.RESIDUAL], y[L.RESIDUAL2], y[L.FORCE], y[L.FORCE2]
    a, drift, Ma = y[L.UNKNOWN], y[L.UNKNOWN2], y[L.MX]
    phi, dphi = f, mu_force  # in the rows of constraints
    for i in range(n):
        r[i] = mass[i] * a[i] + Ma[i] - f[i]  # R1
        r2[i] = mu_force[i] - drift[i]  # R2
    for i in range(n, n + m):
        r[i] = phi[i] / s  # R3
        r2[i] = dphi[i] / s  # R4
    for i in range(n + m, size):
        r[i], r2[i] = phi[i] / s, 0.0


@kernel
def matrix(t, h, run):
    """Matrices 0, 1 and 2 <- [[S, Phi_q^T], [Phi_q, 0]], [[1, Phi_q^T], [Phi_q, 0]], both factorised, and -s^2 K."""
    s = run.memory[S] * h
    velocity_matrix(0, t, run, M=1.0, K=s * s, D=s, Mx_q=s * s, q_v=s)
    if turns_far(run):
        copy_first(run)
        tangent_matrix(block(0, 1, run), t, run, K=s * s, N=s, Gam_q=s, columns=0.0)
        tangent_matrix(block(1, 0, run), t, run, U=-s, Phi_q=1.0, columns=0.0)
        tangent_matrix(block(1, 1, run), t, run, I=1.0, U=-s, Phi_q=1.0)
        return factor_coupled(run)
    tangent_matrix(1, t, run, I=1.0, Phi_q=1.0)
    clear(2, run)
    if couples(1.0, run):
        stiffness_matrix(2, t, run, K=-s * s, Mx_q=-s * s, Gam_q=-s)
        couple(run)
    return factor(0, run) and factor(1, run)


@kernel
def correct(k, h, run):
    """Solve for the corrections and apply them to UNKNOWN and UNKNOWN2; return the largest scaled change of a position
    (or of h times a velocity)."""
    s = run.memory[S] * h
    n, m, size = run.layout[L.N_Q], run.layout[L.N_PHI], run.layout[L.N_ALL]
    y, scale = run.vectors, run.vectors[L.SCALE]
    r, r2, da, u, a, drift = (
        y[L.RESIDUAL],
        y[L.RESIDUAL2],
        y[L.CORRECTION],
        y[L.CORRECTION2],
        y[L.UNKNOWN],
        y[L.UNKNOWN2],
    )
    for i in range(n):
        da[i], u[i] = -r[i], r2[i] / s
    for i in range(n, n + m):
        da[i], u[i] = -r2[i], -r[i] / s
    for i in range(n + m, size):
        da[i], u[i] = -r[i], 0.0
    if run.integers[loop_state.COUPLED]:
        solve_coupled(run)
    else:
        for i in range(n, n + m):
            u[i] += r2[i]
        solve_two(k, run)
    change = 0.0
    for i in range(n):
        a[i] += da[i]
        drift[i] += s * u[i]
        change = larger((abs(da[i]) + abs(u[i])) * scale[i], change)
    for i in range(n, size):
        a[i] += da[i]  # lam
        drift[i] -= s * u[i]  # mu
    return s * s * change
