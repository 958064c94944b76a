"""Exceptions, one class per stage, and the text of their messages.

Every error that a user can cause derives from ``MbdslError``. It holds the place in the model that caused it, if
any, and the exit code of its stage. ``render()`` returns the message: ``file:line:column: error: ...``, the source
line, a caret, and a remedy.
"""

from __future__ import annotations

import linecache
import os
from dataclasses import dataclass
from typing import TYPE_CHECKING

from mbdsl.messages import visible, width

if TYPE_CHECKING:
    from mbdsl.simulation.trajectory import Trajectory


#: characters of a source line that are shown where the width of the output is not known
LONGEST = 160


@dataclass(frozen=True, slots=True)
class Span:
    """A place in a source text.

    Attributes
    ----------
    file : str
        Name of the file.
    line, column : int
        Counted from 1.
    length : int
        Number of characters to mark.
    text : str
        The whole line.
    """

    file: str
    line: int
    column: int
    length: int = 1
    text: str = ""

    def __str__(self) -> str:
        return f"{self.file}:{self.line}:{self.column}"


class MbdslError(Exception):
    """Base class of all errors that a user can cause; the command line prints them without a traceback.

    Parameters
    ----------
    message : str
        What was found and what was expected, in one or two sentences.
    span : Span, optional
        Place in the source text; models from a ``Builder`` have none.
    hint : str, optional
        A remedy.
    notes : sequence of (str, Span or None)
        Texts about further places that are involved.
    """

    exit_code = 2
    severity = "error"
    #: further errors of the same text, which are shown below this one
    others: tuple[MbdslError, ...] = ()

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

    def render(self, columns: int | None = None) -> str:
        """Return the message with its places, source lines and remedy.

        Parameters
        ----------
        columns : int, optional
            Width of the terminal, to which source lines are cut.

        Returns
        -------
        str
            Several lines, without a newline at the end.
        """
        return self._text(f"{self.severity}: ", LONGEST if columns is None else columns - 4)

    def __str__(self) -> str:
        return self._text("")  # without the severity: Python and IPython put the name of the class before it

    def _text(self, severity: str, longest: int = LONGEST) -> str:
        lines = [_line(f"{_where(self.span)}{severity}{self.message}"), *_excerpt(self.span, longest)]
        for text, span in self.notes:
            lines += [_line(f"{_where(span)}note: {text}"), *_excerpt(span, longest)]
        if self.hint:
            lines.append(_line(f"  = {self.hint}"))
        return "\n".join(lines)

    def _render_traceback_(self) -> list[str]:
        """The lines that IPython shows instead of a traceback."""
        return [f"{type(self).__name__}: {self}", *_call(self)]

    def _repr_html_(self) -> str:
        from html import escape

        return f"<pre>{escape(self.render())}</pre>"


def _call(error: BaseException) -> list[str]:
    """The line of the user's code that called mbdsl; none if that is the only line of its cell."""
    found, tb = None, error.__traceback__
    while tb is not None and (package := tb.tb_frame.f_globals.get("__name__", "").partition(".")[0]) != "mbdsl":
        found, tb = found if package == "IPython" else tb, tb.tb_next
    if found is None:
        return []
    file, line = found.tb_frame.f_code.co_filename, found.tb_lineno
    text = linecache.getlines(file, found.tb_frame.f_globals)
    if not 0 < line <= len(text) or text[line - 1].startswith("get_ipython()"):  # the call of a magic
        return []
    if os.path.exists(file):
        return [f"{file}:{line}: {_line(text[line - 1].strip())}"]
    return [f"line {line} of the cell: {_line(text[line - 1].strip())}"] if len(text) > 1 else []


def _where(span: Span | None) -> str:
    return f"{span}: " if span else ""


def _line(text: str) -> str:
    """``text`` on one line, with control characters escaped."""
    return visible(text, line=True)


def _excerpt(span: Span | None, longest: int) -> list[str]:
    if span is None or not span.text:
        return []
    # A long line is cut around the marked word, so that the caret stays below it.
    text, start = span.text.rstrip("\n"), span.column - 1
    left = 0 if len(text) <= longest else max(0, start - longest // 2)
    shown = text[left : left + longest]
    before, marked = shown[: start - left], shown[start - left : start - left + span.length]
    pad = "\t".join(" " * width(visible(part)) for part in before.split("\t"))
    return [f"    {visible(shown)}", f"    {pad}{'^' * max(1, width(visible(marked)))}"]


class SyntaxProblem(MbdslError):
    """The text violates the grammar of the language."""


class ModelError(MbdslError):
    """The text is grammatical, but its model is invalid: unknown names, wrong units, wrong structure."""


class ModelWarning(MbdslError):
    """The model is valid but probably not as intended. Warnings are collected and shown, not raised."""

    severity = "warning"


class ModelNote(ModelWarning):
    """What is passed over in a model, without an effect on its motion."""

    severity = "note"


class AccuracyWarning(UserWarning):
    """A run without a given tolerance ends with an error that exceeds the default one, or with an unknown error."""


class Interrupted(KeyboardInterrupt):
    """A run was interrupted.

    Parameters
    ----------
    trajectory : Trajectory
        The results up to the interruption.
    """

    def __init__(self, trajectory: Trajectory) -> None:
        super().__init__(trajectory)
        self.trajectory = trajectory

    def __str__(self) -> str:
        t = self.trajectory.t
        return f"interrupted at t = {t[-1]:g} s" if len(t) else "interrupted"

    def _render_traceback_(self) -> list[str]:
        """The lines that IPython shows instead of a traceback."""
        return [str(self), "  = `sys.last_value.trajectory` holds the results up to then", *_call(self)]


class UsageError(MbdslError):
    """A command or a function was called with invalid arguments."""


class InitialisationError(MbdslError):
    """No consistent initial state exists, or none was found."""

    exit_code = 3


class EquilibriumError(MbdslError):
    """No static equilibrium exists, or none was found."""

    exit_code = 3


class IntegrationError(MbdslError):
    """The integration failed; ``trajectory`` holds the results up to the failure."""

    exit_code = 4
    trajectory: Trajectory | None = None
