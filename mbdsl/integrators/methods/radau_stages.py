"""The stages of a step of Radau IIA: equations, iteration matrices, corrections, error estimate.

The unknowns of the stages i = 1 ... s at t_i are a_i = v', w_i = q' - v, lam_i, nu_i and mu_i. With the matrix A of
Radau IIA and f = Q - Phi_q^T lam - Gam_v^T nu, their equations are

    V = v_n + h A a,   Q = q_n + h A (V + w)
    R1:  M a_i - f_i = 0
    R2:  G w_i + Phi_q^T mu_i = 0
    R3:  Phi(Q_i, t_i) = 0
    R4:  Phi_q V_i + Phi_t = 0
    R5:  Gam(V_i, Q_i, t_i) = 0

G is M, with a small positive entry for each coordinate without mass. Newton's equations are decoupled, so that no
system of s or 2 s times the size is solved. Let e = (h A)^-2 dQ, so that da = e - (h A)^-1 dw, and
kappa = dlam + (h A)^-1 dmu. In the eigenvectors of h A, for each eigenvalue s (one real, the others complex
pairs), with
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
"""

from __future__ import annotations

from mbdsl.compilation.buffer_layout import (
    FORCE,
    FORCE2,
    MASS,
    MASS_KIND,
    MASS_SLOTS,
    MX,
    MX2,
    N_ALL,
    N_GAM,
    N_PHI,
    N_Q,
    POSITION,
    POSITION0,
    ROWS,
    SCALE,
    SIZE,
    SLOTS,
    TIMES,
    UNKNOWN,
    UNKNOWN0,
    UNKNOWN2,
    VELOCITY,
    VELOCITY0,
)
from mbdsl.compilation.marks import kernel, rare
from mbdsl.integrators.loop.complex_lu import complex_factor, complex_solve
from mbdsl.integrators.loop.linear_solve import clear, compress, factor, has_entries, larger, multiply, solve
from mbdsl.integrators.loop.newton import EPS
from mbdsl.integrators.loop.run_data import inertia
from mbdsl.integrators.loop.tangent_matrices import iteration_matrix, projection_matrix, tangent_matrix
from mbdsl.integrators.methods.radau_coefficients import (
    BACK,
    E1,
    E2,
    EIGENVALUES,
    INVERSE,
    MOST,
    NODES,
    SQUARE,
    THERE,
)
from mbdsl.integrators.methods.radau_coefficients import A as W

#: own rows of ``vectors``: two for intermediate results; G of the coordinates without mass, otherwise 0; q and v at the
#: start of the last step
ERROR, ERROR2, METRIC, QB, VB = range(ROWS, ROWS + 5)
#: rows of the first stage, those of the others follow at distances of STAGE_ROWS: unknowns [a; lam; nu] and
#: [w; mu; 0], their residuals [R1; R3; R5] and [R2; R4; 0], corrections in the eigenvectors and of the stages,
#: corrections of v, and the unknowns in the last step
STAGE, STAGE2, RESIDUAL, RESIDUAL2, SPECTRUM, CHANGE, DV, PAST, PAST2 = range(ROWS + 5, ROWS + 14)
STAGE_ROWS = 9
#: matrices: that of the real s (0); the projection; [K'; N; Gam_q] in the columns of q; [D; 0; Gam_v], empty if
#: negligible; real and imaginary part of that of each complex s
PROJECTION, COUPLING, DAMPING, COMPLEX = 1, 2, 3, 4
#: share of the dampers in the diagonal of the matrix above which [D; 0; Gam_v] is not negligible
DAMPED = 0.02
#: G of a coordinate without mass, relative to the largest mass
MASSLESS = 1e-6


def own_rows(stages):
    """The number of own rows of ``vectors``."""
    return 5 + STAGE_ROWS * stages


def own_matrices(stages):
    """The number of matrices."""
    return COMPLEX + stages - 1


@kernel
def count(run):
    """The number of stages, which is that of the matrices less three."""
    return run.matrices.shape[0] - COMPLEX + 1


