"""HHT-ADD: Hilber-Hughes-Taylor with reactions added for both constraint levels, order 2 in q and v.

Unknowns a_{n+1}, psi_I, psi_II; fa = M^{-1} Q are the accelerations by applied forces alone; b != 1/2 is a parameter:

    q_{n+1} = q_n + h v_n + h^2/2 [(1-2 beta) a_n + 2 beta a_{n+1}] + h^2/2 [(1-b) R_I + b R_II]
    v_{n+1} = v_n + h [(1-gamma) a_n + gamma a_{n+1}] + h/2 (R_I + R_II)
    Phi(q_{n+1}, t_{n+1}) = 0,   (Phi_q v + Phi_t)_{n+1} = 0
    a_{n+1} = (1+alpha) fa_{n+1} - alpha fa_n
    M R_I = -Phi_q^T(q_n, t_n) psi_I,   M R_II = -Phi_q^T(q_{n+1}, t_{n+1}) psi_II

Newton's iteration solves for P and W with q_{n+1} = q_n + h v_n + h^2 P and v_{n+1} = v_n + h W, so that M need not be
inverted. With GP = M M_n^{-1} Phi_q^T(q_n) psi_I, GD = Phi_q^T psi_II, M = M(q_{n+1}) and M_n = M(q_n),

    R1:  M [P - (1/2 - beta) a_n + beta alpha fa_n] - beta (1+alpha) Q_{n+1} + 1/2 [(1-b) GP + b GD] = 0
    R2:  M [W - (1 - gamma) a_n + gamma alpha fa_n] - gamma (1+alpha) Q_{n+1} + 1/2 (GP + GD) = 0
    R3:  1/h^2 Phi = 0,   R4:  1/h (Phi_q v + Phi_t) = 0

If M depends on q, M_n^{-1} is applied body by body, with the factors of the constant part of M (see
:mod:`mbdsl.bodies`). M is inverted only there and in fa_{n+1} = M^{-1} Q_{n+1} at the end of a step.

With the increments p of P, w of W and u = gamma p - beta w, and with Phi_q(q_n) replaced by Phi_q(q_{n+1}), Newton's
equations are split into two systems, as those of HHT-SI2:

    gamma R1 - beta R2:  M u + Phi_q^T chi = -gamma R1 + beta R2,            Phi_q u = -gamma R3 + beta R4 + ...
    R2:                  S w + Phi_q^T eta = -R2 - (1+alpha) h^2 K u,        Phi_q w = -R4 + ...
    S = M + (1+alpha) (beta h^2 K + gamma h D) + beta/(2 gamma) h^2 (Phi_q^T psi_II)_q + beta/gamma h^2 (M [.]_R2)_q,
    K and D of applied forces alone

In space, Phi_q(q_n) and the terms left out differ by the angle that a body turns by within the step. If this angle is
not small, Newton's equations are solved as one system (:mod:`mbdsl.integrators.loop.coupled_correction`), of R2 and R4
for w and eta = (psi_I + psi_II)/2, and of gamma R1 - beta R2 and R3 for u and chi.

The converged solution is that of the full system. psi_II has order 1 only. Therefore reactions are computed from the
acceleration-level equations, and force laws read lam_{n+1}, extrapolated from the means (psi_I + psi_II)/2 of this step
and the one before, which are those of the reactions over the steps to order 2:

    lam_{n+1} = mean + h/(h + h_{n-1}) (mean - mean_{n-1});   in the first step h_{n-1} = 0, mean_{n-1} = lam_0

Local errors are those of HHT-I3. For unequal steps, a_n, which belongs to t_n + alpha h_{n-1}, is converted to
t_n + alpha h_n by fa_n + h_n/h_{n-1} (a_n - fa_n).

Source: Negrut, Jay, Khude, J. Comput. Nonlinear Dyn. 4 (2009) 021008, section on HHT-ADD, with a corrected velocity
formula (it is misprinted there); Jay, Negrut, Extensions of the HHT-alpha method to differential-algebraic equations in
mechanics, ETNA 26 (2007) 190-208. The splitting is our own.
"""

