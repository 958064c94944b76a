"""Steps that end where something happens: within each of the zones around peaks of laws, one at least.

What the zones are: :mod:`mbdsl.system.unseen`. Those of time alone are known before the run, and come as it goes; the
compiled loop holds the next ones. Nothing begins anew in a zone: a step ends there, and its test of errors sees what
the law does.
"""

from __future__ import annotations

from collections.abc import Iterator
from itertools import islice
from typing import TYPE_CHECKING

from mbdsl.integrators.state import NEXT_ZONE, NOW, ROOM, ZONE, ZONES
from mbdsl.kernels import rare

if TYPE_CHECKING:
    from mbdsl.integrators.run import Integration
    from mbdsl.system.unseen import Zone


#: longest controlled step, as a part of the run, for want of a shorter one
LONGEST = 0.02


@rare
def until_zone(h, K, J):
    """The step h, or the part of it that ends in the middle of the next zone, if it would pass that; 0 where more zones
    have to be asked for."""
    while J[NEXT_ZONE] < J[ZONES] and K[NOW] >= K[ZONE + 2 * J[NEXT_ZONE]]:
        J[NEXT_ZONE] += 1
    if J[NEXT_ZONE] == J[ZONES]:
        return 0.0
    start, end = K[ZONE + 2 * J[NEXT_ZONE]], K[ZONE + 2 * J[NEXT_ZONE] + 1]
    return h if K[NOW] + h <= end else 0.5 * (start + end) - K[NOW]


class Landings:
    """The zones of a run with controlled steps."""

    def __init__(self, run: Integration) -> None:
        self._run = run
        self._zones: Iterator[Zone] = iter(())

    def begin(self, t: float) -> None:
        """At the start of the run."""
        run = self._run
        self._zones = run.system.time_zones(t, run.stop, LONGEST * (run.stop - run.start))
        self.refill()

    def rejoin(self) -> None:
        """After the run has been put where a checkpoint was: the zones behind the last that the compiled loop holds."""
        run = self._run
        if (held := run.J[ZONES]) == 0:
            return
        last = tuple(run.K[ZONE + 2 * (held - 1) : ZONE + 2 * held])
        self._zones = run.system.time_zones(run.start, run.stop, LONGEST * (run.stop - run.start))
        for zone in self._zones:
            if (zone.start, zone.end) == last:
                break

    def refill(self) -> None:
        """The next zones, for the compiled loop."""
        run = self._run
        found = list(islice((z for z in self._zones if z.start > run.time), ROOM))
        for k, zone in enumerate(found):
            run.K[ZONE + 2 * k : ZONE + 2 * k + 2] = zone.start, zone.end
        run.J[NEXT_ZONE], run.J[ZONES] = 0, len(found)
