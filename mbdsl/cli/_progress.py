"""Progress of a simulation: a bar on a terminal, plain lines in a file, nothing during the first second."""

from __future__ import annotations

import shutil
from collections.abc import Callable
from typing import TYPE_CHECKING, TextIO

from mbdsl.messages import visible

if TYPE_CHECKING:
    from mbdsl.simulation.progress import Progress
    from mbdsl.studies.runner import StudyProgress

PATIENCE = 1.0  #: seconds of work before anything is shown
BETWEEN_LINES = 5.0  #: seconds between plain lines


class _Line:
    """A line that is overwritten on a terminal; separate lines in a file."""

    def __init__(self, stream: TextIO) -> None:
        self.stream = stream
        self._move: Callable[[str], object] = getattr(stream, "write_raw", stream.write)
        self.terminal = stream.isatty()
        self.shown = False
        self.next = PATIENCE

    def show(self, seconds: float, text: Callable[[], str], whole: Callable[[str], str]) -> None:
        """Show a text, with its bar on a terminal, unless it is too early; ``seconds`` is the time since the start."""
        if seconds < self.next:
            return
        if self.terminal:
            width = max(20, shutil.get_terminal_size().columns - 1)
            self._move("\r" + visible(whole(self._block()), line=True).ljust(width)[:width])
            self.next = seconds + 0.1
        else:
            self.stream.write(visible(text(), line=True) + "\n")
            self.next = seconds + BETWEEN_LINES
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
            self._move("\r" + " " * max(20, shutil.get_terminal_size().columns - 1) + "\r")
            self.stream.flush()
        self.shown = False


class Display(_Line):
    """Callback for ``Progress``; ``say`` prints a line without damaging the bar; ``close`` removes the bar."""

    def __call__(self, progress: Progress) -> None:
        self.show(progress.seconds, lambda: text(progress), lambda block: bar(progress, block))


class Counter(_Line):
    """Callback for ``StudyProgress``; ``kept`` is the number of stored runs."""

    kept = 0

    def __call__(self, study: StudyProgress) -> None:
        self.kept = study.kept
        line = f"{study.done} of {study.total}  {study.what}"
        part = study.done / max(1, study.total)
        self.show(study.seconds, lambda: line, lambda block: f"{blocks(part, block)} {line}")


def done(p: Progress) -> float:
    return min(1.0, max(0.0, (p.t - p.start) / (p.stop - p.start))) if p.stop > p.start else 1.0


def text(p: Progress) -> str:
    """One line: simulated time, step size, iterations per step, time left."""
    part = done(p)
    left = f"{clock(p.seconds * (1.0 - part) / part)} left" if part > 0.0 else "just begun"
    per_step = p.iterations / p.steps if p.steps else 0.0
    return f"{part:4.0%}  t = {p.t:.4g} of {p.stop:.4g} s  h = {p.h:.2g} s  {per_step:.1f} iterations/step  {left}"


def blocks(part: float, block: str = "#", length: int = 20) -> str:
    full = int(part * length)
    return block * full + "." * (length - full)


def bar(p: Progress, block: str = "#", length: int = 20) -> str:
    return f"{blocks(done(p), block, length)} {text(p)}"


def clock(seconds: float) -> str:
    """A duration as seconds, minutes or hours."""
    if seconds < 60:
        return f"{seconds:.0f} s"
    minutes, seconds = divmod(round(seconds), 60)
    hours, minutes = divmod(minutes, 60)
    return f"{hours}:{minutes:02}:{seconds:02}" if hours else f"{minutes}:{seconds:02} min"
