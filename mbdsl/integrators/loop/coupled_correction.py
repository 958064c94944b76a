"""Newton's corrections of a stabilised method as one linear system, where bodies in space turn far within a step.

The splitting of :mod:`mbdsl.integrators.loop.split_correction` neglects terms of the order of the angle that a body
turns by in a step. Newton's iteration then contracts by about this angle, and from one radian on not at all. The full
system of twice the size has the exact Jacobian of the residuals at any angle:

    [[A00, A01], [A10, A11]] (CORRECTION, CORRECTION2) = right sides

It takes four times the operations of the two systems to factorise, and twice to solve.
"""

from mbdsl.integrators.loop import loop_state as S
from mbdsl.integrators.loop.block_lu import BLOCKS as COUPLED
from mbdsl.integrators.loop.block_lu import factor_parts, solve_parts
from mbdsl.integrators.loop.linear_solve import factor
from mbdsl.integrators.loop.rotation_chart import to_body, to_rates, to_world
from mbdsl.kernels import buffer_layout as L
from mbdsl.kernels.marks import kernel, rare

#: number of matrices of the full system
BLOCKS = 4
#: angle that a body turns by in a step, above which the full system is solved [rad]
FAR = 0.05


@kernel
def turns_far(run):
    """Whether a body turns by more than FAR in the step, in a model with constraints; sets ``integers[COUPLED]``."""
    layout, q, most = run.layout, run.vectors[L.POSITION], 0.0
    for k in range(layout[L.N_ROTATIONS] if layout[L.N_PHI] > 0 else 0):
        d = layout[layout[L.ROTATIONS] + 2 * k]
        most = max(most, q[d] * q[d] + q[d + 1] * q[d + 1] + q[d + 2] * q[d + 2])
    run.integers[S.COUPLED] = 1 if most > FAR * FAR else 0
    return most > FAR * FAR


@kernel
def block(row, column, run):
    """The number of the matrix A_{row, column}; those of step control are the last ones."""
    return run.matrices.shape[0] - BLOCKS - 2 * run.integers[S.CONTROLLED] + 2 * row + column


@kernel
def copy_first(run):
    """A00 <- matrix 0, which is not yet factorised."""
    first, matrices = block(0, 0, run), run.matrices
    for i in range(run.layout[L.SIZE]):
        matrices[first, i] = matrices[0, i]


@rare
def factor_coupled(run):
    """Factorise the full system, and for step control matrix 0; False if one is singular."""
    first, matrices = block(0, 0, run), run.matrices
    parts = tuple(matrices[first + k] for k in COUPLED.parts)
    whole = factor_parts(COUPLED, parts, run.pivots[first], run.layout)
    return whole and (run.integers[S.CONTROLLED] == 0 or factor(0, run))


@rare
def solve_coupled(run):
    """CORRECTION and CORRECTION2 <- the solution of the full system with these right sides."""
    first, matrices, vectors = block(0, 0, run), run.matrices, run.vectors
    to_world(L.CORRECTION, run)
    to_world(L.CORRECTION2, run)
    parts = tuple(matrices[first + k] for k in COUPLED.parts)
    rows = (vectors[L.CORRECTION], vectors[L.CORRECTION2])
    solve_parts(COUPLED, parts, run.pivots[first], run.layout, rows)
    to_body(L.CORRECTION, run)
    to_body(L.CORRECTION2, run)
    to_rates(L.CORRECTION, run)
    to_rates(L.CORRECTION2, run)
