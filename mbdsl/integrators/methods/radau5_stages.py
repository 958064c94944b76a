"""The stages of a step of radau5: their equations, the iteration matrices, and the corrections.

For the stages i = 1, 2, 3 at t_i, with the matrix A of Radau IIA, unknowns are a_i = v', w_i = q' - v, lam_i, nu_i and
mu_i; f = Q - Phi_q^T lam - Gam_v^T nu:

    V = v_n + h A a,   Q = q_n + h A (V + w)
    R1:  M a_i - f_i = 0
    R2:  G w_i + Phi_q^T mu_i = 0
    R3:  Phi(Q_i, t_i) = 0
    R4:  Phi_q V_i + Phi_t = 0
    R5:  Gam(V_i, Q_i, t_i) = 0

G is M, with something where a coordinate has no mass. No system of three, or six, times the size is solved. With
e = (h A)^-2 dQ, so that da = e - (h A)^-1 dw, and kappa = dlam + (h A)^-1 dmu, Newton's equations read, for every
eigenvalue s of h A (one is real, two are a complex pair) in its eigenvectors, S = M + s^2 K' + s D, K' = K + (M a)_q,

    R1 + R2/s:   S e + Phi_q^T kappa + Gam_v^T dnu = -R1 - R2/s + ...
    R3:          Phi_q e = -R3/s^2
    R5:          (Gam_v + s Gam_q) e = -R5/s + ...

and then for every stage, with N = (Phi_q v)_q,

    R2:          G dw + Phi_q^T dmu = -R2 + ...
    R4, R3:      Phi_q dw = R4 - (h A)^-1 R3 + N dQ

Masses make K and M drop out of the coupling, however stiff forces are. The dots are D dw and Gam_v dw/s, for which e
is corrected afterwards where dampers are stiff or constraints nonholonomic, and (M w)_q and (Phi_q^T mu)_q dQ, left to
the next iteration: w and mu vanish with the error of the discretisation.
"""

from __future__ import annotations

from mbdsl.compilation.buffer_layout import (
    FP,
    GD,
    MASS,
    MASS_KIND,
    MASS_SLOTS,
    MX,
    MX2,
    N_ALL,
    N_GAM,
    N_PHI,
    N_Q,
    Q0,
    ROWS,
    SCALE,
    SIZE,
    SLOTS,
    TIMES,
    V0,
    X2,
    XA,
    Q,
    V,
    X,
)
from mbdsl.compilation.marks import kernel, rare
from mbdsl.integrators.loop.complex_lu import complex_factor, complex_solve
from mbdsl.integrators.loop.linear_solve import compress, factor, larger, multiply, solve
from mbdsl.integrators.loop.newton import EPS
from mbdsl.integrators.methods.radau5_coefficients import (
    E1,
    E2,
    IM,
    INVERSE,
    L_IM,
    L_RE,
    L_REAL,
    NODES,
    R_IM,
    R_RE,
    R_REAL,
    RE,
    REAL,
    SQUARE,
)
from mbdsl.integrators.methods.radau5_coefficients import A as W

#: rows of Y behind the common ones, three each: stages [a; lam; nu] and [w; mu; 0], their residuals [R1; R3; R5] and
#: [R2; R4; 0], corrections, and the stages of the last step
STAGE, STAGE2, RESIDUAL, RESIDUAL2, CHANGE, PAST, PAST2 = range(ROWS, ROWS + 21, 3)
#: two of scratch; 0, or G, where a coordinate has no mass; q and v where the last step began
ERROR, ERROR2, METRIC, QB, VB = range(ROWS + 21, ROWS + 26)
#: corrections of v, three
DV = ROWS + 26
OWN_ROWS = 29
#: matrices: of the real s, the projection, [K'; N; Gam_q] in columns of q, real and imaginary part for the complex s,
#: and [D; 0; Gam_v], of no entries where that does not matter
PROJECTION, COUPLING, COMPLEX, DAMPING = 1, 2, 3, 5
MATRICES = 6
#: part of the matrix's diagonal that dampers make up, from which on they do
DAMPED = 0.02
#: G where a coordinate has no mass, relative to what moves with it
MASSLESS = 1e-6


@rare
def set_metric(Y, F, I):
    largest = 0.0
    for i in range(I[N_Q]):
        largest = max(largest, F[I[MASS] + i] * Y[SCALE, i] * Y[SCALE, i])
    for i in range(I[N_Q]):
        Y[METRIC, i] = 0.0
        if not F[I[MASS] + i] > 0.0:
            Y[METRIC, i] = MASSLESS * (largest if largest > 0.0 else 1.0) / (Y[SCALE, i] * Y[SCALE, i])


