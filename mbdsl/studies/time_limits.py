"""Runs with a time limit, for checks by other methods."""

from __future__ import annotations

import math
from collections.abc import Callable
from time import perf_counter
from typing import Any

from mbdsl.errors import IntegrationError
from mbdsl.messages import duration
from mbdsl.simulation.progress import Progress, Purpose
from mbdsl.simulation.simulate import simulated
from mbdsl.simulation.trajectory import Trajectory

SHORTEST = 1e-6  #: seconds below which no run is started
LEAST, TIMES = 10.0, 10.0  #: default limit of a check: least time [s], and time relative to that of the checked run


class TooLong(IntegrationError):
    """A run has exceeded its time limit; ``trajectory`` holds the results so far."""


def allowance(spent: float, budget: float | None, runs: float = 1.0) -> float:
    """The time limit [s] of a check by ``runs`` runs of a result that took ``spent`` [s]; ``budget`` overrides it."""
    return runs * max(LEAST, TIMES * spent) if budget is None else budget


def limited(
    model: Any,
    limit: float = math.inf,
    progress: Callable[[Progress], None] | None = None,
    purpose: str = "",
    **given: Any,
) -> Trajectory:
    """A run of at most ``limit`` seconds, calibration runs included; assembly and compilation are not counted.

    Its progress states the ``purpose``. The other arguments are those of :func:`mbdsl.simulate`.

    Raises
    ------
    TooLong
        If it takes longer.
    KeyboardInterrupt
        If it is interrupted.
    MbdslError
        As :func:`mbdsl.simulate`.
    """
    begun, late = 0.0, False
    shown = None if progress is None else Purpose(progress, purpose)

    def watch(p: Progress) -> None:
        nonlocal begun, late
        begun = begun or perf_counter() - p.seconds
        late = perf_counter() - begun > limit
        if late:
            raise KeyboardInterrupt
        if shown is not None:
            shown(p)

    watch.phase = getattr(shown, "phase", None)  # type: ignore[attr-defined]
    if limit <= SHORTEST:
        raise TooLong("there was no time left for it")
    found = simulated(model, progress=watch, **given)
    if found.status == "interrupted":
        if late:
            error = TooLong(f"it was ended after {duration(limit)}, at t = {found.t[-1]:.4g} s")
            error.trajectory = found
            raise error
        raise KeyboardInterrupt
    return found