from mbdsl.integrators.loop import loop_state as S
from mbdsl.integrators.loop.coupled_correction import block, factor_coupled, solve_coupled, turns_far
from mbdsl.integrators.loop.linear_solve import clear, compress, factor, larger, multiply
from mbdsl.integrators.loop.run_data import inertia
from mbdsl.integrators.loop.split_correction import couple, couples, solve_two, stiff
from mbdsl.integrators.loop.tangent_matrices import (
    projection_matrix,
    stiffness_matrix,
    tangent_matrix,
    velocity_matrix,
)
from mbdsl.integrators.method import Method, Option
from mbdsl.integrators.methods import hht_i3
from mbdsl.integrators.methods.hht_i3 import local_error
from mbdsl.integrators.methods.hht_si2 import constraint_residuals
from mbdsl.integrators.methods.newmark import memory, settle, weights
from mbdsl.kernels import buffer_layout as L
from mbdsl.kernels.marks import kernel, rare

__all__ = ["local_error"]

#: rows with a_n and fa_n, and in the places of constraints with the last mean and lam_n
A0, FA = L.KEPT, L.KEPT2
LAW = L.MULTIPLIED  #: row with the multipliers that force laws read, in the places of constraints
#: part of a diagonal entry of S above which forces count as stiff
STIFF = 0.5


def coefficients(options):
    """The coefficients of HHT-I3, and b."""
    return *hht_i3.coefficients(options), options["b"]


def check(options):
    if abs(options["b"] - 1 / 2) < 1e-3:
        return "b = 1/2 gives the same condition for psi_I and psi_II at both constraint levels, and determines neither"
    return None


def begin(c, start):
    a0 = start.fa + c[2] * start.h * start.fa_rate
    total = a0 + start.a - start.fa
    if start.stiff:
        total = 0.0 * total
    rows = {L.UNKNOWN0: [*(total / 2), *start.lam], L.UNKNOWN0 + L.PAST: [*total, *start.lam]}
    return {A0: [*a0, *start.lam], FA: [*start.fa, *start.lam], **rows}


def remembered(c, start):
    """The number of remaining steps of a stiff start, and the length of the last step."""
    return *memory(c, start), 0.0


METHOD = Method(
    "hht-add",
    doc="Hilber-Hughes-Taylor with added reactions: positions and velocities on their constraints",
    order=2,
    index=2,
    enforces=("Phi", "dPhi"),
    family="Newmark",
    source="Negrut, Jay, Khude (2009), HHT-ADD; Jay, Negrut (2007)",
    parameters={"alpha": hht_i3.ALPHA, "b": Option(0.0, -10.0, 10.0, "weight of R_II in the positions, not 1/2")},
    check=check,
    coefficients=coefficients,
    memory=remembered,
    begin=begin,
    sets=3,
    matrices=4,
    coupled=True,
    multipliers=(L.LAM, L.UNKNOWN2, LAW),
    own_reactions=False,
    inverts_mass=True,
    inertia_rows=(L.MULTIPLIED, L.MULTIPLIED2),
    tangent_row=L.MULTIPLIED2,
    acceleration_row=L.UNKNOWN2,
    node=lambda c: 0.5,
    damping_weight=lambda c: c[1] * (1 + c[2]),
    steps=("fixed", "controlled"),
    diverges="hht-add does not pass all singular poses: its iteration diverges if a singular value of Phi_q falls "
    "by more than half within a step; hht-si2 or hht-i3 may pass",
)


@kernel
def share(gamma, alpha):
    """The factor on psi_II in the multipliers of f; with it, K of f includes the term (Phi_q^T psi_II)_q of S."""
    return 1 / (2 * gamma * (1 + alpha))


@kernel
def ahead(h, run):
    """The way from the middle of the step to its end, relative to that from the middle of the step before."""
    return h / (h + run.memory[1])


