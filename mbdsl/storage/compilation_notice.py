"""The announcement of a compilation, which takes seconds when a model of a new structure runs for the first time.

A function that is called without ``announce`` prints it on standard error in a terminal and in a notebook. Nothing is
printed if standard error is a file or a pipe, in worker processes, and by the command line, which shows it itself.
"""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, suppress

_silent = 0


def announce_compilation(
    announce: Callable[[str], None] | None, uncompiled: Callable[[], Sequence[str]]
) -> Sequence[str]:
    """Call ``announce``, by default a function that prints, if code has to be compiled.

    ``uncompiled()`` returns descriptions of this code. The result is the same; () if nothing would be printed.
    """
    if announce is None and not _is_shown():
        return ()
    if what := uncompiled():
        from mbdsl.storage import cache_folder  # the command line imports this module at every start

        (announce or _print)(cache_folder.compiling(what))
    return what


@contextmanager
def silent() -> Iterator[None]:
    """No announcements without ``announce``."""
    global _silent
    _silent += 1
    try:
        yield
    finally:
        _silent -= 1


def _is_shown() -> bool:
    if _silent or sys.stderr is None or _is_worker():
        return False
    if type(sys.stderr).__module__.startswith("ipykernel."):  # a notebook, which is not a terminal
        return True
    with suppress(OSError, ValueError, AttributeError):  # a closed stream
        return sys.stderr.isatty()
    return False


def _is_worker() -> bool:
    """Whether :mod:`multiprocessing` started this process; not if this process has not imported it."""
    loaded = sys.modules.get("multiprocessing")
    return loaded is not None and loaded.parent_process() is not None


def _print(line: str) -> None:
    with suppress(OSError, ValueError):
        print(f"mbdsl: {line}", file=sys.stderr, flush=True)
