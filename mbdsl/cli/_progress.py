"""Progress of a simulation: a bar on a terminal, plain lines in a file, nothing during the first second.

A line states the purpose of a run that is one of several, and estimates the time left from the last seconds.
"""

from __future__ import annotations

import threading
from collections import deque
from collections.abc import Callable
from typing import TYPE_CHECKING, TextIO

from mbdsl.messages import visible, width
from mbdsl.plotting.terminal_text import USUAL, columns

if TYPE_CHECKING:
    from mbdsl.simulation.code_preparation import PreparationProgress as Prepared
    from mbdsl.simulation.progress import Progress
    from mbdsl.studies.runner import StudyProgress

PATIENCE = 1.0  #: seconds of work before anything is shown
BETWEEN_LINES = 5.0  #: seconds between plain lines
RECENT = 3.0  #: seconds of computing from which the time left is estimated, or a tenth of all
SLOWED = 10.0  #: times the estimate by the mean rate from which it says that the rate may change, as near rest
ENDLESS = 100.0 * 86400.0  #: time left [s] above which it is not stated
COLLAPSED = 1e-3  #: step size relative to the longest so far below which this is stated


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
            size = self.size
            line = visible(whole(self._block()), line=True)
            self._move("\r" + (line if len(line) <= size else f"{line[: size - 3].rstrip(' ,')}...").ljust(size))
            self.next = seconds + 0.1
        else:
            self.stream.write(visible(text(), line=True) + "\n")
            self.next = seconds + BETWEEN_LINES
        self.shown = True
        self.stream.flush()

    def count(self, seconds: float, done: int, total: int, what: str) -> None:
        """Show how many of several things are done, and which is next."""
        line, part = f"{done} of {total}  {what}", done / max(1, total)
        self.show(seconds, lambda: line, lambda block: f"{blocks(part, block)} {line}")

    @property
    def size(self) -> int:
        """The columns that a line may have: the terminal's without the last, where some terminals wrap."""
        return (columns(self.stream, 20) or USUAL) - 1

    def _block(self) -> str:
        return "█" if "utf" in (self.stream.encoding or "").lower() else "#"

    def say(self, line: str) -> None:
        self.close()
        self.stream.write(line + "\n")
        self.stream.flush()

    def close(self) -> None:
        if self.terminal and self.shown:
            self._move("\r" + " " * self.size + "\r")
            self.stream.flush()
        self.shown = False


class Display(_Line):
    """Callback for ``Progress``; ``say`` prints a line without damaging the bar; ``close`` removes the bar.

    ``phase`` names work without measured progress, such as compilation. A terminal shows it after a second.
    """

    def __init__(self, stream: TextIO) -> None:
        super().__init__(stream)
        self._pace = Pace()
        self._before = self._last = 0.0  #: seconds of the runs before this one, and of this one so far
        self._waiting: threading.Timer | None = None

    def __call__(self, progress: Progress) -> None:
        self._end_phase()
        pace = self._pace
        if pace.add(progress):
            self._before += self._last
        self._last = progress.seconds
        self.show(
            self._before + progress.seconds,
            lambda: text(progress, pace),
            lambda block: bar(progress, block, pace, self.size),
        )

    def phase(self, what: str) -> None:
        self._end_phase()
        if self.terminal:
            self._waiting = threading.Timer(PATIENCE, self._wait, (what,))
            self._waiting.daemon = True
            self._waiting.start()

    def _wait(self, what: str) -> None:
        self.show(self.next, str, lambda block: f"{what} ...")

    def _end_phase(self) -> None:
        if self._waiting is not None:
            self._waiting.cancel()
            self._waiting.join()  # it may be writing
            self._waiting = None

    def close(self) -> None:
        self._end_phase()
        super().close()


