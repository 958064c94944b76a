"""The three stages of a step of radau5: equations, iteration matrices, corrections, error estimate.

The unknowns of the stages i = 1, 2, 3 at t_i are a_i = v', w_i = q' - v, lam_i, nu_i and mu_i. With the matrix A of
Radau IIA and f = Q - Phi_q^T lam - Gam_v^T nu, their equations are

    V = v_n + h A a,   Q = q_n + h A (V + w)
    R1:  M a_i - f_i = 0
    R2:  G w_i + Phi_q^T mu_i = 0
    R3:  Phi(Q_i, t_i) = 0
    R4:  Phi_q V_i + Phi_t = 0
    R5:  Gam(V_i, Q_i, t_i) = 0

G is M, with a small positive entry for each coordinate without mass. Newton's equations are decoupled, so that no
system of three or six times the size is solved. Let e = (h A)^-2 dQ, so that da = e - (h A)^-1 dw, and
kappa = dlam + (h A)^-1 dmu. In the eigenvectors of h A, for each eigenvalue s (one real, one complex pair), with
S = M + s^2 K' + s D and K' = K + (M a)_q:

    R1 + R2/s:   S e + Phi_q^T kappa + Gam_v^T dnu = -R1 - R2/s + ...
    R3:          Phi_q e = -R3/s^2
    R5:          (Gam_v + s Gam_q) e = -R5/s + ...

and then for every stage, with N = (Phi_q v)_q,

    R2:          G dw + Phi_q^T dmu = -R2 + ...
    R4, R3:      Phi_q dw = R4 - (h A)^-1 R3 + N dQ

Because R2 is weighted with the mass, K and M drop out of the coupling, however stiff the forces. The dots stand for
D dw and Gam_v dw/s, for which e is corrected afterwards if dampers are stiff or constraints nonholonomic; and for
(M w)_q and (Phi_q^T mu)_q dQ, which are left to the next iteration, because w and mu vanish with the discretisation
error.

In space these formulas are those of the rotation vectors psi from the attitudes at the start of the step: v is psi',
and a is psi''. Equations contain Omega = T(psi) v, Omega' and T(psi) w, and Newton's equations their products with T
and T^T, of whose derivatives with respect to psi only those in N remain. Where stages are compared with those of
another step, a is Omega'.
"""

from __future__ import annotations

from mbdsl.integrators.loop.complex_lu import complex_factor, complex_solve
from mbdsl.integrators.loop.linear_solve import clear, compress, factor, has_entries, larger, multiply, solve
from mbdsl.integrators.loop.newton import EPS
from mbdsl.integrators.loop.rotation_chart import (
    from_chart,
    from_rates,
    into_chart,
    out_of_chart,
    to_body,
    to_rates,
    to_second_rates,
    to_world,
)
from mbdsl.integrators.loop.run_data import evaluate, inertia
from mbdsl.integrators.loop.tangent_matrices import iteration_matrix, projection_matrix, tangent_matrix
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
from mbdsl.kernels import buffer_layout as L
from mbdsl.kernels.marks import kernel, rare
from mbdsl.numerics.rotation import INVERSE_INERTIA

#: own rows of ``vectors``: two for intermediate results; G of the coordinates without mass, otherwise 0; q and v at the
#: start of the last step
ERROR, ERROR2, METRIC, QB, VB = range(L.ROWS, L.ROWS + 5)
#: three rows each: stages [a; lam; nu] and [w; mu; 0], their residuals [R1; R3; R5] and [R2; R4; 0], corrections, the
#: stages of the last step, and corrections of v
STAGE, STAGE2, RESIDUAL, RESIDUAL2, CHANGE, PAST, PAST2, DV = range(L.ROWS + 5, L.ROWS + 29, 3)
#: velocities with psi' in the place of Omega, at the ends of this step and of the last one
RATES = L.ROWS + 29
OWN_ROWS = 31
#: matrices: that of the real s (0); the projection; [K'; N; Gam_q] in the columns of q; [D; 0; Gam_v], empty if
#: negligible; real and imaginary part of that of the complex s
PROJECTION, COUPLING, DAMPING, COMPLEX = 1, 2, 3, 4
MATRICES = 6
#: share of the dampers in the diagonal of the matrix above which [D; 0; Gam_v] is not negligible
DAMPED = 0.02
#: G of a coordinate without mass, relative to the largest mass
MASSLESS = 1e-6


