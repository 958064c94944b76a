"""The user's calls: what a program gives remembers the line that gave it, which errors name later."""

from __future__ import annotations

import linecache
import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass

from mbdsl.errors import ModelError, Span
from mbdsl.lang.source import Source

_PACKAGE = os.path.dirname(os.path.dirname(os.path.abspath(__file__))) + os.sep


class CallLine(Source):
    """The line outside of mbdsl that is being executed; its text is read when an error shows it."""

    def __init__(self) -> None:
        frame = sys._getframe(1)
        while frame.f_back is not None and frame.f_code.co_filename.startswith(_PACKAGE):
            frame = frame.f_back
        super().__init__(frame.f_code.co_filename, "")
        self.line = frame.f_lineno

    def _span(self, start: int = 0, end: int = 0) -> Span:
        text = linecache.getline(self.file, self.line).rstrip()
        begin = len(text) - len(text.lstrip())
        return Span(self.file, self.line, begin + 1, max(1, len(text) - begin), text)


@dataclass(frozen=True, slots=True)
class GivenSpan(Span):
    """A place in a text that a program gave, and the line of the call."""

    call: Span | None = None


class GivenText(Source):
    """A text that a program gives for the argument ``what``."""

    def __init__(self, what: str, text: str) -> None:
        super().__init__(f"<{what}>", text)
        self.call = CallLine()

    def _span(self, start: int, end: int) -> Span:
        found = super()._span(start, end)
        return GivenSpan(found.file, found.line, found.column, found.length, found.text, self.call.span(0, 0))


@contextmanager
def called() -> Iterator[None]:
    """While the block runs, errors of given texts get a note with the line that gave them."""
    try:
        yield
    except ModelError as problem:
        if isinstance(problem.span, GivenSpan):
            problem.notes = (*problem.notes, ("it was given here", problem.span.call))
        raise
