"""Stages of dop853: accelerations from the index-1 form, and projection of the end of a step onto the constraints.

With J = [Phi_q; Gam_v], the accelerations and multipliers of a state are the solution of

    [[M, J^T], [J, 0]] [a; lam] = [Q; gamma],   gamma = -(Phi_q v)_q v - Gam_q v - Phi_tt - ...

One evaluation of the tangent gives all of it: with the factors M = 1, N = 1 and Gam_q = 1, its rows of the constraints
contain [(Phi_q v)_q; Gam_q], from which gamma follows, and its columns of the multipliers contain J^T. The rows are
then overwritten with the transpose of the columns. Where Q depends on lam (friction in joints), it is linearised about
the last multipliers, and the solution is repeated.

In space the formulas of the method are those of the rotation vectors psi from the attitudes at the start of the step:
stages hold psi'', while the state holds Omega = T(psi) psi'. The end of the step is kept in both forms.

At the end of a step, Newton's method with the matrix of the last stage, which belongs to the same time, projects q and
v onto Phi = 0, Phi_q v + Phi_t = 0 and Gam = 0 in the metric of M.

Source: E. Hairer, C. Lubich, G. Wanner, Geometric Numerical Integration (2006), section IV.4 (projection).
"""

from mbdsl.integrators.loop import loop_state as S
from mbdsl.integrators.loop.linear_solve import SPARSE_LU, factor, larger, solve
from mbdsl.integrators.loop.newton import EPS, finite
from mbdsl.integrators.loop.rotation_chart import from_rates, to_body, to_rates, to_second_rates, to_world
from mbdsl.integrators.loop.run_data import evaluate
from mbdsl.integrators.loop.symmetric_lu import symmetric_factor, symmetric_solve
from mbdsl.integrators.loop.tangent_matrices import tangent_matrix
from mbdsl.integrators.methods.dop853_coefficients import ALL, NODE, SQUARE, STAGES
from mbdsl.integrators.methods.multiplier_matrix import applies, assemble, factorise, solve_multipliers
from mbdsl.kernels import buffer_layout as L
from mbdsl.kernels.columns import PLANE, SPACE
from mbdsl.kernels.marks import kernel, rare
from mbdsl.system.switches import signature

#: own rows of ``vectors``: [a; lam] of all stages; coefficients of degree 4 to 7 of the interpolation of q, and of v;
#: diagonal of M^{-1/2}, for :mod:`mbdsl.integrators.methods.multiplier_matrix`; [a; lam] at the end of the step, with
#: Omega'; velocities in other axes or charts
STAGE, OF_Q, OF_V = L.ROWS, L.ROWS + ALL, L.ROWS + ALL + 4
ROOT, END, OTHER_VELOCITY = L.ROWS + ALL + 8, L.ROWS + ALL + 9, L.ROWS + ALL + 10
OWN_ROWS = ALL + 11
#: memory: contraction of the projection; largest scaled velocity so far; whether the interpolation of the step is
#: ready; successive stiff steps; successive other steps since; whether forces depend on multipliers; whether a stage
#: without weight in the step has seen a switch that changes
CONTRACTION, SPEED, READY, STIFF_STEPS, OTHERS, FRICTION, CHANGED = range(7)
#: most iterations of a projection; after RENEWED of them the matrix is renewed, or after three if changes decrease by
#: less than the factor SLOW
MOST, RENEWED, SLOW = 14, 5, 0.03
#: change in a projection that may be rounding, in units of the last place, if changes do not become smaller
NOISE = 1e4
#: most solutions for accelerations where forces depend on multipliers; relative change of these that is accepted
REPEATED, AGREED = 20, 1e-13


@kernel
def in_space(run):
    """Whether the model is one in space."""
    return run.frames.shape[1] == SPACE.COLUMNS


@rare
def has_friction(run):
    """Whether a force law depends on multipliers."""
    layout, found, leaf = run.layout, False, SPACE.LEAF if in_space(run) else PLANE.LEAF
    first = layout[L.N_PHI] + layout[L.N_SPRINGS]
    for r in range(first, first + layout[L.N_LAWS]):
        leaves = layout[layout[L.PAIRS] + L.PAIR * r + L.DETAIL]
        found = found or layout[leaves + L.LEAVES + leaf * layout[leaves + 2]] > 0
    return found


