"""HHT-ADD: Hilber-Hughes-Taylor with reactions added for both constraint levels, order 2 in q and v.

Unknowns a_{n+1}, psi_I, psi_II; fa = M^{-1} Q are the accelerations of the applied forces alone, b != 1/2 is free:

    q_{n+1} = q_n + h v_n + h^2/2 [(1-2 beta) a_n + 2 beta a_{n+1}] + h^2/2 [(1-b) R_I + b R_II]
    v_{n+1} = v_n + h [(1-gamma) a_n + gamma a_{n+1}] + h/2 (R_I + R_II)
    Phi(q_{n+1}, t_{n+1}) = 0,   (Phi_q v + Phi_t)_{n+1} = 0
    a_{n+1} = (1+alpha) fa_{n+1} - alpha fa_n
    M R_I = -Phi_q^T(q_n, t_n) psi_I,   M R_II = -Phi_q^T(q_{n+1}, t_{n+1}) psi_II

Iterated on are P and W, what q_{n+1} = q_n + h v_n + h^2 P and v_{n+1} = v_n + h W add up to, so that M need not be
inverted: with GP = M M_n^{-1} Phi_q^T(q_n) psi_I, GD = Phi_q^T psi_II and M = M(q_{n+1}), M_n = M(q_n),

    R1:  M [P - (1/2 - beta) a_n + beta alpha fa_n] - beta (1+alpha) Q_{n+1} + 1/2 [(1-b) GP + b GD] = 0
    R2:  M [W - (1 - gamma) a_n + gamma alpha fa_n] - gamma (1+alpha) Q_{n+1} + 1/2 (GP + GD) = 0
    R3:  1/h^2 Phi = 0,   R4:  1/h (Phi_q v + Phi_t) = 0

Where M depends on q, M_n^{-1} is applied body by body, by the factors of what is constant in it (the elements' own
file); that and fa_{n+1} = M^{-1} Q_{n+1} at the end of a step are all that is inverted.

In the increments w of W and u = gamma p - beta w (p that of P), and with the old Phi_q taken for the new one, Newton's
equations fall apart, as HHT-SI2's do:

    gamma R1 - beta R2:  M u + Phi_q^T chi = -gamma R1 + beta R2,            Phi_q u = -gamma R3 + beta R4 + ...
    R2:                  S w + Phi_q^T eta = -R2 - (1+alpha) h^2 K u,        Phi_q w = -R4 + ...
    S = M + (1+alpha) (beta h^2 K + gamma h D) + beta/(2 gamma) h^2 (Phi_q^T psi_II)_q + beta/gamma h^2 (M [.]_R2)_q,
    K and D of applied forces alone

The converged solution is that of the full system. psi_II is of order 1 only: reactions are found from the
acceleration-level equations, and friction in joints, which has to take psi_II, is of order 1.

Local errors: as HHT-I3's. Where steps differ, a_n, found for t_n + alpha h_{n-1}, becomes that for t_n + alpha h_n:
fa_n + h_n/h_{n-1} (a_n - fa_n).

Source: Negrut, Jay, Khude, J. Comput. Nonlinear Dyn. 4 (2009) 021008, section on HHT-ADD, with the velocity formula
derived anew (misprinted there); Jay, Negrut, Extensions of the HHT-alpha method to differential-algebraic equations in
mechanics, ETNA 26 (2007) 190-208. The splitting is ours.
"""

from mbdsl.compilation.buffer_layout import (
    D2,
    FP,
    GD,
    GP,
    INVERSE,
    KEEP,
    LAM,
    MASS,
    MX,
    MX2,
    N_ALL,
    N_PHI,
    N_Q,
    PAST,
    Q0,
    R2,
    SCALE,
    T2,
    V0,
    X2,
    XA,
    Y1,
    Y2,
    D,
    Q,
    R,
    V,
    X,
)
from mbdsl.compilation.buffer_layout import Q1 as A0  # the row that keeps a_n
from mbdsl.compilation.buffer_layout import V1 as FA  # the row that keeps fa_n
from mbdsl.compilation.marks import kernel
from mbdsl.integrators.loop.linear_solve import compress, factor, larger, multiply
from mbdsl.integrators.loop.loop_state import H
from mbdsl.integrators.loop.split_correction import couple, couples, solve_two, stiff
from mbdsl.integrators.method import Method, Option
from mbdsl.integrators.methods import hht_i3
from mbdsl.integrators.methods.hht_i3 import local_error
from mbdsl.integrators.methods.newmark import settle, start_stiff

