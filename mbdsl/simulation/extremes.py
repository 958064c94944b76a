"""Extremes of signals over all steps of a run: least and largest values with their times, mean and root mean square.

A long run folds its steps into the ranges of the signals that were asked for, whenever they need too much memory.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import astuple, replace
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from mbdsl.expressions.spatial_coordinates import QUATERNION
from mbdsl.expressions.symbolic import walk
from mbdsl.lang.asked_signals import AskedSignals
from mbdsl.messages import OWN, UnitsOfSignals, count, few, shortened
from mbdsl.numerics.blas_threads import with_one_thread
from mbdsl.numerics.quadrature import weights
from mbdsl.simulation.state_signals import StateSignals
from mbdsl.simulation.step_ranges import StepRange, joined, ranges
from mbdsl.simulation.steps import Steps

if TYPE_CHECKING:
    from mbdsl.plotting.figures import TextTable

STEPS, OUTPUTS = "steps", "outputs"  #: what extremes are those of
FOLDED, LEAST_FOLDED = 400_000, 4000  #: quantity of values of signals that are folded at once; least number of steps
#: error of values between the kept ends of steps, relative to the largest: that of velocities in a thinned record
INTERPOLATED = 2e-5
REMARKS = {OUTPUTS: "the outputs, because the steps of the run are not known"}


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
        What is known: "steps", all steps; "outputs", these only; else a text such as "steps from 2 s".
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


class Gathered:
    """Ranges of the steps of a long run that were forgotten, for the signals that were asked for."""

    def __init__(self, signals: AskedSignals, asked: Sequence[str] | None) -> None:
        self._signals = signals
        names = [*signals.defaults, *signals.elastic] if asked is None else signals.select(asked)
        # of quaternions and counted angles, values depend on all earlier steps
        self.ranges = {name: StepRange() for name in names if name != "time" and not _continued(signals, name)}

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
            found.ranges[name] = StepRange(low, low_at, high, high_at, integral, square, span, bool(finite))
        return found

    def add(self, steps: Steps) -> None:
        """Fold steps, which follow those before."""
        steps.ends._names = self._signals
        for name, found in ranges(steps, list(self.ranges)).items():
            self.ranges[name].join(found)

    @property
    def rows(self) -> int:
        """Number of steps that are folded at once."""
        return max(LEAST_FOLDED, FOLDED // max(1, len(self.ranges)))


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
    display : UnitsOfSignals, optional
        The units of the table.
    descriptions : mapping of str to str, optional
        Variable of the model -> its description, for a line below the table.
    """

    def __init__(
        self, entries: Iterable[Extreme], display: UnitsOfSignals = OWN, descriptions: Mapping[str, str] = {}
    ) -> None:
        self._entries, self.display = {entry.signal: entry for entry in entries}, display
        self._descriptions = {name: descriptions[name] for name in self._entries if name in descriptions}

    def __getitem__(self, name: str) -> Extreme:
        return self._entries[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self._entries)

    def __len__(self) -> int:
        return len(self._entries)

    def __repr__(self) -> str:
        return f"<Extremes of {count(len(self), 'signal')}>"

    def __str__(self) -> str:
        return "\n".join([*lines(self.values(), self.display), *self.remarks()])

    def _repr_html_(self) -> str:
        from mbdsl.plotting.html_tables import fragment

        return fragment("Extremes", (), [self.table()], self.remarks())

    def remarks(self) -> list[str]:
        """Return descriptions of variables, and what the values are those of, unless it is all steps.

        Returns
        -------
        list of str
        """
        return [*(f"{name}: {said}" for name, said in self._descriptions.items()), *remarks(self.values())]

    def table(self, note: str = "") -> TextTable:
        """Return the extremes as a table, in the units in which values are displayed.

        Parameters
        ----------
        note : str, optional
            A sentence below the table.

        Returns
        -------
        Table
        """
        from mbdsl.plotting.figures import TextTable

        return TextTable("", head(self.display), [cells(x, self.display) for x in self.values()], note)


def head(display: UnitsOfSignals) -> tuple[str, ...]:
    """The heads of the columns of a table."""
    at = f"at [{display.of('s', 'time').symbol}]"
    return "signal", "unit", "least", at, "largest", at, "mean", "rms"


UNSURE = 1e-9  #: part of the rms below which a mean is displayed as 0
#: least number of outputs before the known steps from which a mean is stated
FEW_OUTPUTS = 50
WIDTH, GAP = 80, "  "  #: columns of a table as text; what is between two of its columns


def cells(x: Extreme, display: UnitsOfSignals, digits: int = 4) -> tuple[str, ...]:
    """A row of a table."""
    unit, second = display.of(x.unit, x.signal), display.of("s", "time")
    numbers = [(x.least, unit), (x.time_of_least, second), (x.largest, unit), (x.time_of_largest, second)]
    numbers += [(0.0 if abs(x.mean) < UNSURE * x.rms else x.mean, unit), (x.rms, unit)]
    return x.signal, unit.symbol, *(f"{value / own.factor:.{digits}g}" for value, own in numbers)


def remarks(found: Iterable[Extreme]) -> list[str]:
    """What the values are those of, unless it is all steps."""
    by = {of: [x.signal for x in found if x.of == of] for of in dict.fromkeys(x.of for x in found)}
    return [f"{few(names)}: of {REMARKS.get(of, of)}" for of, names in by.items() if of != STEPS]


