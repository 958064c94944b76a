"""Peaks of signals that outputs cut: extremes over all steps that no output shows."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from mbdsl.messages import OWN, UnitsOfSignals
from mbdsl.simulation.extremes import OUTPUTS, Extreme
from mbdsl.simulation.state_signals import StateSignals

CUT = 0.02  #: part of the range of a signal by which a peak is above the outputs
ROUNDING = 1e-4  #: excess, relative to signals of the same unit, that may be an error of rounding or interpolation

STILL = 1e-6  #: way in a run, relative to the size of the mechanism, of a mechanism at rest
TOGETHER = 32_000  #: quantity of values of signals at ends of steps that are looked at together: they fit into a cache


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
        which, unit = "highest" if self.value > self.shown else "lowest", display.of(self.unit, self.signal)
        value, shown = unit.text(self.value, 4), unit.text(self.shown + 0.0, 4)
        at = display.of("s", "time").text(self.time)
        return f"{self.signal} is {value} at t = {at}, but the {which} output is {shown}"


def cut_peaks(
    shown: StateSignals, names: Sequence[str], extremes: Callable[[Sequence[str]], Mapping[str, Extreme]]
) -> list[CutPeak]:
    """The peaks of signals that the outputs of a run cut; ``extremes`` finds those of some signals."""
    sizes = _sizes(shown)
    some = _exceeding(shown, [name for name in names if name != "time"], sizes) if shown.steps is not None else []
    found = extremes(some).values() if some else ()
    return outside(found, lambda name: finite_ends(shown._signal(name)), sizes)


def _exceeding(shown: StateSignals, names: Sequence[str], sizes: dict[str, float]) -> Sequence[str]:
    """The signals whose values at the ends of steps, and an eighth of their second differences, by which they may be
    larger between these, do not exclude a cut peak. ``sizes`` gets the values of all."""
    ends = shown.steps.ends
    if shown.gathered is not None or not len(shown.t) or ends.t[0] < shown.t[0] or ends.t[-1] > shown.t[-1]:
        return names
    found: list[tuple[str, float]] = []
    size = max(1, TOGETHER // len(ends.t))
    for k in range(0, len(names), size):
        some = names[k : k + size]
        rows, y = shown.signal_rows(some), ends.signal_rows(some)
        low, high, least, most = y.min(axis=1), y.max(axis=1), rows.min(axis=1), rows.max(axis=1)
        between = 0.125 * np.abs(np.diff(y, 2)).max(axis=1, initial=0.0)
        excess = np.maximum(high - most, least - low) + between
        for unit, x in zip(map(shown.unit, some), np.maximum(-low, high).tolist(), strict=True):
            sizes[unit] = max(sizes.get(unit, 0.0), x)
        far = ~(excess <= CUT * (np.maximum(high, most) - np.minimum(low, least)))
        found += [(name, x) for name, x, cut in zip(some, excess.tolist(), far.tolist(), strict=True) if cut]
    return [name for name, x in found if not x <= ROUNDING * sizes[shown.unit(name)]]


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
        if e.of == OUTPUTS or low > high:
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
