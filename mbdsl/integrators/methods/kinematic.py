"""Kinematics: the motion of mechanisms in which constraints and drivers leave no degree of freedom.

There is no differential equation. With as many independent constraints as coordinates, the unknowns are the
displacement d = q_{n+1} - q_n and v_{n+1}:

    Phi(q_{n+1}, t_{n+1}) = 0
    Phi_q v_{n+1} + Phi_t = 0

Both equations are solved to rounding for any h. Forces do not enter; reactions are computed from the motion on access.
The matrix is that of the other methods; it contains M only for its pivots, and the solution does not depend on M.
Controlled steps end at output times, and no step moves a coordinate by more than the run's limit LARGEST.
"""

from mbdsl.integrators.loop import loop_state as S
from mbdsl.integrators.loop.linear_solve import factor, larger, solve
from mbdsl.integrators.loop.rotation_chart import to_rates
from mbdsl.integrators.loop.split_correction import scale_history
from mbdsl.integrators.loop.tangent_matrices import projection_matrix
from mbdsl.integrators.method import Method
from mbdsl.kernels import buffer_layout as L
from mbdsl.kernels.marks import kernel

METHOD = Method(
    "kinematic",
    doc="positions and velocities from the constraints alone",
    order=0,
    index=0,
    enforces=("Phi", "dPhi"),
    source="the constraints and their time derivative",
    begin=lambda c, start: {L.UNKNOWN0: [*(start.h * start.v), *(0.0 * start.lam)], L.UNKNOWN0 + L.PAST: start.v},
    sets=2,
    own_reactions=False,
    chosen=False,
)


@kernel
def motion(h, run):
    """POSITION from POSITION0 and UNKNOWN; VELOCITY from UNKNOWN2."""
    y = run.vectors
    q, v, q0, d, v_new = y[L.POSITION], y[L.VELOCITY], y[L.POSITION0], y[L.UNKNOWN], y[L.UNKNOWN2]
    for i in range(run.layout[L.N_Q]):
        q[i] = q0[i] + d[i]
        v[i] = v_new[i]


@kernel
def local_error(h, last, c, jerk, snap):
    """Zero: there is no discretisation error."""
    return 0.0, 0.0


@kernel
def estimate(h, formulas, run):
    """The largest scaled displacement in UNKNOWN, relative to the limit LARGEST."""
    d, scale, largest = run.vectors[L.UNKNOWN], run.vectors[L.SCALE], 0.0
    for i in range(run.layout[L.N_Q]):
        largest = larger(abs(d[i]) * scale[i], largest)
    return largest / run.reals[S.LARGEST]


@kernel
def change_step(h, run):
    """Convert the history of displacements to the step size h."""
    scale_history(0, run.layout[L.N_Q], h / run.reals[S.STEP_SIZE], run)


@kernel
def residual(h, run):
    """RESIDUAL and RESIDUAL2 <- [0; Phi] and [0; Phi_q v + Phi_t], from FORCE and FORCE2."""
    y = run.vectors
    r, r2, phi, dphi = y[L.RESIDUAL], y[L.RESIDUAL2], y[L.FORCE], y[L.FORCE2]
    for i in range(run.layout[L.N_Q]):
        r[i], r2[i] = 0.0, 0.0
    for i in range(run.layout[L.N_Q], run.layout[L.N_ALL]):
        r[i], r2[i] = phi[i], dphi[i]


@kernel
def matrix(t, h, run):
    """Matrix 0 <- [[M, Phi_q^T], [Phi_q, 0]], factorised."""
    projection_matrix(0, t, run, M=1.0)
    return factor(0, run)


@kernel
def correct(k, h, run):
    """Solve for the corrections and apply them to UNKNOWN and UNKNOWN2; return the largest scaled change of a position
    (or of h times a velocity)."""
    y, scale = run.vectors, run.vectors[L.SCALE]
    r, r2, of_d, of_v, d, v = (
        y[L.RESIDUAL],
        y[L.RESIDUAL2],
        y[L.CORRECTION],
        y[L.CORRECTION2],
        y[L.UNKNOWN],
        y[L.UNKNOWN2],
    )
    for i in range(run.layout[L.N_ALL]):
        of_d[i], of_v[i] = -r[i], -r2[i]
    solve(0, L.CORRECTION, run)
    to_rates(L.CORRECTION, run)
    solve(0, L.CORRECTION2, run)
    change = 0.0
    for i in range(run.layout[L.N_Q]):
        d[i] += of_d[i]
        v[i] += of_v[i]
        change = larger((abs(of_d[i]) + h * abs(of_v[i])) * scale[i], change)
    return change


@kernel
def finish(h, run):
    """The history consists of q and v only: nothing to do."""
