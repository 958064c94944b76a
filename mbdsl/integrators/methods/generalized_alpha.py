"""Generalised-alpha, stabilised index 2; both constraint levels hold, order 2 in q, v, a and lam.

Unknowns a_{n+1} = q''(t_{n+1}), lam_{n+1}, and abar, mu, which are local to the step. A, its weights and its start
value are those of generalized-alpha-i3:

    (1 - alpha_m) A_{n+1} + alpha_m A_n = (1 - alpha_f) a_{n+1} + alpha_f a_n
    q_{n+1} = q_n + h v_n + h^2 [(1/2 - beta) A_n + beta A_{n+1}] + h^2/2 abar
    v_{n+1} = v_n + h [(1 - gamma) A_n + gamma A_{n+1}]
    R1:  M a_{n+1} - f_{n+1} = 0
    R2:  M abar + Phi_q^T mu = 0
    R3:  1/h^2 Phi(q_{n+1}, t_{n+1}) = 0
    R4:  1/h (Phi_q v + Phi_t)_{n+1} = 0

with M and Phi_q at q_{n+1}. The corrections are those of hht-si2, with the weights of a_{n+1} in q and v as beta and
gamma: a projection with the mass matrix, and the index-3 system. The term (M abar)_q of R2, like (Phi_q^T mu)_q, is
left to the next iteration, because abar vanishes with the discretisation error.

Local errors, and the shift of A_n for unequal steps, are those of generalized-alpha-i3; predictions of abar and mu are
proportional to the step size.

Source: Chung, Hulbert (1993); Arnold, Bruels, Cardona, Error analysis of generalized-alpha Lie group time integration
methods for constrained mechanical systems, Numer. Math. 129 (2015) 149-179, for the stabilised index-2 form. The
projection, with masses, is that of Negrut, Jay, Khude (2009), eq. (12).
"""

from mbdsl.integrators.loop import loop_state as S
from mbdsl.integrators.loop.coupled_correction import turns_far
from mbdsl.integrators.loop.linear_solve import clear, factor
from mbdsl.integrators.loop.split_correction import couple, couples, scale_history
from mbdsl.integrators.loop.tangent_matrices import projection_matrix, stiffness_matrix, velocity_matrix
from mbdsl.integrators.method import Method
from mbdsl.integrators.methods.generalized_alpha_i3 import (
    RHO,
    begin,
    check_constrained,
    coefficients,
    finish,
    local_error,
    memory,
    new_weights,
    shift,
)
from mbdsl.integrators.methods.generalized_alpha_i3 import motion as index_3_motion
from mbdsl.integrators.methods.hht_si2 import constraint_residuals, correct_with, factor_full
from mbdsl.kernels import buffer_layout as L
from mbdsl.kernels.marks import kernel

__all__ = ["finish", "local_error"]

METHOD = Method(
    "generalized-alpha",
    doc="generalised-alpha, stabilised: positions and velocities on their constraints",
    order=2,
    index=2,
    enforces=("Phi", "dPhi"),
    family="Newmark",
    source="Arnold, Bruels, Cardona (2015)",
    parameters={"rho": RHO},
    check_constrained=check_constrained,
    coefficients=coefficients,
    memory=memory,
    begin=begin,
    damping_weight=lambda c: c[1],
    steps=("fixed", "controlled"),
    sets=2,
    matrices=3,
    coupled=True,
)


@kernel
def motion(h, run):
    """POSITION and VELOCITY from the history, UNKNOWN and UNKNOWN2."""
    index_3_motion(h, run)
    q, abar = run.vectors[L.POSITION], run.vectors[L.UNKNOWN2]
    for i in range(run.layout[L.N_Q]):
        q[i] += h * h / 2 * abar[i]


@kernel
def change_step(h, run):
    """Convert A_n, and the history of abar and mu, to the step size h."""
    h0 = run.reals[S.STEP_SIZE]
    if h != h0:
        shift(h, run)
        scale_history(1, run.layout[L.N_ALL], h / h0, run)


@kernel
def residual(h, run):
    """RESIDUAL and RESIDUAL2 from UNKNOWN, UNKNOWN2, MX, MX2, FORCE and FORCE2."""
    n = run.layout[L.N_Q]
    y, mass = run.vectors, run.numbers[run.layout[L.MASS] :]
    r, r2, f, mu_force = y[L.RESIDUAL], y[L.RESIDUAL2], y[L.FORCE], y[L.FORCE2]
    a, abar, Ma, Mabar = y[L.UNKNOWN], y[L.UNKNOWN2], y[L.MX], y[L.MX2]
    for i in range(n):
        r[i] = mass[i] * a[i] + Ma[i] - f[i]  # R1
        r2[i] = mass[i] * abar[i] + Mabar[i] + mu_force[i]  # R2
    constraint_residuals(h, run)


@kernel
def matrix(t, h, run):
    """Matrices 0, 1 and 2 <- [[S, Phi_q^T], [Phi_q, 0]], [[2 M, Phi_q^T], [Phi_q, 0]], both factorised, and -h^2 K'.

    S = M + s h^2 K' + r h D and K' are those of generalized-alpha-i3.
    """
    of_q, of_v = new_weights(run)
    k, d = of_q * h * h, of_v * h
    velocity_matrix(0, t, run, M=1.0, K=k, D=d, Mx_q=k, q_v=k / d)
    if turns_far(run):
        return factor_full(t, h, of_q, of_v, run)
    projection_matrix(1, t, run, M=2.0)
    clear(2, run)
    if couples(1.0, run):
        stiffness_matrix(2, t, run, K=-h * h, Mx_q=-h * h, Gam_q=-h / of_v)
        couple(run)
    return factor(0, run) and factor(1, run)


@kernel
def correct(k, h, run):
    """``correct`` of hht-si2, with the weights of a_{n+1} in q and v as beta and gamma."""
    of_q, of_v = new_weights(run)
    return correct_with(of_q, of_v, k, h, run)
