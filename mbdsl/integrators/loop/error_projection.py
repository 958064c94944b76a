"""The part of an error that constraints, springs and dampers do not remove.

:mod:`mbdsl.integrators.loop.step_control` gives the equations.
"""

from mbdsl.integrators.loop import loop_state as S
from mbdsl.integrators.loop.linear_solve import compress, factor, multiply, solve
from mbdsl.integrators.loop.run_data import evaluate, inertia
from mbdsl.integrators.loop.split_correction import stiff
from mbdsl.integrators.loop.tangent_matrices import tangent_matrix
from mbdsl.kernels import buffer_layout as L
from mbdsl.kernels.marks import rare


@rare
def tangential(row, matrix, run):
    """Remove from a row of ``vectors``, a displacement or velocity, the part that constraints and stiff forces remove.

    vectors[row] <- A^{-1} [M vectors[row]; 0], where A is the factorised ``matrix``. Overwrites TEMPORARY.
    """
    reals, vectors, numbers, layout = run.reals, run.vectors, run.numbers, run.layout
    if layout[L.MASS_KIND] > 0:
        inertia(L.TIMES, row, L.TEMPORARY, run)
    else:
        for i in range(layout[L.N_Q]):
            vectors[L.TEMPORARY, i] = 0.0
    for i in range(layout[L.N_Q]):
        vectors[row, i] = reals[S.MASS_WEIGHT] * (
            numbers[layout[L.MASS] + i] * vectors[row, i] + vectors[L.TEMPORARY, i]
        )
    for i in range(layout[L.N_Q], layout[L.N_ALL]):
        vectors[row, i] = 0.0
    solve(matrix, row, run)


@rare
def damping_matrix(t, h, run):
    """Set the last matrix, unless it belongs to the present iteration matrix: that one without K and Phi_q, compressed
    for ``multiply``."""
    reals, integers, last = run.reals, run.integers, run.matrices.shape[0] - 1
    if integers[S.OTHERS] != integers[S.MATRICES]:
        tangent_matrix(last, t, run, M=reals[S.MASS_WEIGHT], D=reals[S.DAMPING] * h, Gam_v=1.0)
        compress(last, run)
        integers[S.OTHERS] = integers[S.MATRICES]


@rare
def are_dampers_stiff(t, h, run):
    """Whether dampers are stiff. Sets the matrix before the last, unless it belongs to the present iteration matrix:
    that one without K and for a step of size FORGOTTEN, factorised if dampers are stiff."""
    reals, integers, mass, k = run.reals, run.integers, run.reals[S.MASS_WEIGHT], run.matrices.shape[0] - 2
    if abs(integers[S.DAMPERS]) != integers[S.MATRICES]:
        tangent_matrix(k, t, run, M=mass, D=reals[S.DAMPING] * reals[S.FORGOTTEN], Phi_q=1.0, Gam_v=1.0)
        found = h < reals[S.FORGOTTEN] and stiff(0.5, mass, k, run) and factor(k, run)
        integers[S.DAMPERS] = integers[S.MATRICES] if found else -integers[S.MATRICES]
    return integers[S.DAMPERS] > 0


@rare
def forget(run):
    """E_V <- E_V without the part that dampers remove within FORGOTTEN; E_X <- the displacement due to that part."""
    reals, vectors, layout, matrices = run.reals, run.vectors, run.layout, run.matrices
    last = matrices.shape[0] - 1
    for i in range(layout[L.N_ALL]):
        vectors[L.E_X, i] = vectors[L.E_V, i]
    tangential(L.E_V, last - 1, run)
    for i in range(layout[L.N_Q]):
        vectors[L.E_X, i] = reals[S.FORGOTTEN] * (vectors[L.E_X, i] - vectors[L.E_V, i])
    tangential(L.E_X, last - 1, run)


@rare
def tangential_position(run):
    """E_Q <- E_Q without the part that position constraints and stiff springs remove. Overwrites TEMPORARY.

    Dampers and velocity constraints do not remove errors of positions: the error along the normals of velocity
    constraints stays, Gam_v e = Gam_v e_raw.
    """
    vectors, layout, matrices = run.vectors, run.layout, run.matrices
    last = matrices.shape[0] - 1
    for i in range(layout[L.N_ALL]):
        vectors[L.TEMPORARY, i] = 0.0
    for i in range(layout[L.N_Q], layout[L.N_ALL]):
        vectors[L.E_Q, i] = 0.0
    multiply(last, L.E_Q, L.TEMPORARY, run)
    for i in range(layout[L.N_ALL]):
        vectors[L.E_Q, i] = vectors[L.TEMPORARY, i]
    solve(0, L.E_Q, run)


@rare
def set_velocity(error, h, matrix, run):
    """Project v at the start of a step of size h onto the constraints, and add the error that index 3 requires.

    This error is ``error`` times the jerk along the normals of the holonomic constraints. A method of index 3 imposes
    nonholonomic constraints on velocities, which have no such error: components along their normals are removed again.
    The matrix is evaluated at the start of the step, because the normals of earlier steps are not accurate enough.

    Changes VELOCITY0; E_Q <- the change. Overwrites POSITION, VELOCITY, E_V, TEMPORARY, the matrices, and the results
    of ``evaluate``.
    """
    reals, integers, vectors, layout = run.reals, run.integers, run.vectors, run.layout
    n, m = layout[L.N_Q], layout[L.N_PHI]
    a, d = L.UNKNOWN0 + L.PAST * (layout[L.ACCELERATION] - L.UNKNOWN), reals[S.NODES] - reals[S.NODES + 1]
    for i in range(n):
        vectors[L.POSITION, i], vectors[L.VELOCITY, i] = vectors[L.POSITION0, i], vectors[L.VELOCITY0, i]
    evaluate(reals[S.NOW], run)
    integers[S.MATRICES] += 1
    integers[S.FACTORISATIONS] += 1
    integers[S.FRESH] = 1 if matrix(reals[S.NOW], h, run) else 0
    for i in range(n):
        vectors[L.E_V, i] = (vectors[a, i] - vectors[a + 1, i]) / d
        vectors[L.E_Q, i] = error * vectors[L.E_V, i]
    tangential(L.E_V, 0, run)
    for i in range(n):
        vectors[L.E_Q, i] -= error * vectors[L.E_V, i]
    for i in range(layout[L.N_ALL]):
        vectors[L.E_V, i] = -vectors[L.FORCE2, i] if n <= i < n + m else 0.0
    solve(0, L.E_V, run)
    for i in range(n):
        e = vectors[L.E_Q, i] + vectors[L.E_V, i]
        vectors[L.E_Q, i] = e if integers[S.FRESH] and abs(e) < 1e300 else 0.0
        vectors[L.VELOCITY0, i] += vectors[L.E_Q, i]
    # nonholonomic rows of the matrix also contain Gam_q, which leaves an error of O(h) in each pass
    for _ in range(2 if n + m < layout[L.N_ALL] and integers[S.FRESH] else 0):
        for i in range(n):
            vectors[L.VELOCITY, i] = vectors[L.VELOCITY0, i]
        evaluate(reals[S.NOW], run)
        for i in range(layout[L.N_ALL]):
            vectors[L.E_V, i] = -vectors[L.FORCE, i] if i >= n + m else 0.0
        solve(0, L.E_V, run)
        for i in range(n):
            if abs(vectors[L.E_V, i]) < 1e300:
                vectors[L.E_Q, i] += vectors[L.E_V, i]
                vectors[L.VELOCITY0, i] += vectors[L.E_V, i]
