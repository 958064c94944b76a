"""SUNDIALS IDA on the stabilised index-2 form, with its exact sparse Jacobian, through scikit-sundae.

BDF formulas of order 1 to 5. Multipliers are left out of the test of errors, by weights: theirs say nothing about the
motion, and are of an order less. States that come out are projected onto the constraints, which holds them to rounding
where the formulas hold them to the tolerance.

Source: A. C. Hindmarsh et al., ACM Trans. Math. Softw. 31 (2005), 363-396.
"""

from __future__ import annotations

import warnings
from collections.abc import Iterator
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mbdsl.errors import IntegrationError
from mbdsl.integrators.backends import Problem, require
from mbdsl.integrators.method import Method
from mbdsl.system.index1 import Index1
from mbdsl.system.index2 import StabilisedIndex2

Array = NDArray[np.float64]

METHOD = Method(
    "ida",
    doc="SUNDIALS IDA: BDF formulas of variable order, for what is stiff",
    order=5,
    index=2,
    enforces=("Phi", "dPhi"),
    source="Hindmarsh et al., ACM Trans. Math. Softw. 31 (2005), 363-396",
    own_reactions=False,
    sets=2,
    steps=("controlled",),
    needs="scikit-sundae: pip install mbdsl[sundials]",
)
#: the tolerance of a step, as a part of that asked for
SHARE = 0.01
#: weight of a multiplier is so small that no test sees it
UNSEEN = 1e30
#: residual where there is none: IDA goes round in circles with what is no number, and takes a shorter step with this
NOWHERE = 1e30
#: unknowns beyond which the sparse solver is faster
DENSE = 100


def solve(problem: Problem) -> Iterator[tuple[float, Array, Array]]:
    require("sksundae.ida", "sundials", METHOD.name)
    return _states(problem)


def _states(problem: Problem) -> Iterator[tuple[float, Array, Array]]:
    F, onto = StabilisedIndex2(problem.system, problem.left_out), Index1(problem.system, problem.left_out)
    counts, evaluations, matrices = problem.counts, 0, 0
    due = iter([*problem.times, np.inf])
    output = next(due)

    def projected(t: float, y: Array) -> tuple[float, Array, Array]:
        q, v, _ = F.split(y)
        return t, *onto.split(onto.project(t, onto.join(q, v)))

    t, y = problem.start, F.join(problem.q, problem.v, problem.lam)
    rate = F.join(problem.v, problem.a, np.zeros_like(problem.lam))
    for stop in (*(x for x in problem.breaks if problem.start < x < problem.stop), problem.stop):
        solver = _solver(problem, F)
        solver.init_step(t, y, rate)
        while t < stop:
            found = solver.step(stop, "onestep", stop)
            if not found.success:
                raise IntegrationError(found.message)
            counts["steps"] += 1
            counts["evaluations"], counts["matrix_evaluations"] = evaluations + found.nfev, matrices + found.njev
            counts["factorisations"] = counts["matrix_evaluations"]
            t, y = float(found.t), np.array(found.y)
            while output < t:
                yield projected(output, solver.step(output, "normal", stop).y)
                output = next(due)
            if t == output:
                output = next(due)
            yield (state := projected(t, y))
        evaluations, matrices = counts["evaluations"], counts["matrix_evaluations"]
        a, lam = onto.motion(*state)
        y, rate = F.join(*state[1:], lam), F.join(state[2], a, np.zeros_like(lam))


def _solver(problem: Problem, F: StabilisedIndex2):
    from scipy.sparse import csc_array
    from sksundae.ida import IDA

    q, v = problem.tolerances()
    least = 16.0 * np.finfo(float).eps * max(abs(problem.start), abs(problem.stop))  # or it never gives up
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
        small = rows.astype(np.int32), starts.astype(np.int32)  # the indices that it reads
        pattern = csc_array((np.ones(len(rows)), *small), shape=(F.size, F.size))
        options = {"linsolver": "sparse", "jacfn": sparse, "sparsity": pattern}
    atol = np.concatenate([SHARE * q, SHARE * v, unseen])
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # that a Jacobian is given and a pattern too
        options.update(algebraic_idx=F.algebraic.tolist(), min_step=least, max_step=problem.stop - problem.start)
        return IDA(residual, rtol=1e-15, atol=atol, **options)
