"""HHT-SI2: Hilber-Hughes-Taylor, stabilised index 2; both constraint levels hold, order 2 in q, v, a and lam.

Unknowns a_{n+1}, lam_{n+1}, and abar, mu, which are local to the step; f = Q - Phi_q^T lam:

    q_{n+1} = q_n + h v_n + h^2/2 [(1 - 2 beta) a_n + 2 beta a_{n+1}] + h^2/2 abar
    v_{n+1} = v_n + h [(1 - gamma) a_n + gamma a_{n+1}]
    R1:  1/(1+alpha) Mhat a_{n+1} - f_{n+1} + alpha/(1+alpha) f_n = 0
    R2:  Mhat abar + Phi_q^T mu = 0
    R3:  1/h^2 Phi(q_{n+1}, t_{n+1}) = 0
    R4:  1/h (Phi_q v + Phi_t)_{n+1} = 0
    Mhat := M at the predictor q_n + (1+alpha) h v_n, once a step

with gamma = 1/2 - alpha and beta = (1 - alpha)^2/4; a_n ~ q''(t_n + alpha h). Nonholonomic constraints are rows of R1:
1/h Gam(v_{n+1}, q_{n+1}, t_{n+1}) = 0, and f contains -Gam_v^T nu. K = -f_q, D = -f_v and N = (Phi_q v)_q. M is split
into the constant part of its diagonal (``mass``) and the rest (``Ma`` and ``Mabar`` are the rest times a and abar).

The system has twice the size of HHT-I3's, and is split into two. With the increments da of a and e of abar/2, and
S = 1/(1+alpha) M + beta h^2 K + gamma h D, Newton's equations are

    R2:       2 M e + Phi_q^T dmu = -R2 + ...
    R3, R4:   Phi_q e = -R3 + beta/gamma R4 + ...
    R1:       S da + Phi_q^T dlam = -R1 - h^2 K e
    R4:       Phi_q da = -R4/gamma + ...

The first two are a projection with a mass matrix that does not change, and the last two are HHT-I3's system. The dots
stand for h N dq and h^2 (Phi_q^T mu)_q dq. These terms, corrections times a power of h, are left to the next iteration.
The converged solution is that of the full system.

In space, these terms are of the order of the angle that a body turns by within the step. If this angle is not small,
Newton's equations are solved as one system (:mod:`mbdsl.integrators.loop.coupled_correction`), with R3 as it is,

    R1:  S da + Phi_q^T dlam + h^2 K e = -R1
    R4:  (Phi_q + beta/gamma h N) da + h/gamma N e = -R4/gamma
    R2:  2 M e + Phi_q^T dmu + h^2 (Phi_q^T mu)_q (beta da + e) = -R2
    R3:  Phi_q (beta da + e) = -R3

Local errors, and the shift of a_n for unequal steps, are those of HHT-I3. abar and mu vanish with h; their predictions
are proportional to the step size.

Source: Negrut, Jay, Khude, J. Comput. Nonlinear Dyn. 4 (2009) 021008, eqs. (12)-(13), with corrected signs of R1, which
are misprinted there; the splitting is our own.
"""

from mbdsl.integrators.loop import loop_state as S
from mbdsl.integrators.loop.coupled_correction import block, copy_first, factor_coupled, solve_coupled, turns_far
from mbdsl.integrators.loop.linear_solve import clear, factor, larger
from mbdsl.integrators.loop.split_correction import couple, couples, scale_history, solve_two
from mbdsl.integrators.loop.tangent_matrices import (
    projection_matrix,
    stiffness_matrix,
    tangent_matrix,
    velocity_matrix,
)
from mbdsl.integrators.method import Method
from mbdsl.integrators.methods.hht_i3 import ALPHA, begin, coefficients, finish, hold_mass, local_error
from mbdsl.integrators.methods.newmark import memory, weights
from mbdsl.kernels import buffer_layout as L
from mbdsl.kernels.marks import kernel, rare

__all__ = ["finish", "local_error"]

METHOD = Method(
    "hht-si2",
    doc="Hilber-Hughes-Taylor, stabilised: positions and velocities on their constraints",
    order=2,
    index=2,
    enforces=("Phi", "dPhi"),
    family="Newmark",
    source="Negrut, Jay, Khude (2009), eqs. (12)-(13)",
    parameters={"alpha": ALPHA},
    coefficients=coefficients,
    memory=memory,
    begin=begin,
    sets=2,
    matrices=3,
    coupled=True,
    mass_row=L.MASS_POSITION,
    node=lambda c: 1 + c[2],
    mass_weight=lambda c: 1 / (1 + c[2]),
    damping_weight=lambda c: c[1],
    steps=("fixed", "controlled"),
    older=2,
)


@kernel
def motion(h, run):
    """POSITION, VELOCITY and MASS_POSITION from the history, UNKNOWN and UNKNOWN2."""
    beta, gamma, _alpha, past = weights(run)
    hold_mass(h, run)
    y = run.vectors
    q, v, q0, v0 = y[L.POSITION], y[L.VELOCITY], y[L.POSITION0], y[L.VELOCITY0]
    a0, a, abar = y[L.UNKNOWN0], y[L.UNKNOWN], y[L.UNKNOWN2]
    for i in range(run.layout[L.N_Q]):
        a_n = past * a0[i]
        q[i] = q0[i] + h * v0[i] + h * h / 2 * ((1 - 2 * beta) * a_n + 2 * beta * a[i] + abar[i])
        v[i] = v0[i] + h * ((1 - gamma) * a_n + gamma * a[i])