__all__ = ["local_error"]

#: share of S beyond which forces count as stiff
STIFF = 0.5


def coefficients(options):
    """Those of HHT-I3, and b."""
    return *hht_i3.coefficients(options), options["b"]


def check(options):
    if abs(options["b"] - 1 / 2) < 1e-3:
        return "b = 1/2 makes both constraint levels ask the same of psi_I and psi_II, and determines neither"
    return None


def begin(c, start):
    a0 = start.fa + c[2] * start.h * start.fa_rate
    total = a0 + start.a - start.fa
    if start.stiff:
        start_stiff(c)
        total = 0.0 * total
    rows = {XA: [*(total / 2), *start.lam], XA + PAST: [*total, *start.lam]}
    return {A0: a0, FA: start.fa, **rows}


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
    begin=begin,
    sets=3,
    matrices=4,
    multipliers=(LAM, X2, X2),
    own_reactions=False,
    inverts_mass=True,
    inertia_rows=(Y1, Y2),
    tangent_row=Y2,
    acceleration_row=X2,
    node=lambda c: 0.5,
    damping_weight=lambda c: c[1] * (1 + c[2]),
    steps=("fixed", "controlled"),
    diverges="hht-add does not pass all singular poses: its iteration diverges where a singular value of Phi_q falls "
    "by more than half within a step; hht-si2 or hht-i3 may pass",
)


@kernel
def share(c):
    """Of psi_II, what f is evaluated with: K is then the sum that S asks for."""
    return 1 / (2 * c[1] * (1 + c[2]))


@kernel
def motion(h, c, Y, I):
    beta, gamma, alpha = c[0], c[1], c[2]
    n, m = I[N_Q], I[N_PHI]
    for i in range(n):
        Y[Q, i] = Y[Q0, i] + h * Y[V0, i] + h * h * Y[X, i]
        Y[V, i] = Y[V0, i] + h * Y[X2, i]
        a0, fa0 = c[3] * Y[A0, i], alpha * Y[FA, i]
        Y[Y1, i] = Y[X, i] - (1 / 2 - beta) * a0 + beta * fa0
        Y[Y2, i] = Y[X2, i] - (1 - gamma) * a0 + gamma * fa0
    # the multipliers that f and K see; a nonholonomic one acts as an applied force does
    for i in range(n, n + m):
        Y[LAM, i] = share(c) * Y[X2, i]
    for i in range(n + m, I[N_ALL]):
        Y[LAM, i] = Y[X2, i] = Y[X, i]


@kernel
def change_step(h, evaluate, tangent, inertia, c, K, J, Y, Z, C, F, I, A, P):
    """a_n for a step of length h in place of K[H]."""
    for i in range(I[N_Q]):
        Y[A0, i] = Y[FA, i] + h / K[H] * (Y[A0, i] - Y[FA, i])


@kernel
def applied(c, Y, i):
    """Q_i, which evaluate gives less the share of constraint forces."""
    return Y[FP, i] + share(c) * Y[GD, i]


@kernel
def residual(h, c, Y, F, I):
    beta, gamma, alpha, b = c[0], c[1], c[2], c[8]
    n, m = I[N_Q], I[N_PHI]
    for i in range(n):
        mass, force, GP_, GD_ = F[I[MASS] + i], (1 + alpha) * applied(c, Y, i), Y[GP, i], Y[GD, i]
        Y[R, i] = mass * Y[Y1, i] + Y[MX, i] - beta * force + ((1 - b) * GP_ + b * GD_) / 2  # R1
        Y[R2, i] = mass * Y[Y2, i] + Y[MX2, i] - gamma * force + (GP_ + GD_) / 2  # R2
    for i in range(n, n + m):
        Y[R, i] = Y[FP, i] / (h * h)  # R3
        Y[R2, i] = Y[GD, i] / h  # R4
    for i in range(n + m, I[N_ALL]):
        Y[R, i], Y[R2, i] = Y[FP, i] / h, 0.0


