"""SciPy's DOP853 on the index-1 reduction: explicit Runge-Kutta of order 8 by Dormand and Prince."""

from __future__ import annotations

from mbdsl.integrators.backends import Problem
from mbdsl.integrators.method import Method

METHOD = Method(
    "scipy-dop853",
    doc="SciPy's DOP853: explicit Runge-Kutta of order 8 by Dormand and Prince",
    order=8,
    index=1,
    enforces=("Phi", "dPhi"),
    family="Dormand-Prince",
    source="Hairer, Norsett, Wanner (1993), section II.5",
    own_reactions=False,
    steps=("controlled",),
    searches=True,
    spatial=True,
)


def solve(problem: Problem):
    from scipy.integrate import DOP853

    from mbdsl.integrators.external import _scipy

    def make(f, t, y, stop, rtol, atol):
        return DOP853(f, t, y, stop, rtol=rtol, atol=atol, max_step=problem.longest)

    return _scipy.solve(problem, make, share=0.1)
