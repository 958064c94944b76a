"""The objective of the assembly: the distance of a state from its initial guess."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from mbdsl.expressions.symbolic import RATE, coordinate
from mbdsl.mechanism.reduction import Reduction
from mbdsl.system.signals import Matrix, gradients
from mbdsl.system.system import System

Array = NDArray[np.float64]

UNSAID = 1e-4  #: weight of a coordinate without a guess


def members_of(reduction: Reduction, system: System) -> dict[str, list[str]]:
    """The frames at the centres of mass of welded bodies of a part, by the name of their merged body."""
    merged = [note.names for note in reduction.notes if note.action == "merged"]
    own = system.tables.coordinates
    return {names[0]: [f"{name}.c" for name in names] for names in merged if names[0] in own}


class Metric:
    """The distance from a guess, or from rest, of coordinates without an initial value: a sum over all bodies.

    Each body of a group of welded bodies counts: ``members`` are the frames at their centres of mass, by the name of
    the merged body.
    """

    def __init__(self, system: System, members: Mapping[str, Sequence[str]]) -> None:
        self.weight = np.full(system.n, UNSAID)  #: weight of coordinates measured in ``scale``
        size, self.positions, self.velocities = 1.0 / system.tables.size, [], []
        for body, frames in members.items():
            first = system.tables.coordinates[body]
            self.weight[first : first + 3] = 0.0
            for frame in frames:
                self.positions += [coordinate(frame, key) for key in RATE]
                self.velocities += [coordinate(frame, key) for key in RATE.values()]
        self.row_weight = UNSAID * np.tile([size, size, 1.0], len(self.positions) // 3)[:, None]
        self.system = system

    def positions_at(self, t: float, q: Array) -> tuple[Array, Matrix]:
        """Weighted coordinates of members, and their gradient with respect to q."""
        value, d_q, _ = gradients(self.system, self.positions, t, q, np.zeros(self.system.n))
        return self.row_weight[:, 0] * value, scaled(d_q, self.row_weight, np.ones(self.system.n))

    def velocities_at(self, t: float, q: Array, v: Array) -> tuple[Array, Matrix]:
        """Weighted velocities of members, and their gradient with respect to v."""
        value, _, d_v = gradients(self.system, self.velocities, t, q, v)
        return self.row_weight[:, 0] * value, scaled(d_v, self.row_weight, np.ones(self.system.n))


def scaled(J: Matrix, rows: Array, columns: Array) -> Matrix:
    if isinstance(J, np.ndarray):
        return rows * J / columns
    from scipy.sparse import diags_array

    return diags_array(rows[:, 0]) @ J @ diags_array(1.0 / columns)
