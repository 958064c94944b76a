"""Solution of the linear systems for Newton's corrections: one system, or two with a one-way coupling."""

from mbdsl.integrators.loop.linear_solve import clear, compress, has_entries, larger, multiply, solve, solve_both
from mbdsl.integrators.loop.rotation_chart import to_rates
from mbdsl.kernels import buffer_layout as L
from mbdsl.kernels.marks import kernel, rare

#: largest effect of CORRECTION2 on CORRECTION, relative to CORRECTION, that is left to the next iteration: in the first
#: two iterations of a step, and in later ones
EARLY, LATE = 0.3, 0.02


@kernel
def residual_one(of_position, of_velocity, run):
    """RESIDUAL <- [M a - f; Phi/of_position; Gam/of_velocity] with a in UNKNOWN, from MX and FORCE; the divisors are
    dq/da and dv/da of a method of index 3."""
    n, m, size = run.layout[L.N_Q], run.layout[L.N_PHI], run.layout[L.N_ALL]
    y, mass = run.vectors, run.numbers[run.layout[L.MASS] :]
    r, f, a, Ma = y[L.RESIDUAL], y[L.FORCE], y[L.UNKNOWN], y[L.MX]
    for i in range(n):
        r[i] = mass[i] * a[i] + Ma[i] - f[i]
    for i in range(n, n + m):
        r[i] = f[i] / of_position
    for i in range(n + m, size):
        r[i] = f[i] / of_velocity


@kernel
def correct_one(run):
    """Solve for the corrections and apply them; return the largest scaled correction of an acceleration.

    Reads RESIDUAL and the factorised matrix 0; writes CORRECTION and UNKNOWN.
    """
    vectors, layout = run.vectors, run.layout
    correction, unknown, scale = vectors[L.CORRECTION], vectors[L.UNKNOWN], vectors[L.SCALE]
    for i in range(layout[L.N_ALL]):
        correction[i] = -vectors[L.RESIDUAL, i]
    solve(0, L.CORRECTION, run)
    to_rates(L.CORRECTION, run)
    for i in range(layout[L.N_ALL]):
        unknown[i] += correction[i]
    change = 0.0
    for i in range(layout[L.N_Q]):
        change = larger(abs(correction[i]) * scale[i], change)
    return change


@kernel
def scale_history(unknown, count, factor, run):
    """Multiply the first ``count`` entries of UNKNOWN (unknown 0) or UNKNOWN2 (unknown 1) at the last steps."""
    for k in range(L.PAST):
        past = run.vectors[L.UNKNOWN0 + L.PAST * unknown + k]
        for i in range(count):
            past[i] *= factor


@kernel
def solve_two(k, run):
    """Solve both systems in iteration k = 0, 1, ... of a step, with the matrices A0, A1 and A2:

        CORRECTION2 <- A1^{-1} CORRECTION2,   CORRECTION <- A0^{-1} (CORRECTION + A2 CORRECTION2)

    Both are first solved in one loop without A2, which takes little longer than one of them. The effect of A2 is then
    added only if it is large enough. For smooth motion CORRECTION2 is smaller than CORRECTION by a power of h, and its
    effect can be left to the next iteration.
    """
    solve_both(run)
    if has_entries(2, run):
        add_coupling(k, run)
    to_rates(L.CORRECTION, run)
    to_rates(L.CORRECTION2, run)


@rare
def add_coupling(k, run):
    """CORRECTION <- CORRECTION + A0^{-1} A2 CORRECTION2, unless that is negligible. Overwrites TEMPORARY2."""
    vectors, layout = run.vectors, run.layout
    for i in range(layout[L.N_ALL]):
        vectors[L.TEMPORARY2, i] = 0.0
    multiply(2, L.CORRECTION2, L.TEMPORARY2, run)
    change, added = 0.0, 0.0
    for i in range(layout[L.N_Q]):
        change = max(change, abs(vectors[L.CORRECTION, i]) * vectors[L.SCALE, i])
        added = max(added, abs(vectors[L.TEMPORARY2, i]) * vectors[L.DIAGONAL, i])
    if added > (EARLY if k < 2 else LATE) * change:
        solve(0, L.TEMPORARY2, run)
        for i in range(layout[L.N_ALL]):
            vectors[L.CORRECTION, i] += vectors[L.TEMPORARY2, i]


@rare
def stiff(limit, mass, k, run):
    """Whether forces are more than the part ``limit`` of a diagonal entry of matrix k, which is not yet factorised.

    The rest of these entries is ``mass`` times M.
    """
    numbers, layout, matrices = run.numbers, run.layout, run.matrices
    for i in range(layout[L.N_Q]):
        a = matrices[k, layout[layout[L.SLOTS] + layout[L.MASS_SLOTS] + i]]
        if abs(a - mass * numbers[layout[L.MASS] + i]) > limit * abs(a):
            return True
    return False


@kernel
def couples(mass, run):
    """Whether A2 may matter: forces are stiff compared with ``mass`` times M in A0, or the model has force laws or
    nonholonomic constraints, whose derivatives the diagonal need not show."""
    layout = run.layout
    return layout[L.N_LAWS] + layout[L.N_GAM] > 0 or stiff(LATE, mass, 0, run)


@rare
def couple(run):
    """Compress A2 for ``multiply``; leave it empty if it is negligible compared with A0, which is not yet factorised.

    Writes DIAGONAL.
    """
    vectors, layout, matrices, pivots = run.vectors, run.layout, run.matrices, run.pivots
    ratio = 0.0
    clear(2, run)
    for i in range(layout[L.N_Q]):
        slot = layout[layout[L.SLOTS] + layout[L.MASS_SLOTS] + i]
        d = abs(matrices[0, slot])
        vectors[L.DIAGONAL, i] = vectors[L.SCALE, i] / d if d > 0.0 else 0.0
        ratio = max(ratio, abs(matrices[2, slot]) / max(d, 1e-300))
    if ratio <= LATE and layout[L.N_LAWS] + layout[L.N_GAM] == 0:
        return
    compress(2, run)
    ratio = 0.0
    for k in range(pivots[2, pivots.shape[1] - 1]):
        r, c = pivots[2, 2 * k], pivots[2, 2 * k + 1]
        if r < layout[L.N_Q]:
            ratio = max(ratio, abs(matrices[2, k]) * vectors[L.DIAGONAL, r] / vectors[L.SCALE, c])
    if ratio <= LATE:
        clear(2, run)
