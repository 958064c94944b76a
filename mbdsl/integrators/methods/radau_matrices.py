"""The matrices of Newton's iteration on the stages of Radau IIA, and solutions with them in the eigenvectors of h A.

The equations: :mod:`mbdsl.integrators.methods.radau_stages`.
"""

from mbdsl.integrators.loop import loop_state as S
from mbdsl.integrators.loop.block_lu import COMPLEX as NUMBERS
from mbdsl.integrators.loop.block_lu import factor_parts, solve_parts
from mbdsl.integrators.loop.linear_solve import clear, compress, factor, solve
from mbdsl.integrators.loop.newton import EPS
from mbdsl.integrators.loop.rotation_chart import (
    out_of_chart,
    to_body,
    to_rates,
    to_world,
)
from mbdsl.integrators.loop.tangent_matrices import iteration_matrix, projection_matrix, tangent_matrix
from mbdsl.integrators.methods.radau_coefficients import METRIC
from mbdsl.kernels import buffer_layout as L
from mbdsl.kernels.marks import kernel, rare

#: matrices: that of the real s (0); the projection; [K'; N; Gam_q] in the columns of q; [D; 0; Gam_v], empty if
#: negligible; real and imaginary part of that of each complex s
PROJECTION, COUPLING, DAMPING, COMPLEX = 1, 2, 3, 4
#: share of the dampers in the diagonal of the matrix above which [D; 0; Gam_v] is not negligible
DAMPED = 0.02
#: flexibility of soft constraints, relative to the square of the motion in a step over the least mass
SOFTNESS = 10.0


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
def matrices(R, start, h, still, run):
    """All matrices of a step from ``start``, at the state last evaluated, factorised; False if that failed. ``still``:
    acceptable error of scaled velocities."""
    vectors, layout, matrices, t = run.vectors, run.layout, run.matrices, start + R.nodes[R.stages // 2] * h
    s, good = R.values[0] * h, True
    iteration_matrix(0, t, run, M=1.0, K=s * s, D=s, Mx_q=s * s, Gam_q=s)
    projection_matrix(PROJECTION, t, run, M=1.0)
    for i in range(layout[L.N_Q]):
        matrices[PROJECTION, layout[layout[L.SLOTS] + layout[L.MASS_SLOTS] + i]] += vectors[METRIC, i]
    tangent_matrix(COUPLING, t, run, K=1.0, Mx_q=1.0, N=1.0, Gam_q=1.0)
    compress(COUPLING, run)
    for p in range(1, R.stages, 2):
        x, y, real, imag = R.values[p] * h, R.values[p + 1] * h, COMPLEX + p - 1, COMPLEX + p
        k, l = x * x - y * y, 2.0 * x * y
        iteration_matrix(real, t, run, M=1.0, K=k, D=x, Mx_q=k, Gam_q=x)
        # the imaginary part is the difference of these two
        iteration_matrix(imag, t, run, M=1.0, K=k + l, D=x + y, Mx_q=k + l, Gam_q=x + y)
        if R.stages > 3:
            soften(real, h, run)
            soften(imag, h, run)
        for i in range(layout[L.SIZE]):
            matrices[imag, i] -= matrices[real, i]
        good = good and factor_parts(NUMBERS, (matrices[real], matrices[imag]), run.pivots[real], layout)
    if R.stages > 3:
        soften(0, h, run)
        soften(PROJECTION, h, run)
    prepare_damping(t, s, still, run)
    return good and factor(0, run) and factor(PROJECTION, run)


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
def transform(R, first, last, h, rank, run):
    """CHANGE = -R/s^rank (rank 0: -R - R2/s) in the eigenvectors: the real, then real and imaginary part of complex
    ones."""
    vectors, s = run.vectors, 1.0 / (R.values[0] * h)
    p = s if rank == 1 else s * s
    for i in range(first, last):
        u = along(R.there[0], R.RESIDUAL, i, vectors)
        u = p * u if rank > 0 else u + s * along(R.there[0], R.RESIDUAL2, i, vectors)
        vectors[R.CHANGE, i] = -u
    for j in R.pairs:
        size = h * (R.values[j] * R.values[j] + R.values[j + 1] * R.values[j + 1])
        x, y = R.values[j] / size, -R.values[j + 1] / size  # 1/s
        q, r = (x, y) if rank == 1 else (x * x - y * y, 2.0 * x * y)
        for i in range(first, last):
            v, w = along(R.there[j], R.RESIDUAL, i, vectors), along(R.there[j + 1], R.RESIDUAL, i, vectors)
            if rank > 0:
                v, w = q * v - r * w, q * w + r * v
            else:
                f, g = along(R.there[j], R.RESIDUAL2, i, vectors), along(R.there[j + 1], R.RESIDUAL2, i, vectors)
                v, w = v + x * f - y * g, w + x * g + y * f
            vectors[R.CHANGE + j, i], vectors[R.CHANGE + j + 1, i] = -v, -w


@kernel
def along(weights, row, i, vectors):
    """The sum of entries i of the rows from ``row`` on, with their weights."""
    value = 0.0
    for weight in weights:
        value += weight * vectors[row, i]
        row += 1
    return value


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
    parts, rows = (matrices[k], matrices[k + 1]), (vectors[real], vectors[imag])
    solve_parts(NUMBERS, parts, run.pivots[k], run.layout, rows)
    for row in (real, imag):
        to_body(row, run)
        to_rates(row, run)


@kernel
def solve_stages(R, h, run):
    """e and kappa of all stages, in CHANGE, from the residuals."""
    vectors, layout = run.vectors, run.layout
    n, m, size = layout[L.N_Q], layout[L.N_PHI], layout[L.N_ALL]
    transform(R, 0, n, h, 0, run)
    transform(R, n, n + m, h, 2, run)
    transform(R, n + m, size, h, 1, run)
    solve_in_chart(0, R.CHANGE, run)
    for j in range(1, R.stages, 2):
        solve_complex(COMPLEX + j - 1, R.CHANGE + j, R.CHANGE + j + 1, run)
    for i in range(size):
        spectrum = tuple(vectors[R.CHANGE + j, i] for j in R.each)
        for k in R.each:
            total = 0.0
            for j in R.each:
                total += R.back[k][j] * spectrum[j]
            vectors[R.CHANGE + k, i] = total