@rare
def predict(ratio, steps_behind, Y, I):
    """The stages by the polynomials of the last step, whose length times ``ratio`` the new one has.

    Without a past, or where that led nowhere, accelerations and multipliers stay as they are; or, with less than
    nothing behind it, accelerations vanish.
    """
    c0, c1, c2 = NODES[0], NODES[1], NODES[2]
    for k in range(3):
        x = 1.0 + NODES[k] * ratio
        l0 = (x - c1) * (x - c2) / ((c0 - c1) * (c0 - c2))
        l1 = (x - c0) * (x - c2) / ((c1 - c0) * (c1 - c2))
        l2 = (x - c0) * (x - c1) / ((c2 - c0) * (c2 - c1))
        if steps_behind > 0:
            for i in range(I[N_ALL]):
                Y[STAGE + k, i] = l0 * Y[PAST, i] + l1 * Y[PAST + 1, i] + l2 * Y[PAST + 2, i]
                Y[STAGE2 + k, i] = ratio * ratio * ratio * Y[PAST2 + k, i]
        else:
            for i in range(I[N_ALL]):
                Y[STAGE + k, i], Y[STAGE2 + k, i] = Y[XA, i], 0.0
            if steps_behind < 0:
                for i in range(I[N_Q]):
                    Y[STAGE + k, i] = 0.0


@kernel
def motion(k, h, Y, I):
    """q and v at the end of stage k, and the unknowns where evaluate looks for them."""
    a0, a1, a2 = h * W[k][0], h * W[k][1], h * W[k][2]
    b0, b1, b2 = h * h * SQUARE[k][0], h * h * SQUARE[k][1], h * h * SQUARE[k][2]
    c = h * NODES[k]
    for i in range(I[N_Q]):
        x, y, z = Y[STAGE, i], Y[STAGE + 1, i], Y[STAGE + 2, i]
        Y[V, i] = Y[V0, i] + a0 * x + a1 * y + a2 * z
        drift = a0 * Y[STAGE2, i] + a1 * Y[STAGE2 + 1, i] + a2 * Y[STAGE2 + 2, i]
        Y[Q, i] = Y[Q0, i] + c * Y[V0, i] + b0 * x + b1 * y + b2 * z + drift
    for i in range(I[N_ALL]):
        Y[X, i], Y[X2, i] = Y[STAGE + k, i], Y[STAGE2 + k, i]


@kernel
def residual(k, Y, F, I):
    n, m = I[N_Q], I[N_PHI]
    for i in range(n):
        mass = F[I[MASS] + i]
        Y[RESIDUAL + k, i] = mass * Y[X, i] + Y[MX, i] - Y[FP, i]
        Y[RESIDUAL2 + k, i] = (mass + Y[METRIC, i]) * Y[X2, i] + Y[MX2, i] + Y[GD, i]
    for i in range(n, n + m):
        Y[RESIDUAL + k, i], Y[RESIDUAL2 + k, i] = Y[FP, i], Y[GD, i]
    for i in range(n + m, I[N_ALL]):
        Y[RESIDUAL + k, i], Y[RESIDUAL2 + k, i] = Y[FP, i], 0.0


@rare
def matrices(tangent, t, h, still, Y, Z, C, F, I, A, P):
    """All matrices at the state last evaluated, factorised; False where that failed. ``still``: what scaled velocities
    need not be better than."""
    s, x, y = REAL * h, RE * h, IM * h
    k, l = x * x - y * y, 2.0 * x * y
    tangent(t, 1.0, s * s, s, 1.0, 1.0, 0.0, 1.0, s, s * s, Y, Z, C, F, I, A[0])
    tangent(t, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, Y, Z, C, F, I, A[PROJECTION])
    for i in range(I[N_Q]):
        A[PROJECTION, I[I[SLOTS] + I[MASS_SLOTS] + i]] += Y[METRIC, i]
    tangent(t, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 1.0, 1.0, Y, Z, C, F, I, A[COUPLING])
    compress(A[COUPLING], P[COUPLING], I)
    tangent(t, 1.0, k, x, 1.0, 1.0, 0.0, 1.0, x, k, Y, Z, C, F, I, A[COMPLEX])
    # the imaginary part is what this one has more
    tangent(t, 1.0, k + l, x + y, 1.0, 1.0, 0.0, 1.0, x + y, k + l, Y, Z, C, F, I, A[COMPLEX + 1])
    for i in range(I[SIZE]):
        A[COMPLEX + 1, i] -= A[COMPLEX, i]
    prepare_damping(tangent, t, s, still, Y, Z, C, F, I, A, P)
    return (
        factor(A[0], P[0], I)
        and factor(A[PROJECTION], P[PROJECTION], I)
        and complex_factor(A[COMPLEX], A[COMPLEX + 1], P[COMPLEX], I)
    )


