"""Kinematics: what constraints and drivers determine without leaving anything free is no differential equation.

With as many (independent) constraints as coordinates, unknowns are the displacement d = q_{n+1} - q_n and v_{n+1}:

    Phi(q_{n+1}, t_{n+1}) = 0
    Phi_q v_{n+1} + Phi_t = 0

Both are solved to rounding, whatever h. Forces do not enter; reactions follow from the motion where somebody asks. The
matrix is that of the other methods with M beside Phi_q, for the sake of its pivots: the solution does not depend on it.
Where steps are controlled, they end at outputs, and none moves a coordinate by more than K[LARGEST].
"""

from mbdsl.compilation.buffer_layout import D2, FP, GD, N_ALL, N_Q, PAST, Q0, R2, SCALE, X2, XA, D, Q, R, V, X
from mbdsl.compilation.marks import kernel
from mbdsl.integrators.loop.linear_solve import factor, larger, solve
from mbdsl.integrators.loop.loop_state import LARGEST, H
from mbdsl.integrators.method import Method

METHOD = Method(
    "kinematic",
    doc="positions and velocities from the constraints alone",
    order=0,
    index=0,
    enforces=("Phi", "dPhi"),
    source="the constraints and their time derivative",
    coefficients=lambda options: (0.0,),
    begin=lambda c, start: {XA: [*(start.h * start.v), *(0.0 * start.lam)], XA + PAST: start.v},
    sets=2,
    own_reactions=False,
    chosen=False,
)


@kernel
def motion(h, c, Y, I):
    for i in range(I[N_Q]):
        Y[Q, i] = Y[Q0, i] + Y[X, i]
        Y[V, i] = Y[X2, i]


@kernel
def local_error(h, last, c, jerk, snap):
    """There is none."""
    return 0.0, 0.0


@kernel
def estimate(local_error, inertia, h, c, K, J, Y, F, I, A, P):
    """The largest displacement, relative to what it may be."""
    largest = 0.0
    for i in range(I[N_Q]):
        largest = larger(abs(Y[X, i]) * Y[SCALE, i], largest)
    return largest / K[LARGEST]


@kernel
def change_step(h, evaluate, tangent, inertia, c, K, J, Y, Z, C, F, I, A, P):
    """Displacements of the past, as with steps of length h in place of K[H]."""
    for k in range(PAST):
        for i in range(I[N_Q]):
            Y[XA + k, i] *= h / K[H]


@kernel
def residual(h, c, Y, F, I):
    for i in range(I[N_Q]):
        Y[R, i], Y[R2, i] = 0.0, 0.0
    for i in range(I[N_Q], I[N_ALL]):
        Y[R, i], Y[R2, i] = Y[FP, i], Y[GD, i]


@kernel
def matrix(tangent, t, h, c, Y, Z, C, F, I, A, P):
    """[[M, Phi_q^T], [Phi_q, 0]]."""
    tangent(t, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, Y, Z, C, F, I, A[0])
    return factor(A[0], P[0], I)


@kernel
def correct(k, h, c, Y, I, A, P):
    for i in range(I[N_ALL]):
        Y[D, i], Y[D2, i] = -Y[R, i], -Y[R2, i]
    solve(A[0], P[0], I, Y, D)
    solve(A[0], P[0], I, Y, D2)
    change = 0.0
    for i in range(I[N_Q]):
        Y[X, i] += Y[D, i]
        Y[X2, i] += Y[D2, i]
        change = larger((abs(Y[D, i]) + h * abs(Y[D2, i])) * Y[SCALE, i], change)
    return change


@kernel
def finish(inertia, h, c, Y, F, I, A, P):
    """Nothing but q and v is kept."""