@rare
def set_metric(run):
    """Set row METRIC: G of the coordinates without mass, and of the rotations of a body without inertia about some
    axis, as a thin rod."""
    vectors, numbers, layout = run.vectors, run.numbers, run.layout
    largest = 0.0
    for i in range(layout[L.N_Q]):
        largest = max(largest, numbers[layout[L.MASS] + i] * vectors[L.SCALE, i] * vectors[L.SCALE, i])
        vectors[METRIC, i] = 0.0
    least = MASSLESS * (largest if largest > 0.0 else 1.0)
    for i in range(layout[L.N_Q]):
        if not numbers[layout[L.MASS] + i] > 0.0:
            vectors[METRIC, i] = least / (vectors[L.SCALE, i] * vectors[L.SCALE, i])
    for k in range(layout[L.N_ROTATIONS]):
        d, at = layout[layout[L.ROTATIONS] + 2 * k], layout[layout[L.ROTATIONS] + 2 * k + 1]
        if numbers[at + INVERSE_INERTIA] == 0.0:  # the same about all axes: matrices are in those of the world
            for i in range(d, d + 3):
                vectors[METRIC, i] = least / (vectors[L.SCALE, i] * vectors[L.SCALE, i])


@rare
def predict(ratio, degree, h, run):
    """The stages extrapolated by the polynomials of the last step; ``ratio``: of the new to the last step length.

    With ``degree`` 0 or 2, accelerations and multipliers are those at the start of the step; if it is negative,
    accelerations are zero.
    """
    vectors, layout = run.vectors, run.layout
    c0, c1, c2 = NODES[0], NODES[1], NODES[2]
    for k in range(3):
        x = 1.0 + NODES[k] * ratio
        l0 = (x - c1) * (x - c2) / ((c0 - c1) * (c0 - c2))
        l1 = (x - c0) * (x - c2) / ((c1 - c0) * (c1 - c2))
        l2 = (x - c0) * (x - c1) / ((c2 - c0) * (c2 - c1))
        if degree > 2:
            for i in range(layout[L.N_ALL]):
                vectors[STAGE + k, i] = l0 * vectors[PAST, i] + l1 * vectors[PAST + 1, i] + l2 * vectors[PAST + 2, i]
                vectors[STAGE2 + k, i] = ratio * ratio * ratio * vectors[PAST2 + k, i]
        else:
            for i in range(layout[L.N_ALL]):
                vectors[STAGE + k, i], vectors[STAGE2 + k, i] = vectors[L.UNKNOWN0, i], 0.0
            if degree < 0:
                for i in range(layout[L.N_Q]):
                    vectors[STAGE + k, i] = 0.0
    if layout[L.N_ROTATIONS] > 0:
        for k in (0, 2, 1):
            motion(k, h, run)
            to_second_rates(STAGE + k, run)


@kernel
def motion(k, h, run):
    """q and v at stage k, and its unknowns in the rows that evaluations read."""
    vectors, layout = run.vectors, run.layout
    a0, a1, a2 = h * W[k][0], h * W[k][1], h * W[k][2]
    b0, b1, b2 = h * h * SQUARE[k][0], h * h * SQUARE[k][1], h * h * SQUARE[k][2]
    c = h * NODES[k]
    for i in range(layout[L.N_Q]):
        x, y, z = vectors[STAGE, i], vectors[STAGE + 1, i], vectors[STAGE + 2, i]
        vectors[L.VELOCITY, i] = vectors[L.VELOCITY0, i] + a0 * x + a1 * y + a2 * z
        drift = a0 * vectors[STAGE2, i] + a1 * vectors[STAGE2 + 1, i] + a2 * vectors[STAGE2 + 2, i]
        vectors[L.POSITION, i] = (
            vectors[L.POSITION0, i] + c * vectors[L.VELOCITY0, i] + b0 * x + b1 * y + b2 * z + drift
        )
    for i in range(layout[L.N_ALL]):
        vectors[L.UNKNOWN, i], vectors[L.UNKNOWN2, i] = vectors[STAGE + k, i], vectors[STAGE2 + k, i]
    from_chart(run)


