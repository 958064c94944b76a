"""Violations of constraints that were left out as redundant: the motion is then not that of the model any more."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from mbdsl.initial.consistent import InitialState
from mbdsl.kernels.arrays import Array
from mbdsl.numerics.saddle_point import dense
from mbdsl.simulation import derived_signals
from mbdsl.system import System

#: violations, relative to the mechanism's size or in radians, up to which they count as rounding and errors of
#: positions; and if the other constraints are violated by at least a part of them
LARGEST, LARGEST_ALIKE, PART = 1e-6, 1e-3, 0.1


def violations(
    system: System, first: InitialState, t: Array, q: Array, v: Array, numbers: derived_signals.Numbers
) -> Array:
    """The violations (N, m + p) of all constraints at states q, v (N, n) at times t (N,).

    ``numbers`` are the angles that count turns at these states; without them, the system has those of the state.
    Lengths are relative to the mechanism's size; angles, whose rows depend on rotations only, are in radians.
    """
    size = system.tables.size
    if system.scene.spatial:
        J = dense(system.velocity_jacobian(first.t, first.q, first.v))
        size = np.where((J[:, system.tables.lengths] != 0.0).any(axis=1), size, 1.0)
    Phi, _, Gam = derived_signals.residuals(system, t, q, v, numbers)
    found = np.abs(np.concatenate([Phi, Gam], axis=1)) / size
    found[:, list(system.tables.switchable)] = 0.0  # hold at times only
    return found


def violated(every: Array, redundant: Sequence[int]) -> NDArray[np.bool_]:
    """Whether constraints that were left out are violated (N,), from the violations of all (N, m + p).

    A method that does not satisfy the others exactly does not satisfy these either, and its errors are known.
    """
    found, others = every[:, list(redundant)].max(axis=1), np.delete(every, redundant, axis=1).max(axis=1, initial=0.0)
    return found > np.clip(others / PART, LARGEST, LARGEST_ALIKE)
