"""The stages of a step of Radau IIA with an odd number s of stages: equations, matrices, corrections, error estimate.

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
kappa = dlam + (h A)^-1 dmu. In the eigenvectors of h A, for each eigenvalue s (one real, the others in complex pairs),
with S = M + s^2 K' + s D and K' = K + (M a)_q:

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

``R``, the coefficients and rows of a method (:class:`mbdsl.integrators.methods.radau_coefficients.Scheme`), is a
constant of the translation: sums over stages are unrolled.

v within a step is the polynomial of degree s of the stages, with an error of the order h^{s+1}. With more than three
stages it is larger than the error at the ends of steps, and the tolerance of the embedded formula is proportional to
that of the result.
"""

from mbdsl.integrators.loop import loop_state as S
from mbdsl.integrators.loop.linear_solve import has_entries, larger, multiply, solve
from mbdsl.integrators.loop.rotation_chart import (
    from_chart,
    from_rates,
    into_chart,
    to_second_rates,
)
from mbdsl.integrators.loop.run_data import evaluate, inertia
from mbdsl.integrators.methods.radau_coefficients import ERROR, ERROR2, METRIC, QB, VB
from mbdsl.integrators.methods.radau_matrices import COUPLING, DAMPING, PROJECTION, along, solve_in_chart, solve_stages
from mbdsl.kernels import buffer_layout as L
from mbdsl.kernels.marks import kernel, rare
from mbdsl.numerics.rotation import INVERSE_INERTIA

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
def predict(R, ratio, degree, h, run):
    """The stages extrapolated by the polynomials of the last step; ``ratio``: of the new to the last step length.

    With ``degree`` 2 and more than three stages, accelerations and multipliers are those of the parabola that fits the
    stages of the last step best: a polynomial of high degree magnifies what the iteration has left in them. Else with
    ``degree`` 0 or 2 they are those at the start of the step; if it is negative, accelerations are zero.
    """
    vectors, layout, shrunk = run.vectors, run.layout, 1.0
    for _ in R.each:
        shrunk *= ratio
    shrunk = shrunk if degree > 2 else 0.0
    for k in range(R.stages):
        x = 1.0 + R.nodes[k] * ratio
        if degree > 2 or (degree == 2 and R.stages > 3):
            weights = tuple(extrapolated(R, p, x) for p in R.each)
            if degree == 2:
                weights = tuple(R.fit[0][p] + x * (R.fit[1][p] + x * R.fit[2][p]) for p in R.each)
            for i in range(layout[L.N_ALL]):
                vectors[R.STAGE + k, i] = along(weights, R.PAST, i, vectors)
                vectors[R.STAGE2 + k, i] = shrunk * vectors[R.PAST2 + k, i]
        else:
            for i in range(layout[L.N_ALL]):
                vectors[R.STAGE + k, i], vectors[R.STAGE2 + k, i] = vectors[L.UNKNOWN0, i], 0.0
            if degree < 0:
                clear_row(R.STAGE + k, 0, layout[L.N_Q], run)
    if layout[L.N_ROTATIONS] > 0:
        for k in R.predicted:
            motion(R, k, h, run)
            to_second_rates(R.STAGE + k, run)


@kernel
def extrapolated(R, p, x):
    """The Lagrange polynomial of node p at x."""
    top, bottom = 1.0, 1.0
    for q in R.each:
        if q != p:
            top *= x - R.nodes[q]
            bottom *= R.nodes[p] - R.nodes[q]
    return top / bottom


@kernel
def clear_row(row, first, last, run):
    """Set entries of a row to zero."""
    vectors = run.vectors
    for i in range(first, last):
        vectors[row, i] = 0.0


@kernel
def motion(R, k, h, run):
    """q and v at stage k, and its unknowns in the rows that evaluations read."""
    vectors, layout, c = run.vectors, run.layout, h * R.nodes[k]
    a, b = tuple(h * x for x in R.A[k]), tuple(h * h * x for x in R.square[k])
    for i in range(layout[L.N_Q]):
        v, q = vectors[L.VELOCITY0, i], vectors[L.POSITION0, i] + c * vectors[L.VELOCITY0, i]
        for j in R.each:
            v += a[j] * vectors[R.STAGE + j, i]
            q += b[j] * vectors[R.STAGE + j, i]
        vectors[L.VELOCITY, i], vectors[L.POSITION, i] = v, q + along(a, R.STAGE2, i, vectors)
    for i in range(layout[L.N_ALL]):
        vectors[L.UNKNOWN, i], vectors[L.UNKNOWN2, i] = vectors[R.STAGE + k, i], vectors[R.STAGE2 + k, i]
    from_chart(run)