@kernel
def add(weights, up, down, source, target, first, last, run):
    """Add the rows ``source`` of all stages, with their weights times ``up`` over ``down``, to row ``target``."""
    vectors, c = run.vectors, run.coefficients
    for j in range(count(run)):
        weight, row = up * c[weights + j] / down, source + STAGE_ROWS * j
        for i in range(first, last):
            vectors[target, i] += weight * vectors[row, i]


@kernel
def clear_row(row, first, last, run):
    """Set entries of a row to zero."""
    vectors = run.vectors
    for i in range(first, last):
        vectors[row, i] = 0.0


@rare
def set_metric(run):
    """Set row METRIC: G of the coordinates without mass."""
    vectors, numbers, layout = run.vectors, run.numbers, run.layout
    largest = 0.0
    for i in range(layout[N_Q]):
        largest = max(largest, numbers[layout[MASS] + i] * vectors[SCALE, i] * vectors[SCALE, i])
    for i in range(layout[N_Q]):
        vectors[METRIC, i] = 0.0
        if not numbers[layout[MASS] + i] > 0.0:
            vectors[METRIC, i] = (
                MASSLESS * (largest if largest > 0.0 else 1.0) / (vectors[SCALE, i] * vectors[SCALE, i])
            )


@rare
def predict(ratio, steps_behind, run):
    """The stages extrapolated by the polynomials of the last step; ``ratio``: of the new to the last step length.

    With ``steps_behind`` = 0, accelerations and multipliers are those at the start of the step; if it is negative,
    accelerations are zero.
    """
    vectors, layout, c, stages = run.vectors, run.layout, run.coefficients, count(run)
    shrunk = 1.0
    for _ in range(stages):
        shrunk *= ratio
    for k in range(stages):
        stage, stage2, past2 = STAGE + STAGE_ROWS * k, STAGE2 + STAGE_ROWS * k, PAST2 + STAGE_ROWS * k
        if steps_behind > 0:
            x = 1.0 + c[NODES + k] * ratio
            clear_row(stage, 0, layout[N_ALL], run)
            for p in range(stages):
                top, bottom = 1.0, 1.0
                for q in range(stages):
                    if q != p:
                        top *= x - c[NODES + q]
                        bottom *= c[NODES + p] - c[NODES + q]
                weight, past = top / bottom, PAST + STAGE_ROWS * p
                for i in range(layout[N_ALL]):
                    vectors[stage, i] += weight * vectors[past, i]
            for i in range(layout[N_ALL]):
                vectors[stage2, i] = shrunk * vectors[past2, i]
        else:
            for i in range(layout[N_ALL]):
                vectors[stage, i], vectors[stage2, i] = vectors[UNKNOWN0, i], 0.0
            if steps_behind < 0:
                clear_row(stage, 0, layout[N_Q], run)


@kernel
def motion(k, h, run):
    """q and v at stage k, and its unknowns in the rows that evaluations read."""
    vectors, layout = run.vectors, run.layout
    n, c, stage = layout[N_Q], h * run.coefficients[NODES + k], STAGE + STAGE_ROWS * k
    for i in range(n):
        vectors[VELOCITY, i] = vectors[VELOCITY0, i]
        vectors[POSITION, i] = vectors[POSITION0, i] + c * vectors[VELOCITY0, i]
        vectors[ERROR, i] = 0.0
    add(W + MOST * k, h, 1.0, STAGE, VELOCITY, 0, n, run)
    add(SQUARE + MOST * k, h * h, 1.0, STAGE, POSITION, 0, n, run)
    add(W + MOST * k, h, 1.0, STAGE2, ERROR, 0, n, run)
    for i in range(n):
        vectors[POSITION, i] += vectors[ERROR, i]
    for i in range(layout[N_ALL]):
        vectors[UNKNOWN, i], vectors[UNKNOWN2, i] = vectors[stage, i], vectors[stage + 1, i]