@kernel
def change_step(h, run):
    """Convert the history of abar and mu to the step size h."""
    h0 = run.reals[S.STEP_SIZE]
    if h != h0:
        scale_history(1, run.layout[L.N_ALL], h / h0, run)


@kernel
def residual(h, run):
    """RESIDUAL and RESIDUAL2 from UNKNOWN, UNKNOWN2, MX, MX2, FORCE, FORCE0 and FORCE2."""
    _beta, _gamma, alpha, _past = weights(run)
    n = run.layout[L.N_Q]
    y, mass = run.vectors, run.numbers[run.layout[L.MASS] :]
    r, r2, f, f0, mu_force = y[L.RESIDUAL], y[L.RESIDUAL2], y[L.FORCE], y[L.FORCE0], y[L.FORCE2]
    a, abar, Ma, Mabar = y[L.UNKNOWN], y[L.UNKNOWN2], y[L.MX], y[L.MX2]
    for i in range(n):
        r[i] = (mass[i] * a[i] + Ma[i]) / (1 + alpha) - f[i] + alpha / (1 + alpha) * f0[i]  # R1
        r2[i] = mass[i] * abar[i] + Mabar[i] + mu_force[i]  # R2
    constraint_residuals(h, run)


@kernel
def constraint_residuals(h, run):
    """The rows of constraints of RESIDUAL and RESIDUAL2: R3 = Phi/h^2 and R4 = dPhi/h, Gam/h and 0."""
    y, n, m = run.vectors, run.layout[L.N_Q], run.layout[L.N_PHI]
    r, r2, phi, dphi = y[L.RESIDUAL], y[L.RESIDUAL2], y[L.FORCE], y[L.FORCE2]
    for i in range(n, n + m):
        r[i], r2[i] = phi[i] / (h * h), dphi[i] / h
    for i in range(n + m, run.layout[L.N_ALL]):
        r[i], r2[i] = phi[i] / h, 0.0


@kernel
def matrix(t, h, run):
    """Matrices 0 and 1 <- [[S, Phi_q^T], [Phi_q, 0]] and [[2 M, Phi_q^T], [Phi_q, 0]], factorised;
    matrix 2 <- -h^2 K (and -h/gamma Gam_q), not factorised, or empty where it is negligible."""
    beta, gamma, alpha, _past = weights(run)
    mass = 1 / (1 + alpha)
    velocity_matrix(0, t, run, M=mass, K=beta * h * h, D=gamma * h, q_v=beta * h / gamma)
    if turns_far(run):
        return factor_full(t, h, beta, gamma, run)
    projection_matrix(1, t, run, M=2.0)
    clear(2, run)
    if couples(mass, run):
        stiffness_matrix(2, t, run, K=-h * h, Gam_q=-h / gamma)
        couple(run)
    return factor(0, run) and factor(1, run)


@rare
def factor_full(t, h, beta, gamma, run):
    """Set and factorise the matrix of the full system; its A00 is matrix 0, which has been set."""
    copy_first(run)
    tangent_matrix(block(0, 1, run), t, run, K=h * h, N=h / gamma, Gam_q=h / gamma, columns=0.0)
    tangent_matrix(block(1, 0, run), t, run, U=beta * h * h, Phi_q=beta, columns=0.0)
    tangent_matrix(block(1, 1, run), t, run, M=2.0, U=h * h, Phi_q=1.0)
    return factor_coupled(run)


@kernel
def correct(k, h, run):
    """Solve for the corrections and apply them to UNKNOWN and UNKNOWN2; return the largest scaled change of a position,
    h^2 times that of beta a + abar/2."""
    beta, gamma, _alpha, _past = weights(run)
    return correct_with(beta, gamma, k, h, run)


@kernel
def correct_with(beta, gamma, k, h, run):
    """``correct`` for dq_{n+1}/da_{n+1} = beta h^2 and dv_{n+1}/da_{n+1} = gamma h."""
    n, m, size = run.layout[L.N_Q], run.layout[L.N_PHI], run.layout[L.N_ALL]
    y, scale = run.vectors, run.vectors[L.SCALE]
    r, r2, da, e = y[L.RESIDUAL], y[L.RESIDUAL2], y[L.CORRECTION], y[L.CORRECTION2]
    a, abar = y[L.UNKNOWN], y[L.UNKNOWN2]
    for i in range(n):
        da[i], e[i] = -r[i], -r2[i]
    for i in range(n, n + m):
        da[i], e[i] = -r2[i] / gamma, -r[i]
    for i in range(n + m, size):
        da[i], e[i] = -r[i] / gamma, 0.0
    if run.integers[S.COUPLED]:
        solve_coupled(run)
    else:
        for i in range(n, n + m):
            e[i] += beta / gamma * r2[i]
        solve_two(k, run)
    change = 0.0
    for i in range(n):
        a[i] += da[i]
        abar[i] += 2 * e[i]
        change = larger((beta * abs(da[i]) + abs(e[i])) * scale[i], change)
    for i in range(n, size):
        a[i] += da[i]  # lam
        abar[i] += e[i]  # mu
    return h * h * change
