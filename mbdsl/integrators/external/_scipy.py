"""SciPy's ODE solvers on the index-1 reduction, with a projection onto the constraints after each step.

One-step methods continue from the projected state. Multistep methods cannot, because the projection would not agree
with their history. They integrate f(t, P(t, y)) instead, where P is the projection. Their y drifts, but f does not
depend on the drift, and the state that is returned is P(t, y).

The tolerance is that of one step, for each coordinate and velocity; the error of many steps is somewhat larger.
"""

from __future__ import annotations

import warnings
from collections import Counter
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np

from mbdsl.errors import IntegrationError
from mbdsl.integrators.backends import Problem
from mbdsl.integrators.external import _pieces
from mbdsl.integrators.external._pieces import State
from mbdsl.kernels.arrays import Array
from mbdsl.system.index1 import Index1

#: smallest relative tolerance that SciPy accepts
LEAST = 2.3e-14


def weights(problem: Problem, f: Index1, share: float) -> tuple[Array, Array]:
    """Relative and absolute tolerances of a step, as y: ``share`` times those of the problem.

    Only velocities have relative tolerances: a crank must have the same accuracy after a hundred turns as before.
    """
    assert problem.tol is not None
    q, v = problem.tolerances()
    relative = np.concatenate([np.full(f.coordinates.size, LEAST), np.full(len(v), max(LEAST, share * problem.tol))])
    # a rotation by d changes a quaternion by d/2
    return relative, share * np.concatenate([f.coordinates.each(q, 0.5), v])


def solve(problem: Problem, make: Callable[..., Any], share: float, multistep: bool = False) -> Iterator[State]:
    """Yield the states at all steps and outputs; ``make(f, t, y, stop, rtol, atol)`` returns an ``OdeSolver``."""
    f = Index1(problem.system, problem.left_out)
    rtol, atol = weights(problem, f, share)

    def projected(t: float, y: Array) -> Array:
        return f(t, f.project(t, y))

    def begin(t: float, q: Array, v: Array, stop: float) -> _ScipyPiece:
        solver = make(projected if multistep else f, t, f.join(q, v), stop, rtol, atol)
        return _ScipyPiece(f, solver, multistep, problem.counts)

    return _pieces.solve(problem, begin)


class _ScipyPiece:
    """A SciPy solver within one piece of a motion; see :class:`mbdsl.integrators.external._pieces.Solver`."""

    def __init__(self, f: Index1, solver: Any, multistep: bool, counts: Counter[str]) -> None:
        self._f, self._solver, self._multistep = f, solver, multistep
        self._counts, self._before = counts, counts.copy()

    @property
    def t(self) -> float:
        return float(self._solver.t)

    def step(self) -> None:
        f, solver, counts = self._f, self._solver, self._counts
        self._interpolant: Callable[[float], Array] | None = None
        with warnings.catch_warnings(), np.errstate(all="ignore"):
            warnings.simplefilter("ignore")  # the solvers also report failures by their status
            message = solver.step()
        if solver.status == "failed":
            raise IntegrationError(message or "the solver failed without a message")
        self._end = f.project(solver.t, solver.y)
        if not self._multistep:
            solver.y, solver.f = self._end, f(solver.t, self._end)
        counts["evaluations"] = f.evaluations
        counts["matrix_evaluations"] = self._before["matrix_evaluations"] + solver.njev
        counts["factorisations"] = self._before["factorisations"] + solver.nlu

    def at(self, t: float) -> tuple[Array, Array]:
        if t == self._solver.t:
            return self._f.split(self._end)
        if self._interpolant is None:
            self._interpolant = self._solver.dense_output()
        return self._f.split(self._f.project(t, self._interpolant(t)))