@kernel
def residual(k, run):
    """Residuals of stage k, as evaluated."""
    vectors, numbers, layout = run.vectors, run.numbers, run.layout
    n, m, first, second = layout[N_Q], layout[N_PHI], RESIDUAL + STAGE_ROWS * k, RESIDUAL2 + STAGE_ROWS * k
    for i in range(n):
        mass = numbers[layout[MASS] + i]
        vectors[first, i] = mass * vectors[UNKNOWN, i] + vectors[MX, i] - vectors[FORCE, i]
        vectors[second, i] = (mass + vectors[METRIC, i]) * vectors[UNKNOWN2, i] + vectors[MX2, i] + vectors[FORCE2, i]
    for i in range(n, n + m):
        vectors[first, i], vectors[second, i] = vectors[FORCE, i], vectors[FORCE2, i]
    for i in range(n + m, layout[N_ALL]):
        vectors[first, i], vectors[second, i] = vectors[FORCE, i], 0.0


@rare
def matrices(t, h, still, run):
    """All matrices at the state last evaluated, factorised; False if that failed. ``still``: acceptable error of scaled
    velocities."""
    vectors, layout, matrices, c, good = run.vectors, run.layout, run.matrices, run.coefficients, True
    s = c[EIGENVALUES] * h
    iteration_matrix(0, t, run, M=1.0, K=s * s, D=s, Mx_q=s * s, Gam_q=s)
    projection_matrix(PROJECTION, t, run, M=1.0)
    for i in range(layout[N_Q]):
        matrices[PROJECTION, layout[layout[SLOTS] + layout[MASS_SLOTS] + i]] += vectors[METRIC, i]
    tangent_matrix(COUPLING, t, run, K=1.0, Mx_q=1.0, N=1.0, Gam_q=1.0)
    compress(COUPLING, run)
    for p in range(1, count(run), 2):
        x, y, real, imag = c[EIGENVALUES + p] * h, c[EIGENVALUES + p + 1] * h, COMPLEX + p - 1, COMPLEX + p
        k, l = x * x - y * y, 2.0 * x * y
        iteration_matrix(real, t, run, M=1.0, K=k, D=x, Mx_q=k, Gam_q=x)
        # the imaginary part is the difference of these two
        iteration_matrix(imag, t, run, M=1.0, K=k + l, D=x + y, Mx_q=k + l, Gam_q=x + y)
        for i in range(layout[SIZE]):
            matrices[imag, i] -= matrices[real, i]
        good = good and complex_factor(matrices[real], matrices[imag], run.pivots[real], layout)
    prepare_damping(t, s, still, run)
    return good and factor(0, run) and factor(PROJECTION, run)


@rare
def prepare_damping(t, s, still, run):
    """The matrix of D and Gam_v, empty if negligible.

    It matters for arbitrarily short steps, too: rounding of positions divided by h is in w, and D h times that in v.
    """
    layout, matrices = run.layout, run.matrices
    tangent_matrix(DAMPING, t, run, D=1.0, Gam_v=1.0)
    matters = layout[N_GAM] > 0
    for i in range(layout[N_Q]):
        slot = layout[layout[SLOTS] + layout[MASS_SLOTS] + i]
        d, a = abs(matrices[DAMPING, slot]), abs(matrices[0, slot])
        matters = matters or s * d > DAMPED * a or 10.0 * EPS * d > still * a
    if matters:
        compress(DAMPING, run)
    else:
        clear(DAMPING, run)