@kernel
def motion(row, stages, h, run):
    """POSITION and VELOCITY of the stage with this row of the table, from the accelerations of the first ``stages``."""
    c, vectors = run.coefficients, run.vectors
    s, one, two = h * c[NODE + row], ALL * row, ALL * (SQUARE + row)
    for i in range(run.layout[L.N_Q]):
        v, q = 0.0, 0.0
        for j in range(stages):
            a = vectors[STAGE + j, i]
            v += c[one + j] * a
            q += c[two + j] * a
        vectors[L.VELOCITY, i] = vectors[L.VELOCITY0, i] + h * v
        vectors[L.POSITION, i] = vectors[L.POSITION0, i] + (s * vectors[L.VELOCITY0, i] + h * h * q)
    from_rates(vectors[L.POSITION], vectors[L.VELOCITY], run)


# -- accelerations -----------------------------------------------------------------------------------------------------


@kernel
def evaluate_state(t, run):
    """Forces without constraint forces, and constraints, at the state in POSITION and VELOCITY."""
    vectors, layout = run.vectors, run.layout
    if run.memory[FRICTION] == 0.0:
        for i in range(layout[L.N_ALL]):
            vectors[L.UNKNOWN, i] = 0.0
    layout[L.NEW_MASS] = 1
    evaluate(t, run)
    run.integers[S.ITERATIONS] += 1


@kernel
def mirror(at, mirrored, row, column, velocity, run):
    """CORRECTION <- CORRECTION - (entry at ``at``) v in this row; the entry <- that at ``mirrored``."""
    matrix, vectors = run.matrices[0], run.vectors
    vectors[L.CORRECTION, row] -= matrix[at] * vectors[velocity, column]
    matrix[at] = matrix[mirrored]


@kernel
def in_world_axes(run):
    """The row with the velocities in the axes of the matrices."""
    if run.layout[L.N_ROTATIONS] == 0:
        return L.VELOCITY
    for i in range(run.layout[L.N_Q]):
        run.vectors[OTHER_VELOCITY, i] = run.vectors[L.VELOCITY, i]
    to_world(OTHER_VELOCITY, run)
    return OTHER_VELOCITY


@rare
def in_time(run):
    """CORRECTION, in the rows of constraints, -= partial derivatives with respect to time; see
    :mod:`mbdsl.system.time_derivatives`."""
    vectors, gradients, frames, numbers, layout = run.vectors, run.gradients, run.frames, run.numbers, run.layout
    n, m, registers = layout[L.N_Q], layout[L.N_PHI], layout[L.REGISTERS]
    pose, rates, carried, moved, gradient_rate = PLANE.POSE, PLANE.RATE, PLANE.CARRIED, PLANE.MOVED, PLANE.GRADIENT_RATE
    if in_space(run):
        pose, rates, carried = SPACE.POSE, SPACE.RATE, SPACE.CARRIED
        moved, gradient_rate = SPACE.MOVED, SPACE.GRADIENT_RATE
    for r in range(m):
        o = layout[L.PAIRS] + L.PAIR * r
        if layout[o + L.LEFT_OUT]:
            continue
        if layout[o + L.DETAIL] >= 0:
            vectors[L.CORRECTION, n + r] += numbers[registers + layout[layout[o + L.DETAIL] + 2]]
        for k in range(layout[L.N_MOVING]):
            moving = layout[L.MOVING] + moved * k
            frame = layout[moving]
            for side in range(2):
                if layout[o + L.FRAME_A + side] == frame:
                    for j in range(pose):
                        vectors[L.CORRECTION, n + r] -= (
                            gradients[r, gradient_rate + pose * side + j] * frames[frame, rates + j]
                            + gradients[r, pose * side + j] * numbers[registers + layout[moving + 1 + carried + j]]
                        )
    for k in range(layout[L.N_GAM]):
        o = layout[layout[L.GAMMAS] + k]
        if not layout[o + 3]:
            vectors[L.CORRECTION, n + m + k] -= numbers[registers + layout[o + 1]]


