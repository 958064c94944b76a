"""Python's collector of cyclic garbage, paused while a model is set up.

Reading and assembling a model makes many objects that stay, and hardly any cycle. Each collection visits all of them
again: with 16,384 bodies a third of the time until the first step.
"""

from __future__ import annotations

import gc
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import wraps
from typing import ParamSpec, TypeVar

Given = ParamSpec("Given")
Found = TypeVar("Found")


@contextmanager
def paused() -> Iterator[None]:
    """No collection inside the block; nested blocks leave the collector as they found it."""
    enabled = gc.isenabled()
    gc.disable()
    try:
        yield
    finally:
        if enabled:
            gc.enable()


def uncollected(function: Callable[Given, Found]) -> Callable[Given, Found]:
    """A decorator: no collection during a call."""

    @wraps(function)
    def call(*args: Given.args, **kwargs: Given.kwargs) -> Found:
        with paused():
            return function(*args, **kwargs)

    return call
