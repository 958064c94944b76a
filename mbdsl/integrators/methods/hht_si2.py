"""HHT-SI2: Hilber-Hughes-Taylor, stabilised index 2; both constraint levels hold, order 2 in q, v, a and lam.

Unknowns a_{n+1}, lam_{n+1} and, local to the step, abar, mu; f = Q - Phi_q^T lam:

    q_{n+1} = q_n + h v_n + h^2/2 [(1 - 2 beta) a_n + 2 beta a_{n+1}] + h^2/2 abar
    v_{n+1} = v_n + h [(1 - gamma) a_n + gamma a_{n+1}]
    R1:  1/(1+alpha) Mhat a_{n+1} - f_{n+1} + alpha/(1+alpha) f_n = 0
    R2:  Mhat abar + Phi_q^T mu = 0
    R3:  1/h^2 Phi(q_{n+1}, t_{n+1}) = 0
    R4:  1/h (Phi_q v + Phi_t)_{n+1} = 0
    Mhat := M at the predictor q_n + (1+alpha) h v_n, once a step

The system of twice the size is not solved as one. In the increments da of a and e of abar/2, with S = 1/(1+alpha) M +
beta h^2 K + gamma h D, Newton's equations read

    R2:       2 M e + Phi_q^T dmu = -R2 + ...
    R3, R4:   Phi_q e = -R3 + beta/gamma R4 + ...
    R1:       S da + Phi_q^T dlam = -R1 - h^2 K e
    R4:       Phi_q da = -R4/gamma + ...

a projection with a mass matrix that does not change, and HHT-I3's own system. The dots are h N dq and
h^2 (Phi_q^T mu)_q dq: a power of h times a correction, left to the next iteration. The converged solution is that of
the full system.

Local errors are those of HHT-I3, and so is the shift of a_n where steps differ. abar and mu, which vanish with h, are
predicted in proportion to it.

Source: Negrut, Jay, Khude, J. Comput. Nonlinear Dyn. 4 (2009) 021008, eqs. (12)-(13), with R1's signs derived anew
(they are misprinted there); the splitting is ours.
"""

from mbdsl.compilation.buffer_layout import (
    D2,
    F0,
    FP,
    GD,
    MASS,
    MX,
    MX2,
    N_ALL,
    N_PHI,
    N_Q,
    PAST,
    Q0,
    Q_MASS,
    R2,
    SCALE,
    V0,
    X2,
    XA,
    D,
    Q,
    R,
    V,
    X,
)
from mbdsl.compilation.marks import kernel
from mbdsl.integrators.loop.linear_solve import factor, larger
from mbdsl.integrators.loop.loop_state import H
from mbdsl.integrators.loop.split_correction import couple, couples, solve_two
from mbdsl.integrators.method import Method
from mbdsl.integrators.methods.hht_i3 import ALPHA, begin, coefficients, finish, hold_mass, local_error

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
    begin=begin,
    sets=2,
    matrices=3,
    mass_row=Q_MASS,
    node=lambda c: 1 + c[2],
    mass_weight=lambda c: 1 / (1 + c[2]),
    damping_weight=lambda c: c[1],
    steps=("fixed", "controlled"),
)


@kernel
def motion(h, c, Y, I):
    beta, gamma = c[0], c[1]
    hold_mass(h, c, Y, I)
    for i in range(I[N_Q]):
        a0, a = c[3] * Y[XA, i], Y[X, i]
        Y[Q, i] = Y[Q0, i] + h * Y[V0, i] + h * h / 2 * ((1 - 2 * beta) * a0 + 2 * beta * a + Y[X2, i])
        Y[V, i] = Y[V0, i] + h * ((1 - gamma) * a0 + gamma * a)


@kernel
def change_step(h, evaluate, tangent, inertia, c, K, J, Y, Z, C, F, I, A, P):
    """abar and mu of the past, as with steps of length h in place of K[H]."""
    for k in range(PAST if h != K[H] else 0):
        for i in range(I[N_ALL]):
            Y[XA + PAST + k, i] *= h / K[H]


@kernel
def residual(h, c, Y, F, I):
    alpha = c[2]
    n, m = I[N_Q], I[N_PHI]
    for i in range(n):
        mass = F[I[MASS] + i]
        Y[R, i] = (mass * Y[X, i] + Y[MX, i]) / (1 + alpha) - Y[FP, i] + alpha / (1 + alpha) * Y[F0, i]  # R1
        Y[R2, i] = mass * Y[X2, i] + Y[MX2, i] + Y[GD, i]  # R2
    for i in range(n, n + m):
        Y[R, i] = Y[FP, i] / (h * h)  # R3
        Y[R2, i] = Y[GD, i] / h  # R4
    for i in range(n + m, I[N_ALL]):
        Y[R, i], Y[R2, i] = Y[FP, i] / h, 0.0


@kernel
def matrix(tangent, t, h, c, Y, Z, C, F, I, A, P):
    """[[S, Phi_q^T], [Phi_q, 0]], [[2 M, Phi_q^T], [Phi_q, 0]] and -h^2 K."""
    beta, gamma, alpha = c[0], c[1], c[2]
    tangent(t, 1 / (1 + alpha), beta * h * h, gamma * h, 1.0, 1.0, 0.0, 1.0, beta * h / gamma, 0.0, Y, Z, C, F, I, A[0])
    tangent(t, 2.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, Y, Z, C, F, I, A[1])
    P[2, P.shape[1] - 1] = 0
    if couples(1 / (1 + alpha), A, F, I):
        tangent(t, 0.0, -h * h, 0.0, 0.0, 0.0, 0.0, 0.0, -h / gamma, 0.0, Y, Z, C, F, I, A[2])
        couple(A, P, I, Y)
    return factor(A[0], P[0], I) and factor(A[1], P[1], I)


@kernel
def correct(k, h, c, Y, I, A, P):
    """Solve for the corrections, apply them; the largest scaled change of a position (or of h times a velocity)."""
    beta, gamma = c[0], c[1]
    n, m = I[N_Q], I[N_PHI]
    for i in range(n):
        Y[D, i], Y[D2, i] = -Y[R, i], -Y[R2, i]
    for i in range(n, n + m):
        Y[D, i], Y[D2, i] = -Y[R2, i] / gamma, -Y[R, i] + beta / gamma * Y[R2, i]
    for i in range(n + m, I[N_ALL]):
        Y[D, i], Y[D2, i] = -Y[R, i] / gamma, 0.0
    solve_two(k, A, P, I, Y)
    change = 0.0
    for i in range(n):
        a, e = Y[D, i], Y[D2, i]
        Y[X, i] += a
        Y[X2, i] += 2 * e
        change = larger((beta * abs(a) + abs(e)) * Y[SCALE, i], change)
    for i in range(n, I[N_ALL]):
        Y[X, i] += Y[D, i]
        Y[X2, i] += Y[D2, i]
    return h * h * change
