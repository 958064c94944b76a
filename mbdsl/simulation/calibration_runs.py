"""Calibration runs and what they show: the error estimate of each, the order in which errors decrease, the result."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from mbdsl.integrators.loop import loop_state as S
from mbdsl.kernels.arrays import Array
from mbdsl.simulation.event_sequences import Event
from mbdsl.simulation.ladder_constants import LADDER, order_bounds
from mbdsl.simulation.mechanism_run import Kept

#: status of a run that was ended because it took more steps than it may, in addition to those of
#: :mod:`mbdsl.integrators.loop.loop_state`
COSTLY = 101


@dataclass
class Trial:
    """A calibration run with tolerance ``eps``: q, v (N, n) at the times t (N,) that it reached.

    ``difference`` (N,): largest difference from the run before, up to each time. ``claim`` (N,): the error estimate.
    ``contacts`` (N,): the effect of contacts that the error leaves undecided, included in the claim.
    """

    eps: float
    status: int
    steps: int
    t: Array
    q: Array
    v: Array
    kept: Kept
    difference: Array = field(default_factory=lambda: np.empty(0))
    claim: Array = field(default_factory=lambda: np.empty(0))
    contacts: Array = field(default_factory=lambda: np.empty(0))
    event: Event | None = None  #: the first event that this run and the one before do not have both
    hoped: float = np.inf  #: the error estimate at the end, if errors decrease regularly

    @property
    def done(self) -> bool:
        return self.status == S.DONE

    @property
    def error(self) -> float:
        """The error estimate at the end; infinite if there is none."""
        return float(self.claim[-1]) if len(self.claim) else np.inf

    @property
    def differs(self) -> float:
        return float(self.difference[-1]) if len(self.difference) else np.inf


@dataclass(frozen=True)
class Calibrated:
    """The error estimate of a result (None: unknown), the horizon up to which the tolerance is kept (None: to the end),
    and the reason why it is not kept longer."""

    error: float | None = None
    horizon: float | None = None
    reason: str = ""


def observed_order(trials: Sequence[Trial]) -> float | None:
    """The order p of errors C eps^p from the last three runs, within bounds; None if they do not determine it."""
    if len(trials) < 3 or not 0.0 < trials[-1].differs < trials[-2].differs < LADDER.saturated:
        return None
    sizes, differences = [x.eps for x in trials[-3:]], [x.differs for x in trials[-2:]]
    return order_bounds(sizes, differences, LADDER.least_order, LADDER.most_order, halvings=30)[1]
