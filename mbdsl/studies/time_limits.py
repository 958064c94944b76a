"""Runs with a time limit."""

from __future__ import annotations

import math
from collections.abc import Callable
from time import perf_counter
from typing import Any

from mbdsl.errors import IntegrationError
from mbdsl.messages import duration
from mbdsl.simulation.progress import Progress, Purpose, announce_phase
from mbdsl.simulation.simulate import simulated
from mbdsl.simulation.trajectory import Trajectory
from mbdsl.storage import cache_folder

SHORTEST = 1e-6  #: seconds below which no run is started
LEAST, TIMES = 10.0, 10.0  #: default limit of a check: least time [s], and time relative to that of the checked run


class TooLong(IntegrationError):
    """A run has exceeded its time limit; ``trajectory`` holds the results so far."""


class Deadline:
    """Ends a run when its time is over: it is the run's callback ``progress``.

    Parameters
    ----------
    limit : float [s]
        For the step loop, calibration runs included.
    left : float [s]
        From now on, compilation included.
    compiling : float [s]
        Expected time of a compilation: none is begun that would exceed ``left``.
    shown : callable, optional
        Another callback for the progress.

    Attributes
    ----------
    spent : dict
        Seconds of the step loop and of the compilation of a run that was ended; empty if its loop had not begun.
    """

    def __init__(
        self,
        limit: float,
        left: float = math.inf,
        compiling: float = 0.0,
        shown: Callable[[Progress], None] | None = None,
    ) -> None:
        self.limit, self.end, self.compiling, self.shown = limit, perf_counter() + left, compiling, shown
        self.begun, self.seconds, self.late = 0.0, 0.0, False
        self.spent: dict[str, float] = {}

    def __call__(self, now: Progress) -> None:
        """Progress starts from zero in every calibration run."""
        clock = perf_counter()
        self.begun = self.begun or clock - now.seconds
        self.seconds = clock - self.begun
        self._check(self.seconds > self.limit or clock > self.end)
        if self.shown is not None:
            self.shown(now)

    def phase(self, what: str) -> None:
        announce_phase(self.shown, what)

    def announcing(self, announce: Callable[[str], None] | None) -> Callable[[str], None]:
        """``announce``, and a check before a compilation."""

        def said(text: str) -> None:
            self._check(text == cache_folder.compiling() and perf_counter() + self.compiling > self.end)
            if announce is not None:
                announce(text)

        return said

    def _check(self, over: bool) -> None:
        if over:
            self.late = True
            raise KeyboardInterrupt

    def run(self, simulate: Callable[[], Trajectory]) -> Trajectory:
        """The trajectory of a run with this callback.

        Raises
        ------
        TooLong
            If it was ended.
        KeyboardInterrupt
            If it was interrupted.
        """
        error = TooLong("there was no time left for it")
        try:
            found = simulate()
            if found.status != "interrupted":
                return found
            after = duration(min(self.limit, self.seconds))
            error = TooLong(f"it was ended after {after}, at t = {found.t[-1]:.4g} s")
            error.trajectory = found
            self.spent = {"integrate": self.seconds, "compile": found.stats["seconds"]["compile"]}
        except KeyboardInterrupt:
            if not self.late:
                raise
        if not self.late:
            raise KeyboardInterrupt
        raise error


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
    if limit <= SHORTEST:
        raise TooLong("there was no time left for it")
    deadline = Deadline(limit, shown=None if progress is None else Purpose(progress, purpose))
    return deadline.run(lambda: simulated(model, progress=deadline, **given))