@kernel
def matrix(tangent, t, h, c, Y, Z, C, F, I, A, P):
    """[[S, Phi_q^T], [Phi_q, 0]], [[M, Phi_q^T], [Phi_q, 0]], -(1+alpha) h^2 K and, where forces are stiff, S - M."""
    beta, gamma, alpha, b = c[0], c[1], c[2], c[8]
    k, d = beta * (1 + alpha), gamma * (1 + alpha)
    of_lam = 2 * d * (1 - b - beta / gamma) / (1 - 2 * b)  # how psi_II follows eta
    tangent(
        t, 1.0, k * h * h, d * h, of_lam, 1.0, 0.0, 1.0, beta * h / gamma, beta / gamma * h * h, Y, Z, C, F, I, A[0]
    )
    tangent(t, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, Y, Z, C, F, I, A[1])
    P[2, P.shape[1] - 1] = 0
    if couples(1.0, A, F, I):
        tangent(t, 0.0, -(1 + alpha) * h * h, 0.0, 0.0, 0.0, 0.0, 0.0, -h / gamma, -h * h, Y, Z, C, F, I, A[2])
        couple(A, P, I, Y)
    P[3, P.shape[1] - 1] = 0
    if stiff(STIFF, 1.0, A, F, I):
        tangent(t, 0.0, k * h * h, d * h, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, Y, Z, C, F, I, A[3])
        compress(A[3], P[3], I)
    return factor(A[0], P[0], I) and factor(A[1], P[1], I)


@kernel
def correct(k, h, c, Y, I, A, P):
    """Solve for the corrections, apply them; the largest scaled change of a position (or of h times a velocity)."""
    beta, gamma, alpha, b = c[0], c[1], c[2], c[8]
    n, m = I[N_Q], I[N_PHI]
    for i in range(n + m):
        Y[D, i], Y[D2, i] = -Y[R2, i], -gamma * Y[R, i] + beta * Y[R2, i]
    for i in range(n + m, I[N_ALL]):
        Y[D, i], Y[D2, i] = -Y[R, i], 0.0
    solve_two(k, A, P, I, Y)
    change = 0.0
    for i in range(n):
        w, u = Y[D, i], Y[D2, i]
        Y[X, i] += (beta * w + u) / gamma
        Y[X2, i] += w
        change = larger((beta * abs(w) + abs(u)) * Y[SCALE, i], change)
    for i in range(n, n + m):
        eta = Y[D, i]
        zeta = (Y[D2, i] + beta * eta) / gamma
        Y[X, i] += 2 * (zeta - b * eta) / (1 - 2 * b)  # psi_I
        Y[X2, i] += 2 * ((1 - b) * eta - zeta) / (1 - 2 * b)  # psi_II
    for i in range(n + m, I[N_ALL]):
        Y[X, i] += Y[D, i] / (gamma * (1 + alpha))
    return h * h * change / gamma


@kernel
def finish(inertia, h, c, Y, F, I, A, P):
    """fa_{n+1} = M^{-1} Q_{n+1} and a_{n+1}; the pose last evaluated, that of both, is where the next step begins.

    Q is that of the last evaluation and, where forces are stiff, what the last correction makes of it: there Q_v dv may
    be large where dv is negligible.
    """
    gamma, alpha = c[1], c[2]
    for i in range(I[N_ALL]):
        Y[T2, i] = 0.0
    multiply(A[3], P[3], Y, D, T2)
    for i in range(I[N_Q]):
        Y[T2, i], Y[D2, i] = -Y[T2, i] / gamma, Y[D2, i] / gamma
    multiply(A[2], P[2], Y, D2, T2)
    for i in range(I[N_Q]):
        Y[FP, i] = applied(c, Y, i) + Y[T2, i] / (1 + alpha)
        Y[A0, i] = -alpha * Y[FA, i]
    inertia(INVERSE, FP, FA, Y, F, I)
    for i in range(I[N_Q]):
        Y[A0, i] += (1 + alpha) * Y[FA, i]
    I[KEEP] = 1
    settle(c)
