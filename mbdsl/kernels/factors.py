"""The factors of the parts of an iteration matrix, in the order in which the emitted ``tangent`` takes them."""

from __future__ import annotations

from typing import NamedTuple


class Factors(NamedTuple):
    """The matrix (n + m + p, n + m + p) is

        cM M + cK K + cD D + cA (M a)_q      Phi_q^T - cL Q_lam     Gam_v^T - cL Q_nu
        cP Phi_q + cN N                      0                      0
        cV Gam_v + cW Gam_q                  0                      0

    with K = (Phi_q^T lam + Gam_v^T nu - Q)_q, D = (Gam_v^T nu - Q)_v, N = (Phi_q v)_q, and a in a row of vectors.
    """

    cM: float = 0.0
    cK: float = 0.0
    cD: float = 0.0
    cL: float = 0.0
    cP: float = 0.0
    cN: float = 0.0
    cV: float = 0.0
    cW: float = 0.0
    cA: float = 0.0
    cC: float = 1.0  #: of the columns Phi_q^T and Gam_v^T
    cU: float = 0.0  #: of d(Phi_q^T mu)/dq, and of what charts of rotations add, with the second multipliers mu
    cE: float = 0.0  #: of the unit matrix
    cG: float = 0.0  #: not 0: the columns are those at the start of the step
