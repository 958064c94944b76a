"""Where a frequency response is sampled, and its resonances and antiresonances."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np

from mbdsl.kernels.arrays import Array, Complex

Of = Callable[[Array], Complex]  #: frequencies (N,) [Hz] -> responses (N, o, i)

EACH, LEAST, MOST = 60, 201, 6000  #: points of a decade; least and largest number of points
ROUNDS, CHANGE = 9, 0.15  #: halvings where the response changes by more than this between points, relative to it
CLOSE = 1e-7  #: least relative distance of points
DIVISIONS, FINER = 8, 6  #: of the half of a bracket around a resonance, and how often it is divided
UNDAMPED = 1e-11  #: damping ratio that is rounding
BUMP, DIP = 1.001, 2.0  #: least ratio of a resonance to what surrounds it, and of that to an antiresonance
#: points beside a resonance, in half widths; and beside an undamped one, relative to its frequency
WIDTHS = np.array([0.0, 0.1, 0.2, 0.35, 0.5, 0.75, 1.0, 1.5, 2.0, 3.0, 5.0, 10.0])
AROUND = 10.0 ** -np.arange(1.0, 6.5, 0.5)


class ResponseExtreme(NamedTuple):
    """A resonance or an antiresonance: its frequency [Hz] and whether it is one of the amplitude's maxima."""

    f: float
    highest: bool
    infinite: bool = False


def frequency_of(pole: complex) -> float:
    """The frequency [Hz] of the largest response of a pole: w sqrt(1 - 2 d^2); 0 if there is none."""
    square = pole.imag**2 - pole.real**2
    return float(np.sqrt(square)) / (2.0 * np.pi) if square > 0.0 else 0.0


def undamped(pole: complex) -> bool:
    return abs(pole.real) <= UNDAMPED * abs(pole)


def sampled(of: Of, poles: Sequence[complex], low: float, high: float) -> Array:
    """Frequencies (N,) [Hz]: evenly in the logarithm, and more of them where the response changes."""
    points = max(LEAST, int(np.ceil(EACH * np.log10(high / low))) + 1)
    found = [np.geomspace(low, high, points)]
    singular = []
    for pole in poles:
        f = frequency_of(pole)
        if not (low / 2.0 < f < 2.0 * high and pole.imag > 0.0):
            continue
        beside = AROUND if undamped(pole) else WIDTHS * abs(pole.real) / abs(pole)
        found += [f * (1.0 + beside), f * (1.0 - beside)]
        singular += [f] if undamped(pole) else []
    f = _distinct(np.concatenate(found), low, high)
    for pole in singular:
        f = f[np.abs(f / pole - 1.0) > CLOSE]
    for _ in range(ROUNDS):
        H = of(f)
        size = np.abs(H)
        largest = np.maximum(size[1:], size[:-1])
        step = np.abs(np.diff(H, axis=0)) > CHANGE * np.where(largest > 0.0, largest, np.inf)
        where = step.any(axis=(1, 2)) & (np.diff(f) > 2.0 * CLOSE * f[1:])
        if not where.any() or len(f) + where.sum() > MOST:
            break
        f = _distinct(np.concatenate([f, np.sqrt(f[:-1] * f[1:])[where]]), low, high)
        for pole in singular:
            f = f[np.abs(f / pole - 1.0) > CLOSE]
    return f


def _distinct(f: Array, low: float, high: float) -> Array:
    """Ascending, within the range, and no two closer than ``CLOSE``."""
    f = np.unique(np.clip(f, low, high))
    kept = np.append(True, np.diff(f) > CLOSE * f[1:])
    kept[-1] = True
    return np.asarray(f[kept])


def extremes(f: Array, size: Array, of: Callable[[Array], Array], poles: Sequence[complex]) -> list[ResponseExtreme]:
    """The resonances and antiresonances of one response, by ascending frequency.

    Parameters
    ----------
    f, size : (N,) [Hz]
        Frequencies and amplitudes.
    of : function
        The amplitudes (N,) at frequencies (N,) [Hz].
    poles : sequence of complex [1/s]
        Those of the linear model.
    """
    if not size.any():
        return []
    infinite = [frequency_of(pole) for pole in poles if undamped(pole) and pole.imag > 0.0]
    found = []
    for k, highest in _turns(size):
        inside = [x for x in infinite if f[k - 1] < x < f[k + 1]] if highest else []
        if inside and _grows(of, inside[0]):
            found.append(ResponseExtreme(inside[0], True, True))
            continue
        found.append(ResponseExtreme(_refined(of, f[k - 1], f[k + 1], highest), highest))
    return found


def _turns(size: Array) -> list[tuple[int, bool]]:
    """Indices of maxima and minima inside of the range that stand out."""
    # alternate maxima and minima whose ratio is at least BUMP
    turns: list[tuple[int, bool]] = []
    high = low = 0
    rising: bool | None = None
    for k in range(1, len(size)):
        high, low = (k if size[k] > size[high] else high), (k if size[k] < size[low] else low)
        if rising is not False and size[k] * BUMP < size[high]:
            turns.append((high, True))
            rising, low = False, k
            high = k
        elif rising is not True and size[low] * BUMP < size[k]:
            turns.append((low, False))
            rising, high = True, k
            low = k
    ends = [(0, None), *turns, (len(size) - 1, None)]
    found = []
    for (before, _), (k, highest), (after, _) in zip(ends, ends[1:], ends[2:], strict=False):
        if not 0 < k < len(size) - 1:
            continue
        if highest or DIP * size[k] <= min(size[before], size[after]):
            found.append((k, bool(highest)))
    return found


def _grows(of: Callable[[Array], Array], f: float) -> bool:
    """Whether the amplitude grows without bound towards a frequency."""
    near, far = of(f * (1.0 + np.array([1e-6, 1e-4])))
    return bool(near > 30.0 * far)


def _refined(of: Callable[[Array], Array], low: float, high: float, highest: bool) -> float:
    """The frequency of a maximum or minimum between two others: on finer and finer grids, then of a parabola."""
    for _ in range(FINER):
        f = np.linspace(low, high, 2 * DIVISIONS + 1)
        square = of(f) ** 2
        k = min(max(int(np.argmax(square) if highest else np.argmin(square)), 1), len(f) - 2)
        low, high = float(f[k - 1]), float(f[k + 1])
    step, (a, b, c) = 0.5 * (high - low), square[k - 1 : k + 2]
    bend = a - 2.0 * b + c
    return float(f[k] + (np.clip(0.5 * (a - c) / bend, -1.0, 1.0) * step if bend else 0.0))
