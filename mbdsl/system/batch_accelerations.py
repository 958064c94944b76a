"""Accelerations and multipliers at many states: one compiled loop evaluates them, then all are solved together.

The equations are those of :mod:`mbdsl.system.accelerations`, which also solves them where they are nearly singular.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import cache

import numpy as np
from numpy.typing import NDArray

from mbdsl.compilation import code_cache
from mbdsl.compilation.buffer_layout import FORCE, POSITION, UNKNOWN, UNKNOWN2, VELOCITY
from mbdsl.compilation.marks import kernel
from mbdsl.system.accelerations import ACCURATE, BOUNDED, balance
from mbdsl.system.emit import EVALUATE, TANGENT
from mbdsl.system.system import DENSE_LIMIT, System
from mbdsl.system.time_derivatives import Clock

Array = NDArray[np.float64]

#: least number of states for which loading the compiled loop pays off; most numbers in matrices solved together
MANY, TOGETHER = 2000, 2**21
SAMPLE = code_cache.Signature(
    (
        *(EVALUATE, TANGENT, "vector", "matrix", "matrix", "ints", "matrix", "ints"),
        *("matrix", "matrix", "matrix", "matrix", "matrix", "matrix", "matrix", "vector", "ints", "vector"),
    )
)


@kernel
def sample(
    evaluate, tangent, times, qs, vs, places, given, read, forces, tangents, rates, values,
    vectors, frames, gradients, numbers, layout, matrix,
):  # fmt: skip
    """At every state, with ``given`` written to the ``places`` of ``numbers``, write: the forces; the entries of the
    matrices of M, Phi_q and Gam_v (tangents) and of (Phi_q v)_q and Gam_q (rates); ``numbers`` at ``read`` (values)."""
    n = qs.shape[1]
    for i in range(len(times)):
        for k in range(len(places)):
            numbers[places[k]] = given[i, k]
        for k in range(vectors.shape[1]):
            vectors[UNKNOWN, k] = 0.0
            vectors[UNKNOWN2, k] = 0.0
        for k in range(n):
            vectors[POSITION, k] = qs[i, k]
            vectors[VELOCITY, k] = vs[i, k]
        evaluate(times[i], vectors, frames, gradients, numbers, layout)
        for k in range(n):
            forces[i, k] = vectors[FORCE, k]
        # factors: M, K, D, f_lam, Phi_q, N, Gam_v, Gam_q, (M x)_q, columns, U, I, P
        tangent(
            times[i],
            1.0,
            0.0,
            0.0,
            0.0,
            1.0,
            0.0,
            1.0,
            0.0,
            0.0,
            1.0,
            0.0,
            0.0,
            0.0,
            vectors,
            frames,
            gradients,
            numbers,
            layout,
            matrix,
        )
        for k in range(len(matrix)):
            tangents[i, k] = matrix[k]
        tangent(
            times[i],
            0.0,
            0.0,
            0.0,
            0.0,
            0.0,
            1.0,
            0.0,
            1.0,
            0.0,
            1.0,
            0.0,
            0.0,
            0.0,
            vectors,
            frames,
            gradients,
            numbers,
            layout,
            matrix,
        )
        for k in range(len(matrix)):
            rates[i, k] = matrix[k]
        for k in range(len(read)):
            values[i, k] = numbers[read[k]]


@cache
def compiled() -> Callable:
    """``sample`` compiled, once for all models."""
    from mbdsl.system import batch_accelerations

    arguments = (
        "evaluate, tangent, times, qs, vs, places, given, read, forces, tangents, rates, values, "
        "vectors, frames, gradients, numbers, layout, matrix"
    )
    text = f'''"""Emitted by mbdsl: the equations of motion at many states."""

from mbdsl.system import batch_accelerations


def sample({arguments}):
    batch_accelerations.sample({arguments})
'''
    return code_cache.functions("mbdsl_sampling", text, {"sample": SAMPLE}, lambda: [batch_accelerations])[0]


def sampled(
    system: System, t: Array, q: Array, v: Array, left_out: tuple[int, ...], numbers: Mapping[int, Array]
) -> tuple[Array, Array, NDArray[np.bool_]] | None:
    """a (N, n) and lam (N, m + p) at states (N,), (N, n), (N, n), and a mask (N,) of the states that have them.

    ``numbers`` are values (N,) by their offset in the tables. None if there are few states, or if they have to be
    evaluated one by one: large models, friction in joints, frames that move as a function of time, bodies in space,
    whose matrices are in other axes than their forces.
    """
    if len(t) < MANY or system.of_multipliers or system.unknowns > DENSE_LIMIT or not code_cache.enabled():
        return None
    if len(system.tables.rotations):
        return None
    w = system.workspace()
    clock = Clock(w.layout, system.m, system.p)
    if clock.carried:
        return None
    from scipy.sparse import csr_array

    n, size = system.n, system.unknowns
    kept = np.delete(np.arange(system.m + system.p), left_out)
    rows, columns = system.tables.pattern
    where = rows * size + columns, np.arange(system.size)
    place = csr_array((np.ones(system.size), where), shape=(size * size, system.size))
    places, read = np.array(list(numbers), np.int64), np.concatenate([clock.drivers, clock.gammas])
    U = np.column_stack([*numbers.values()]) if numbers else np.zeros((len(t), 0))
    kernels, A = system.kernels(), np.zeros(system.size)
    a, lam, known = np.zeros((len(t), n)), np.zeros((len(t), system.m + system.p)), np.zeros(len(t), bool)
    chunk = max(1, TOGETHER // size**2)
    for first in range(0, len(t), chunk):
        at = slice(first, min(first + chunk, len(t)))
        count = at.stop - at.start
        f, R = np.zeros((count, n)), np.zeros((count, len(read)))
        K, N = np.zeros((count, system.size)), np.zeros((count, system.size))
        now = (np.ascontiguousarray(x[at]) for x in (t, q, v))
        held = np.ascontiguousarray(U[at])
        compiled()(
            kernels.evaluate,
            kernels.tangent,
            *now,
            places,
            held,
            read,
            f,
            K,
            N,
            R,
            w.vectors,
            w.frames,
            w.gradients,
            w.numbers,
            w.layout,
            A,
        )
        in_time = np.zeros((count, clock.size))
        in_time[:, clock.driven] = -R[:, : len(clock.drivers)]
        in_time[:, clock.rows] = R[:, len(clock.drivers) :]
        rates = (place @ N.T).T.reshape(-1, size, size)[:, n:, :n]
        gamma_c = -np.einsum("ijk,ik->ij", rates, v[at]) - in_time
        full = (place @ K.T).T.reshape(-1, size, size)
        J = full[:, n:, :n][:, kept]
        a[at], lam[at][:, kept], known[at] = _solve(system, full[:, :n, :n], J, f, gamma_c[:, kept])
    return a, lam, known


def _solve(system: System, M: Array, J: Array, f: Array, gamma_c: Array) -> tuple[Array, Array, NDArray[np.bool_]]:
    n, m = system.n, J.shape[1]
    K = np.zeros((len(M), n + m, n + m))
    d = balance(system, M.diagonal(axis1=1, axis2=2), J)
    K[:, :n, :n], K[:, n:, :n], K[:, :n, n:] = M, J, J.transpose(0, 2, 1)
    K *= d[:, :, None] * d[:, None, :]
    b = d * np.concatenate([f, gamma_c], axis=1)
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
