"""How far a simulation is: a bar on a terminal, plain lines elsewhere, nothing for work of less than a second."""

from __future__ import annotations

import shutil
from typing import TYPE_CHECKING, TextIO

if TYPE_CHECKING:
    from mbdsl.simulation import Progress

PATIENCE = 1.0  #: seconds of work before anything is shown
BETWEEN_LINES = 5.0  #: seconds between plain lines


class Display:
    """Call it with every ``Progress``; ``say`` prints a line without tearing the bar; ``close`` removes it."""

    def __init__(self, stream: TextIO) -> None:
        self.stream = stream
        self.terminal = stream.isatty()
        self.shown = False
        self.next = PATIENCE

    def __call__(self, progress: Progress) -> None:
        if progress.seconds < self.next:
            return
        if self.terminal:
            width = max(20, shutil.get_terminal_size().columns - 1)
            self.stream.write("\r" + bar(progress, self._block()).ljust(width)[:width])
            self.next = progress.seconds + 0.1
        else:
            self.stream.write(text(progress) + "\n")
            self.next = progress.seconds + BETWEEN_LINES
        self.shown = True
        self.stream.flush()

    def _block(self) -> str:
        return "█" if "utf" in (self.stream.encoding or "").lower() else "#"

    def say(self, line: str) -> None:
        self.close()
        self.stream.write(line + "\n")
        self.stream.flush()

    def close(self) -> None:
        if self.terminal and self.shown:
            self.stream.write("\r" + " " * max(20, shutil.get_terminal_size().columns - 1) + "\r")
            self.stream.flush()
        self.shown = False


def done(p: Progress) -> float:
    return min(1.0, max(0.0, (p.t - p.start) / (p.stop - p.start))) if p.stop > p.start else 1.0


def text(p: Progress) -> str:
    """One line: simulated time, step size, iterations per step, time left."""
    part = done(p)
    left = f"{clock(p.seconds * (1.0 - part) / part)} left" if part > 0.0 else "just begun"
    per_step = p.iterations / p.steps if p.steps else 0.0
    return f"{part:4.0%}  t = {p.t:.4g} of {p.stop:.4g} s  h = {p.h:.2g} s  {per_step:.1f} iterations/step  {left}"


def bar(p: Progress, block: str = "#", length: int = 20) -> str:
    full = int(done(p) * length)
    return f"{block * full}{'.' * (length - full)} {text(p)}"


def clock(seconds: float) -> str:
    """A duration as a person says it."""
    if seconds < 60:
        return f"{seconds:.0f} s"
    minutes, seconds = divmod(round(seconds), 60)
    hours, minutes = divmod(minutes, 60)
    return f"{hours}:{minutes:02}:{seconds:02}" if hours else f"{minutes}:{seconds:02} min"
