"""Progress of an integration."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace


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
        Elapsed wall-clock time of this run.
    what : str
        The purpose of this run, if it is one of several, such as "calibration run 2".
    """

    t: float
    start: float
    stop: float
    h: float
    steps: int
    iterations: int
    seconds: float
    what: str = ""


def announce_phase(progress: Callable[[Progress], None] | None, what: str) -> None:
    """Call the method ``phase`` of a callback, if it has one, at the start of work that has no progress to measure."""
    phase = getattr(progress, "phase", None)
    if phase is not None:
        phase(what)


class Purpose:
    """A callback that adds the purpose of a run to its progress, for another callback."""

    def __init__(self, progress: Callable[[Progress], None], what: str) -> None:
        self.progress, self.what = progress, what

    def __call__(self, p: Progress) -> None:
        self.progress(replace(p, what="; ".join(text for text in (self.what, p.what) if text)))

    def phase(self, what: str) -> None:
        announce_phase(self.progress, f"{what} ({self.what})")
