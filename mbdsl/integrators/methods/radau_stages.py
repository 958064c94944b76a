"""The stages of a step of Radau IIA with any odd number s of stages: iteration matrices, corrections, error estimate.

The equations are those of :mod:`mbdsl.integrators.methods.radau5_stages`, with i = 1 ... s, and one real and (s - 1)/2
complex eigenvalues. With three stages, the kernels there take two thirds of the time of these.

v within a step is the polynomial of degree s of the stages, with an error of the order h^{s+1}. It is larger than the
error at the ends of steps, and the tolerance of the embedded formula is proportional to that of the result.
"""

from __future__ import annotations

from mbdsl.integrators.loop import loop_state as S
from mbdsl.integrators.loop.complex_lu import complex_factor
from mbdsl.integrators.loop.linear_solve import compress, factor, has_entries, larger, multiply, solve
from mbdsl.integrators.loop.rotation_chart import from_chart, from_rates, into_chart, to_second_rates
from mbdsl.integrators.loop.run_data import evaluate, inertia
from mbdsl.integrators.loop.tangent_matrices import iteration_matrix, projection_matrix, tangent_matrix
from mbdsl.integrators.methods.radau5_stages import (
    COMPLEX,
    COUPLING,
    DAMPING,
    ERROR,
    ERROR2,
    METRIC,
    PROJECTION,
    QB,
    VB,
    prepare_damping,
    solve_complex,
    solve_in_chart,
)
from mbdsl.integrators.methods.radau_coefficients import (
    BACK,
    E1,
    E2,
    EIGENVALUES,
    FIT,
    INTEGRALS,
    INVERSE,
    MOST,
    NODES,
    SQUARE,
    THERE,
)
from mbdsl.integrators.methods.radau_coefficients import A as W
from mbdsl.kernels import buffer_layout as L
from mbdsl.kernels.marks import kernel, rare

#: flexibility of soft constraints, relative to the square of the motion in a step over the least mass
SOFTNESS = 10.0
#: rows of the first stage, those of the others follow at distances of STAGE_ROWS: unknowns [a; lam; nu] and
#: [w; mu; 0], their residuals [R1; R3; R5] and [R2; R4; 0], corrections in the eigenvectors and of the stages,
#: corrections of v, and the unknowns in the last step
STAGE, STAGE2, RESIDUAL, RESIDUAL2, SPECTRUM, CHANGE, DV, PAST, PAST2 = range(L.ROWS + 5, L.ROWS + 14)
STAGE_ROWS = 9


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
def predict(ratio, degree, h, run):
    """The stages extrapolated by the polynomials of the last step; ``ratio``: of the new to the last step length.

    With ``degree`` 2, accelerations and multipliers are those of the parabola that fits the stages of the last step
    best: a polynomial of high degree magnifies what the iteration has left in them. With 0 they are those at the start
    of the step; if it is negative, accelerations are zero.
    """
    vectors, layout, c, stages = run.vectors, run.layout, run.coefficients, count(run)
    shrunk = 1.0
    for _ in range(stages):
        shrunk *= ratio
    for k in range(stages):
        stage, stage2, past2 = STAGE + STAGE_ROWS * k, STAGE2 + STAGE_ROWS * k, PAST2 + STAGE_ROWS * k
        if degree > 0:
            x = 1.0 + c[NODES + k] * ratio
            clear_row(stage, 0, layout[L.N_ALL], run)
            for p in range(stages):
                top, bottom = 1.0, 1.0
                for q in range(stages):
                    if q != p:
                        top *= x - c[NODES + q]
                        bottom *= c[NODES + p] - c[NODES + q]
                weight, past = top / bottom, PAST + STAGE_ROWS * p
                if degree == 2:
                    weight = c[FIT + p] + x * (c[FIT + MOST + p] + x * c[FIT + 2 * MOST + p])
                for i in range(layout[L.N_ALL]):
                    vectors[stage, i] += weight * vectors[past, i]
            for i in range(layout[L.N_ALL]):
                vectors[stage2, i] = shrunk * vectors[past2, i] if degree > 2 else 0.0
        else:
            for i in range(layout[L.N_ALL]):
                vectors[stage, i], vectors[stage2, i] = vectors[L.UNKNOWN0, i], 0.0
            if degree < 0:
                clear_row(stage, 0, layout[L.N_Q], run)
    if layout[L.N_ROTATIONS] > 0:
        for k in range(stages):
            motion(k, h, run)
            to_second_rates(STAGE + STAGE_ROWS * k, run)


