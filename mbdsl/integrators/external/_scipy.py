"""SciPy's ODE solvers on the index-1 reduction, step by step, the state projected onto the constraints after each.

One-step methods go on from the projected state. A multistep method cannot: its history would not fit. It is given
f(t, P(t, y)) instead, with P the projection, so that it drifts without consequence, and P(t, y) is what comes out.

The tolerance is that of a step, per coordinate and velocity; what steps add up to is somewhat larger.
"""

from __future__ import annotations

import warnings
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mbdsl.errors import IntegrationError
from mbdsl.integrators.backends import Problem
from mbdsl.system.index1 import Index1

Array = NDArray[np.float64]
State = tuple[float, Array, Array]

#: the least relative tolerance that SciPy takes
LEAST = 2.3e-14


def weights(problem: Problem, share: float) -> tuple[Array, Array]:
    """Relative and absolute tolerances (2n,) of a step: ``share`` of what is asked for.

    Relative ones are for velocities only: a crank that has turned a hundred times is to be as exact as before.
    """
    assert problem.tol is not None
    q, v = problem.tolerances()
    n = problem.system.n
    relative = np.concatenate([np.full(n, LEAST), np.full(n, max(LEAST, share * problem.tol))])
    return relative, share * np.concatenate([q, v])


def solve(problem: Problem, make: Callable[..., Any], share: float, multistep: bool = False) -> Iterator[State]:
    """States at all steps and outputs; ``make(f, t, y, stop, rtol, atol)`` gives an ``OdeSolver``."""
    f = Index1(problem.system, problem.left_out)
    rtol, atol = weights(problem, share)
    t, y = problem.start, f.join(problem.q, problem.v)
    due = iter([*problem.times, np.inf])
    output = next(due)
    counts = problem.counts

    def projected(t: float, y: Array) -> Array:
        return f(t, f.project(t, y))

    for stop in (*(x for x in problem.breaks if problem.start < x < problem.stop), problem.stop):
        before = counts.copy()
        solver = make(projected if multistep else f, t, y, stop, rtol, atol)
        while solver.status == "running":
            with warnings.catch_warnings(), np.errstate(all="ignore"):
                warnings.simplefilter("ignore")  # what they warn of, they also report
                message = solver.step()
            if solver.status == "failed":
                raise IntegrationError(message or "the solver gives no reason")
            if output < solver.t:
                interpolant = solver.dense_output()
                while output < solver.t:
                    yield output, *f.split(f.project(output, interpolant(output)))
                    output = next(due)
            t, y = solver.t, f.project(solver.t, solver.y)
            if not multistep:
                solver.y, solver.f = y, f(t, y)
            counts["steps"] += 1
            counts["evaluations"] = f.evaluations
            counts["matrix_evaluations"] = before["matrix_evaluations"] + solver.njev
            counts["factorisations"] = before["factorisations"] + solver.nlu
            if t == output:
                output = next(due)
            yield t, *f.split(y)