@rare
def prepare_damping(tangent, t, s, still, Y, Z, C, F, I, A, P):
    """D and Gam_v. However short steps are: w has the rounding of positions over h, and D h times that is in v."""
    tangent(t, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, Y, Z, C, F, I, A[DAMPING])
    matters = I[N_GAM] > 0
    for i in range(I[N_Q]):
        slot = I[I[SLOTS] + I[MASS_SLOTS] + i]
        d, a = abs(A[DAMPING, slot]), abs(A[0, slot])
        matters = matters or s * d > DAMPED * a or 10.0 * EPS * d > still * a
    if matters:
        compress(A[DAMPING], P[DAMPING], I)
    else:
        P[DAMPING, P.shape[1] - 1] = 0


@kernel
def transform(first, last, h, rank, Y):
    """-R/s^rank, and R2/s more where rank is 0, in the eigenvectors: the real one, real and imaginary part."""
    s, size = 1.0 / (REAL * h), h * (RE * RE + IM * IM)
    x, y = RE / size, -IM / size  # 1/s of the complex one
    p, q = (s, x) if rank == 1 else (s * s, x * x - y * y)
    r = y if rank == 1 else 2.0 * x * y
    for i in range(first, last):
        a, b, c = Y[RESIDUAL, i], Y[RESIDUAL + 1, i], Y[RESIDUAL + 2, i]
        u = L_REAL[0] * a + L_REAL[1] * b + L_REAL[2] * c
        v = L_RE[0] * a + L_RE[1] * b + L_RE[2] * c
        w = L_IM[0] * a + L_IM[1] * b + L_IM[2] * c
        if rank > 0:
            u, v, w = p * u, q * v - r * w, q * w + r * v
        else:
            a, b, c = Y[RESIDUAL2, i], Y[RESIDUAL2 + 1, i], Y[RESIDUAL2 + 2, i]
            f = L_RE[0] * a + L_RE[1] * b + L_RE[2] * c
            g = L_IM[0] * a + L_IM[1] * b + L_IM[2] * c
            u += s * (L_REAL[0] * a + L_REAL[1] * b + L_REAL[2] * c)
            v, w = v + x * f - y * g, w + x * g + y * f
        Y[CHANGE, i], Y[CHANGE + 1, i], Y[CHANGE + 2, i] = -u, -v, -w


@kernel
def correct(h, unit, Y, I, A, P):
    """Solve for the corrections, apply them; the largest scaled change of a position or ``unit`` times a velocity."""
    n, m, size = I[N_Q], I[N_PHI], I[N_ALL]
    solve_stages(h, Y, I, A, P)
    largest = 0.0
    for k in range(3):
        b0, b1, b2 = h * h * SQUARE[k][0], h * h * SQUARE[k][1], h * h * SQUARE[k][2]
        for i in range(n):
            Y[ERROR, i] = b0 * Y[CHANGE, i] + b1 * Y[CHANGE + 1, i] + b2 * Y[CHANGE + 2, i]
            largest = larger(abs(Y[ERROR, i]) * Y[SCALE, i], largest)
        for i in range(n, size):
            Y[ERROR2, i] = 0.0
        multiply(A[COUPLING], P[COUPLING], Y, ERROR, ERROR2)
        a0, a1, a2 = INVERSE[k][0] / h, INVERSE[k][1] / h, INVERSE[k][2] / h
        for i in range(n):
            Y[RESIDUAL2 + k, i] = -Y[RESIDUAL2 + k, i]
        for i in range(n, n + m):
            Y[RESIDUAL2 + k, i] += Y[ERROR2, i]
            Y[RESIDUAL2 + k, i] -= a0 * Y[RESIDUAL, i] + a1 * Y[RESIDUAL + 1, i] + a2 * Y[RESIDUAL + 2, i]
        solve(A[PROJECTION], P[PROJECTION], I, Y, RESIDUAL2 + k)
    for k in range(3):
        a0, a1, a2 = INVERSE[k][0] / h, INVERSE[k][1] / h, INVERSE[k][2] / h
        b0, b1, b2 = h * W[k][0], h * W[k][1], h * W[k][2]
        for i in range(n + m):
            w0, w1, w2 = Y[RESIDUAL2, i], Y[RESIDUAL2 + 1, i], Y[RESIDUAL2 + 2, i]
            Y[STAGE + k, i] += Y[CHANGE + k, i] - (a0 * w0 + a1 * w1 + a2 * w2)
            Y[STAGE2 + k, i] += Y[RESIDUAL2 + k, i]
        for i in range(n + m, size):
            Y[STAGE + k, i] += Y[CHANGE + k, i]
        for i in range(n):
            e = b0 * Y[CHANGE, i] + b1 * Y[CHANGE + 1, i] + b2 * Y[CHANGE + 2, i]
            Y[DV + k, i] = e - Y[RESIDUAL2 + k, i]
    if P[DAMPING, P.shape[1] - 1] > 0:
        couple(h, Y, I, A, P)
    for k in range(3):
        for i in range(n):
            largest = larger(unit * abs(Y[DV + k, i]) * Y[SCALE, i], largest)
    return largest


