"""The range of the theory of flexible bodies: in a floating frame, deformation has to be small."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from mbdsl.bodies.contract import LARGEST_BEND
from mbdsl.system.system import System

#: the theory, as messages name it, and the remedy
SMALL = "a floating frame assumes small deformation"
REMEDY = 'formulation = "ancf" allows large deformation'


class Bend(NamedTuple):
    """A body that bends further than its theory allows: the state's row, its name, and the angle [rad]."""

    row: int
    name: str
    angle: float


def first_bend(system: System, q: NDArray[np.float64]) -> Bend | None:
    """The first of N states q (N, n) at which a body bends beyond the range of its theory; None if none does."""
    first: Bend | None = None
    for name in system.tables.flexible:
        body, d = system.tables.models[name], system.tables.coordinates[name]
        angles = body.bend(q[:, d : d + body.n])
        beyond = np.flatnonzero(angles > LARGEST_BEND)
        if len(beyond) and (first is None or beyond[0] < first.row):
            first = Bend(int(beyond[0]), name, float(angles[beyond[0]]))
    return first