@kernel
def residual(k, run):
    """Residuals of stage k, as evaluated."""
    vectors, numbers, layout = run.vectors, run.numbers, run.layout
    n, m = layout[L.N_Q], layout[L.N_PHI]
    for i in range(n):
        mass = numbers[layout[L.MASS] + i]
        vectors[RESIDUAL + k, i] = mass * vectors[L.UNKNOWN, i] + vectors[L.MX, i] - vectors[L.FORCE, i]
        vectors[RESIDUAL2 + k, i] = (
            (mass + vectors[METRIC, i]) * vectors[L.UNKNOWN2, i] + vectors[L.MX2, i] + vectors[L.FORCE2, i]
        )
    for i in range(n, n + m):
        vectors[RESIDUAL + k, i], vectors[RESIDUAL2 + k, i] = vectors[L.FORCE, i], vectors[L.FORCE2, i]
    for i in range(n + m, layout[L.N_ALL]):
        vectors[RESIDUAL + k, i], vectors[RESIDUAL2 + k, i] = vectors[L.FORCE, i], 0.0
    into_chart(RESIDUAL + k, run)
    into_chart(RESIDUAL2 + k, run)


@kernel
def residuals(t, h, run):
    """Residuals of all stages of a step from t; the second stage last, as the matrices are evaluated there."""
    for stage in (0, 2, 1):
        motion(stage, h, run)
        run.layout[L.NEW_MASS] = 1
        evaluate(t + NODES[stage] * h, run)
        residual(stage, run)


@rare
def constraint_size(run):
    """Largest violation of the constraints on positions, in all stages."""
    vectors, layout = run.vectors, run.layout
    value = 0.0
    for k in range(3):
        for i in range(layout[L.N_Q], layout[L.N_Q] + layout[L.N_PHI]):
            value = max(value, abs(vectors[RESIDUAL + k, i]))
    return value


@kernel
def finish(h, run):
    """q and v at the end of the step, and its unknowns."""
    motion(2, h, run)


@rare
def matrices(start, h, still, run):
    """All matrices of a step from ``start``, at the state last evaluated, factorised; False if that failed. ``still``:
    acceptable error of scaled velocities."""
    vectors, layout, matrices, t = run.vectors, run.layout, run.matrices, start + NODES[1] * h
    s, x, y = REAL * h, RE * h, IM * h
    k, l = x * x - y * y, 2.0 * x * y
    iteration_matrix(0, t, run, M=1.0, K=s * s, D=s, Mx_q=s * s, Gam_q=s)
    projection_matrix(PROJECTION, t, run, M=1.0)
    for i in range(layout[L.N_Q]):
        matrices[PROJECTION, layout[layout[L.SLOTS] + layout[L.MASS_SLOTS] + i]] += vectors[METRIC, i]
    tangent_matrix(COUPLING, t, run, K=1.0, Mx_q=1.0, N=1.0, Gam_q=1.0)
    compress(COUPLING, run)
    iteration_matrix(COMPLEX, t, run, M=1.0, K=k, D=x, Mx_q=k, Gam_q=x)
    # the imaginary part is the difference of these two
    iteration_matrix(COMPLEX + 1, t, run, M=1.0, K=k + l, D=x + y, Mx_q=k + l, Gam_q=x + y)
    for i in range(layout[L.SIZE]):
        matrices[COMPLEX + 1, i] -= matrices[COMPLEX, i]
    prepare_damping(t, s, still, run)
    return (
        factor(0, run)
        and factor(PROJECTION, run)
        and complex_factor(matrices[COMPLEX], matrices[COMPLEX + 1], run.pivots[COMPLEX], layout)
    )


@rare
def prepare_damping(t, s, still, run):
    """The matrix of D and Gam_v, empty if negligible.

    It matters for arbitrarily short steps, too: rounding of positions divided by h is in w, and D h times that in v.
    """
    layout, matrices = run.layout, run.matrices
    tangent_matrix(DAMPING, t, run, D=1.0, Gam_v=1.0)
    matters = layout[L.N_GAM] > 0
    for i in range(layout[L.N_Q]):
        slot = layout[layout[L.SLOTS] + layout[L.MASS_SLOTS] + i]
        d, a = abs(matrices[DAMPING, slot]), abs(matrices[0, slot])
        matters = matters or s * d > DAMPED * a or 10.0 * EPS * d > still * a
    if matters:
        compress(DAMPING, run)
    else:
        clear(DAMPING, run)


