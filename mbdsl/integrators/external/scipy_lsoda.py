"""SciPy's LSODA on the index-1 reduction: variable order, with automatic choice of Adams or BDF formulas."""

from __future__ import annotations

import numpy as np

from mbdsl.integrators.backends import Problem
from mbdsl.integrators.method import Method

METHOD = Method(
    "scipy-lsoda",
    doc="SciPy's LSODA: variable order, with automatic choice of Adams or BDF formulas",
    order=12,
    index=1,
    enforces=("Phi", "dPhi"),
    family="Adams/BDF",
    source="Petzold, SIAM J. Sci. Stat. Comput. 4 (1983), 136-148",
    own_reactions=False,
    steps=("controlled",),
    searches=True,
    spatial=True,
)

#: smaller rates are set to zero, because LSODA computes nan from numbers close to underflow
NOTHING = 1e-200


def solve(problem: Problem):
    from scipy.integrate import LSODA

    from mbdsl.integrators.external import _scipy

    def make(f, t, y, stop, rtol, atol):
        def settled(t, y):
            rate = f(t, y)
            return np.where(np.abs(rate) < NOTHING, 0.0, rate)

        return LSODA(settled, t, y, stop, rtol=rtol, atol=atol, max_step=problem.longest)

    return _scipy.solve(problem, make, share=0.01, multistep=True)
