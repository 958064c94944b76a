"""How far an integration is."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Progress:
    """How far an integration is; given to the callback some ten times a second."""

    t: float
    start: float
    stop: float
    h: float
    steps: int
    iterations: int
    seconds: float
