"""Named groups, arguments of the kernels: the kernels of the method; the functions of the scene and the buffers.

Named tuples are resolved at compilation: a kernel reads only those fields that it uses.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from mbdsl.kernels.marks import kernel

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]


class Step(NamedTuple):
    """The kernels of a step that the loop calls; see :mod:`mbdsl.integrators.loop.driver`."""

    trial_length: Callable
    take: Callable
    interpolate: Callable
    store: Callable
    next_length: Callable


class Formulas(NamedTuple):
    """The kernels of a method that the common step calls; see :mod:`mbdsl.integrators.loop.multistep`."""

    motion: Callable
    residual: Callable
    matrix: Callable
    correct: Callable
    finish: Callable
    estimate: Callable
    local_error: Callable
    change_step: Callable


class RunData(NamedTuple):
    """The compiled functions of the scene, and the buffers of a run.

    Rows, columns and entries of the buffers have names in :mod:`mbdsl.kernels.buffer_layout`, those of ``reals``
    and ``integers`` in :mod:`mbdsl.integrators.loop.loop_state`.
    """

    evaluate_at: Callable  #: called by :func:`evaluate`
    tangent_at: Callable  #: called by :func:`mbdsl.integrators.loop.tangent_matrices.tangent_matrix`
    inertia_at: Callable  #: called by :func:`inertia`
    coefficients: Floats  #: the method's numbers, which follow from its options; constant
    memory: Floats  #: numbers that the method carries from step to step
    reals: Floats  #: floats of the step loop
    integers: Integers  #: integers of the step loop
    vectors: Floats  #: (rows, N) vectors of the step
    frames: Floats  #: (frames, columns) frame table
    gradients: Floats  #: (coordinates of frame pairs, columns) gradient table
    numbers: Floats  #: float tables and registers
    layout: Integers  #: integer tables: positions of everything in the other buffers
    matrices: Floats  #: (matrices, entries) iteration matrices
    pivots: Integers  #: (matrices, entries) their pivots, or rows and columns of their entries


#: the buffers that steps change
CHANGED = RunData._fields[RunData._fields.index("memory") :]


@kernel
def evaluate(t, run):
    """Rows FORCE, FORCE2 (and PAST_FORCE) of ``vectors`` at the state in rows POSITION and VELOCITY."""
    run.evaluate_at(t, run.vectors, run.frames, run.gradients, run.numbers, run.layout)


@kernel
def inertia(task, row, target, run):
    """A task of the mass matrix (:mod:`mbdsl.kernels.buffer_layout`), from one row of ``vectors`` to another."""
    run.inertia_at(task, row, target, run.vectors, run.numbers, run.layout)
