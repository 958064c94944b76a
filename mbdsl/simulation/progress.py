"""Progress of an integration."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Progress:
    """Progress of an integration, passed to the callback ``progress`` about ten times a second.

    Attributes
    ----------
    t : float [s]
        Time reached.
    start, stop : float [s]
        Interval of integration.
    h : float [s]
        Present step size.
    steps, iterations : int
        Numbers of steps and of Newton iterations so far.
    seconds : float [s]
        Elapsed wall-clock time.
    """

    t: float
    start: float
    stop: float
    h: float
    steps: int
    iterations: int
    seconds: float