@kernel
def transform(first, last, h, rank, run):
    """CHANGE = -R/s^rank (rank 0: -R - R2/s) in the eigenvectors: the real, then the complex one."""
    vectors = run.vectors
    s, size = 1.0 / (REAL * h), h * (RE * RE + IM * IM)
    x, y = RE / size, -IM / size  # 1/s of the complex one
    p, q = (s, x) if rank == 1 else (s * s, x * x - y * y)
    r = y if rank == 1 else 2.0 * x * y
    for i in range(first, last):
        a, b, c = vectors[RESIDUAL, i], vectors[RESIDUAL + 1, i], vectors[RESIDUAL + 2, i]
        u = L_REAL[0] * a + L_REAL[1] * b + L_REAL[2] * c
        v = L_RE[0] * a + L_RE[1] * b + L_RE[2] * c
        w = L_IM[0] * a + L_IM[1] * b + L_IM[2] * c
        if rank > 0:
            u, v, w = p * u, q * v - r * w, q * w + r * v
        else:
            a, b, c = vectors[RESIDUAL2, i], vectors[RESIDUAL2 + 1, i], vectors[RESIDUAL2 + 2, i]
            f = L_RE[0] * a + L_RE[1] * b + L_RE[2] * c
            g = L_IM[0] * a + L_IM[1] * b + L_IM[2] * c
            u += s * (L_REAL[0] * a + L_REAL[1] * b + L_REAL[2] * c)
            v, w = v + x * f - y * g, w + x * g + y * f
        vectors[CHANGE, i], vectors[CHANGE + 1, i], vectors[CHANGE + 2, i] = -u, -v, -w


@kernel
def correct(h, unit, run):
    """Solve for the corrections, apply them; the largest scaled change of a position or ``unit`` times a velocity."""
    vectors, layout = run.vectors, run.layout
    n, m, size = layout[L.N_Q], layout[L.N_PHI], layout[L.N_ALL]
    solve_stages(h, run)
    largest = 0.0
    for k in range(3):
        b0, b1, b2 = h * h * SQUARE[k][0], h * h * SQUARE[k][1], h * h * SQUARE[k][2]
        for i in range(n):
            vectors[ERROR, i] = b0 * vectors[CHANGE, i] + b1 * vectors[CHANGE + 1, i] + b2 * vectors[CHANGE + 2, i]
            largest = larger(abs(vectors[ERROR, i]) * vectors[L.SCALE, i], largest)
        for i in range(n, size):
            vectors[ERROR2, i] = 0.0
        from_rates(vectors[L.POSITION], vectors[ERROR], run)
        multiply(COUPLING, ERROR, ERROR2, run)
        a0, a1, a2 = INVERSE[k][0] / h, INVERSE[k][1] / h, INVERSE[k][2] / h
        for i in range(n):
            vectors[RESIDUAL2 + k, i] = -vectors[RESIDUAL2 + k, i]
        for i in range(n, n + m):
            vectors[RESIDUAL2 + k, i] += vectors[ERROR2, i]
            vectors[RESIDUAL2 + k, i] -= (
                a0 * vectors[RESIDUAL, i] + a1 * vectors[RESIDUAL + 1, i] + a2 * vectors[RESIDUAL + 2, i]
            )
        solve_in_chart(PROJECTION, RESIDUAL2 + k, run)
    for k in range(3):
        a0, a1, a2 = INVERSE[k][0] / h, INVERSE[k][1] / h, INVERSE[k][2] / h
        b0, b1, b2 = h * W[k][0], h * W[k][1], h * W[k][2]
        for i in range(n + m):
            w0, w1, w2 = vectors[RESIDUAL2, i], vectors[RESIDUAL2 + 1, i], vectors[RESIDUAL2 + 2, i]
            vectors[STAGE + k, i] += vectors[CHANGE + k, i] - (a0 * w0 + a1 * w1 + a2 * w2)
            vectors[STAGE2 + k, i] += vectors[RESIDUAL2 + k, i]
        for i in range(n + m, size):
            vectors[STAGE + k, i] += vectors[CHANGE + k, i]
        for i in range(n):
            e = b0 * vectors[CHANGE, i] + b1 * vectors[CHANGE + 1, i] + b2 * vectors[CHANGE + 2, i]
            vectors[DV + k, i] = e - vectors[RESIDUAL2 + k, i]
    if has_entries(DAMPING, run):
        couple(h, run)
    for k in range(3):
        for i in range(n):
            largest = larger(unit * abs(vectors[DV + k, i]) * vectors[L.SCALE, i], largest)
    return largest


@kernel
def solve_in_chart(k, row, run):
    """``solve`` for a row with forces on psi, which becomes a change of psi; T is that at POSITION."""
    out_of_chart(row, run)
    solve(k, row, run)
    to_rates(row, run)