@kernel
def motion(h, run):
    """POSITION, VELOCITY, LAM, MULTIPLIED and MULTIPLIED2 from the history, UNKNOWN (P) and UNKNOWN2 (W)."""
    beta, gamma, alpha, past = weights(run)
    n, m, size = run.layout[L.N_Q], run.layout[L.N_PHI], run.layout[L.N_ALL]
    y = run.vectors
    q, v, q0, v0, P, W, lam = (
        y[L.POSITION],
        y[L.VELOCITY],
        y[L.POSITION0],
        y[L.VELOCITY0],
        y[L.UNKNOWN],
        y[L.UNKNOWN2],
        y[L.LAM],
    )
    a0, fa0, of_R1, of_R2 = y[A0], y[FA], y[L.MULTIPLIED], y[L.MULTIPLIED2]
    for i in range(n):
        q[i] = q0[i] + h * v0[i] + h * h * P[i]
        v[i] = v0[i] + h * W[i]
        a_n, fa_n = past * a0[i], alpha * fa0[i]
        of_R1[i] = P[i] - (1 / 2 - beta) * a_n + beta * fa_n
        of_R2[i] = W[i] - (1 - gamma) * a_n + gamma * fa_n
    # the multipliers in f and K; nonholonomic ones act like applied forces
    for i in range(n, n + m):
        lam[i] = share(gamma, alpha) * W[i]
        mean = (P[i] + W[i]) / 2
        y[LAW, i] = mean + ahead(h, run) * (mean - a0[i])
    for i in range(n + m, size):
        lam[i] = W[i] = y[LAW, i] = P[i]


@kernel
def change_step(h, run):
    """Convert a_n (row A0) to the step size h."""
    a0, fa0 = run.vectors[A0], run.vectors[FA]
    for i in range(run.layout[L.N_Q]):
        a0[i] = fa0[i] + h / run.reals[S.STEP_SIZE] * (a0[i] - fa0[i])


@kernel
def residual(h, run):
    """RESIDUAL and RESIDUAL2 from MULTIPLIED, MULTIPLIED2, MX, MX2, FORCE, FORCE2 and PAST_FORCE."""
    beta, gamma, alpha, _past = weights(run)
    b, part = run.coefficients[3], share(gamma, alpha)
    n = run.layout[L.N_Q]
    y, mass = run.vectors, run.numbers[run.layout[L.MASS] :]
    r, r2, f, GD, GP = y[L.RESIDUAL], y[L.RESIDUAL2], y[L.FORCE], y[L.FORCE2], y[L.PAST_FORCE]
    of_R1, of_R2, M1, M2 = y[L.MULTIPLIED], y[L.MULTIPLIED2], y[L.MX], y[L.MX2]
    for i in range(n):
        force = (1 + alpha) * (f[i] + part * GD[i])
        r[i] = mass[i] * of_R1[i] + M1[i] - beta * force + ((1 - b) * GP[i] + b * GD[i]) / 2  # R1
        r2[i] = mass[i] * of_R2[i] + M2[i] - gamma * force + (GP[i] + GD[i]) / 2  # R2
    constraint_residuals(h, run)


@kernel
def matrix(t, h, run):
    """Matrices 0 and 1 <- [[S, Phi_q^T], [Phi_q, 0]] and [[M, Phi_q^T], [Phi_q, 0]], factorised.

    Matrix 2 <- -(1+alpha) h^2 K; matrix 3 <- the terms of S with K and D of f if forces are stiff, otherwise empty.
    """
    beta, gamma, alpha, _past = weights(run)
    iteration(0, 0.0, t, h, run)
    clear(2, run)
    if couples(1.0, run):
        stiffness_matrix(2, t, run, K=-(1 + alpha) * h * h, Mx_q=-h * h, Gam_q=-h / gamma)
        couple(run)
    clear(3, run)
    if stiff(STIFF, 1.0, 0, run):
        tangent_matrix(3, t, run, K=beta * (1 + alpha) * h * h, D=gamma * (1 + alpha) * h)
        compress(3, run)
    if turns_far(run):
        return factor_full(t, h, run)
    projection_matrix(1, t, run, M=1.0)
    return factor(0, run) and factor(1, run)


@kernel
def iteration(j, past, t, h, run):
    """Matrix j <- [[S, Phi_q^T], [Phi_q, 0]], with ``past`` times the change of Phi_q^T within the step."""
    beta, gamma, alpha, _past = weights(run)
    k, d = beta * (1 + alpha), gamma * (1 + alpha)
    of_lam = d * (1 + ahead(h, run))  # d times the derivative of lam by eta
    of_mass, of_Gam = beta / gamma * h * h, beta * h / gamma
    velocity_matrix(j, t, run, M=1.0, K=k * h * h, D=d * h, Mx_q=of_mass, f_lam=of_lam, q_v=of_Gam, P=past)