@kernel
def saddle(t, run):
    """Matrix 0 <- [[M, J^T], [J, 0]] at the state last evaluated, or C C^T; CORRECTION <- [Q; gamma]."""
    vectors, layout = run.vectors, run.layout
    n, size = layout[L.N_Q], layout[L.N_ALL]
    run.integers[S.MATRICES] += 1
    if applies(run):
        assemble(ROOT, run)
        return
    tangent_matrix(0, t, run, M=1.0, N=1.0, Gam_q=1.0)
    v = in_world_axes(run)
    for i in range(n):
        vectors[L.CORRECTION, i] = vectors[L.FORCE, i]
    for i in range(n, size):
        vectors[L.CORRECTION, i] = 0.0
    if layout[L.SOLVER] == SPARSE_LU:
        o = layout[L.SPARSE]
        count = layout[o + 2 * size]
        table = o + 2 * size + 1
        for e in range(count):
            i, j, lower, upper = layout[table + e], layout[table + count + e], size + e, size + count + e
            if i >= n > j:
                mirror(lower, upper, i, j, v, run)
            elif j >= n > i:
                mirror(upper, lower, j, i, v, run)
    else:
        for i in range(n, size):
            for j in range(n):
                mirror(i * size + j, j * size + i, i, j, v, run)
    if size > n:
        in_time(run)


@kernel
def is_symmetric(run):
    """Whether matrix 0 is factorised as a symmetric one."""
    return run.layout[L.SOLVER] == SPARSE_LU and run.memory[FRICTION] == 0.0


@kernel
def factorised(run):
    """A status: whether matrix 0 could be factorised."""
    run.integers[S.FACTORISATIONS] += 1
    if applies(run):
        done = factorise(run)
    elif is_symmetric(run):
        done = symmetric_factor(run.matrices[0], run.layout)
    else:
        done = factor(0, run)
    if done:
        return S.RUNNING
    return S.SINGULAR if finite(run) else S.NOT_FINITE


@kernel
def solve_row(row, run):
    """vectors[row] <- A^{-1} vectors[row] with the factors of matrix 0."""
    if applies(run):
        solve_multipliers(run.vectors[row], ROOT, run)
    elif is_symmetric(run):
        to_world(row, run)
        symmetric_solve(run.matrices[0], run.layout, run.vectors[row])
        to_body(row, run)
    else:
        solve(0, row, run)


@rare
def with_friction(t, run):
    """CORRECTION <- [a; lam] at the state last evaluated, whose forces depend on lam; a status."""
    vectors, layout = run.vectors, run.layout
    n, size, largest = layout[L.N_Q], layout[L.N_ALL], 0.0
    for _ in range(REPEATED):
        saddle(t, run)  # CORRECTION <- [Q - J^T lam; gamma]
        for i in range(n):  # multipliers that vanish have the rounding errors of the forces
            largest = max(largest, abs(vectors[L.CORRECTION, i]))
        tangent_matrix(0, t, run, M=1.0, f_lam=1.0, Phi_q=1.0, Gam_v=1.0)
        status = factorised(run)
        if status != S.RUNNING:
            return status
        solve(0, L.CORRECTION, run)
        change = 0.0
        for i in range(n, size):
            change = larger(abs(vectors[L.CORRECTION, i]), change)
            vectors[L.UNKNOWN, i] += vectors[L.CORRECTION, i]
            vectors[L.CORRECTION, i] = vectors[L.UNKNOWN, i]
            largest = max(largest, abs(vectors[L.UNKNOWN, i]))
        if not change < 1e300:
            return S.NOT_FINITE
        if change <= AGREED * largest:
            return S.RUNNING
        evaluate_state(t, run)
    return S.DIVERGED


@kernel
def solve_state(t, row, run):
    """Row ``row`` <- [a; lam] at the state last evaluated; a status."""
    vectors, size = run.vectors, run.layout[L.N_ALL]
    if run.memory[FRICTION] > 0.0:
        status = with_friction(t, run)
    else:
        saddle(t, run)
        status = factorised(run)
        if status == S.RUNNING:
            solve_row(L.CORRECTION, run)
    if status != S.RUNNING:
        return status
    total = 0.0
    for i in range(size):
        vectors[row, i] = vectors[L.CORRECTION, i]
        total += abs(vectors[L.CORRECTION, i])
    return S.RUNNING if total < 1e300 else S.NOT_FINITE


@kernel
def is_changed(run):
    """Whether a switch differs, at the state last evaluated, from its state at the start of the step."""
    return signature(run.numbers, run.layout) != run.integers[S.SIGNATURE]


