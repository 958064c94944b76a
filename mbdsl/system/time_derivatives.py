"""Partial time derivatives in the constraints at acceleration level: second derivatives of drivers, and Gam_t."""

from __future__ import annotations

import numpy as np

from mbdsl.kernels import buffer_layout as L
from mbdsl.kernels.arrays import Array, Integers
from mbdsl.kernels.columns import PLANE as C
from mbdsl.system.workspace import Workspace


class TimeTerms:
    """The places of time-dependent terms on the gradient tape, for ``m`` and ``p`` constraints."""

    def __init__(self, layout: Integers, m: int, p: int) -> None:
        self.size, registers = m + p, int(layout[L.REGISTERS])
        detail = [int(layout[layout[L.PAIRS] + L.PAIR * r + 4]) for r in range(m)]
        self.driven = np.array([r for r in range(m) if detail[r] >= 0], np.int64)
        self.drivers = np.array([registers + layout[detail[r] + 2] for r in self.driven], np.int64)
        self.rows = np.arange(m, m + p)
        self.gammas = np.array([registers + layout[layout[layout[L.GAMMAS] + k] + 1] for k in range(p)], np.int64)
        records = [layout[layout[L.MOVING] + C.MOVED * k :][: C.MOVED] for k in range(int(layout[L.N_MOVING]))]
        moving = {int(record[0]): registers + record[7:] for record in records}
        #: rows of the gradient table with a side on a frame that moves as a function of time
        self.carried = [
            (r, 3 * side, frame, moving[frame])
            for r in range(m if moving else 0)
            for side in range(2)
            if (frame := int(layout[layout[L.PAIRS] + L.PAIR * r + side])) in moving
        ]

    def __call__(self, w: Workspace) -> Array:
        """Phi_tt and Gam_t (m + p,), with (Phi_q v)_t of frames that move."""
        found = np.zeros(self.size)
        found[self.driven] = -w.numbers[self.drivers]
        found[self.rows] = w.numbers[self.gammas]
        for r, side, frame, accelerations in self.carried:
            rate = w.gradients[r, C.GRADIENT_RATE + side :][:3]
            found[r] += rate @ w.frames[frame, 3:6] + w.gradients[r, side : side + 3] @ w.numbers[accelerations]
        return found
