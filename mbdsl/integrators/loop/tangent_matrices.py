"""Matrices of the linearised equations: sums of derivatives of a scene's equations, with a factor on each.

With f = Q - Phi_q^T lam - Gam_v^T nu, K = -f_q, D = -f_v, f_lam from force laws that depend on reactions, N =
(Phi_q v)_q and x in the row that the method declares as ``tangent_row``:

    [[M + I + K + D + (M x)_q + U,   Phi_q^T - f_lam + P,   Gam_v^T],
     [Phi_q + N,                     0,                     0      ],
     [Gam_v + Gam_q,                 0,                     0      ]]

with the unit matrix I, and in space U = (Phi_q^T mu)_q, and P, the Phi_q^T of the start of the step less the present
one. Phi_q^T and Gam_v^T on the right have a common factor, ``columns``, which is 1 by default. If the factors of Gam_v
and Gam_q are both zero, nonholonomic rows have that factor on the diagonal. The derivatives are those at the state of
the last evaluation.

In space, the unknowns are small rotations, and the changes of rotation vectors psi are T(psi)^{-1} times these. Terms
of velocities (D, Gam_v, and Phi_q in the rows with N) contain T^{-1} if both K and D have factors, whose ratio is that
of dq and dv. M and I contain it if K, D or U has a factor.
"""

from mbdsl.kernels import buffer_layout as L
from mbdsl.kernels.marks import kernel


@kernel
def tangent_matrix(
    k, t, run, M=0.0, K=0.0, D=0.0, Mx_q=0.0, f_lam=0.0, Phi_q=0.0, N=0.0, Gam_v=0.0, Gam_q=0.0, columns=1.0, U=0.0,
    I=0.0, P=0.0
):  # fmt: skip
    """Matrix k <- the matrix in the module's docstring with these factors."""
    vectors, frames, gradients, numbers, layout = run.vectors, run.frames, run.gradients, run.numbers, run.layout
    matrix = run.matrices[k]
    run.tangent_at(
        t, M, K, D, f_lam, Phi_q, N, Gam_v, Gam_q, Mx_q, columns, U, I, P, vectors, frames, gradients, numbers, layout,
        matrix
    )  # fmt: skip


@kernel
def iteration_matrix(k, t, run, M, K, D, Gam_q, Mx_q=0.0, f_lam=1.0, N=0.0, P=0.0):
    """Matrix k <- that of Newton's iteration, [[M + K + D + (M x)_q, Phi_q^T], [Phi_q + N, 0]].

    With the derivatives of a method's formulas, the factor K is dq/da, the factor D is dv/da, and Gam_q is dq/dv.
    """
    tangent_matrix(k, t, run, M=M, K=K, D=D, Mx_q=Mx_q, f_lam=f_lam, Phi_q=1.0, N=N, Gam_v=1.0, Gam_q=Gam_q, P=P)


@kernel
def velocity_matrix(k, t, run, M, K, D, q_v, Mx_q=0.0, f_lam=1.0, P=0.0):
    """``iteration_matrix`` of a stabilised method, whose rows of constraints are those on velocities; q_v is dq/dv.

    N is left to the next iteration in the plane. In space it is as large as the spin of a body.
    """
    N = q_v if run.layout[L.N_ROTATIONS] > 0 else 0.0
    iteration_matrix(k, t, run, M=M, K=K, D=D, Mx_q=Mx_q, f_lam=f_lam, Gam_q=q_v, N=N, P=P)


@kernel
def projection_matrix(k, t, run, M):
    """Matrix k <- [[M, Phi_q^T], [Phi_q, 0]], which projects onto the holonomic constraints."""
    tangent_matrix(k, t, run, M=M, Phi_q=1.0)


@kernel
def stiffness_matrix(k, t, run, K, Gam_q, Mx_q=0.0):
    """Matrix k <- [K + (M x)_q; 0; Gam_q] in the columns of the coordinates: dR/dq of all residuals R except Phi."""
    tangent_matrix(k, t, run, K=K, Gam_q=Gam_q, Mx_q=Mx_q)
