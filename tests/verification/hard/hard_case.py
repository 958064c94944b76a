"""Hard cases as data: a model with its expected results, and the result of a run."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from mbdsl.simulation.trajectory import Trajectory

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Check:
    """The expected values of a signal, ``values`` at ``times`` [s] or one constant; errors are in units of ``scale``.

    Errors below ``within`` are accepted at any step. ``grows`` limits the growth of an energy, which a method may
    dissipate but not create. The tolerance does not apply to signals that are not ``controlled``: reactions.
    """

    signal: str
    values: float | Sequence[float]
    times: Sequence[float] = ()
    scale: float = 1.0
    within: float = 1e-3
    grows: float | None = None
    controlled: bool = True

    def error(self, of: Trajectory) -> float:
        """The largest error, scaled; of an energy with its sign."""
        off = self.differences(of)
        return float(off[np.abs(off).argmax()]) if self.grows is not None else float(np.abs(off).max())

    def differences(self, of: Trajectory) -> Array:
        signal = of[self.signal]
        found = np.interp(self.times, of.t, signal) if len(self.times) else signal
        return (found - np.asarray(self.values, float)) / self.scale


@dataclass(frozen=True)
class Stop:
    """The expected failure of a run: its exit code, words of the message, and the interval of time [s].

    Methods may stop earlier for reasons of their ``own``, given by words of their messages.
    """

    code: int
    says: Sequence[str] = ()
    after: float | None = None
    before: float | None = None
    own: Sequence[str] = ()


@dataclass(frozen=True)
class Case:
    """A model with parameters, an optional step [s], an optional tolerance, and the expected result."""

    model: Path
    name: str
    group: str
    answer: str  #: source of the answer
    stop: float
    step: float | None = None
    tol: float | None = None
    parameters: Mapping[str, str | float] = field(default_factory=dict)
    checks: tuple[Check, ...] = ()
    stops: Stop | None = None

    def __str__(self) -> str:
        return f"{self.model.stem}: {self.name}" if self.name else self.model.stem


@dataclass(frozen=True)
class Cell:
    """The result of one run: ``verdict`` is "right", "step" (an error that the step explains), "stops", "slow" or
    "WRONG"."""

    verdict: str
    text: str
    reason: str = ""  #: reason why it stopped

    def __str__(self) -> str:
        return {"WRONG": f"WRONG {self.text}", "step": f"({self.text})"}.get(self.verdict, self.text)
