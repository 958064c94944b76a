"""Peaks of signals that outputs cut: values at the ends of steps that no output shows."""

from __future__ import annotations

from collections.abc import Iterable
from typing import NamedTuple

import numpy as np

from mbdsl.simulation.state_signals import StateSignals

CUT = 0.02  #: part of the range of a signal by which a peak is above the outputs
ROUNDING = 1e-6  #: excess, relative to signals of the same unit, that may consist of rounding errors
#: number of steps above which signals are left out that need a solution of the equations at each of them
MANY = 20_000


class CutPeak(NamedTuple):
    """A largest or least value of a signal that no output shows.

    Attributes
    ----------
    signal, unit : str
        Its name and SI unit.
    value : float
        The value at the end of a step.
    time : float [s]
        The time of this end.
    shown : float
        The largest or least value of the outputs.
    """

    signal: str
    unit: str
    value: float
    time: float
    shown: float

    def __str__(self) -> str:
        unit, most = f" {self.unit}" if self.unit else "", "most" if self.value > self.shown else "least"
        outputs = f"outputs show at {most} {self.shown + 0.0:.4g}{unit}"
        return f"{self.signal} is {self.value:.4g}{unit} at t = {self.time:.6g} s, and {outputs}"


def cut_peaks(shown: StateSignals, names: Iterable[str]) -> list[CutPeak]:
    """The peaks of signals that the outputs of a run cut, as far as the run has kept its steps."""
    ends = shown.ends
    if ends is None or not len(shown.t):
        return []
    inside = (ends.t >= shown.t[0]) & (ends.t <= shown.t[-1])
    t, found, sizes = ends.t[inside], [], _sizes(shown)
    for name in names:
        if name == "time" or (len(t) > MANY and not ends.is_at_hand(name)):
            continue
        x, y, unit = shown._signal(name), ends._signal(name)[inside], shown.unit(name)
        known = np.isfinite(y)
        x, y, at = x[np.isfinite(x)], y[known], t[known]
        if not len(x) or not len(y):
            continue
        low, high = min(y.min(), x.min()), max(y.max(), x.max())
        sizes[unit] = max(sizes.get(unit, 0.0), -low, high)
        for k, outside, edge in (
            (int(y.argmax()), y.max() - x.max(), x.max()),
            (int(y.argmin()), x.min() - y.min(), x.min()),
        ):
            if outside > CUT * (high - low):
                found.append((outside, CutPeak(name, unit, float(y[k]), float(at[k]), float(edge))))
    return [peak for outside, peak in found if outside > ROUNDING * sizes[peak.unit]]


def _sizes(shown: StateSignals) -> dict[str, float]:
    """Unit -> size of such signals in a motion, beside which others are rounding errors."""
    length, rate = shown.system.tables.size, float(np.abs(shown.v * shown.system.tables.scale).max(initial=0.0))
    found = {"m": length, "m/s": length * rate, "m/s2": length * rate**2}
    return found | {"rad": 1.0, "rad/s": rate, "rad/s2": rate**2, "": 1.0}
