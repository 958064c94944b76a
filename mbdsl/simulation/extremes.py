"""Extremes of signals over all steps of a run: least and largest values with their times, mean and root mean square.

The values at the ends of all steps are known (:mod:`mbdsl.simulation.steps`). Near the largest of them the motion
between the ends is evaluated, and a parabola gives the top. Where a run is short, all of its steps are evaluated at
five points, those of a Lobatto rule, which also gives the mean. A long run folds its steps into the ranges of the
signals that were asked for, whenever they need too much memory.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import astuple, dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from mbdsl.expressions.spatial_coordinates import QUATERNION
from mbdsl.expressions.symbolic import walk
from mbdsl.lang.asked_signals import AskedSignals
from mbdsl.messages import count, few
from mbdsl.numerics.blas_threads import with_one_thread
from mbdsl.numerics.quadrature import lobatto_points, weights
from mbdsl.simulation.state_signals import StateSignals
from mbdsl.simulation.steps import Steps

Array = NDArray[np.float64]

STEPS, ROWS = "steps", "rows"  #: what extremes are those of
REMARKS = {ROWS: "the rows, because the steps of the run are not known"}
FEW = 1000  #: number of steps up to which all of them are evaluated between their ends
PLACES = 3  #: number of places where an extreme is sought
PARTS = 6  #: points in each interval beside such a place
BLOCK, BLOCKS = 64, 16  #: length, and largest number, of the blocks of values in which places are sought
ALIKE = 3.0  #: ratio of successive second differences up to which a parabola goes through three of the points
ROUNDED = 1e-12  #: part of the range by which a value between ends of steps has to exceed those at the ends
SAME = 1e-6  #: part of the range by which values at ends of steps may differ when computed with others


class Extreme(NamedTuple):
    """Extremes and means of a signal.

    Attributes
    ----------
    signal, unit : str
        Its name and SI unit.
    least, largest : float
        Least and largest value.
    time_of_least, time_of_largest : float [s]
        Their times.
    mean, rms : float
        Mean, and root of the mean square, over time.
    of : str
        What is known: "steps", all steps; "rows", the rows of the result only; else a text such as "steps from 2 s".
    """

    signal: str
    unit: str
    least: float
    time_of_least: float
    largest: float
    time_of_largest: float
    mean: float
    rms: float
    of: str = "steps"


@dataclass
class Range:
    """Extremes of some values, with their times, and integrals over time."""

    least: float = np.inf
    time_of_least: float = np.nan
    largest: float = -np.inf
    time_of_largest: float = np.nan
    integral: float = 0.0
    square: float = 0.0
    span: float = 0.0
    finite: bool = True  #: whether all values are

    def see(self, t: Array, y: Array, margin: float = 0.0) -> None:
        """Add values y (N,) at times t (N,), which exceed those before by more than a margin, but not to integrals."""
        if len(y):
            low, high = int(y.argmin()), int(y.argmax())
            if y[low] < self.least - margin:
                self.least, self.time_of_least = float(y[low]), float(t[low])
            if y[high] > self.largest + margin:
                self.largest, self.time_of_largest = float(y[high]), float(t[high])

    def add(self, t: Array, y: Array, w: Array) -> None:
        """Add values y (N,) with their weights w (N,) in integrals; those that are not finite are left out."""
        if not np.isfinite(integral := float(w @ y)):
            finite = np.isfinite(y)
            t, y, w, self.finite = t[finite], y[finite], w[finite], False
            integral = float(w @ y)
        self.see(t, y)
        self.integral, self.span = self.integral + integral, self.span + float(w.sum())
        self.square += float(np.einsum("i,i,i", w, y, y))

    def join(self, other: Range) -> None:
        """Add what another range contains, of other times."""
        self.see(np.array([other.time_of_least, other.time_of_largest]), np.array([other.least, other.largest]))
        self.integral, self.square = self.integral + other.integral, self.square + other.square
        self.span += other.span

    def extreme(self, signal: str, unit: str, of: str) -> Extreme:
        """The result; nan if there is no finite value."""
        if self.least > self.largest:
            return Extreme(signal, unit, np.nan, np.nan, np.nan, np.nan, np.nan, np.nan, of)
        mean, square = (x / self.span if self.span else np.nan for x in (self.integral, self.square))
        if not self.span:  # one value
            mean, square = self.least, self.least**2
        inside = min(max(mean, self.least), self.largest)
        low, high, rms = self.least + 0.0, self.largest + 0.0, float(np.sqrt(max(0.0, square)))
        return Extreme(signal, unit, low, self.time_of_least, high, self.time_of_largest, inside + 0.0, rms, of)


class Gathered:
    """Ranges of the steps of a long run that were forgotten, for the signals that were asked for."""

    def __init__(self, signals: AskedSignals, asked: Sequence[str] | None) -> None:
        self._signals = signals
        names = [*signals.defaults, *signals.elastic] if asked is None else signals.select(asked)
        # of quaternions and counted angles, values depend on all earlier steps
        self.ranges = {name: Range() for name in names if name != "time" and not _continued(signals, name)}

    def state(self) -> dict[str, list[float]]:
        """The ranges as plain values, for a checkpoint."""
        return {name: [float(x) for x in astuple(found)] for name, found in self.ranges.items()}

    @classmethod
    def of_state(cls, signals: AskedSignals, state: Mapping[str, Sequence[float]] | None) -> Gathered | None:
        """The inverse of ``state``.

        Raises
        ------
        LookupError, TypeError, ValueError
            If it does not contain ranges of signals.
        """
        if state is None:
            return None
        if any(name not in signals for name in state):
            raise ValueError("it has ranges of signals that this model lacks")
        found = cls(signals, [])
        for name, numbers in state.items():
            low, low_at, high, high_at, integral, square, span, finite = map(float, numbers)
            found.ranges[name] = Range(low, low_at, high, high_at, integral, square, span, bool(finite))
        return found

    def add(self, steps: Steps) -> None:
        """Fold steps, which follow those before."""
        steps.ends._names = self._signals
        for name, found in ranges(steps, list(self.ranges)).items():
            self.ranges[name].join(found)


def _continued(signals: AskedSignals, name: str) -> bool:
    """Whether the value of a signal depends on earlier states."""
    if signals.scene.spatial and name.rpartition(".")[2] in QUATERNION:
        return True
    entry = signals.entry(name)
    return entry is not None and any(node.op == "angle" for node in walk(entry[0]))


class Extremes(Mapping[str, Extreme]):
    """The extremes of signals by their names; ``print`` and notebooks show a table.

    Parameters
    ----------
    entries : iterable of Extreme
        One for each signal.
    """

    def __init__(self, entries: Iterable[Extreme]) -> None:
        self._entries = {entry.signal: entry for entry in entries}

    def __getitem__(self, name: str) -> Extreme:
        return self._entries[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self._entries)

    def __len__(self) -> int:
        return len(self._entries)

    def __repr__(self) -> str:
        return f"<Extremes of {count(len(self), 'signal')}>"

    def __str__(self) -> str:
        return "\n".join(lines(self.values()))

    def _repr_html_(self) -> str:
        from mbdsl.plotting.figures import Table
        from mbdsl.plotting.html_tables import fragment

        return fragment("Extremes", (), [Table("", HEAD, [cells(x) for x in self.values()])], remarks(self.values()))


HEAD = ("signal", "unit", "least", "at [s]", "largest", "at [s]", "mean", "rms")


LONG = 24  #: letters of a name up to which the others are aligned with it


def cells(x: Extreme) -> tuple[str, ...]:
    """A row of a table."""
    numbers = (x.least, x.time_of_least, x.largest, x.time_of_largest, x.mean, x.rms)
    return x.signal, x.unit, *(f"{value:.4g}" for value in numbers)


def remarks(found: Iterable[Extreme]) -> list[str]:
    """What the values are those of, unless it is all steps."""
    by = {of: [x.signal for x in found if x.of == of] for of in dict.fromkeys(x.of for x in found)}
    return [f"{few(names)}: of {REMARKS.get(of, of)}" for of, names in by.items() if of != STEPS]


def lines(found: Iterable[Extreme]) -> list[str]:
    """A table as text; long names are in lines of their own."""
    found = list(found)
    rows = [HEAD, *map(cells, found)]
    wide = [max(len(row[k]) for row in rows if k or len(row[0]) <= LONG) for k in range(len(HEAD))]
    shown = []
    for name, unit, *numbers in rows:
        if len(name) > wide[0]:
            shown.append(name)
            name = ""
        right = "".join(f"  {x:>{w}}" for x, w in zip(numbers, wide[2:], strict=True))
        shown.append(f"{name:<{wide[0]}}  {unit:<{wide[1]}}{right}")
    return [*shown, *remarks(found)]


@with_one_thread
def extremes(shown: StateSignals, names: Iterable[str]) -> Extremes:
    """Extremes of signals over the time of a trajectory, of all steps as far as they are known."""
    names, steps, t = [name for name in names if name != "time"], shown.steps, shown.t
    if not len(t):
        return Extremes(Range().extreme(name, shown.unit(name), ROWS) for name in names)
    first, last = float(t[0] if shown._since is None else shown._since), float(t[-1])
    near = 1e-9 * (last - first)
    known: dict[str, Range] = {}
    since = np.inf
    if steps is not None and steps.ends.t[0] < last - near:
        since = max(float(steps.ends.t[0]), first)
        begin = first if first > steps.ends.t[0] + near else -np.inf
        following = [x for x in names if shown.gathered is None or not _continued(shown._names, x)]
        known = ranges(steps, following, begin, last if last < steps.ends.t[-1] - near else np.inf)
    return Extremes(_of(shown, name, known.get(name), since, since <= first + near) for name in names)


def _of(shown: StateSignals, name: str, known: Range | None, since: float, whole: bool) -> Extreme:
    """The extreme of a signal from its range over the steps since a time, which are the ``whole`` run, and its rows."""
    t, x, unit = shown.t, shown._signal(name), shown.unit(name)
    found, of = Range(), STEPS
    earlier = None if shown.gathered is None or not shown._from_start else shown.gathered.ranges.get(name)
    if known is not None:
        found.join(known)
    if known is not None and not whole and earlier is not None:
        found.join(earlier)
    elif known is None or not whole:
        rows = t <= since
        found.add(t[rows], x[rows], weights(t[rows]))
        before = ", rows before" if shown._since is None else ""
        of = ROWS if known is None else f"steps from {since:.6g} s on{before}"
    finite = np.isfinite(x)
    found.see(t[finite], x[finite])
    return found.extreme(name, unit, of)


def ranges(steps: Steps, names: Sequence[str], begin: float = -np.inf, end: float = np.inf) -> dict[str, Range]:
    """Signal -> range over the steps, or over their part between two times that they enclose [s]."""
    ends = steps.ends
    inside = (ends.t > begin) & (ends.t < end)
    t = ends.t if inside.all() else np.concatenate([[max(begin, ends.t[0])], ends.t[inside], [min(end, ends.t[-1])]])
    reactions = any(ends.needs_reactions(name) for name in names)
    whole = len(t) <= FEW or not inside.all()
    times, w = (lobatto_points(t) if len(t) <= FEW else (t, weights(t))) if len(t) > 1 else (t, np.ones(1))
    states = steps.at(times, reactions) if whole else ends
    found: dict[str, Range] = {}
    values: dict[str, Array] = {}
    for name in names:
        y = states._signal(name)
        if states is not ends:
            y = _joined(y, times, ends, name)
        found[name] = Range()
        found[name].add(times, y, w)
        if found[name].largest > found[name].least and found[name].finite and len(times) > 2:
            values[name] = y
    _refine(steps, reactions, times, values, found)
    return found


def value_at(shown: StateSignals, name: str, t: float) -> float:
    """The value of a signal at a time [s] of a run whose steps are known."""
    steps = shown.steps
    assert steps is not None
    ends = steps.ends
    k = int(np.clip(np.searchsorted(ends.t, t, side="right") - 1, 0, max(0, len(ends.t) - 2)))
    times = np.array([ends.t[k], min(max(t, ends.t[k]), ends.t[-1])])
    states = steps.at(times, ends.needs_reactions(name))
    return float(_joined(states._signal(name), times, ends, name)[1])


def _joined(y: Array, t: Array, ends: StateSignals, name: str) -> Array:
    """Values y (N,) at times t as a continuation of those at the ends of steps: angles may differ by turns."""
    known = ends._signal(name)
    k = np.searchsorted(ends.t, t).clip(0, len(ends.t) - 1)
    at = np.flatnonzero(ends.t[k] == t)
    if not len(at) or ends.unit(name) != "rad":
        return y
    turns = _turns(known[k[at[0]]] - y[at[0]])
    return y + turns if np.isfinite(turns) and turns else y


def _places(y: Array) -> NDArray[np.int64]:
    """The samples, among values y (N,), next to which the largest value may lie; not the first and the last one."""
    N = len(y)
    if N > BLOCK * BLOCKS:
        tops = np.maximum.reduceat(y, np.arange(0, N, BLOCK))
        k = int(np.clip(y.argmax(), 2, N - 3))
        slack = float(np.abs(np.diff(y[k - 2 : k + 3], 2)).max())
        blocks = np.flatnonzero(tops >= tops.max() - slack)
        if len(blocks) > BLOCKS:
            blocks = blocks[np.argpartition(tops[blocks], -BLOCKS)[-BLOCKS:]]
        j = (BLOCK * blocks[:, None] + np.arange(BLOCK)).ravel().clip(0, N - 1)
    else:
        j = np.arange(N)
    now, before, behind = y[j], y[np.maximum(j - 1, 0)], y[np.minimum(j + 1, N - 1)]
    peaks = np.flatnonzero((now >= before) & (now >= behind))
    j, now, before, behind = j[peaks], now[peaks], before[peaks], behind[peaks]
    bend = 2.0 * now - before - behind
    top = now + (behind - before) ** 2 / np.where(bend > 0.0, 8.0 * bend, np.inf)
    return j[np.argsort(-top, kind="stable")[:PLACES]].clip(1, N - 2)


def _refine(steps: Steps, reactions: bool, t: Array, values: Mapping[str, Array], found: Mapping[str, Range]) -> None:
    """Add values near extremes to ranges; signals have ``values`` (N,) at times t (N,)."""
    places = {name: np.unique(np.concatenate([_places(y), _places(-y)])) for name, y in values.items()}
    if not places:
        return
    j = np.concatenate([*places.values()])
    intervals = np.unique(np.concatenate([j - 1, j]))
    h, parts = t[intervals + 1] - t[intervals], np.arange(PARTS) / PARTS
    times = np.concatenate([(t[intervals, None] + parts * h[:, None]).ravel(), t[intervals + 1]])
    order = np.argsort(times, kind="stable")
    states = steps.at(times[order], reactions)
    place = np.empty(len(order), np.int64)
    place[order] = np.arange(len(order))
    # of each place its points in the interval before it, in that behind it, and the end of that
    before, behind = np.searchsorted(intervals, j - 1), np.searchsorted(intervals, j)
    own = np.arange(PARTS)
    at = [before[:, None] * PARTS + own, behind[:, None] * PARTS + own, behind[:, None] + PARTS * len(intervals)]
    rows = place[np.concatenate(at, axis=1)]
    for name, js, own in zip(places, places.values(), _split(rows, places), strict=True):
        y, known, size = states._signal(name)[own], values[name], found[name].largest - found[name].least
        if states.unit(name) == "rad":
            y = y + _turns(known[js - 1] - y[:, 0])[:, None]
        good = (np.abs(known[js - 1] - y[:, 0]) <= SAME * size) & (np.abs(known[js + 1] - y[:, -1]) <= SAME * size)
        near, y = states.t[own][good], y[good]
        found[name].see(near.ravel(), y.ravel(), ROUNDED * size)
        for sign in (1.0, -1.0):
            top_t, top = _tops(near, sign * y)
            found[name].see(top_t, sign * top, ROUNDED * size)


def _split(rows: NDArray[np.int64], places: Mapping[str, NDArray[np.int64]]) -> list[NDArray[np.int64]]:
    return np.split(rows, np.cumsum([len(js) for js in places.values()])[:-1])


def _turns(angle: Array) -> Array:
    """The whole turns [rad] next to angles."""
    return 2.0 * np.pi * np.round(angle / (2.0 * np.pi))


def _tops(t: Array, y: Array) -> tuple[Array, Array]:
    """Times and values (K,) of the tops of parabolas through the largest of values (P, N), in rows, and its neighbours.

    Rows are left out whose values are not smooth there, as at a jump.
    """
    j = y.argmax(axis=1)
    rows = np.flatnonzero((j > 1) & (j < y.shape[1] - 2))
    around = j[rows, None] + np.arange(-2, 3)
    t, y = t[rows[:, None], around], y[rows[:, None], around]
    with np.errstate(all="ignore"):
        h = np.diff(t)
        slope = np.diff(y) / h
        bend = 2.0 * np.diff(slope) / (h[:, 1:] + h[:, :-1])
        smooth = (bend.max(axis=1) < 0.0) & (bend.min(axis=1) > ALIKE * bend.max(axis=1))
        middle = (slope[:, 1] * h[:, 2] + slope[:, 2] * h[:, 1]) / (h[:, 1] + h[:, 2])
        top_t, top = t[:, 2] - middle / bend[:, 1], y[:, 2] - 0.5 * middle**2 / bend[:, 1]
    return top_t[smooth], top[smooth]
