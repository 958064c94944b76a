"""Warnings about runs: every module of this folder has ``warnings(run) -> list[str]``, and is asked about each run.

A module with ``BEFORE = True`` is asked before the first step, the others when the run has ended. A stream holds the
last rows of a run only: modules that need no others have ``OF_STREAMS = True``.
"""

from __future__ import annotations

import pkgutil
from functools import cache
from importlib import import_module
from types import ModuleType

from mbdsl.simulation.examined_run import ExaminedRun


@cache
def modules() -> tuple[ModuleType, ...]:
    """The modules of this folder, in the order of their names."""
    return tuple(import_module(f"{__name__}.{info.name}") for info in pkgutil.iter_modules(__path__))


def warnings(run: ExaminedRun, before: bool = False) -> list[str]:
    """The warnings about a run that has ended, or ``before`` its first step."""
    asked = [x for x in modules() if getattr(x, "BEFORE", False) == before]
    if run.stream is not None and not before:
        asked = [x for x in asked if getattr(x, "OF_STREAMS", False)]
    return [text for module in asked for text in module.warnings(run)]
