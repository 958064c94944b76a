"""Standard output and error of a command: control characters are escaped, lines are wrapped and coloured on terminals,
and closed or full streams stop no run."""

from __future__ import annotations

import errno
import os
import sys
from contextlib import suppress
from types import TracebackType
from typing import Any, TextIO

from mbdsl.errors import MbdslError, UsageError
from mbdsl.messages import visible
from mbdsl.plotting.terminal_text import coloured, columns, painted, wrapped

BROKEN_PIPE = 141


class OutputStream:
    """A text stream that escapes control characters; after its first failure, kept in ``problem``, it discards.

    On a terminal it wraps and colours whole lines (:mod:`mbdsl.plotting.terminal_text`); with ``verbatim`` it does
    neither.

    Parameters
    ----------
    stream : text stream or None
        The underlying stream; None if its descriptor was closed before the start.
    """

    def __init__(self, stream: TextIO | None) -> None:
        self._stream = stream
        self.problem: OSError | None = None
        self.verbatim = False
        self._colours = coloured(self)
        self._begun = ""  # the beginning of a line

    def write(self, text: str) -> int:
        shown = visible(text)
        size = columns(self)
        if self.verbatim or not (size or self._colours):
            self.write_raw(shown)
            return len(text)
        *lines, self._begun = f"{self._begun}{shown}".split("\n")
        for line in lines:
            pieces = (wrapped(line, size) if size else [line]) or [""]
            self.write_raw("\n".join(painted(pieces) if self._colours else pieces) + "\n")
        return len(text)

    def write_raw(self, text: str) -> None:
        """Write without escaping, to move the cursor; the caller has escaped names and values."""
        if not text or self.problem is not None:
            return
        try:
            if self._stream is None:
                raise OSError(errno.EBADF, "it is closed")
            self._stream.write(text)
        except (OSError, ValueError) as problem:  # a closed file object raises ValueError
            self._fail(problem)

    def flush(self) -> None:
        if self._begun:
            rest, self._begun = self._begun, ""
            self.write_raw(rest)
        if self._stream is None or self.problem is not None:
            return
        try:
            self._stream.flush()
        except (OSError, ValueError) as problem:
            self._fail(problem)

    def _fail(self, problem: Exception) -> None:
        self.problem = problem if isinstance(problem, OSError) else OSError(errno.EBADF, "it is closed")
        # The buffered text is discarded; otherwise Python reports the error again at exit.
        with suppress(OSError, ValueError, AttributeError):
            os.dup2(os.open(os.devnull, os.O_WRONLY), self.fileno())
            if self._stream is not None:
                self._stream.flush()

    def isatty(self) -> bool:
        try:
            return self._stream is not None and self._stream.isatty()
        except ValueError:
            return False

    def fileno(self) -> int:
        if self._stream is None:
            raise OSError(errno.EBADF, "it is closed")
        return self._stream.fileno()

    @property
    def encoding(self) -> str:
        return getattr(self._stream, "encoding", None) or "utf-8"

    def __getattr__(self, name: str) -> Any:
        return getattr(self._stream, name)


def print_problem(problem: MbdslError) -> None:
    """Print an error or a warning on standard error; excerpts of the model have the width of a terminal."""
    for each in (problem, *problem.others):
        print(each.render(columns(sys.stderr)), file=sys.stderr)


def say(text: str) -> None:
    """Print a line on standard error, as the announcement of a compilation."""
    print(text, file=sys.stderr)


def can_write(characters: str) -> bool:
    """Whether the encoding of standard output has some characters."""
    try:
        characters.encode(sys.stdout.encoding or "utf-8")
    except (UnicodeEncodeError, LookupError):
        return False
    return True


def verbatim() -> None:
    """Print what follows on standard output as it is: code, whose lines have to stay whole."""
    if isinstance(sys.stdout, OutputStream):
        sys.stdout.verbatim = True


class Streams:
    """Context in which ``sys.stdout`` and ``sys.stderr`` are instances of ``Stream``."""

    def __enter__(self) -> Streams:
        _occupy_closed_descriptors()
        self._before = sys.stdout, sys.stderr
        for stream in self._before:
            if hasattr(stream, "reconfigure"):  # a terminal without Unicode gets escapes instead of a failure
                with suppress(ValueError):
                    stream.reconfigure(errors="backslashreplace")
        self.out, self.err = OutputStream(sys.stdout), OutputStream(sys.stderr)
        sys.stdout, sys.stderr = self.out, self.err
        return self

    def __exit__(self, *failure: type | BaseException | TracebackType | None) -> None:
        sys.stdout, sys.stderr = self._before

    def exit_code(self, code: int) -> int:
        """The exit code of the command; an error code if it succeeded but its output failed. Call it in the context."""
        self.out.flush()
        problem = self.out.problem
        if isinstance(problem, BrokenPipeError):  # the reader has closed the pipe (| head): no message
            code = code or BROKEN_PIPE
        elif problem is not None:
            reason = problem.strerror or str(problem)
            wrong = UsageError(f"cannot write to standard output: {reason}", hint="files are not affected by this")
            print_problem(wrong)
            code = code or wrong.exit_code
        self.err.flush()
        return code


def _occupy_closed_descriptors() -> None:
    """Open the null device for closed standard streams, so that no other file gets their descriptors."""
    for descriptor in (0, 1, 2):
        try:
            os.fstat(descriptor)
        except OSError:
            os.open(os.devnull, os.O_RDWR)  # gets the lowest free descriptor, this one