@kernel
def solve_stages(t, h, run):
    """All stages of a step from t, and its end before projection, in POSITION, VELOCITY and UNKNOWN; a status."""
    vectors, c, memory = run.vectors, run.coefficients, run.memory
    size = run.layout[L.N_ALL]
    memory[CHANGED] = 0.0
    for k in range(1, STAGES):
        motion(k, k, h, run)
        s = t + c[NODE + k] * h
        evaluate_state(s, run)
        status = solve_state(s, STAGE + k, run)
        if status != S.RUNNING:
            return status
        if c[ALL * STAGES + k] == 0.0 and run.integers[S.WATCHING]:
            memory[CHANGED] = larger(memory[CHANGED], 1.0 if is_changed(run) else 0.0)
        to_second_rates(STAGE + k, run)
    motion(STAGES, STAGES, h, run)
    for i in range(size):
        vectors[L.UNKNOWN, i] = vectors[STAGE + STAGES - 1, i]
    return S.RUNNING


# -- the end of a step -------------------------------------------------------------------------------------------------


@kernel
def correct(unit, run):
    """Correct POSITION and VELOCITY by the violations last evaluated; the largest scaled change of a position or
    ``unit`` times a velocity."""
    vectors, layout = run.vectors, run.layout
    n, m, size = layout[L.N_Q], layout[L.N_PHI], layout[L.N_ALL]
    for i in range(n):
        vectors[L.CORRECTION, i], vectors[L.CORRECTION2, i] = 0.0, 0.0
    for i in range(n, n + m):
        vectors[L.CORRECTION, i], vectors[L.CORRECTION2, i] = -vectors[L.FORCE, i], -vectors[L.FORCE2, i]
    for i in range(n + m, size):
        vectors[L.CORRECTION, i], vectors[L.CORRECTION2, i] = 0.0, -vectors[L.FORCE, i]
    solve_row(L.CORRECTION, run)
    solve_row(L.CORRECTION2, run)
    to_rates(L.CORRECTION, run)
    change = 0.0
    for i in range(n):
        vectors[L.POSITION, i] += vectors[L.CORRECTION, i]
        vectors[L.VELOCITY, i] += vectors[L.CORRECTION2, i]
        change = larger(abs(vectors[L.CORRECTION, i]) * vectors[L.SCALE, i], change)
        change = larger(unit * abs(vectors[L.CORRECTION2, i]) * vectors[L.SCALE, i], change)
    return change


@kernel
def project(t, size, unit, run):
    """Project the state onto the constraints at t, and evaluate it; a status. ``size`` of the mechanism."""
    memory, former, ratio, last, floor = run.memory, 0.0, run.memory[CONTRACTION], False, EPS * size
    for k in range(MOST):
        evaluate_state(t, run)
        if last:
            return S.RUNNING
        if k == RENEWED or (k > 2 and k < RENEWED and ratio > SLOW):
            saddle(t, run)
            status = factorised(run)
            if status != S.RUNNING:
                return status
        change = correct(unit, run)
        if not change < 1e100:
            return S.NOT_FINITE
        if k > 1 and former > 100.0 * floor:  # the second change of v is that due to the first one of q
            ratio = change / former
            memory[CONTRACTION] = min(max(ratio, 0.5 * memory[CONTRACTION]), 0.5)
        stalled = k > RENEWED and change > 0.3 * former and change <= NOISE * floor
        last = change <= floor or 10.0 * ratio * change <= floor or stalled
        former = change
    return S.DIVERGED


@kernel
def finish(t, h, run):
    """Project the end of a step of length h, at t, onto the constraints, and compute its accelerations; a status."""
    memory, vectors, layout = run.memory, run.vectors, run.layout
    n, size, largest = layout[L.N_Q], layout[L.N_ALL], 1.0
    if size > n:
        for i in range(n):
            largest = max(largest, abs(vectors[L.POSITION, i]) * vectors[L.SCALE, i])
            memory[SPEED] = max(memory[SPEED], abs(vectors[L.VELOCITY, i]) * vectors[L.SCALE, i])
        status = project(t, largest, 1.0 / memory[SPEED] if memory[SPEED] > 0.0 else h, run)
        if status != S.RUNNING:
            return status
    else:
        evaluate_state(t, run)
    status = solve_state(t, END, run)
    if status == S.RUNNING:
        for i in range(size):
            vectors[L.UNKNOWN, i], vectors[STAGE + STAGES, i] = vectors[END, i], vectors[END, i]
        to_second_rates(STAGE + STAGES, run)
    return status
