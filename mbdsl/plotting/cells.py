"""The cells of a figure in colours: the edges of the cells, the axis of the colours, and the colour of a value."""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import pairwise

from mbdsl.plotting.axes import Axis, axis, coordinate

LEVELS = 128  #: number of colours
MISSING = "#c9ced6"  #: cells without a value
#: the colour map "viridis" of Smith, van der Walt and Firing (CC0), at equal distances
VIRIDIS = (
    *("#440154", "#481a6c", "#472f7d", "#414487", "#39568c", "#31688e", "#2a788e", "#23888e", "#1f988b", "#22a884"),
    *("#35b779", "#54c568", "#7ad151", "#a5db36", "#d2e21b", "#fde725"),
)


def edges(values: Sequence[float], log: bool) -> list[float]:
    """Coordinates of the edges of the cells: the middles between values, and as far outside."""
    c = [coordinate(v, log) for v in values]
    if len(c) == 1:
        return [c[0] - 0.5, c[0] + 0.5]
    middles = [0.5 * (a + b) for a, b in pairwise(c)]
    return [2.0 * c[0] - middles[0], *middles, 2.0 * c[-1] - middles[-1]]


def scale(values: Sequence[float]) -> Axis:
    """The axis of the colours of values."""
    low, high = (min(values), max(values)) if values else (0.0, 1.0)
    if high - low <= 1e-12 * max(abs(low), abs(high)):
        half = 0.5 * abs(low) or 1.0
        low, high = low - half, high + half
    return axis(low, high, False, 6)


def colour(place: float) -> str:
    """The colour of a place between 0 and 1; grey for nan."""
    return MISSING if not math.isfinite(place) else level(min(LEVELS - 1, max(0, int(place * LEVELS))))


def level(k: int) -> str:
    """The colour with a number from 0 to ``LEVELS`` - 1."""
    at = (k + 0.5) / LEVELS * (len(VIRIDIS) - 1)
    j = min(int(at), len(VIRIDIS) - 2)
    one, other = (bytes.fromhex(VIRIDIS[j + i][1:]) for i in (0, 1))
    return "#" + "".join(f"{round(a + (b - a) * (at - j)):02x}" for a, b in zip(one, other, strict=True))
