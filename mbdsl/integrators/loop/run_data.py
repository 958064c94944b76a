"""What the kernels of a step share: the kernels of the method, and the scene's functions with the buffers of the run.

Both are named tuples, which numba takes apart when it compiles: a kernel pays for what it uses of them, and for nothing
else.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from mbdsl.compilation.marks import kernel

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]


class Formulas(NamedTuple):
    """The kernels of a method; see :mod:`mbdsl.integrators.loop.driver`."""

    motion: Callable
    residual: Callable
    matrix: Callable
    correct: Callable
    finish: Callable
    estimate: Callable
    local_error: Callable
    change_step: Callable


class RunData(NamedTuple):
    """The compiled functions of the scene, and all that is read and written in a run.

    Rows, columns and entries of the buffers have names in :mod:`mbdsl.compilation.buffer_layout`, those of ``reals``
    and ``integers`` in :mod:`mbdsl.integrators.loop.loop_state`.
    """

    evaluate_at: Callable  #: called by :func:`evaluate`
    tangent_at: Callable  #: called by :func:`mbdsl.integrators.loop.tangent_matrices.tangent`
    inertia_at: Callable  #: called by :func:`inertia`
    coefficients: Floats  #: numbers of the method that follow from its options; no kernel changes them
    memory: Floats  #: numbers that the method carries from step to step
    reals: Floats  #: floats of the step loop
    integers: Integers  #: integers of the step loop
    vectors: Floats  #: (rows, N) vectors of the step
    frames: Floats  #: (frames, columns) frame table
    gradients: Floats  #: (coordinates of frame pairs, columns) gradient table
    numbers: Floats  #: float tables and registers
    layout: Integers  #: integer tables: where in the other buffers what is
    matrices: Floats  #: (matrices, entries) iteration matrices
    pivots: Integers  #: (matrices, entries) their pivots, or rows and columns of their entries


@kernel
def evaluate(t, run):
    """Rows FORCE, FORCE2 (and PAST_FORCE) of ``vectors`` at the state in rows POSITION and VELOCITY."""
    run.evaluate_at(t, run.vectors, run.frames, run.gradients, run.numbers, run.layout)


@kernel
def inertia(task, row, target, run):
    """A task of the mass matrix (:mod:`mbdsl.compilation.buffer_layout`), from one row of ``vectors`` to another."""
    run.inertia_at(task, row, target, run.vectors, run.numbers, run.layout)
