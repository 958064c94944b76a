"""SUNDIALS IDA on the stabilised index-2 form, with its exact sparse Jacobian, through scikit-sundae.

BDF formulas of order 1 to 5. Weights exclude the multipliers from the error test, because their errors do not affect
the motion and their order is lower by one. The states that are returned are projected onto the constraints, which then
hold to rounding; without the projection they would hold to the tolerance.

Source: A. C. Hindmarsh et al., ACM Trans. Math. Softw. 31 (2005), 363-396.
"""

from __future__ import annotations

import warnings
from collections.abc import Iterator
from typing import Any

import numpy as np

from mbdsl.errors import IntegrationError
from mbdsl.integrators.backends import Problem, require
from mbdsl.integrators.external import _pieces
from mbdsl.integrators.method import Method
from mbdsl.kernels.arrays import Array
from mbdsl.system.index1 import Index1
from mbdsl.system.stabilised_index2 import StabilisedIndex2

METHOD = Method(
    "ida",
    doc="SUNDIALS IDA: BDF formulas of variable order, for stiff models",
    order=5,
    index=2,
    enforces=("Phi", "dPhi"),
    family="BDF",
    source="Hindmarsh et al., ACM Trans. Math. Softw. 31 (2005), 363-396",
    own_reactions=False,
    sets=2,
    steps=("controlled",),
    searches=True,
    spatial=True,
    needs="scikit-sundae: pip install '.[sundials]' in the folder of mbdsl",
)
#: tolerance of a step, relative to that of the problem
SHARE = 0.01
#: tolerance of multipliers, so large that it excludes them from the error test
UNSEEN = 1e30
#: replaces residuals that are nan: IDA then takes a shorter step; with nan it would repeat the same step without end
NOWHERE = 1e30
#: number of unknowns above which the sparse solver is faster
DENSE = 100


def solve(problem: Problem) -> Iterator[tuple[float, Array, Array]]:
    require("sksundae.ida", "sundials", METHOD.name)
    return _states(problem)


def _states(problem: Problem) -> Iterator[tuple[float, Array, Array]]:
    F, onto = StabilisedIndex2(problem.system, problem.left_out), Index1(problem.system, problem.left_out)
    return _pieces.solve(problem, lambda t, q, v, stop: _IdaPiece(problem, F, onto, t, q, v, stop))


class _IdaPiece:
    """IDA within one piece of a motion; see :class:`mbdsl.integrators.external._pieces.Solver`."""

    def __init__(
        self, problem: Problem, F: StabilisedIndex2, onto: Index1, t: float, q: Array, v: Array, stop: float
    ) -> None:
        self.t, self._F, self._onto, self._stop, self._counts = t, F, onto, stop, problem.counts
        self._looked_at = t
        self._before = problem.counts.copy()
        self._solver = _solver(problem, F)
        a, lam = (problem.a, problem.lam) if t == problem.start else onto.motion(t, q, v)
        y = F.join(q, v, lam)
        self._solver.init_step(t, y, F.rates(y, a))

    def step(self) -> None:
        if self._looked_at != self.t:
            self._solver.step(self.t, "normal", self._stop)  # otherwise the next call would return this step again
        found = self._solver.step(self._stop, "onestep", self._stop)
        if not found.success:
            raise IntegrationError(found.message)
        self.t = self._looked_at = float(found.t)
        self._end = self._onto_constraints(self.t, found.y)
        for what, count in (("evaluations", found.nfev), ("matrix_evaluations", found.njev)):
            self._counts[what] = self._before[what] + count
        self._counts["factorisations"] = self._counts["matrix_evaluations"]

    def at(self, t: float) -> tuple[Array, Array]:
        if t == self.t:
            return self._end
        self._looked_at = t
        return self._onto_constraints(t, self._solver.step(t, "normal", self._stop).y)

    def _onto_constraints(self, t: float, y: Array) -> tuple[Array, Array]:
        q, v, _ = self._F.split(np.array(y))
        return self._onto.split(self._onto.project(t, self._onto.join(q, v)))


def _solver(problem: Problem, F: StabilisedIndex2):
    from scipy.sparse import csc_array
    from sksundae.ida import IDA

    q, v = problem.tolerances()
    least = 16.0 * np.finfo(float).eps * max(abs(problem.start), abs(problem.stop))  # without a limit it never fails
    unseen = np.full(len(F.algebraic), UNSEEN)
    rows, starts = F.pattern
    columns = np.repeat(np.arange(F.size), np.diff(starts))

    def residual(t, y, rate, out):
        out[:] = np.nan_to_num(F(t, y, rate), nan=NOWHERE)

    def sparse(t, y, rate, res, cj, out):
        out[:] = np.nan_to_num(F.jacobian(t, y, rate, cj))

    def dense(t, y, rate, res, cj, out):
        out[rows, columns] = np.nan_to_num(F.jacobian(t, y, rate, cj))

    options: dict[str, Any] = {"linsolver": "dense", "jacfn": dense}
    if F.size > DENSE:
        small = rows.astype(np.int32), starts.astype(np.int32)  # IDA reads 32-bit indices
        pattern = csc_array((np.ones(len(rows)), *small), shape=(F.size, F.size))
        options = {"linsolver": "sparse", "jacfn": sparse, "sparsity": pattern}
    # a rotation by d changes a quaternion by d/2
    atol = np.concatenate([F.coordinates.each(SHARE * q, 0.5), SHARE * v, unseen])
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # a warning that both a Jacobian and a pattern are given
        most = min(problem.longest, problem.stop - problem.start)
        options.update(algebraic_idx=F.algebraic.tolist(), min_step=least, max_step=most)
        return IDA(residual, rtol=1e-15, atol=atol, **options)