def lines(found: Iterable[Extreme], display: UnitsOfSignals = OWN) -> list[str]:
    """A table as text of at most WIDTH columns; names that leave no room for the numbers are in lines of their own."""
    found = list(found)
    for digits in (4, 3):  # numbers such as -1.234e-05 may need too much room
        rows = [head(display), *(cells(x, display, digits) for x in found)]
        wide = [max(len(row[k]) for row in rows) for k in range(len(rows[0]))]
        room = WIDTH - sum(wide[1:]) - len(GAP) * (len(wide) - 1)
        if room >= len(rows[0][0]):
            break
    first = max(len(row[0]) for row in rows if len(row[0]) <= max(room, len(rows[0][0])))
    shown = []
    for name, unit, *numbers in rows:
        if len(name) > first:
            shown.append(shortened(name, WIDTH))
            name = ""
        right = "".join(f"{GAP}{x:>{w}}" for x, w in zip(numbers, wide[2:], strict=True))
        shown.append(f"{name:<{first}}{GAP}{unit:<{wide[1]}}{right}")
    return shown


def _extreme(found: StepRange, signal: str, unit: str, of: str) -> Extreme:
    """The result; nan if there is no finite value."""
    if found.least > found.largest:
        return Extreme(signal, unit, np.nan, np.nan, np.nan, np.nan, np.nan, np.nan, of)
    mean, square = (x / found.span if found.span else np.nan for x in (found.integral, found.square))
    if not found.span:  # one value
        mean, square = found.least, found.least**2
    inside = min(max(mean, found.least), found.largest)
    low, high, rms = found.least + 0.0, found.largest + 0.0, float(np.sqrt(max(0.0, square)))
    return Extreme(signal, unit, low, found.time_of_least, high, found.time_of_largest, inside + 0.0, rms, of)


@with_one_thread
def extremes(shown: StateSignals, names: Iterable[str]) -> Extremes:
    """Extremes of signals over the time of a trajectory, of all steps as far as they are known."""
    names, steps, t = [name for name in names if name != "time"], shown.steps, shown.t
    if not len(t):
        return Extremes(_extreme(StepRange(), name, shown.unit(name), OUTPUTS) for name in names)
    first, last = float(t[0] if shown._since is None else shown._since), float(t[-1])
    near = 1e-9 * (last - first)
    known: dict[str, StepRange] = {}
    since = np.inf
    if steps is not None and steps.ends.t[0] < last - near:
        since = max(float(steps.ends.t[0]), first)
        begin = first if first > steps.ends.t[0] + near else -np.inf
        following = [x for x in names if shown.gathered is None or not _continued(shown._names, x)]
        if begin > -np.inf:  # between steps, turns before this time are known of angles themselves only
            following = [x for x in following if shown.unit(x) == "rad" or not _continued(shown._names, x)]
        known = ranges(steps, following, begin, last if last < steps.ends.t[-1] - near else np.inf)
    return Extremes(_of(shown, name, known.get(name), since, since <= first + near) for name in names)


def _of(shown: StateSignals, name: str, known: StepRange | None, since: float, whole: bool) -> Extreme:
    """The extreme of a signal from its range over the steps since a time, of the ``whole`` run or not, and outputs."""
    t, x, unit = shown.t, shown._signal(name), shown.unit(name)
    found, of = StepRange(), STEPS
    earlier = None if shown.gathered is None or not shown._from_start else shown.gathered.ranges.get(name)
    if known is not None:
        found.join(known)
    if known is not None and not whole and earlier is not None:
        found.join(earlier)
    elif known is None or not whole:
        rows = t <= (np.inf if known is None else since)
        before_t, before_x = t[rows], x[rows]
        if known is not None and len(before_t) and before_t[-1] < since:  # the time up to the first known step
            before_t, before_x = np.append(before_t, since), np.append(before_x, value_at(shown, name, since))
        found.add(before_t, before_x, weights(before_t))
        before = ", outputs before" if shown._since is None else ""
        of = OUTPUTS if known is None else f"steps from {since:.6g} s on{before}"
    finite, top = np.isfinite(x), replace(found)
    found.see(t[finite], x[finite])
    # an output that exceeds a flat top by less than an error of interpolation does not have its time
    error = INTERPOLATED * max(abs(found.least), abs(found.largest))
    if found.least > top.least - error:
        found.time_of_least = top.time_of_least
    if found.largest < top.largest + error:
        found.time_of_largest = top.time_of_largest
    result = _extreme(found, name, unit, of)
    unsure = of not in (STEPS, OUTPUTS) and (t <= since).sum() < FEW_OUTPUTS
    return result._replace(mean=np.nan, rms=np.nan) if unsure else result


def value_at(shown: StateSignals, name: str, t: float) -> float:
    """The value of a signal at a time [s] of a run whose steps are known."""
    steps = shown.steps
    assert steps is not None
    ends = steps.ends
    k = int(np.clip(np.searchsorted(ends.t, t, side="right") - 1, 0, max(0, len(ends.t) - 2)))
    times = np.array([ends.t[k], min(max(t, ends.t[k]), ends.t[-1])])
    states = steps.at(times, ends.needs_reactions([name]))
    return float(joined(states.signal_rows([name]), times, ends, [name])[0, 1])
