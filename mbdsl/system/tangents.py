"""Matrices of the linearised equations at many states, dense, for models of moderate size.

A call of compiled code from Python takes longer than an evaluation of a small model. Therefore the arguments of all
calls are prepared once, and all entries are added to matrices together.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

import numpy as np

from mbdsl.kernels import buffer_layout as L
from mbdsl.kernels.arrays import Array
from mbdsl.system.emit import FACTORS
from mbdsl.system.system import System


def tangents(
    system: System, t: Array, q: Array, v: Array, lam: Array, a: Array | None, requests: Sequence[Mapping[str, float]]
) -> list[Array]:
    """A list of matrices (N, n + m + p, n + m + p) at states q, v (N, n), lam (N, m + p) at times t (N,).

    ``requests`` contains the factors of each, as keywords of ``System.entries``; those with ``cA`` need the
    accelerations a (N, n). Rotations of bodies in space are in world axes.
    """
    n, size, count, w = system.n, system.unknowns, len(t), system._at(t[0], q[0], v[0], lam[0])
    kernels, A, vectors = system._any_kernels(1), np.zeros(system.size), w.vectors
    rest = vectors, w.frames, w.gradients, w.numbers, w.layout
    position, velocity, accelerations = vectors[L.POSITION, :n], vectors[L.VELOCITY, :n], vectors[L.UNKNOWN, :n]
    multipliers = vectors[L.UNKNOWN, n:size]
    evaluate = _of_time(kernels.evaluate, *rest)
    calls = [_of_time(kernels.tangent, *(x.get(c, float(c == "cC")) for c in FACTORS), *rest, A) for x in requests]
    found = np.empty((len(requests), count, system.size))
    in_space = len(system.tables.rotations) > 0
    for k, now in enumerate(t.tolist()):
        position[:] = system.into_charts(q[k], w.numbers) if in_space else q[k]
        velocity[:], multipliers[:] = v[k], lam[k]
        evaluate(now)
        if a is not None:
            accelerations[:] = a[k]
        for tangent, entries in zip(calls, found, strict=True):
            tangent(now)
            entries[k] = A
    rows, columns = system.tables.pattern
    place = (np.arange(count)[:, None] * size**2 + rows * size + columns).ravel()
    sums = [np.bincount(place, x.ravel(), count * size**2).astype(np.float64, copy=False) for x in found]
    return [x.reshape(count, size, size) for x in sums]


def _of_time(function: Callable, *others) -> Callable[[float], object]:
    prepare = getattr(function, "prepared", None)  # code that is not compiled has none
    return (lambda t: function(t, *others)) if prepare is None else prepare(0.0, *others)