@kernel
def residual(R, k, run):
    """Residuals of stage k, as evaluated."""
    vectors, numbers, layout, first, second = run.vectors, run.numbers, run.layout, R.RESIDUAL + k, R.RESIDUAL2 + k
    n, m = layout[L.N_Q], layout[L.N_PHI]
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
def residuals(R, t, h, run):
    """Residuals of all stages of a step from t; the middle one last, as the matrices are evaluated there."""
    for number in range(R.stages):
        k = R.evaluated[number]
        motion(R, k, h, run)
        run.layout[L.NEW_MASS] = 1
        evaluate(t + R.nodes[k] * h, run)
        residual(R, k, run)


@rare
def constraint_size(R, run):
    """Largest violation of the constraints on positions, in all stages."""
    vectors, layout = run.vectors, run.layout
    value = 0.0
    for k in range(R.stages):
        for i in range(layout[L.N_Q], layout[L.N_Q] + layout[L.N_PHI]):
            value = max(value, abs(vectors[R.RESIDUAL + k, i]))
    return value


@kernel
def finish(R, h, run):
    """q and v at the end of the step, and its unknowns."""
    motion(R, R.stages - 1, h, run)


@kernel
def correct(R, h, unit, run):
    """Solve for the corrections, apply them; the largest scaled change of a position or ``unit`` times a velocity."""
    vectors, layout = run.vectors, run.layout
    n, m, size = layout[L.N_Q], layout[L.N_PHI], layout[L.N_ALL]
    solve_stages(R, h, run)
    largest = 0.0
    for k in range(R.stages):
        a, b, row = tuple(x / h for x in R.inverse[k]), tuple(h * h * x for x in R.square[k]), R.RESIDUAL2 + k
        for i in range(n):
            vectors[ERROR, i] = along(b, R.CHANGE, i, vectors)
            largest = larger(abs(vectors[ERROR, i]) * vectors[L.SCALE, i], largest)
        clear_row(ERROR2, n, size, run)
        from_rates(vectors[L.POSITION], vectors[ERROR], run)
        multiply(COUPLING, ERROR, ERROR2, run)
        for i in range(n):
            vectors[row, i] = -vectors[row, i]
        for i in range(n, n + m):
            vectors[row, i] += vectors[ERROR2, i]
            vectors[row, i] -= along(a, R.RESIDUAL, i, vectors)
        solve_in_chart(PROJECTION, row, run)
    for k in range(R.stages):
        a, b = tuple(x / h for x in R.inverse[k]), tuple(h * x for x in R.A[k])
        for i in range(n + m):
            vectors[R.STAGE + k, i] += vectors[R.CHANGE + k, i] - along(a, R.RESIDUAL2, i, vectors)
            vectors[R.STAGE2 + k, i] += vectors[R.RESIDUAL2 + k, i]
        for i in range(n + m, size):
            vectors[R.STAGE + k, i] += vectors[R.CHANGE + k, i]
        for i in range(n):
            vectors[R.DV + k, i] = along(b, R.CHANGE, i, vectors) - vectors[R.RESIDUAL2 + k, i]
    if has_entries(DAMPING, run):
        couple(R, h, run)
    for k in range(R.stages):
        for i in range(n):
            largest = larger(unit * abs(vectors[R.DV + k, i]) * vectors[L.SCALE, i], largest)
    return largest


@rare
def couple(R, h, run):
    """Correct a for dw, in RESIDUAL2, by D and Gam_v."""
    vectors, layout = run.vectors, run.layout
    for k in range(R.stages):
        first, second = R.RESIDUAL + k, R.RESIDUAL2 + k
        for i in range(layout[L.N_ALL]):
            vectors[ERROR, i], vectors[first, i], vectors[second, i] = -vectors[second, i], 0.0, 0.0
        from_rates(vectors[L.POSITION], vectors[ERROR], run)
        multiply(DAMPING, ERROR, first, run)
        into_chart(first, run)
    solve_stages(R, h, run)
    for k in range(R.stages):
        b = tuple(h * x for x in R.A[k])
        for i in range(layout[L.N_ALL]):
            vectors[R.STAGE + k, i] += vectors[R.CHANGE + k, i]
        for i in range(layout[L.N_Q]):
            vectors[R.DV + k, i] += along(b, R.CHANGE, i, vectors)