@kernel
def motion(k, h, run):
    """q and v at stage k, and its unknowns in the rows that evaluations read."""
    vectors, layout = run.vectors, run.layout
    n, c, stage = layout[L.N_Q], h * run.coefficients[NODES + k], STAGE + STAGE_ROWS * k
    for i in range(n):
        vectors[L.VELOCITY, i] = vectors[L.VELOCITY0, i]
        vectors[L.POSITION, i] = vectors[L.POSITION0, i] + c * vectors[L.VELOCITY0, i]
        vectors[ERROR, i] = 0.0
    add(W + MOST * k, h, 1.0, STAGE, L.VELOCITY, 0, n, run)
    add(SQUARE + MOST * k, h * h, 1.0, STAGE, L.POSITION, 0, n, run)
    add(W + MOST * k, h, 1.0, STAGE2, ERROR, 0, n, run)
    for i in range(n):
        vectors[L.POSITION, i] += vectors[ERROR, i]
    for i in range(layout[L.N_ALL]):
        vectors[L.UNKNOWN, i], vectors[L.UNKNOWN2, i] = vectors[stage, i], vectors[stage + 1, i]
    from_chart(run)


@kernel
def residual(k, run):
    """Residuals of stage k, as evaluated."""
    vectors, numbers, layout = run.vectors, run.numbers, run.layout
    n, m, first, second = layout[L.N_Q], layout[L.N_PHI], RESIDUAL + STAGE_ROWS * k, RESIDUAL2 + STAGE_ROWS * k
    for i in range(n):
        mass = numbers[layout[L.MASS] + i]
        vectors[first, i] = mass * vectors[L.UNKNOWN, i] + vectors[L.MX, i] - vectors[L.FORCE, i]
        vectors[second, i] = (
            (mass + vectors[METRIC, i]) * vectors[L.UNKNOWN2, i] + vectors[L.MX2, i] + vectors[L.FORCE2, i]
        )
    for i in range(n, n + m):
        vectors[first, i], vectors[second, i] = vectors[L.FORCE, i], vectors[L.FORCE2, i]
    for i in range(n + m, layout[L.N_ALL]):
        vectors[first, i], vectors[second, i] = vectors[L.FORCE, i], 0.0
    into_chart(first, run)
    into_chart(second, run)


