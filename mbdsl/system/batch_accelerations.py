"""Accelerations and multipliers at many states: one compiled loop evaluates them, then all are solved together.

The equations are those of :mod:`mbdsl.system.accelerations`, which also solves them where they are nearly singular.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import cache
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from mbdsl.compilation import code_cache
from mbdsl.kernels import buffer_layout as L
from mbdsl.kernels.arrays import Array, Integers
from mbdsl.kernels.marks import kernel
from mbdsl.numerics import rotation_arrays
from mbdsl.numerics.rotation import BASE
from mbdsl.system.accelerations import ACCURATE, BOUNDED, CONVERGED, ITERATIONS, balance
from mbdsl.system.emit import EVALUATE, TANGENT
from mbdsl.system.system import DENSE_LIMIT, System
from mbdsl.system.time_derivatives import TimeTerms

#: least number of states for which loading the compiled loop pays off; most numbers in matrices solved together
MANY, TOGETHER = 64, 2**21
SAMPLE = code_cache.Signature(
    (
        *(EVALUATE, TANGENT, "vector", "matrix", "matrix", "matrix", "ints", "matrix", "ints"),
        *("matrix", "matrix", "matrix", "matrix", "matrix", "matrix", "matrix", "vector", "ints", "vector"),
    )
)


class Given(NamedTuple):
    """N states: times (N,), qs, vs (N, n), lams (N, m + p); and ``given`` (N, k) for the ``places`` of ``numbers``."""

    times: object
    qs: object
    vs: object
    lams: object
    places: object
    given: object


class StateEquations(NamedTuple):
    """For each state: f; the entries of the matrices of M, Phi_q, Gam_v and Q_lam (tangents) and of (Phi_q v)_q and
    Gam_q (rates); ``numbers`` at ``read`` (values)."""

    read: object
    forces: object
    tangents: object
    rates: object
    values: object


class EquationBuffers(NamedTuple):
    """The buffers of the equations, and the entries of a matrix."""

    vectors: object
    frames: object
    gradients: object
    numbers: object
    layout: object
    matrix: object


@kernel
def sample(evaluate, tangent, states, found, buffers):
    """Fill in what is ``Found`` at the states that are ``Given``, with the kernels of a system."""
    times, qs, vs, lams, places, given = states
    read, forces, tangents, rates, values = found
    vectors, frames, gradients, numbers, layout, matrix = buffers
    n = qs.shape[1]
    for i in range(len(times)):
        for k in range(len(places)):
            numbers[places[k]] = given[i, k]
        for k in range(vectors.shape[1]):
            vectors[L.UNKNOWN, k] = 0.0
            vectors[L.UNKNOWN2, k] = 0.0
        for k in range(lams.shape[1]):
            vectors[L.UNKNOWN, n + k] = lams[i, k]
        for k in range(n):
            vectors[L.POSITION, k] = qs[i, k]
            vectors[L.VELOCITY, k] = vs[i, k]
        evaluate(times[i], vectors, frames, gradients, numbers, layout)
        for k in range(n):
            forces[i, k] = vectors[L.FORCE, k]
        # factors: see mbdsl.kernels.factors
        tangent(
            times[i], 1.0, 0.0, 0.0, 1.0, 1.0, 0.0, 1.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0,
            vectors, frames, gradients, numbers, layout, matrix,
        )  # fmt: skip
        for k in range(len(matrix)):
            tangents[i, k] = matrix[k]
        tangent(
            times[i], 0.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 1.0, 0.0, 1.0, 0.0, 0.0, 0.0,
            vectors, frames, gradients, numbers, layout, matrix,
        )  # fmt: skip
        for k in range(len(matrix)):
            rates[i, k] = matrix[k]
        for k in range(len(read)):
            values[i, k] = numbers[read[k]]


@cache
def compiled() -> Callable:
    """``sample`` compiled, once for all models."""
    from mbdsl.system import batch_accelerations

    apart, together = ", ".join(f for x in (Given, StateEquations, EquationBuffers) for f in x._fields), ""
    for group in (Given, StateEquations, EquationBuffers):
        together += f", batch_accelerations.{group.__name__}({', '.join(group._fields)})"
    text = f'''"""Emitted by mbdsl: the equations of motion at many states."""

from mbdsl.system import batch_accelerations


def sample(evaluate, tangent, {apart}):
    batch_accelerations.sample(evaluate, tangent{together})
'''
    return code_cache.functions("mbdsl_sampling", text, {"sample": SAMPLE}, lambda: [batch_accelerations])[0]


def sampled(
    system: System,
    t: Array,
    q: Array,
    v: Array,
    left_out: tuple[int, ...],
    numbers: Mapping[int, Array],
    least: int | None = None,
) -> tuple[Array, Array, NDArray[np.bool_]] | None:
    """a (N, n) and lam (N, m + p) at states (N,), (N, n), (N, n), and a mask (N,) of the states that have them.

    ``numbers`` are values (N,) by their offset in the tables. None if there are fewer states than ``least`` (``MANY``),
    or if they have to be evaluated one by one: large models, and frames that move as a function of time.
    """
    if len(t) < (MANY if least is None else least) or system.unknowns > DENSE_LIMIT or not code_cache.enabled():
        return None
    states = _States(system, left_out, numbers)
    if states.clock.carried:
        return None
    N, n, rows = len(t), system.n, system.m + system.p
    a, lam, known = np.zeros((N, n)), np.zeros((N, rows)), np.zeros(N, bool)
    chunk = max(1, TOGETHER // system.unknowns**2)
    for first in range(0, N, chunk):
        at = np.arange(first, min(first + chunk, N))
        a[at], lam[at], known[at] = states.solve(t, q, v, lam, at)
        if system.of_multipliers:
            at = at[known[at]]
            known[at] = False
            size = np.abs(lam[at]).max(axis=1, initial=0.0)
            for _ in range(ITERATIONS):
                if not len(at):
                    break
                before = lam[at]
                a[at], lam[at], solved = states.solve(t, q, v, lam, at)
                change = np.abs(lam[at] - before).max(axis=1, initial=0.0)
                size = np.maximum(size, np.abs(lam[at]).max(axis=1, initial=0.0))
                done = solved & (change <= CONVERGED * size)
                known[at[done]] = True
                at, size = at[solved & ~done], size[solved & ~done]
    return a, lam, known


class _States:
    """The equations of motion of a system at many states, linearised about multipliers."""

    def __init__(self, system: System, left_out: tuple[int, ...], numbers: Mapping[int, Array]) -> None:
        self.system, self.work = system, system.workspace()
        self.clock = TimeTerms(self.work.layout, system.m, system.p)
        self.kept = np.delete(np.arange(system.m + system.p), left_out)
        self.rotations = system.tables.rotations
        axes = (self.rotations[:, 1:] + np.arange(9)).ravel() if len(self.rotations) else np.zeros(0, np.int64)
        self.read = np.concatenate([self.clock.drivers, self.clock.gammas, axes])
        base = (self.rotations[:, 1:] + BASE + np.arange(4)).ravel() if len(self.rotations) else np.zeros(0, np.int64)
        self.places = np.concatenate([base, np.array(list(numbers), np.int64)])
        self.numbers = list(numbers.values())
        rows, columns = system.tables.pattern
        where = rows * system.unknowns + columns
        self.order = np.argsort(where, kind="stable")
        self.slots, self.starts = np.unique(where[self.order], return_index=True)

    def solve(self, t: Array, q: Array, v: Array, lam: Array, at: Integers):
        """a, lam and whether they are accurate, at the states ``at`` of all."""
        system, clock, w = self.system, self.clock, self.work
        n, count = system.n, len(at)
        q, v, lam = q[at], v[at], lam[at]
        given = [x[at, None] for x in self.numbers]
        if len(self.rotations):  # attitudes are the origins of their charts, as in System.into_charts
            own = self.rotations[:, :1] + np.arange(3)
            given = [rotation_arrays.quaternions(q[:, own]).reshape(count, -1), *given]
            q[:, own] = 0.0
        f, values = np.zeros((count, n)), np.zeros((count, len(self.read)))
        K, N = np.zeros((count, system.size)), np.zeros((count, system.size))
        kernels = system._any_kernels(1)
        held = np.concatenate(given, axis=1) if given else np.zeros((count, 0))
        *states, held = (np.ascontiguousarray(x) for x in (t[at], q, v, lam, held))
        compiled()(
            *(kernels.evaluate, kernels.tangent, *states, self.places, held, self.read, f, K, N, values),
            *(w.vectors, w.frames, w.gradients, w.numbers, w.layout, np.zeros(system.size)),
        )
        drivers, gammas, axes = np.split(values, np.cumsum([len(clock.drivers), len(clock.gammas)]), axis=1)
        in_time = np.zeros((count, clock.size))
        in_time[:, clock.driven], in_time[:, clock.rows] = -drivers, gammas
        R = axes.reshape(count, -1, 3, 3)
        gamma_c = -np.einsum("ijk,ik->ij", self._matrices(N, R)[:, n:, :n], v) - in_time
        A, kept = self._matrices(K, R), self.kept
        U = A[:, :n, n:][:, :, kept]
        b = np.concatenate([f + np.einsum("ijk,ik->ij", U, lam[:, kept]), gamma_c[:, kept]], axis=1)
        a, found, known = _solve(system, A[:, :n, :n], A[:, n:, :n][:, kept], U, b)
        lam[:, kept] = found
        return a, lam, known

    def _matrices(self, entries: Array, R: Array) -> Array:
        """Matrices (N, unknowns, unknowns) in body axes with these entries (N, size); those of one place are added."""
        size = self.system.unknowns
        found = np.zeros((len(entries), size * size))
        if len(self.slots):
            found[:, self.slots] = np.add.reduceat(entries[:, self.order], self.starts, axis=1)
        found = found.reshape(-1, size, size)
        for k, (d, _) in enumerate(self.rotations):
            own = slice(d, d + 3)
            found[:, own] = R[:, k].transpose(0, 2, 1) @ found[:, own]
            found[:, :, own] = found[:, :, own] @ R[:, k]
        return found


def _solve(system: System, M: Array, J: Array, U: Array, b: Array) -> tuple[Array, Array, NDArray[np.bool_]]:
    n, m = system.n, J.shape[1]
    K = np.zeros((len(M), n + m, n + m))
    d = balance(system, M.diagonal(axis1=1, axis2=2), J)
    K[:, :n, :n], K[:, n:, :n], K[:, :n, n:] = M, J, U
    K *= d[:, :, None] * d[:, None, :]
    b = d * b
    with np.errstate(all="ignore"):
        try:
            x = np.linalg.solve(K, b[:, :, None])[:, :, 0]
        except np.linalg.LinAlgError:  # singular at one of the states
            x = np.full_like(b, np.nan)
        r = np.abs(b - np.einsum("ijk,ik->ij", K, x)).max(axis=1, initial=0.0)
        size = np.abs(b).max(axis=1, initial=0.0)
        known = (r <= ACCURATE * size) & (np.abs(x).max(axis=1, initial=0.0) <= BOUNDED * size)
    x = d * x
    return x[:, :n], x[:, n:], known
