"""Peaks of signals that outputs cut: extremes over all steps that no output shows."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from mbdsl.display_unit import OWN, UnitsOfSignals
from mbdsl.simulation.extremes import ROWS, Extreme
from mbdsl.simulation.state_signals import StateSignals

CUT = 0.02  #: part of the range of a signal by which a peak is above the outputs
ROUNDING = 1e-4  #: excess, relative to signals of the same unit, that may be an error of rounding or interpolation

STILL = 1e-6  #: way in a run, relative to the size of the mechanism, of a mechanism at rest


class CutPeak(NamedTuple):
    """A largest or least value of a signal that no output shows.

    Attributes
    ----------
    signal, unit : str
        Its name and SI unit.
    value : float
        The value, an extreme over all steps.
    time : float [s]
        Its time.
    shown : float
        The largest or least value of the outputs.
    """

    signal: str
    unit: str
    value: float
    time: float
    shown: float

    def __str__(self) -> str:
        return self.text(OWN)

    def text(self, display: UnitsOfSignals) -> str:
        """Return a sentence with the values in the units in which they are displayed.

        Parameters
        ----------
        display : UnitsOfSignals

        Returns
        -------
        str
        """
        most, unit = "most" if self.value > self.shown else "least", display.of(self.unit, self.signal)
        value, shown = unit.text(self.value, 4), unit.text(self.shown + 0.0, 4)
        at = display.of("s", "time").text(self.time)
        return f"{self.signal} is {value} at t = {at}, and outputs show at {most} {shown}"


def cut_peaks(shown: StateSignals, extremes: Iterable[Extreme]) -> list[CutPeak]:
    """The peaks, among the extremes of signals, that the outputs of a run cut."""
    return outside(extremes, lambda name: finite_ends(shown._signal(name)), _sizes(shown))


def finite_ends(x: NDArray[np.float64]) -> tuple[float, float]:
    """Least and largest of the finite values of x (N,)."""
    x = x[np.isfinite(x)]
    return float(x.min(initial=np.inf)), float(x.max(initial=-np.inf))


def outside(
    extremes: Iterable[Extreme], ends: Callable[[str], tuple[float, float]], sizes: Mapping[str, float]
) -> list[CutPeak]:
    """The extremes that are outside of the least and the largest output of their signal, which ``ends`` returns.

    ``sizes`` are those of signals by their units, beside which others are rounding errors.
    """
    found, sizes = [], dict(sizes)
    for e in extremes:
        low, high = ends(e.signal)
        if e.of == ROWS or low > high:
            continue
        sizes[e.unit] = max(sizes.get(e.unit, 0.0), -e.least, e.largest)
        for value, time, edge in ((e.largest, e.time_of_largest, high), (e.least, e.time_of_least, low)):
            if abs(value - edge) > CUT * (e.largest - e.least):
                found.append(CutPeak(e.signal, e.unit, value, time, edge))
    return [peak for peak in found if abs(peak.value - peak.shown) > ROUNDING * sizes[peak.unit]]


def _sizes(shown: StateSignals) -> dict[str, float]:
    """Unit -> size of such signals in a motion, beside which others are rounding errors."""
    length, rate = shown.system.tables.size, float(np.abs(shown.v * shown.system.tables.scale).max(initial=0.0))
    if len(shown.t) > 1:
        rate = max(rate, STILL / abs(float(shown.t[-1] - shown.t[0])))
    found = {"m": length, "m/s": length * rate, "m/s2": length * rate**2}
    return found | {"rad": 1.0, "rad/s": rate, "rad/s2": rate**2, "": 1.0}