@kernel
def solve_stages(h, Y, I, A, P):
    """e and kappa of all stages, in CHANGE, from the residuals."""
    n, m, size = I[N_Q], I[N_PHI], I[N_ALL]
    transform(0, n, h, 0, Y)
    transform(n, n + m, h, 2, Y)
    transform(n + m, size, h, 1, Y)
    solve(A[0], P[0], I, Y, CHANGE)
    complex_solve(A[COMPLEX], A[COMPLEX + 1], P[COMPLEX], I, Y[CHANGE + 1], Y[CHANGE + 2])
    for i in range(size):
        u, v, w = Y[CHANGE, i], 2.0 * Y[CHANGE + 1, i], 2.0 * Y[CHANGE + 2, i]
        for k in range(3):
            Y[CHANGE + k, i] = R_REAL[k] * u + R_RE[k] * v - R_IM[k] * w


@rare
def couple(h, Y, I, A, P):
    """What dw, in RESIDUAL2, makes of a by D and Gam_v."""
    for k in range(3):
        for i in range(I[N_ALL]):
            Y[ERROR, i], Y[RESIDUAL + k, i], Y[RESIDUAL2 + k, i] = -Y[RESIDUAL2 + k, i], 0.0, 0.0
        multiply(A[DAMPING], P[DAMPING], Y, ERROR, RESIDUAL + k)
    solve_stages(h, Y, I, A, P)
    for k in range(3):
        for i in range(I[N_ALL]):
            Y[STAGE + k, i] += Y[CHANGE + k, i]
        b0, b1, b2 = h * W[k][0], h * W[k][1], h * W[k][2]
        for i in range(I[N_Q]):
            Y[DV + k, i] += b0 * Y[CHANGE, i] + b1 * Y[CHANGE + 1, i] + b2 * Y[CHANGE + 2, i]


@rare
def estimate(inertia, h, speed, Y, F, I, A, P):
    """The error of the embedded formula of order 3: the largest of q, scaled, and of v, relative to ``speed`` moreover.

    Filtered by (1 - s J)^-1 with the real s, J being that of the equations of motion with their constraints: what is
    stiff has no part in it.
    """
    n, s = I[N_Q], REAL * h
    for i in range(n):
        a, b, c = Y[STAGE, i], Y[STAGE + 1, i], Y[STAGE + 2, i]
        w = E1[0] * Y[STAGE2, i] + E1[1] * Y[STAGE2 + 1, i] + E1[2] * Y[STAGE2 + 2, i]
        Y[ERROR, i] = h * (h * (E2[0] * a + E2[1] * b + E2[2] * c) + w)
        Y[CHANGE, i] = h * (REAL * Y[XA, i] + E1[0] * a + E1[1] * b + E1[2] * c)
    for i in range(I[N_ALL]):
        Y[ERROR2, i], Y[MX, i] = 0.0, 0.0
    multiply(A[COUPLING], P[COUPLING], Y, ERROR, ERROR2)
    if I[MASS_KIND] > 0:
        inertia(TIMES, CHANGE, MX, Y, F, I)
    for i in range(n):
        Y[CHANGE, i] = F[I[MASS] + i] * Y[CHANGE, i] + Y[MX, i] - s * Y[ERROR2, i]
    for i in range(n, n + I[N_PHI]):
        Y[CHANGE, i] = 0.0
    for i in range(n + I[N_PHI], I[N_ALL]):
        Y[CHANGE, i] = -Y[ERROR2, i]
    solve(A[0], P[0], I, Y, CHANGE)
    largest = 0.0
    for i in range(n):
        of_q, of_v = Y[ERROR, i] + s * Y[CHANGE, i], Y[CHANGE, i]
        largest = larger(max(abs(of_q), abs(of_v) / speed) * Y[SCALE, i], largest)
    return largest
