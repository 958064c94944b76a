"""What a step of the method of Moreau and Jean consists of; see :mod:`mbdsl.integrators.contact_steps`."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from mbdsl.numerics.contact_modes import Modes

Array = NDArray[np.float64]
Rows = NDArray[np.int64]


class StepStart(NamedTuple):
    """The start of a step of length h."""

    t: float
    q: Array
    v: Array
    h: float


class StepEquations(NamedTuple):
    """The equations of a step with n coordinates and k constraints, and the inverse (n + k, n + k) of their matrix."""

    A: Array  #: M + C
    C: Array
    U: Array  #: J^T - Q_lam (n, k), at q_theta
    J: Array  #: (k, n)
    inverse: Array


class ClosedContacts(NamedTuple):
    """Contacts (numbers) that are closed in a step, and their rows: W (r, n), with their velocities u (r,) before; and
    the speed that counts as rest."""

    which: Rows
    rows: list[int]
    W: Array
    u: Array
    slow: float


class StepSolution(NamedTuple):
    """x = [dv; h dlam] for s and c, and the impulses P (r,) and modes of the contacts."""

    s: Array
    x: Array
    P: Array
    modes: Modes


class OwnForces(NamedTuple):
    """s (n,) of the motion of a solution; there the states of switches at which forces jump, and their quantities."""

    s: Array
    side: Rows
    quantities: Array
