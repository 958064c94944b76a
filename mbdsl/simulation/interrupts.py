"""Ctrl-C, SIGTERM and SIGHUP: recorded immediately, handled at points where no results are lost."""

from __future__ import annotations

import signal
import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager, suppress

#: sent at a shutdown (SIGTERM), and when the terminal is closed (SIGHUP)
ENDS = tuple(getattr(signal, name) for name in ("SIGTERM", "SIGHUP") if hasattr(signal, name))
SIGNALS = (signal.SIGINT, *ENDS)


@contextmanager
def deferred(most: int | None = None, note: str = "") -> Iterator[list[int]]:
    """Context in which signals are appended to the list that it returns, instead of raising exceptions.

    An exception within a call of compiled code may leave it as another one, and an exception during writing destroys
    the file. The first signal prints the ``note``; after ``most`` signals the next one raises KeyboardInterrupt.
    """
    heard: list[int] = []
    if threading.current_thread() is not threading.main_thread():
        yield heard  # only the main thread receives signals
        return

    def hear(number, frame) -> None:
        heard.append(number)
        if note and len(heard) == 1:
            with suppress(OSError, ValueError):  # the terminal was closed
                print(note, file=sys.stderr)
        if most is not None and len(heard) > most:
            raise KeyboardInterrupt

    former = {}
    for number in SIGNALS:
        present = signal.getsignal(number)
        # signals that are ignored stay ignored; those without a handler keep their default action
        if present not in (None, signal.SIG_IGN, signal.SIG_DFL):
            former[number] = signal.signal(number, hear)
    try:
        yield heard
    finally:
        for number, handler in former.items():
            signal.signal(number, handler)


@contextmanager
def terminated() -> Iterator[list[int]]:
    """SIGTERM and SIGHUP act like Ctrl-C, unless the program handles or ignores them itself.

    All three are appended to the list that the context returns: an extension that is being imported turns
    KeyboardInterrupt into an ImportError of its own.
    """
    heard: list[int] = []

    def interrupt(number, frame) -> None:
        heard.append(number)
        raise KeyboardInterrupt

    former = {}
    if threading.current_thread() is threading.main_thread():
        for number in SIGNALS:
            if signal.getsignal(number) in (signal.SIG_DFL, signal.default_int_handler):
                former[number] = signal.signal(number, interrupt)
    try:
        yield heard
    finally:
        for number, handler in former.items():
            signal.signal(number, handler)
