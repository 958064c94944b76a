"""Ranges of signals over steps: extremes with their times, and integrals.

The values at the ends of all steps are known (:mod:`mbdsl.simulation.steps`). Near the largest of them the motion
between the ends is evaluated, and a polynomial through five values gives the top. Where steps are few, all of them are
evaluated at five points, those of a Lobatto rule, which also gives the integrals. All signals are handled together, as
rows of arrays.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from mbdsl.kernels.arrays import Array, Integers
from mbdsl.numerics.quadrature import lobatto_points, weights

if TYPE_CHECKING:
    from mbdsl.simulation.state_signals import StateSignals
    from mbdsl.simulation.steps import Steps

Indices = Integers

FEW = 300  #: number of steps up to which all of them are evaluated between their ends
MANY = 3000  #: the same of a run whose discrete variables change: rules across several steps would smear them
TOGETHER = 1_000_000  #: quantity of values of signals that are handled at once
PLACES = 3  #: number of places where an extreme is sought
PARTS = 6  #: points in each interval beside such a place
ALIKE = 3.0  #: ratio of successive second differences up to which a polynomial goes through five of the points
NEWTON = 3  #: iterations for its top
#: part of the range by which a value between ends of steps has to exceed those at the ends; next to the first and the
#: last one, where a motion from rest is not a top
ROUNDED, BORDER = 1e-12, 1e-5
SAME = 1e-6  #: part of the range by which values at ends of steps may differ when computed with others


@dataclass
class StepRange:
    """Extremes of some values, with their times, and integrals over time."""

    least: float = np.inf
    time_of_least: float = np.nan
    largest: float = -np.inf
    time_of_largest: float = np.nan
    integral: float = 0.0
    square: float = 0.0
    span: float = 0.0
    finite: bool = True  #: whether all values are

    def see(self, t: Array, y: Array) -> None:
        """Add values y (N,) at times t (N,), but not to integrals."""
        if len(y):
            for k in (int(y.argmin()), int(y.argmax())):
                self.see_one(float(t[k]), float(y[k]))

    def see_one(self, t: float, y: float, margin: float = 0.0) -> None:
        """Add a value at a time, if it exceeds those before by more than a margin."""
        if y < self.least - margin:
            self.least, self.time_of_least = y, t
        if y > self.largest + margin:
            self.largest, self.time_of_largest = y, t

    def add(self, t: Array, y: Array, w: Array) -> None:
        """Add values y (N,) with their weights w (N,) in integrals; those that are not finite are left out."""
        if not np.isfinite(integral := float((w * y).sum())):
            finite = np.isfinite(y)
            t, y, w, self.finite = t[finite], y[finite], w[finite], False
            integral = float((w * y).sum())
        self.see(t, y)
        self.integral, self.span = self.integral + integral, self.span + float(w.sum())
        self.square += float((w * y * y).sum())

    def join(self, other: StepRange) -> None:
        """Add what another range contains, of other times."""
        self.see(np.array([other.time_of_least, other.time_of_largest]), np.array([other.least, other.largest]))
        self.integral, self.square = self.integral + other.integral, self.square + other.square
        self.span += other.span


def ranges(steps: Steps, names: Sequence[str], begin: float = -np.inf, end: float = np.inf) -> dict[str, StepRange]:
    """Signal -> range over the steps, or over their part between two times that they enclose [s]."""
    residuals = [name for name in names if _is_residual(name)]
    found = _ranges(steps, [name for name in names if not _is_residual(name)], begin, end, True)
    return found | _ranges(steps, residuals, begin, end, False)


def _is_residual(name: str) -> bool:
    """Whether a signal is a residual of constraints: between ends of steps, it would be an error of interpolation."""
    return name.rpartition(".")[2].startswith(("Phi[", "dPhi[", "Gam["))


def _ranges(steps: Steps, names: Sequence[str], begin: float, end: float, between: bool) -> dict[str, StepRange]:
    """As ``ranges``, with the motion ``between`` the ends, or without."""
    ends = steps.ends
    inside = (ends.t > begin) & (ends.t < end)
    t = ends.t if inside.all() else np.concatenate([[max(begin, ends.t[0])], ends.t[inside], [min(end, ends.t[-1])]])
    jumps = steps.jumps[(steps.jumps > t[0]) & (steps.jumps < t[-1])] if len(steps.jumps) and len(t) else steps.jumps
    if len(jumps):  # values on both sides of each
        t = np.unique(np.concatenate([t, jumps, np.nextafter(jumps, -np.inf)]))
    reactions = ends.needs_reactions(names)
    few = len(t) <= (MANY if len(jumps) else FEW) and between
    times, w = (t, np.ones(1)) if len(t) < 2 else lobatto_points(t) if few else (t, weights(t))
    states = steps.at(times, reactions) if few or len(t) != len(ends.t) or not inside.all() else ends
    found: dict[str, StepRange] = {}
    size = max(1, TOGETHER // len(times))
    for k in range(0, len(names), size):
        some = names[k : k + size]
        y = states.signal_rows(some)
        if states is not ends:
            y = joined(y, times, ends, some)
        own = [StepRange() for _ in some]
        whole = _add(own, times, y, w)
        if between and len(times) > 2 and whole.any():
            _refine(
                steps,
                reactions,
                times,
                y[whole],
                [x for x, good in zip(some, whole, strict=True) if good],
                [x for x, good in zip(own, whole, strict=True) if good],
            )
        found.update(zip(some, own, strict=True))
    return found


def _add(found: Sequence[StepRange], t: Array, y: Array, w: Array) -> NDArray[np.bool_]:
    """Add values (k, N) of signals to their ranges; whether they are finite, and not constant (k,)."""
    weighted = y * w  # sums of pairs: those of BLAS depend on the place of arrays in memory
    integral = weighted.sum(axis=1)
    finite = np.isfinite(integral)
    low, high = y.argmin(axis=1), y.argmax(axis=1)
    square, span = (y * weighted).sum(axis=1), float(w.sum())
    for k, own in enumerate(found):
        if finite[k]:
            own.see(t[[low[k], high[k]]], y[k, [low[k], high[k]]])
            own.integral, own.square, own.span = float(integral[k]), float(square[k]), span
        else:
            own.add(t, y[k], w)
    return finite & (y[np.arange(len(y)), high] > y[np.arange(len(y)), low])


def joined(y: Array, t: Array, ends: StateSignals, names: Sequence[str]) -> Array:
    """Values (k, N) of signals at times t, continued from those at the ends of steps: angles may differ by turns."""
    angles = [k for k, name in enumerate(names) if ends.unit(name) == "rad"]
    at = np.searchsorted(ends.t, t).clip(0, len(ends.t) - 1)
    common = np.flatnonzero(ends.t[at] == t)
    if angles and len(common):
        known = ends.signal_rows([names[k] for k in angles])[:, at[common[0]]]
        turns = _turns(known - y[angles, common[0]])
        y[angles] += np.where(np.isfinite(turns), turns, 0.0)[:, None]
    return y


def _turns(angle: Array) -> Array:
    """The whole turns [rad] next to angles."""
    return 2.0 * np.pi * np.round(angle / (2.0 * np.pi))


def _places(y: Array, sign: float) -> Indices:
    """The samples (k, PLACES), among values y (k, N), next to which the largest value of each row of sign y may lie.

    A parabola through a local maximum and its neighbours gives the height of the top beside it. Those that are too low
    are replaced by the highest one. They have neighbours: the first and the last sample are replaced by those.
    """
    N = y.shape[1]
    falls = y[:, 1:] < y[:, :-1] if sign > 0.0 else y[:, 1:] > y[:, :-1]
    rises = y[:, 1:] > y[:, :-1] if sign > 0.0 else y[:, 1:] < y[:, :-1]
    local = np.ones(y.shape, bool)
    local[:, 1:] &= ~falls
    local[:, :-1] &= ~rises
    row, j = np.nonzero(local)
    now, before, behind = (sign * y[row, i] for i in (j, np.maximum(j - 1, 0), np.minimum(j + 1, N - 1)))
    bend = 2.0 * now - before - behind
    rise = (behind - before) ** 2 / np.where(bend > 0.0, 8.0 * bend, np.inf)
    order = np.lexsort((-(now + rise), row))
    first = np.searchsorted(row, np.arange(len(y)))
    count = np.append(first[1:], len(row)) - first
    best = order[first[:, None] + np.minimum(np.arange(PLACES), count[:, None] - 1)]
    highest = np.maximum.reduceat(now, first)
    low = now[best] + 2.0 * rise[best] < highest[:, None]
    return np.where(low, j[best[:, :1]], j[best]).clip(1, N - 2)


def _refine(
    steps: Steps, reactions: bool, t: Array, y: Array, names: Sequence[str], found: Sequence[StepRange]
) -> None:
    """Add values near extremes to ranges; signals have values y (k, N) at times t (N,)."""
    N = y.shape[1]
    places = np.stack([_places(y, 1.0), _places(y, -1.0)]).reshape(2 * len(names), -1)
    place = np.unique(np.arange(len(places))[:, None] * N + places)
    signal, j = place // N % len(names), place % N
    sign = np.where(place < N * len(names), 1.0, -1.0)
    times, points = _points(t, j)
    order = np.argsort(times, kind="stable")
    at = np.empty(len(order), np.int64)
    at[order] = np.arange(len(order))
    states, rows = steps.at(times[order], reactions), at[points]
    near, values = states.t[rows], states.signal_rows(names)[signal[:, None], rows]
    angles = np.array([states.unit(name) == "rad" for name in names])[signal]
    values[angles] += _turns(y[signal, j - 1] - values[:, 0])[angles, None]
    size = np.array([x.largest - x.least for x in found])[signal]
    good = np.abs(y[signal, j - 1] - values[:, 0]) <= SAME * size
    good &= np.abs(y[signal, j + 1] - values[:, -1]) <= SAME * size
    top_t, top = _tops(near, sign[:, None] * values)
    first = np.where(sign > 0.0, y.argmax(axis=1)[signal], y.argmin(axis=1)[signal])
    margins = np.where((first == 0) | (first == N - 1), BORDER, ROUNDED) * size
    for k in np.flatnonzero(good).tolist():
        found[signal[k]].see_one(float(top_t[k]), float(sign[k] * top[k]), float(margins[k]))


def _points(t: Array, j: Indices) -> tuple[Array, Indices]:
    """Times in the intervals beside the times t[j], and of each of these the indices (., 2 PARTS + 1) of its own."""
    intervals = np.unique(np.concatenate([j - 1, j]))
    h, parts = t[intervals + 1] - t[intervals], np.arange(PARTS) / PARTS
    times = np.concatenate([(t[intervals, None] + parts * h[:, None]).ravel(), t[intervals + 1]])
    before, behind = np.searchsorted(intervals, j - 1), np.searchsorted(intervals, j)
    own = np.arange(PARTS)
    at = [before[:, None] * PARTS + own, behind[:, None] * PARTS + own, behind[:, None] + PARTS * len(intervals)]
    return times, np.concatenate(at, axis=1)


def _tops(t: Array, y: Array) -> tuple[Array, Array]:
    """Times and values (P,) of the largest of the values (P, N) in each row.

    If values are smooth there, they are those of the top of the polynomial through five values.
    """
    j, all_of = y.argmax(axis=1), np.arange(len(y))
    around = all_of[:, None], j.clip(2, y.shape[1] - 3)[:, None] + np.arange(-2, 3)
    top_t, top = t[all_of, j], y[all_of, j]
    t, y = t[around], y[around]
    with np.errstate(all="ignore"):
        h = np.diff(t)
        slope = np.diff(y) / h
        bend = 2.0 * np.diff(slope) / (h[:, 1:] + h[:, :-1])
        smooth = (bend.max(axis=1) < 0.0) & (bend.min(axis=1) > ALIKE * bend.max(axis=1)) & (top == y[:, 2])
    t, y, unit = t[smooth], y[smooth], h[smooth, 1:2]
    x = (t - t[:, 2:3]) / unit
    c = np.linalg.solve(x[:, :, None] ** np.arange(5), (y - y[:, 2:3])[:, :, None])[:, :, 0].T
    s = np.zeros(len(y))
    for _ in range(NEWTON):
        slope, bend = (k * c[k] for k in range(1, 5)), (k * (k - 1) * c[k] for k in range(2, 5))
        s = s - sum(a * s**k for k, a in enumerate(slope)) / sum(a * s**k for k, a in enumerate(bend))
    rise = sum(a * s**k for k, a in enumerate(c))
    good = (np.abs(s) <= 1.0) & (rise >= 0.0)
    smooth[smooth] = good
    top_t[smooth], top[smooth] = (t[:, 2] + s * unit[:, 0])[good], (y[:, 2] + rise)[good]
    return top_t, top
