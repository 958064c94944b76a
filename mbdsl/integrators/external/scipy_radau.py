"""SciPy's Radau on the index-1 reduction: Radau IIA of order 5, for stiff models."""

from __future__ import annotations

from mbdsl.integrators.backends import Problem
from mbdsl.integrators.method import Method

METHOD = Method(
    "scipy-radau",
    doc="SciPy's Radau: Radau IIA of order 5, for stiff models",
    order=5,
    index=1,
    enforces=("Phi", "dPhi"),
    family="Radau IIA",
    source="Hairer, Wanner (1996), section IV.8",
    own_reactions=False,
    steps=("controlled",),
    searches=True,
    spatial=True,
)


def solve(problem: Problem):
    from scipy.integrate import Radau

    from mbdsl.integrators.external import _scipy

    def make(f, t, y, stop, rtol, atol):
        solver = Radau(f, t, y, stop, rtol=rtol.max(), atol=atol, max_step=problem.longest)
        solver.rtol = rtol  # the constructor takes one value, which also sets the tolerance of its Newton iteration
        return solver

    return _scipy.solve(problem, make, share=1.0)