@kernel
def transform(first, last, h, rank, run):
    """SPECTRUM = -R/s^rank (rank 0: -R - R2/s) in the eigenvectors: the real, then real and imaginary part of complex
    ones."""
    vectors, c = run.vectors, run.coefficients
    for j in range(count(run)):
        row = SPECTRUM + STAGE_ROWS * j
        clear_row(row, first, last, run)
        add(THERE + MOST * j, 1.0, 1.0, RESIDUAL, row, first, last, run)
    s = 1.0 / (c[EIGENVALUES] * h)
    if rank > 0:
        p = s if rank == 1 else s * s
        for i in range(first, last):
            vectors[SPECTRUM, i] = -(p * vectors[SPECTRUM, i])
    else:
        clear_row(ERROR, first, last, run)
        add(THERE, 1.0, 1.0, RESIDUAL2, ERROR, first, last, run)
        for i in range(first, last):
            vectors[SPECTRUM, i] = -(vectors[SPECTRUM, i] + s * vectors[ERROR, i])
    for j in range(1, count(run), 2):
        re, im, real = c[EIGENVALUES + j], c[EIGENVALUES + j + 1], SPECTRUM + STAGE_ROWS * j
        imag, size = real + STAGE_ROWS, h * (re * re + im * im)
        x, y = re / size, -im / size  # 1/s
        if rank > 0:
            q, r = (x, y) if rank == 1 else (x * x - y * y, 2.0 * x * y)
            for i in range(first, last):
                v, w = vectors[real, i], vectors[imag, i]
                vectors[real, i], vectors[imag, i] = -(q * v - r * w), -(q * w + r * v)
        else:
            clear_row(ERROR, first, last, run)
            clear_row(ERROR2, first, last, run)
            add(THERE + MOST * j, 1.0, 1.0, RESIDUAL2, ERROR, first, last, run)
            add(THERE + MOST * (j + 1), 1.0, 1.0, RESIDUAL2, ERROR2, first, last, run)
            for i in range(first, last):
                f, g = vectors[ERROR, i], vectors[ERROR2, i]
                vectors[real, i] = -(vectors[real, i] + x * f - y * g)
                vectors[imag, i] = -(vectors[imag, i] + x * g + y * f)


@kernel
def correct(h, unit, run):
    """Solve for the corrections, apply them; the largest scaled change of a position or ``unit`` times a velocity."""
    vectors, layout, stages = run.vectors, run.layout, count(run)
    n, m, size = layout[N_Q], layout[N_PHI], layout[N_ALL]
    solve_stages(h, run)
    largest = 0.0
    for k in range(stages):
        row = RESIDUAL2 + STAGE_ROWS * k
        clear_row(ERROR, 0, n + m, run)
        clear_row(ERROR2, n, size, run)
        add(SQUARE + MOST * k, h * h, 1.0, CHANGE, ERROR, 0, n, run)
        add(INVERSE + MOST * k, 1.0, h, RESIDUAL, ERROR, n, n + m, run)
        for i in range(n):
            largest = larger(abs(vectors[ERROR, i]) * vectors[SCALE, i], largest)
        multiply(COUPLING, ERROR, ERROR2, run)
        for i in range(n):
            vectors[row, i] = -vectors[row, i]
        for i in range(n, n + m):
            vectors[row, i] += vectors[ERROR2, i]
            vectors[row, i] -= vectors[ERROR, i]
        solve(PROJECTION, row, run)
    for k in range(stages):
        stage, change, w = STAGE + STAGE_ROWS * k, CHANGE + STAGE_ROWS * k, RESIDUAL2 + STAGE_ROWS * k
        dv = DV + STAGE_ROWS * k
        clear_row(ERROR, 0, n + m, run)
        clear_row(dv, 0, n, run)
        add(INVERSE + MOST * k, 1.0, h, RESIDUAL2, ERROR, 0, n + m, run)
        add(W + MOST * k, h, 1.0, CHANGE, dv, 0, n, run)
        for i in range(n + m):
            vectors[stage, i] += vectors[change, i] - vectors[ERROR, i]
            vectors[stage + 1, i] += vectors[w, i]
        for i in range(n + m, size):
            vectors[stage, i] += vectors[change, i]
        for i in range(n):
            vectors[dv, i] -= vectors[w, i]
    if has_entries(DAMPING, run):
        couple(h, run)
    for k in range(stages):
        dv = DV + STAGE_ROWS * k
        for i in range(n):
            largest = larger(unit * abs(vectors[dv, i]) * vectors[SCALE, i], largest)
    return largest