@kernel
def residuals(t, h, run):
    """Residuals of all stages of a step from t; the middle one last, as the matrices are evaluated there."""
    stages = count(run)
    for k in range(1, stages + 1):
        stage = (stages // 2 + k) % stages
        motion(stage, h, run)
        run.layout[L.NEW_MASS] = 1
        evaluate(t + run.coefficients[NODES + stage] * h, run)
        residual(stage, run)


@rare
def constraint_size(run):
    """Largest violation of the constraints on positions, in all stages."""
    vectors, layout = run.vectors, run.layout
    value = 0.0
    for k in range(count(run)):
        for i in range(layout[L.N_Q], layout[L.N_Q] + layout[L.N_PHI]):
            value = max(value, abs(vectors[RESIDUAL + STAGE_ROWS * k, i]))
    return value


@kernel
def finish(h, run):
    """q and v at the end of the step, and its unknowns."""
    motion(count(run) - 1, h, run)


@rare
def soften(k, h, run):
    """If SOFT, subtract a flexibility from the diagonal of matrix k in the rows of constraints.

    All stages are corrected with one matrix. In a step over a singular pose, the Jacobian of the constraints along the
    direction that becomes free there has one sign in the first stages and the other one in the last: corrections with
    either sign make the errors of some stages larger. With a flexibility of the square of the motion in a step, over
    the least mass, this direction is hardly corrected, and its motion is that of the prediction.
    """
    vectors, numbers, layout, matrix = run.vectors, run.numbers, run.layout, run.matrices[k]
    if run.integers[S.SOFT] == 0:
        return
    least, speed = 1e300, 0.0
    for i in range(layout[L.N_Q]):
        mass = numbers[layout[L.MASS] + i] * vectors[L.SCALE, i] * vectors[L.SCALE, i]
        if mass > 0.0:
            least = min(least, mass)
        speed = max(speed, abs(vectors[L.VELOCITY0, i]) * vectors[L.SCALE, i])
    for r in range(layout[L.N_PHI]):
        o = layout[L.PAIRS] + L.PAIR * r
        if layout[o + L.LEFT_OUT] == 0:
            matrix[layout[layout[L.SLOTS] + layout[o + L.SLOT]]] -= SOFTNESS * (speed * h) ** 2 / least


@rare
def matrices(start, h, still, run):
    """All matrices of a step from ``start``, at the state last evaluated, factorised; False if that failed. ``still``:
    acceptable error of scaled velocities."""
    t = start + run.coefficients[NODES + count(run) // 2] * h
    vectors, layout, matrices, c, good = run.vectors, run.layout, run.matrices, run.coefficients, True
    s = c[EIGENVALUES] * h
    iteration_matrix(0, t, run, M=1.0, K=s * s, D=s, Mx_q=s * s, Gam_q=s)
    projection_matrix(PROJECTION, t, run, M=1.0)
    for i in range(layout[L.N_Q]):
        matrices[PROJECTION, layout[layout[L.SLOTS] + layout[L.MASS_SLOTS] + i]] += vectors[METRIC, i]
    tangent_matrix(COUPLING, t, run, K=1.0, Mx_q=1.0, N=1.0, Gam_q=1.0)
    compress(COUPLING, run)
    for p in range(1, count(run), 2):
        x, y, real, imag = c[EIGENVALUES + p] * h, c[EIGENVALUES + p + 1] * h, COMPLEX + p - 1, COMPLEX + p
        k, l = x * x - y * y, 2.0 * x * y
        iteration_matrix(real, t, run, M=1.0, K=k, D=x, Mx_q=k, Gam_q=x)
        # the imaginary part is the difference of these two
        iteration_matrix(imag, t, run, M=1.0, K=k + l, D=x + y, Mx_q=k + l, Gam_q=x + y)
        soften(real, h, run)
        soften(imag, h, run)
        for i in range(layout[L.SIZE]):
            matrices[imag, i] -= matrices[real, i]
        good = good and complex_factor(matrices[real], matrices[imag], run.pivots[real], layout)
    soften(0, h, run)
    soften(PROJECTION, h, run)
    prepare_damping(t, s, still, run)
    return good and factor(0, run) and factor(PROJECTION, run)


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
    n, m, size = layout[L.N_Q], layout[L.N_PHI], layout[L.N_ALL]
    solve_stages(h, run)
    largest = 0.0
    for k in range(stages):
        row = RESIDUAL2 + STAGE_ROWS * k
        clear_row(ERROR, 0, n + m, run)
        clear_row(ERROR2, n, size, run)
        add(SQUARE + MOST * k, h * h, 1.0, CHANGE, ERROR, 0, n, run)
        add(INVERSE + MOST * k, 1.0, h, RESIDUAL, ERROR, n, n + m, run)
        for i in range(n):
            largest = larger(abs(vectors[ERROR, i]) * vectors[L.SCALE, i], largest)
        from_rates(vectors[L.POSITION], vectors[ERROR], run)
        multiply(COUPLING, ERROR, ERROR2, run)
        for i in range(n):
            vectors[row, i] = -vectors[row, i]
        for i in range(n, n + m):
            vectors[row, i] += vectors[ERROR2, i]
            vectors[row, i] -= vectors[ERROR, i]
        solve_in_chart(PROJECTION, row, run)
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
            largest = larger(unit * abs(vectors[dv, i]) * vectors[L.SCALE, i], largest)
    return largest


@kernel
def solve_stages(h, run):
    """e and kappa of all stages, in CHANGE, from the residuals."""
    layout = run.layout
    n, m, size = layout[L.N_Q], layout[L.N_PHI], layout[L.N_ALL]
    transform(0, n, h, 0, run)
    transform(n, n + m, h, 2, run)
    transform(n + m, size, h, 1, run)
    solve_in_chart(0, SPECTRUM, run)
    for j in range(1, count(run), 2):
        real, row = COMPLEX + j - 1, SPECTRUM + STAGE_ROWS * j
        solve_complex(real, row, row + STAGE_ROWS, run)
    for k in range(count(run)):
        change = CHANGE + STAGE_ROWS * k
        clear_row(change, 0, size, run)
        add(BACK + MOST * k, 1.0, 1.0, SPECTRUM, change, 0, size, run)


@rare
def couple(h, run):
    """Correct a for dw, in RESIDUAL2, by D and Gam_v."""
    vectors, layout, stages = run.vectors, run.layout, count(run)
    n = layout[L.N_Q]
    for k in range(stages):
        first, second = RESIDUAL + STAGE_ROWS * k, RESIDUAL2 + STAGE_ROWS * k
        for i in range(layout[L.N_ALL]):
            vectors[ERROR, i], vectors[first, i], vectors[second, i] = -vectors[second, i], 0.0, 0.0
        from_rates(vectors[L.POSITION], vectors[ERROR], run)
        multiply(DAMPING, ERROR, first, run)
        into_chart(first, run)
    solve_stages(h, run)
    for k in range(stages):
        stage, change, dv = STAGE + STAGE_ROWS * k, CHANGE + STAGE_ROWS * k, DV + STAGE_ROWS * k
        for i in range(layout[L.N_ALL]):
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
    n, s = layout[L.N_Q], real * h
    for i in range(n):
        vectors[ERROR, i], vectors[ERROR2, i], vectors[CHANGE, i] = 0.0, 0.0, real * vectors[L.UNKNOWN0, i]
    add(E1, 1.0, 1.0, STAGE2, ERROR, 0, n, run)
    add(E2, 1.0, 1.0, STAGE, ERROR2, 0, n, run)
    add(E1, 1.0, 1.0, STAGE, CHANGE, 0, n, run)
    for i in range(n):
        vectors[ERROR, i] = h * (h * vectors[ERROR2, i] + vectors[ERROR, i])
        vectors[CHANGE, i] = h * vectors[CHANGE, i]
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


# -- output and history -----------------------------------------------------------------------------------------------


@rare
def interpolate(k, x, h, out, run):
    """q and v by the polynomials of the stages: v of degree s, q of degree s + 1."""
    vectors, c, n, stages = run.vectors, run.coefficients, run.layout[L.N_Q], count(run)
    for i in range(n):
        out[k, i] = vectors[L.POSITION0, i] + x * h * vectors[L.VELOCITY0, i]
        out[k, n + i] = vectors[L.VELOCITY0, i]
    for j in range(stages):
        once, twice = 0.0, 0.0
        for p in range(stages - 1, -1, -1):
            once = x * (once + c[INTEGRALS + MOST * j + p])
            twice = x * (twice + c[INTEGRALS + MOST * j + p] / (p + 2))
        once, twice, stage = h * once, h * h * x * twice, STAGE + STAGE_ROWS * j
        for i in range(n):
            out[k, n + i] += once * vectors[stage, i]
            out[k, i] += twice * vectors[stage, i] + once * vectors[stage + 1, i]
    from_rates(out[k], out[k, n:], run)


@kernel
def store(h, run):
    """Store the step as the last one."""
    reals, vectors, layout, stages = run.reals, run.vectors, run.layout, count(run)
    for k in range(stages):
        at, source = STAGE_ROWS * k, STAGE + STAGE_ROWS * k
        if layout[L.N_ROTATIONS] > 0:
            motion(k, h, run)
            source = L.UNKNOWN
        for i in range(layout[L.N_ALL]):
            vectors[PAST + at, i], vectors[PAST2 + at, i] = vectors[source, i], vectors[STAGE2 + at, i]
    for i in range(layout[L.N_Q]):
        vectors[QB, i], vectors[VB, i], vectors[L.POSITION0, i], vectors[L.VELOCITY0, i] = (
            vectors[L.POSITION0, i],
            vectors[L.VELOCITY0, i],
            vectors[L.POSITION, i],
            vectors[L.VELOCITY, i],
        )
    last = PAST + STAGE_ROWS * (stages - 1)
    for i in range(layout[L.N_ALL]):
        vectors[L.UNKNOWN0 + 1, i], vectors[L.UNKNOWN0, i] = vectors[last - STAGE_ROWS, i], vectors[last, i]
    if reals[S.TOL] > 0.0:
        reals[S.NODES], reals[S.NODES + 1] = reals[S.STEP_END], reals[S.NOW] + run.coefficients[NODES + stages - 2] * h
