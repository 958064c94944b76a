"""A source text and places in it, for messages."""

from __future__ import annotations

from bisect import bisect_right
from functools import cached_property
from itertools import accumulate

from mbdsl.errors import ModelError, Span


class Source:
    """One text of the language, with the name under which messages show it."""

    def __init__(self, file: str, text: str) -> None:
        self.file = file
        self.text = text
        self._spans: dict[tuple[int, int], Span] = {}  # loops request the same places repeatedly
        self._lines: dict[int, str] = {}  # shared by the places in them: a line may be as long as the text

    @cached_property
    def _starts(self) -> list[int]:
        return [0, *accumulate(len(line) for line in self.text.split("\n") for line in (line + "\n",))]

    def span(self, start: int, end: int) -> Span:
        """The place from ``start`` to ``end`` (offsets), cut at the end of its first line."""
        found = self._spans.get((start, end))
        if found is None:
            found = self._spans[start, end] = self._span(start, end)
        return found

    def _span(self, start: int, end: int) -> Span:
        start = min(start, len(self.text))
        line = bisect_right(self._starts, start) - 1
        first = self._starts[line]
        if (text := self._lines.get(line)) is None:
            last = self._starts[line + 1] - 1 if line + 1 < len(self._starts) else len(self.text)
            text = self._lines[line] = self.text[first:last].rstrip("\r")
        length = max(1, min(end, first + len(text)) - start)
        return Span(self.file, line + 1, start - first + 1, length, text)

    def __repr__(self) -> str:
        return f"Source({self.file!r})"


#: the place of a piece of syntax: source, start and end offsets; None if it has no text
At = tuple[Source, int, int] | None


def span_of(at: At) -> Span | None:
    return at[0].span(at[1], at[2]) if at is not None else None


def cover(first: At, last: At) -> At:
    """From the beginning of ``first`` to the end of ``last``."""
    if first is None or last is None:
        return first or last
    return first[0], first[1], last[2]


class placed:
    """``with placed(at):`` errors of the block that have no place yet get this one."""

    __slots__ = ("at",)

    def __init__(self, at: At) -> None:
        self.at = at

    def __enter__(self) -> None:
        pass

    def __exit__(self, kind: object, problem: BaseException | None, traceback: object) -> None:
        if isinstance(problem, ModelError) and problem.span is None:
            problem.span = span_of(self.at)