@kernel
def solve_complex(k, real, imag, run):
    """The same with the complex matrix in the matrices k and k + 1, for the rows ``real`` + i ``imag``."""
    vectors, matrices = run.vectors, run.matrices
    for row in (real, imag):
        out_of_chart(row, run)
        to_world(row, run)
    complex_solve(matrices[k], matrices[k + 1], run.pivots[k], run.layout, vectors[real], vectors[imag])
    for row in (real, imag):
        to_body(row, run)
        to_rates(row, run)


@kernel
def solve_stages(h, run):
    """e and kappa of all stages, in CHANGE, from the residuals."""
    vectors, layout = run.vectors, run.layout
    n, m, size = layout[L.N_Q], layout[L.N_PHI], layout[L.N_ALL]
    transform(0, n, h, 0, run)
    transform(n, n + m, h, 2, run)
    transform(n + m, size, h, 1, run)
    solve_in_chart(0, CHANGE, run)
    solve_complex(COMPLEX, CHANGE + 1, CHANGE + 2, run)
    for i in range(size):
        u, v, w = vectors[CHANGE, i], 2.0 * vectors[CHANGE + 1, i], 2.0 * vectors[CHANGE + 2, i]
        for k in range(3):
            vectors[CHANGE + k, i] = R_REAL[k] * u + R_RE[k] * v - R_IM[k] * w


@rare
def couple(h, run):
    """Correct a for dw, in RESIDUAL2, by D and Gam_v."""
    vectors, layout = run.vectors, run.layout
    for k in range(3):
        for i in range(layout[L.N_ALL]):
            vectors[ERROR, i], vectors[RESIDUAL + k, i], vectors[RESIDUAL2 + k, i] = (
                -vectors[RESIDUAL2 + k, i],
                0.0,
                0.0,
            )
        from_rates(vectors[L.POSITION], vectors[ERROR], run)
        multiply(DAMPING, ERROR, RESIDUAL + k, run)
        into_chart(RESIDUAL + k, run)
    solve_stages(h, run)
    for k in range(3):
        for i in range(layout[L.N_ALL]):
            vectors[STAGE + k, i] += vectors[CHANGE + k, i]
        b0, b1, b2 = h * W[k][0], h * W[k][1], h * W[k][2]
        for i in range(layout[L.N_Q]):
            vectors[DV + k, i] += b0 * vectors[CHANGE, i] + b1 * vectors[CHANGE + 1, i] + b2 * vectors[CHANGE + 2, i]


@rare
def estimate(h, speed, run):
    """The error of the embedded formula of order 3: the largest of scaled q, and of scaled v relative to ``speed``.

    It is filtered by (1 - s J)^-1 with the real s and the Jacobian J of the constrained equations of motion, which
    removes stiff components.
    """
    vectors, numbers, layout = run.vectors, run.numbers, run.layout
    n, s = layout[L.N_Q], REAL * h
    for i in range(n):
        a, b, c = vectors[STAGE, i], vectors[STAGE + 1, i], vectors[STAGE + 2, i]
        w = E1[0] * vectors[STAGE2, i] + E1[1] * vectors[STAGE2 + 1, i] + E1[2] * vectors[STAGE2 + 2, i]
        vectors[ERROR, i] = h * (h * (E2[0] * a + E2[1] * b + E2[2] * c) + w)
        vectors[CHANGE, i] = h * (REAL * vectors[L.UNKNOWN0, i] + E1[0] * a + E1[1] * b + E1[2] * c)
    from_rates(vectors[L.POSITION], vectors[ERROR], run)
    from_rates(vectors[L.POSITION], vectors[CHANGE], run)
    for i in range(layout[L.N_ALL]):
        vectors[ERROR2, i], vectors[L.MX, i] = 0.0, 0.0
    multiply(COUPLING, ERROR, ERROR2, run)
    if layout[L.MASS_KIND] > 0:
        inertia(L.TIMES, CHANGE, L.MX, run)
    for i in range(n):
        vectors[CHANGE, i] = (
            numbers[layout[L.MASS] + i] * vectors[CHANGE, i] + vectors[L.MX, i] - s * vectors[ERROR2, i]
        )
    for i in range(n, n + layout[L.N_PHI]):
        vectors[CHANGE, i] = 0.0
    for i in range(n + layout[L.N_PHI], layout[L.N_ALL]):
        vectors[CHANGE, i] = -vectors[ERROR2, i]
    solve(0, CHANGE, run)
    largest = 0.0
    for i in range(n):
        of_q, of_v = vectors[ERROR, i] + s * vectors[CHANGE, i], vectors[CHANGE, i]
        largest = larger(max(abs(of_q), abs(of_v) / speed) * vectors[L.SCALE, i], largest)
    return largest