@kernel
def solve_stages(h, run):
    """e and kappa of all stages, in CHANGE, from the residuals."""
    vectors, layout, matrices, pivots = run.vectors, run.layout, run.matrices, run.pivots
    n, m, size = layout[N_Q], layout[N_PHI], layout[N_ALL]
    transform(0, n, h, 0, run)
    transform(n, n + m, h, 2, run)
    transform(n + m, size, h, 1, run)
    solve(0, SPECTRUM, run)
    for j in range(1, count(run), 2):
        real, row = COMPLEX + j - 1, SPECTRUM + STAGE_ROWS * j
        complex_solve(matrices[real], matrices[real + 1], pivots[real], layout, vectors[row], vectors[row + STAGE_ROWS])
    for k in range(count(run)):
        change = CHANGE + STAGE_ROWS * k
        clear_row(change, 0, size, run)
        add(BACK + MOST * k, 1.0, 1.0, SPECTRUM, change, 0, size, run)


@rare
def couple(h, run):
    """Correct a for dw, in RESIDUAL2, by D and Gam_v."""
    vectors, layout, stages = run.vectors, run.layout, count(run)
    n = layout[N_Q]
    for k in range(stages):
        first, second = RESIDUAL + STAGE_ROWS * k, RESIDUAL2 + STAGE_ROWS * k
        for i in range(layout[N_ALL]):
            vectors[ERROR, i], vectors[first, i], vectors[second, i] = -vectors[second, i], 0.0, 0.0
        multiply(DAMPING, ERROR, first, run)
    solve_stages(h, run)
    for k in range(stages):
        stage, change, dv = STAGE + STAGE_ROWS * k, CHANGE + STAGE_ROWS * k, DV + STAGE_ROWS * k
        for i in range(layout[N_ALL]):
            vectors[stage, i] += vectors[change, i]
        clear_row(ERROR, 0, n, run)
        add(W + MOST * k, h, 1.0, CHANGE, ERROR, 0, n, run)
        for i in range(n):
            vectors[dv, i] += vectors[ERROR, i]


@rare
def estimate(h, speed, run):
    """The error of the embedded formula: the largest of scaled q, and of scaled v relative to ``speed``.

    It is filtered by (1 - s J)^-1 with the real s and the Jacobian J of the constrained equations of motion, which
    removes stiff components.
    """
    vectors, numbers, layout, real = run.vectors, run.numbers, run.layout, run.coefficients[EIGENVALUES]
    n, s = layout[N_Q], real * h
    for i in range(n):
        vectors[ERROR, i], vectors[ERROR2, i], vectors[CHANGE, i] = 0.0, 0.0, real * vectors[UNKNOWN0, i]
    add(E1, 1.0, 1.0, STAGE2, ERROR, 0, n, run)
    add(E2, 1.0, 1.0, STAGE, ERROR2, 0, n, run)
    add(E1, 1.0, 1.0, STAGE, CHANGE, 0, n, run)
    for i in range(n):
        vectors[ERROR, i] = h * (h * vectors[ERROR2, i] + vectors[ERROR, i])
        vectors[CHANGE, i] = h * vectors[CHANGE, i]
    for i in range(layout[N_ALL]):
        vectors[ERROR2, i], vectors[MX, i] = 0.0, 0.0
    multiply(COUPLING, ERROR, ERROR2, run)
    if layout[MASS_KIND] > 0:
        inertia(TIMES, CHANGE, MX, run)
    for i in range(n):
        vectors[CHANGE, i] = numbers[layout[MASS] + i] * vectors[CHANGE, i] + vectors[MX, i] - s * vectors[ERROR2, i]
    for i in range(n, n + layout[N_PHI]):
        vectors[CHANGE, i] = 0.0
    for i in range(n + layout[N_PHI], layout[N_ALL]):
        vectors[CHANGE, i] = -vectors[ERROR2, i]
    solve(0, CHANGE, run)
    largest = 0.0
    for i in range(n):
        of_q, of_v = vectors[ERROR, i] + s * vectors[CHANGE, i], vectors[CHANGE, i]
        largest = larger(max(abs(of_q), abs(of_v) / speed) * vectors[SCALE, i], largest)
    return largest
