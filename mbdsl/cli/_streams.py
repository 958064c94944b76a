"""Standard output and error while a command runs: what a model says reaches a terminal as text only, and a stream that
is closed or full ends no work."""

from __future__ import annotations

import errno
import os
import sys
from contextlib import suppress
from types import TracebackType
from typing import Any, TextIO

from mbdsl.errors import UsageError
from mbdsl.messages import visible

BROKEN_PIPE = 141


class Stream:
    """A text stream that escapes control characters; after its first failure, kept in ``problem``, it discards.

    Parameters
    ----------
    stream : text stream or None
        Where to write; None where the descriptor was closed before the start.
    """

    def __init__(self, stream: TextIO | None) -> None:
        self._stream = stream
        self.problem: OSError | None = None

    def write(self, text: str) -> int:
        self.write_raw(visible(text))
        return len(text)

    def write_raw(self, text: str) -> None:
        """As it is, for what moves the cursor; names and values in it were made visible before."""
        if not text or self.problem is not None:
            return
        try:
            if self._stream is None:
                raise OSError(errno.EBADF, "it is closed")
            self._stream.write(text)
        except (OSError, ValueError) as problem:  # a closed file object raises ValueError
            self._fail(problem)

    def flush(self) -> None:
        if self._stream is None or self.problem is not None:
            return
        try:
            self._stream.flush()
        except (OSError, ValueError) as problem:
            self._fail(problem)

    def _fail(self, problem: Exception) -> None:
        self.problem = problem if isinstance(problem, OSError) else OSError(errno.EBADF, "it is closed")
        # What is still buffered must go somewhere, or Python complains once more when it ends.
        with suppress(OSError, ValueError, AttributeError):
            os.dup2(os.open(os.devnull, os.O_WRONLY), self._stream.fileno())  # type: ignore[union-attr]
            self._stream.flush()  # type: ignore[union-attr]

    def isatty(self) -> bool:
        try:
            return self._stream is not None and self._stream.isatty()
        except ValueError:
            return False

    @property
    def encoding(self) -> str:
        return getattr(self._stream, "encoding", None) or "utf-8"

    def __getattr__(self, name: str) -> Any:
        return getattr(self._stream, name)


class Streams:
    """While the block runs, ``sys.stdout`` and ``sys.stderr`` are of this kind."""

    def __enter__(self) -> Streams:
        _occupy_closed_descriptors()
        self._before = sys.stdout, sys.stderr
        for stream in self._before:
            if hasattr(stream, "reconfigure"):  # a terminal without Unicode gets escapes instead of a failure
                with suppress(ValueError):
                    stream.reconfigure(errors="backslashreplace")
        self.out, self.err = Stream(sys.stdout), Stream(sys.stderr)
        sys.stdout, sys.stderr = self.out, self.err  # type: ignore[assignment]
        return self

    def __exit__(self, *failure: type | BaseException | TracebackType | None) -> None:
        sys.stdout, sys.stderr = self._before

    def exit_code(self, code: int) -> int:
        """That of the command, unless it succeeded and its output did not arrive. To be asked within the block."""
        self.out.flush()
        problem = self.out.problem
        if isinstance(problem, BrokenPipeError):  # the reader has left (| head) and wants no message
            code = code or BROKEN_PIPE
        elif problem is not None:
            reason = problem.strerror or str(problem)
            wrong = UsageError(f"cannot write to standard output: {reason}", hint="files are not affected by this")
            print(wrong.render(), file=self.err)
            code = code or wrong.exit_code
        self.err.flush()
        return code


def _occupy_closed_descriptors() -> None:
    """A file opened later must not become standard output because its number was free."""
    for descriptor in (0, 1, 2):
        try:
            os.fstat(descriptor)
        except OSError:
            os.open(os.devnull, os.O_RDWR)  # the lowest number that is free: this one