@rare
def estimate(R, h, speed, run):
    """The error of the embedded formula of order s: the largest of scaled q, and of scaled v relative to ``speed``.

    It is filtered by (1 - s J)^-1 with the real s and the Jacobian J of the constrained equations of motion, which
    removes stiff components.
    """
    vectors, numbers, layout, change = run.vectors, run.numbers, run.layout, R.CHANGE
    n, s = layout[L.N_Q], R.values[0] * h
    for i in range(n):
        of_w, of_a = along(R.e1, R.STAGE2, i, vectors), along(R.e2, R.STAGE, i, vectors)
        of_v = R.values[0] * vectors[L.UNKNOWN0, i]
        for j in R.each:
            of_v += R.e1[j] * vectors[R.STAGE + j, i]
        vectors[ERROR, i], vectors[change, i] = h * (h * of_a + of_w), h * of_v
    from_rates(vectors[L.POSITION], vectors[ERROR], run)
    from_rates(vectors[L.POSITION], vectors[change], run)
    clear_row(ERROR2, 0, layout[L.N_ALL], run)
    clear_row(L.MX, 0, layout[L.N_ALL], run)
    multiply(COUPLING, ERROR, ERROR2, run)
    if layout[L.MASS_KIND] > 0:
        inertia(L.TIMES, change, L.MX, run)
    for i in range(n):
        vectors[change, i] = (
            numbers[layout[L.MASS] + i] * vectors[change, i] + vectors[L.MX, i] - s * vectors[ERROR2, i]
        )
    clear_row(change, n, n + layout[L.N_PHI], run)
    for i in range(n + layout[L.N_PHI], layout[L.N_ALL]):
        vectors[change, i] = -vectors[ERROR2, i]
    solve(0, change, run)
    largest = 0.0
    for i in range(n):
        of_q, of_v = vectors[ERROR, i] + s * vectors[change, i], vectors[change, i]
        largest = larger(max(abs(of_q), abs(of_v) / speed) * vectors[L.SCALE, i], largest)
    return largest


# -- output and history -----------------------------------------------------------------------------------------------


@rare
def interpolate(R, k, x, h, out, run):
    """q and v by the polynomials of the stages: v of degree s, q of degree s + 1."""
    vectors, n = run.vectors, run.layout[L.N_Q]
    for i in range(n):
        out[k, i] = vectors[L.POSITION0, i] + x * h * vectors[L.VELOCITY0, i]
        out[k, n + i] = vectors[L.VELOCITY0, i]
    for j in range(R.stages):
        once, twice, weights = 0.0, 0.0, R.integrals[j]
        for p in range(R.stages - 1, -1, -1):
            once = x * (once + weights[p])
            twice = x * (twice + weights[p] / (p + 2))
        once, twice = h * once, h * h * x * twice
        for i in range(n):
            out[k, n + i] += once * vectors[R.STAGE + j, i]
            out[k, i] += twice * vectors[R.STAGE + j, i] + once * vectors[R.STAGE2 + j, i]
    from_rates(out[k], out[k, n:], run)


@kernel
def store(R, h, run):
    """Store the step as the last one."""
    reals, vectors, layout = run.reals, run.vectors, run.layout
    for k in range(R.stages):
        row = R.STAGE + k
        if layout[L.N_ROTATIONS] > 0:
            motion(R, k, h, run)
            row = L.UNKNOWN
        for i in range(layout[L.N_ALL]):
            vectors[R.PAST + k, i], vectors[R.PAST2 + k, i] = vectors[row, i], vectors[R.STAGE2 + k, i]
    for i in range(layout[L.N_Q]):
        vectors[QB, i], vectors[VB, i], vectors[L.POSITION0, i], vectors[L.VELOCITY0, i] = (
            vectors[L.POSITION0, i],
            vectors[L.VELOCITY0, i],
            vectors[L.POSITION, i],
            vectors[L.VELOCITY, i],
        )
    last = R.PAST + R.stages - 1
    for i in range(layout[L.N_ALL]):
        vectors[L.UNKNOWN0 + 1, i], vectors[L.UNKNOWN0, i] = vectors[last - 1, i], vectors[last, i]
    if reals[S.TOL] > 0.0:
        reals[S.NODES], reals[S.NODES + 1] = reals[S.STEP_END], reals[S.NOW] + R.nodes[R.stages - 2] * h
