"""Our sparse LU compared with SciPy's SuperLU and LAPACK's dense LU, on the iteration matrices of chains and four-bar
loops.

python tests/benchmarks/sparse_solvers.py [--repeats 7]

Times of factorisation and solution are measured separately, in microseconds. SuperLU runs with the order from the graph
and without pivoting, its fastest setting here, and with its own column order. Our LU runs in the compiled step loop;
SuperLU has to be called from Python, and its times include the call. The table also lists the largest residual of each,
relative to the right-hand side. No time is asserted.
"""

from __future__ import annotations

import argparse
import os
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # idle BLAS threads spin, which counts as processor time

import numpy as np
from scipy.linalg import lu_factor, lu_solve
from scipy.sparse import csc_array
from scipy.sparse.linalg import splu

import mbdsl
from mbdsl.compilation import code_cache
from mbdsl.initial.consistent import initial_state
from mbdsl.integrators.loop import linear_solve, sparse_lu
from mbdsl.integrators.run import MethodRun
from mbdsl.mechanism import graph
from mbdsl.system import build

MODELS = Path(__file__).parents[2] / "models"
CASES = (("slider_crank", 0), ("seven_body", 0), ("four_bar", 2), ("four_bar", 40), ("four_bar", 400))
CASES += (("chain", 8), ("chain", 64), ("chain", 512), ("chain", 4096))
DENSE = 500  #: unknowns up to which LAPACK is tried
TEXT = """
from mbdsl.integrators.loop import sparse_lu


def factor(count, assembled, matrix, layout):
    for _ in range(count):
        for i in range(assembled.size):
            matrix[i] = assembled[i]
        if not sparse_lu.sparse_factor(matrix, layout):
            return 0
    return 1


def solve(count, matrix, layout, vector):
    for _ in range(count):
        sparse_lu.sparse_solve(matrix, layout, vector)
"""


@dataclass(frozen=True)
class Cost:
    """Microseconds of a factorisation and of a solution by one solver, and its largest residual."""

    matrix: str
    unknowns: int
    solver: str
    entries: int
    factor: float
    solve: float
    residual: float

    def __str__(self) -> str:
        solver = f"{self.solver}, {self.entries} entries" if self.entries else self.solver
        return (
            f"{self.matrix:14} {self.unknowns:6d} {solver:28} {self.factor:10.2f} {self.solve:10.2f} "
            f"{self.residual:9.1e}"
        )


def compiled() -> list[Callable]:
    signatures = {
        "factor": code_cache.Signature(("int", "vector", "vector", "ints"), gives="int"),
        "solve": code_cache.Signature(("int", "vector", "ints", "vector")),
    }
    return code_cache.functions("mbdsl_measure_sparse", TEXT, signatures, lambda: [linear_solve, sparse_lu])


def seconds(call: Callable[[int], object], repeats: int) -> float:
    """The least time of one repetition."""
    count, spent = 1, 0.0
    while spent < 2e-3:
        count *= 2
        begun = time.process_time()
        call(count)
        spent = time.process_time() - begun
    found = []
    for _ in range(repeats):
        begun = time.process_time()
        call(count)
        found.append(time.process_time() - begun)
    return min(found) / count


def times(call: Callable[[], object]) -> Callable[[int], None]:
    def often(count: int) -> None:
        for _ in range(count):
            call()

    return often


def compare(model: str, n: int, repeats: int) -> list[Cost]:
    """All solvers on one matrix."""
    scene = mbdsl.load(MODELS / f"{model}.mbd", {"N": n} if n else {})
    mechanism = graph.build(scene)
    system = build(scene, mechanism)
    start = initial_state(system, mechanism, 0.0)
    N, h = system.unknowns, 1e-3
    # the matrix of hht-i3, scaled so that all entries have the size of masses
    M = csc_array(system.tangent(0.0, start.q, start.v, start.lam, cM=1 / 0.9, cK=0.3 * h * h, cD=0.6 * h, cP=1.0))
    b = np.random.default_rng(0).normal(size=N)
    order = system.elimination_order()
    rows, columns = system.tables.pattern
    pattern = sparse_lu.analyse(N, rows, columns, order)
    run = MethodRun(system, "hht-i3", h, 0.0, h, np.array([]))
    entries = M.tocoo()
    at = dict(zip(zip(rows.tolist(), columns.tolist(), strict=True), pattern.slots.tolist(), strict=True))
    B = np.zeros(pattern.size)
    for r, c, value in zip(entries.row.tolist(), entries.col.tolist(), entries.data.tolist(), strict=True):
        B[at[r, c]] = value
    A, I, x = np.zeros(pattern.length), run.layout, np.zeros(N)
    factor, solve = compiled()
    assert factor(1, B, A, I) == 1
    x[:] = b
    solve(1, A, I, x)
    name, other = f"{model} {n}" if n else model, b.copy()
    found: list[Cost] = []

    def row(what: str, entries: int, one: float, other: float, x: np.ndarray) -> None:
        residual = float(np.abs(M @ x - b).max() / np.abs(b).max())
        found.append(Cost(name, N, what, entries, 1e6 * one, 1e6 * other, residual))

    row(
        "ours",
        pattern.size,
        seconds(lambda count: factor(count, B, A, I), repeats),
        seconds(lambda count: solve(count, A, I, other), repeats),
        x,
    )
    ordered = csc_array(M[order][:, order])
    given = {"permc_spec": "NATURAL", "diag_pivot_thresh": 0.0, "options": {"SymmetricMode": True}}
    for what, matrix, options in (("SuperLU, our order", ordered, given), ("SuperLU, its own", csc_array(M), {})):
        lu = splu(matrix, **options)
        own = matrix is ordered
        x = np.zeros(N)
        x[order if own else slice(None)] = lu.solve(b[order] if own else b)
        factoring = seconds(times(lambda m=matrix, o=options: splu(m, **o)), repeats)
        row(what, lu.nnz, factoring, seconds(times(lambda lu=lu: lu.solve(b)), repeats), x)
    if N <= DENSE:
        dense = M.toarray()
        lu = lu_factor(dense)
        factoring = seconds(times(lambda: lu_factor(dense)), repeats)
        row("LAPACK, dense", 0, factoring, seconds(times(lambda: lu_solve(lu, b)), repeats), lu_solve(lu, b))
    return found


def table(repeats: int = 7, cases=CASES) -> str:
    head = f"{'matrix':14} {'N':>6} {'':28} {'factor us':>10} {'solve us':>10} {'residual':>9}"
    return "\n".join([head, *(str(cost) for model, n in cases for cost in compare(model, n, repeats))])


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--repeats", type=int, default=7)
    print(table(parser.parse_args().repeats))
