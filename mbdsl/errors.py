"""What can go wrong, one class per stage, and how it is told.

Every error that a user can cause derives from :class:`MbdslError`. It carries the place in the model that
caused it (if there is one) and the process exit code that belongs to its stage; ``render()`` gives the text
that a person reads: ``file:line:column: error: ...``, the line, a caret, and what would be right.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from mbdsl.messages import visible, width

if TYPE_CHECKING:
    from mbdsl.simulation.trajectory import Trajectory


@dataclass(frozen=True, slots=True)
class Span:
    """A place in a source text: 1-based line and column, the length marked, and the line itself."""

    file: str
    line: int
    column: int
    length: int = 1
    text: str = ""

    def __str__(self) -> str:
        return f"{self.file}:{self.line}:{self.column}"


class MbdslError(Exception):
    """An error to show to a user, never a traceback.

    Parameters
    ----------
    message : str
        What was found and what was expected, in one or two sentences.
    span : Span, optional
        Where; models built by library have none.
    hint : str, optional
        What to try.
    notes : sequence of (str, Span or None)
        Other places that belong to the problem, each with its own line.
    """

    exit_code = 2
    severity = "error"

    def __init__(
        self,
        message: str,
        span: Span | None = None,
        hint: str | None = None,
        notes: tuple[tuple[str, Span | None], ...] = (),
    ) -> None:
        super().__init__(message)
        self.message = message
        self.span = span
        self.hint = hint
        self.notes = tuple(notes)

    def render(self) -> str:
        """The whole message as a person reads it, several lines."""
        lines = [_line(f"{_where(self.span)}{self.severity}: {self.message}"), *_excerpt(self.span)]
        for text, span in self.notes:
            lines += [_line(f"{_where(span)}note: {text}"), *_excerpt(span)]
        if self.hint:
            lines.append(_line(f"  = {self.hint}"))
        return "\n".join(lines)

    def __str__(self) -> str:
        return self.render()


def _where(span: Span | None) -> str:
    return f"{span}: " if span else ""


def _line(text: str) -> str:
    """One line, whatever names and values it quotes."""
    return visible(text, line=True)


def _excerpt(span: Span | None) -> list[str]:
    if span is None or not span.text:
        return []
    # A very long line is cut around the caret, so that the caret stays under its word.
    text, start = span.text.rstrip("\n"), span.column - 1
    left = max(0, start - 80)
    shown = text[left : left + 160]
    before, marked = shown[: start - left], shown[start - left : start - left + span.length]
    pad = "\t".join(" " * width(visible(part)) for part in before.split("\t"))
    return [f"    {visible(shown)}", f"    {pad}{'^' * max(1, width(visible(marked)))}"]


class SyntaxProblem(MbdslError):
    """The text is not of the language."""


class ModelError(MbdslError):
    """The text is of the language, but the model it describes makes no sense (names, units, structure)."""


class ModelWarning(MbdslError):
    """A model that makes sense but is hardly what was meant. Collected and shown, not raised."""

    severity = "warning"


class Interrupted(KeyboardInterrupt):
    """A run was interrupted; ``trajectory`` holds the results up to there."""

    def __init__(self, trajectory: Trajectory) -> None:
        super().__init__(trajectory)
        self.trajectory = trajectory

    def __str__(self) -> str:
        t = self.trajectory.t
        return f"interrupted at t = {t[-1]:g} s" if len(t) else "interrupted"


class UsageError(MbdslError):
    """A command or function was called with arguments that do not fit."""


class InitialisationError(MbdslError):
    """No consistent initial state exists, or it was not found."""

    exit_code = 3


class EquilibriumError(MbdslError):
    """No static equilibrium exists, or it was not found."""

    exit_code = 3


class IntegrationError(MbdslError):
    """The integration could not go on; ``trajectory`` holds the results up to there."""

    exit_code = 4
    trajectory: Trajectory | None = None