@rare
def factor_full(t, h, run):
    """Set and factorise the matrix of the full system."""
    beta, gamma, alpha, _past = weights(run)
    b = run.coefficients[3]
    # eta and chi give 1/2 psi_I = of_eta eta + of_chi chi, and psi_I is multiplied by Phi_q of the start of the step
    of_eta, of_chi, in_chi = (beta / gamma - b) / (1 - 2 * b), 1 / (gamma * (1 - 2 * b)), gamma * (1 - b) - beta
    of_G = (gamma * b - beta) / (2 * gamma) * h * h
    iteration(block(0, 0, run), of_eta, t, h, run)
    tangent_matrix(block(0, 1, run), t, run, K=(1 + alpha) * h * h, N=h / gamma, Gam_q=h / gamma, columns=0.0, P=of_chi)
    tangent_matrix(block(1, 0, run), t, run, U=beta * of_G, Phi_q=beta, columns=0.0, P=in_chi * of_eta)
    tangent_matrix(block(1, 1, run), t, run, M=1.0, U=of_G, Phi_q=1.0, P=in_chi * of_chi)
    return factor_coupled(run)


@kernel
def correct(k, h, run):
    """Solve for the corrections and apply them to UNKNOWN and UNKNOWN2; return the largest scaled change of a position
    (or of h times a velocity)."""
    beta, gamma, alpha, _past = weights(run)
    b = run.coefficients[3]
    n, m, size = run.layout[L.N_Q], run.layout[L.N_PHI], run.layout[L.N_ALL]
    y, scale = run.vectors, run.vectors[L.SCALE]
    r, r2, w, u, P, W = y[L.RESIDUAL], y[L.RESIDUAL2], y[L.CORRECTION], y[L.CORRECTION2], y[L.UNKNOWN], y[L.UNKNOWN2]
    for i in range(n + m):
        w[i], u[i] = -r2[i], -gamma * r[i] + beta * r2[i]
    for i in range(n + m, size):
        w[i], u[i] = -r[i], 0.0
    if run.integers[S.COUPLED]:
        for i in range(n, n + m):
            u[i] = -gamma * r[i]
        solve_coupled(run)
    else:
        solve_two(k, run)
    change = 0.0
    for i in range(n):
        P[i] += (beta * w[i] + u[i]) / gamma
        W[i] += w[i]
        change = larger((beta * abs(w[i]) + abs(u[i])) * scale[i], change)
    eta, chi, psi_I, psi_II = w, u, P, W  # in the rows of constraints
    for i in range(n, n + m):
        zeta = (chi[i] + beta * eta[i]) / gamma
        psi_I[i] += 2 * (zeta - b * eta[i]) / (1 - 2 * b)
        psi_II[i] += 2 * ((1 - b) * eta[i] - zeta) / (1 - 2 * b)
    for i in range(n + m, size):
        P[i] += w[i] / (gamma * (1 + alpha))
    return h * h * change / gamma


@kernel
def finish(h, run):
    """FA <- fa_{n+1} = M^{-1} Q_{n+1}; A0 <- a_{n+1}. The next step starts at the pose of the last evaluation (KEEP).

    Q is that of the last evaluation. If forces are stiff, its change by the last correction is added, because Q_v dv
    may be large although dv is negligible. Overwrites FORCE, TEMPORARY2 and CORRECTION2.
    """
    _beta, gamma, alpha, _past = weights(run)
    n, part, y = run.layout[L.N_Q], share(gamma, alpha), run.vectors
    f, GD, more, u, a0, fa0 = y[L.FORCE], y[L.FORCE2], y[L.TEMPORARY2], y[L.CORRECTION2], y[A0], y[FA]
    for i in range(run.layout[L.N_ALL]):
        more[i] = 0.0
    multiply(3, L.CORRECTION, L.TEMPORARY2, run)
    for i in range(n):
        more[i], u[i] = -more[i] / gamma, u[i] / gamma
    multiply(2, L.CORRECTION2, L.TEMPORARY2, run)
    for i in range(n):
        f[i] = f[i] + part * GD[i] + more[i] / (1 + alpha)
        a0[i] = -alpha * fa0[i]
    inertia(L.INVERSE, L.FORCE, FA, run)
    for i in range(n):
        a0[i] += (1 + alpha) * fa0[i]
    for i in range(n, run.layout[L.N_ALL]):
        a0[i], fa0[i] = (y[L.UNKNOWN, i] + y[L.UNKNOWN2, i]) / 2, y[LAW, i]
    run.memory[1] = h
    run.layout[L.KEEP] = 1
    settle(run)
