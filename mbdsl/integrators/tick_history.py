"""What ticks of clocks add to the history of a method, for :mod:`mbdsl.integrators.loop.ticks`."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from mbdsl.integrators.method import Method, Start
from mbdsl.kernels import buffer_layout as L
from mbdsl.kernels.arrays import Array

if TYPE_CHECKING:
    from mbdsl.system import System

#: highest order of methods whose history needs no jumps of rates
HIGHEST = 2


def weights(method: Method, c: Array, system: System, rows: int) -> list[float] | None:
    """The numbers appended to the coefficients c of a method with so many ``rows`` of vectors; None if its history
    cannot take a jump in compiled code, as that of forces over masses if M is not diagonal."""
    if method.order > HIGHEST or not system.tables.layout[L.TICKS]:
        return None
    of_a, of_fa, of_lam = (_rows(method, c, k, 1.0) for k in range(3))
    doubled = _rows(method, c, 0, 2.0)
    if L.FORCE0 in of_a or (any(of_fa.values()) and (system.p or not system.mass_is_diagonal)):
        return None
    found: list[float] = []
    older = rows - 2 * method.older
    histories = {L.UNKNOWN0: older, L.UNKNOWN0 + L.PAST: older + method.older}
    for row, a in of_a.items():
        exponent = float(np.log2(doubled[row] / a)) if a else 0.0
        own = list(range(row, row + (L.PAST if row in histories else 1)))
        own += range(histories[row], histories[row] + method.older) if row in histories else ()
        for k in own:
            found += [float(k), a, round(exponent), of_fa[row], of_lam[row]]
    return [*found, float(len(found) // 5)]


def _rows(method: Method, c: Array, which: int, h: float) -> dict[int, float]:
    """Row -> what one unit of the accelerations, of the applied forces over masses, or of the multipliers adds to it.

    The rows are those of one coordinate and one constraint.
    """
    zero, one = np.zeros(1), np.ones(1)
    a, fa, lam = (one if k == which else zero for k in range(3))
    start = Start(h, zero, zero, a, lam, fa, zero, zero, False)
    place = 1 if which == 2 else 0
    return {row: float(x[place]) if len(x) > place else 0.0 for row, x in method.begin(c, start).items()}