class Pace:
    """The rate at which a run advances, over its last ``RECENT`` of computing.

    An estimate of the time left from the mean rate since the start is wrong by any factor if a run slows down.
    """

    def __init__(self) -> None:
        self._points: deque[tuple[float, float]] = deque()
        self._longest = self._seconds = 0.0

    def add(self, p: Progress) -> bool:
        """Note the progress of a run; whether it is another run than before."""
        another = bool(self._points) and (p.seconds < self._seconds or p.t < self._points[-1][1])
        self._seconds = p.seconds
        if another:
            self._points.clear()
            self._longest = 0.0
        if not self._points:
            self._points.append((0.0, p.start))
        self._longest = max(self._longest, p.h)
        if p.seconds - self._points[-1][0] >= 0.05:  # seldom enough for a short list
            self._points.append((p.seconds, p.t))
        while len(self._points) > 2 and p.seconds - self._points[1][0] > max(RECENT, 0.1 * p.seconds):
            self._points.popleft()
        return another

    def left(self, p: Progress) -> str:
        """The time left, as a text."""
        seconds, t = self._points[0]
        if p.t <= p.start:
            return "just begun"
        if p.t <= t or p.seconds <= seconds:
            return "stands still" if p.seconds - seconds > RECENT else "just begun"
        left = (p.stop - p.t) * (p.seconds - seconds) / (p.t - t)
        if left >= ENDLESS:
            return "hardly advances"
        usual = (p.stop - p.t) * p.seconds / (p.t - p.start)
        return f"{clock(left)} left" + " at this rate" * (left > SLOWED * usual)

    def step(self, p: Progress) -> str:
        """The present step size, with the longest so far if it has collapsed."""
        fallen = f" (fallen from {self._longest:.2g} s)" if p.h < COLLAPSED * self._longest else ""
        return f"h = {p.h:.2g} s{fallen}"


class Counter(_Line):
    """Callback for ``StudyProgress``; ``kept`` is the number of stored runs."""

    kept = 0

    def __call__(self, study: StudyProgress) -> None:
        self.kept = study.kept
        self.count(study.seconds, study.done, study.total, study.what)


class Preparation(_Line):
    """Callback for the progress of ``mbdsl warm``; in a file or a pipe, each line appears once."""

    _last = ""

    def __call__(self, progress: Prepared) -> None:
        now = f"{progress.done} {progress.what}"
        if now == self._last and not self.terminal:
            return
        self._last = now
        self.count(progress.seconds, progress.done, progress.total, f"compiling {progress.what}")


def done(p: Progress) -> float:
    return min(1.0, max(0.0, (p.t - p.start) / (p.stop - p.start))) if p.stop > p.start else 1.0


def text(p: Progress, pace: Pace | None = None, iterations: bool = True) -> str:
    """One line: simulated time, step size, iterations per step, time left, purpose of the run.

    Third-party integrators state neither their step size nor iterations, explicit methods have no iterations.
    """
    if pace is None:
        pace = Pace()
        pace.add(p)
    known = p.h < p.stop - p.start
    counted = known and iterations and p.iterations > 0
    per_step = f"{p.iterations / p.steps if p.steps else 0.0:.1f} iterations/step" if counted else ""
    parts = [f"{done(p):4.0%}", f"t = {p.t:.4g} of {p.stop:.4g} s", pace.step(p) if known else "", per_step]
    return "  ".join(part for part in (*parts, pace.left(p), p.what) if part)


def blocks(part: float, block: str = "#", length: int = 20) -> str:
    full = int(part * length)
    return block * full + "." * (length - full)


def bar(p: Progress, block: str = "#", pace: Pace | None = None, size: int = 200) -> str:
    """The line with a bar, in at most ``size`` columns: iterations, the bar, and purpose are shortened in turn."""
    line = text(p, pace)
    if width(line) + 21 > size:
        line = text(p, pace, iterations=False)
    if width(line) > size and p.what:
        line = f"{line[: size - 3]}..."
    length = next((n for n in (20, 15, 10, 5) if width(line) + n + 1 <= size), 0)
    return f"{blocks(done(p), block, length)} {line}" if length else line


def clock(seconds: float) -> str:
    """A duration as seconds, minutes or hours."""
    if seconds < 60:
        return f"{seconds:.0f} s"
    minutes, seconds = divmod(round(seconds), 60)
    hours, minutes = divmod(minutes, 60)
    return f"{hours}:{minutes:02}:{seconds:02}" if hours else f"{minutes}:{seconds:02} min"
