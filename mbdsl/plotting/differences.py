"""Differences of results: a result minus another one, at the times of the other, part by part in bounded memory."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Sequence
from typing import TYPE_CHECKING

import numpy as np

from mbdsl.errors import UsageError
from mbdsl.results.stored import Layout, Result

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Array = NDArray[np.float64]

RATES = {"x": "vx", "y": "vy", "phi": "w", "vx": "ax", "vy": "ay", "w": "alpha"}
NO_JUMPS = np.empty(0)
ROUNDING = 1e-12  #: times that are outside by less than this part of the range are at its end


def rate_of(name: str, names: Collection[str]) -> str | None:
    """The name of the derivative of a signal; None if it is not among ``names``."""
    owner, dot, key = name.rpartition(".")
    rate = f"{owner}.{RATES[key]}" if dot and key in RATES else None
    return rate if rate in names else None


class Difference(Result):
    """A result minus another one, at the times of the other one.

    Values between the times of ``result`` are interpolated, by cubic Hermite polynomials if it has the derivative of
    the signal, and linearly otherwise. Between a time and an event, where the signal may jump, they continue the motion
    before it, and between an event and the next time that behind it. Times outside its range have no value (nan).

    Parameters
    ----------
    result, base : Result
        The results; the difference has the signals of both.

    Attributes
    ----------
    interpolated : bool
        Whether values were interpolated when the columns were read.
    """

    def __init__(self, result: Result, base: Result) -> None:
        known = set(result.names)
        names = [name for name in base.names if name in known]
        if not names:
            raise UsageError(
                f"{result.label} and {base.label} have no signal in common", hint="--difference compares equal signals"
            )
        units = {name: base.unit(name) or result.unit(name) for name in names}
        for name, unit in units.items():
            if result.unit(name) not in ("", unit):
                other = f"{result.unit(name)} in {result.label}"
                raise UsageError(f"`{name}` has the unit {unit} in {base.label} and {other}")
        self.result, self.base, self.interpolated = result, base, False
        label = f"{result.label} − {base.label}"
        super().__init__(label, Layout([base.time, *names], {base.time: "s", **units}, self._parts))
        self.events = base.events
        if base.groups is not None:
            self.groups = [[name for name in group if name in known] for group in base.groups]

    def rates(self, names: Sequence[str]) -> list[str]:
        """The signals of ``names`` that are interpolated with their derivatives."""
        known = set(self.result.names)
        return [name for name in names if rate_of(name, known)]

    def _parts(self, asked: Sequence[str], rows: int) -> Iterator[list[Array]]:
        names = asked[1:]
        window = Window(self.result, names, rows)
        for t, columns in self.base.chunks(names, rows):
            window.move(t)
            self.interpolated |= not window.has(t)
            yield [t, *(window.at(t, name) - columns[name] for name in names)]


class Window:
    """The part of a result that encloses a range of times; it moves forward.

    Parameters
    ----------
    result : Result
    names : sequence of str
        The signals that are interpolated.
    rows : int
        Number of rows that are read at a time.
    """

    def __init__(self, result: Result, names: Sequence[str], rows: int) -> None:
        known = set(result.names)
        self._rates = {name: rate_of(name, known) for name in names}
        self._names = list(dict.fromkeys([*names, *filter(None, self._rates.values())]))
        self._jumps = {True: result.jumps(True), False: result.jumps(False)}
        self._parts = result.chunks(self._names, rows)
        self._t = np.empty(0)
        self._columns = {name: np.empty(0) for name in self._names}
        self._more = True

    def move(self, t: Array) -> None:
        """Enclose the ascending times (k,), which are not before those of earlier calls."""
        if not len(t):
            return
        start = max(int(np.searchsorted(self._t, t[0], side="left")) - 2, 0)
        times, columns = [self._t[start:]], {name: [values[start:]] for name, values in self._columns.items()}
        while self._more and not (len(times[-1]) and times[-1][-1] >= t[-1]):
            part = next(self._parts, None)
            if part is None:
                self._more = False
            else:
                times.append(part[0])
                for name in self._names:
                    columns[name].append(part[1][name])
        self._t = np.concatenate(times)
        self._columns = {name: np.concatenate(values) for name, values in columns.items()}

    def has(self, t: Array) -> bool:
        """Whether all times (k,) within the range are those of the result."""
        if not len(self._t):
            return True
        inside = t[(t >= self._t[0]) & (t <= self._t[-1])]
        return bool(np.isin(inside, self._t).all())

    def at(self, t: Array, name: str) -> Array:
        """Values (k,) of a signal at times (k,) within the window; nan outside the range of the result."""
        rate = self._rates[name]
        position = rate is not None and rate.rpartition(".")[2] in RATES  # only its derivative jumps
        rates = None if rate is None else self._columns[rate]
        return interpolated(t, self._t, self._columns[name], rates, self._jumps[position])


def interpolated(t: Array, known: Array, values: Array, rates: Array | None, jumps: Array = NO_JUMPS) -> Array:
    """Values (k,) at times ``t``: cubic Hermite polynomials, or linear without ``rates`` and where these are nan.

    Parameters
    ----------
    t : (k,)
        Times.
    known : (K,)
        Ascending times. Where two are equal, the value of the second holds from there on.
    values, rates : (K,)
        Values and their derivatives at the known times.
    jumps : (J,)
        Ascending times of jumps. At a jump and up to the next known time, the value is that behind it; without
        ``rates``, the known value. Between two jumps there is no value (nan).

    Returns
    -------
    (k,)
        Values; nan outside the known times.
    """
    if not len(known):
        return np.full(len(t), np.nan)
    if len(known) == 1:
        return np.where(t == known[0], values[0], np.nan)
    slack = ROUNDING * max(abs(known[0]), abs(known[-1]))
    k = np.clip(np.searchsorted(known, t, side="right") - 1, 0, len(known) - 2)
    h = known[k + 1] - known[k]
    x = np.clip(np.divide(t - known[k], h, out=np.ones(len(t)), where=h > 0.0), 0.0, 1.0)
    a, b = values[k], values[k + 1]
    found = a + x * (b - a)
    if rates is not None:
        u, v = h * rates[k], h * rates[k + 1]
        cubic = a + x * (u + x * (3.0 * (b - a) - 2.0 * u - v + x * (2.0 * (a - b) + u + v)))
        found = np.where(np.isfinite(cubic), cubic, found)
    first, end = (np.searchsorted(jumps, known[i] + slack, side="right") for i in (k, k + 1))
    if (some := np.flatnonzero(first < end)).size:
        before = t[some] < jumps[first[some]] - slack
        after = t[some] >= jumps[end[some] - 1] - slack
        there = k[some] + ~before
        slope = np.zeros(len(some)) if rates is None else np.nan_to_num(rates[there])
        found[some] = np.where(before | after, values[there] + slope * (t[some] - known[there]), np.nan)
    found = np.where(x == 0.0, a, np.where(x == 1.0, b, found))  # known values are not interpolated
    return np.where((t < known[0] - slack) | (t > known[-1] + slack), np.nan, found)
