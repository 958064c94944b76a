"""Events of two calibration runs: whether their sequences agree, and how far the times of one event are apart.

Runs with different errors have their events at slightly different times. Between the two times of one event, one run is
behind a jump and the other before it. No tolerance reduces this difference: an output there counts with the difference
of the times instead. If the sequences differ, in their sources or their order, nothing is known from there on.

A rigid contact that comes to rest has impacts that become ever shorter; where they are cut off depends on the
tolerance. Impacts of one run that all lie within a negligible time of the rest of the contact in the other are no
difference.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import NamedTuple

import numpy as np

from mbdsl.integrators.event_list import EventGroup, kind
from mbdsl.integrators.event_set import EventSet
from mbdsl.kernels.arrays import Array
from mbdsl.mechanism import sticking
from mbdsl.mechanism.contacts import COUNT, HELD, MODE, number

#: what a change of the number of a component is called; of several at one time, impacts are the first
IMPACT, CLOSES, OPENS, STICKS, SLIDES = "impact", "rest", "opening", "sticking", "sliding"
ORDER = {IMPACT: "0", OPENS: "1", SLIDES: "1", STICKS: "2", CLOSES: "3"}


class Event(NamedTuple):
    """What happened at time t [s]: its kind, and its source, a component or a place in the text."""

    t: float
    kind: str
    source: str

    @property
    def text(self) -> str:
        what = f"the {self.kind} of `{self.source}`" if self.kind in ORDER else f"`{self.kind}` at {self.source}"
        return f"{what} at t = {self.t:.6g} s"

    def same(self, other: Event) -> bool:
        """Whether this is the same event at another time."""
        return self[1:] == other[1:]


class Compared(NamedTuple):
    """The events of two runs: pairs of times (k, 2) of those that both have, until ``end`` [s]; the first that they do
    not have both, if there is one."""

    times: Array
    end: float = np.inf
    first: Event | None = None


def sequence(events: EventSet) -> list[Event]:
    """All events of a run, but for ticks in compiled code, which are exact."""
    own = {
        id(branch): (kind(branch, events.events), f"{branch.span.file}:{branch.span.line}" if branch.span else "")
        for branch in events.events.branches
    }
    found = [Event(x.t, *own[id(branch)]) for x in events.acted for branch in x.branches]
    for name, zero, rises, falls in _watched(events):
        if name in events.names:
            found += _changes(events, name, zero, rises, falls)
    return sorted(found, key=lambda x: (x.t, ORDER.get(x.kind, ""), x.source))


def _watched(events: EventSet) -> Iterable[tuple[str, bool | None, str, str]]:
    """Numbers of components, whether their event begins where they are zero, or where they are not, and what its begin
    and its end are called."""
    scene = events.system.scene
    for contact in scene.contacts:
        yield number(contact.name, COUNT), None, IMPACT, ""
        yield number(contact.name, MODE), False, CLOSES, OPENS
        yield number(contact.name, HELD), False, STICKS, SLIDES
    for joint in scene.sticking:
        yield sticking.number(joint.name, sticking.SLIDING), True, STICKS, SLIDES


def _changes(events: EventSet, own: str, zero: bool | None, rises: str, falls: str) -> list[Event]:
    """The events of one number; ``zero`` None: every change of it is one."""
    k, source = 1 + events.names.index(own), own.rpartition(".")[0]
    times = np.concatenate([rows[:, 0] for rows in events.history])
    x = np.concatenate([rows[:, k] for rows in events.history])
    state = x if zero is None else ((x == 0.0) == zero).astype(float)
    at = 1 + np.flatnonzero(np.diff(state))
    return [Event(float(times[i]), rises if state[i] > state[i - 1] else falls, source) for i in at.tolist()]


def compared(one: EventSet, other: EventSet, near: float, stop: float) -> Compared:
    """The events of two runs until ``stop`` [s]; times that differ by less than ``near`` [s] have no order."""
    near = max(near, *(2.0 * x.contacts.shortest for x in (one, other) if x.contacts is not None), 0.0)
    a, b = sequence(one), sequence(other)
    pairs: list[tuple[float, float]] = []
    i = j = 0
    while i < len(a) and j < len(b):
        if not a[i].same(b[j]):
            if (further := _past_the_rest(a, i, b, j, near)) is not None:
                i, j = further
                continue
            if not _moved_up(b, j, a[i], near):
                first = min(a[i], b[j], key=lambda x: x.t)
                return Compared(np.array(pairs).reshape(-1, 2), first.t, first)
        pairs.append((a[i].t, b[j].t))
        i, j = i + 1, j + 1
    for x in (*a[i:], *b[j:]):
        if x.t < stop - near:
            return Compared(np.array(pairs).reshape(-1, 2), x.t, x)
        pairs.append((x.t, stop))  # the other run has it shortly behind the end
    return Compared(np.array(pairs).reshape(-1, 2))


def _moved_up(b: list[Event], j: int, event: Event, near: float) -> bool:
    """Whether an event like ``event`` follows b[j] within ``near``; it then comes before it."""
    k = j + 1
    while k < len(b) and b[k].t <= b[j].t + near:
        if b[k].same(event):
            b.insert(j, b.pop(k))
            return True
        k += 1
    return False


def _past_the_rest(a: list[Event], i: int, b: list[Event], j: int, near: float) -> tuple[int, int] | None:
    """The next events, where a contact rests in one run and has its last impacts in the other; None if none does."""
    if a[i].kind != CLOSES:
        back = _past_the_rest(b, j, a, i, near) if b[j].kind == CLOSES else None
        return None if back is None else back[::-1]
    k = j
    while k < len(b) and b[k].t <= a[i].t + near:
        if b[k].same(a[i]):
            return i, k
        if b[k][1:] != (IMPACT, a[i].source):
            return None
        k += 1
    return None


def apart(t: Array, one: Iterable[EventGroup], other: Iterable[EventGroup], near: float) -> Array:
    """The difference (N,) of the two times of an event of two runs, at times t (N,) between them; 0 elsewhere [s].

    Times within ``near`` [s] of an event belong to it. The k-th events of one kind and place are the same; ticks of
    clocks are exact.
    """
    known = {_source(group): group.times for group in other}
    pairs = [np.empty((0, 2))]
    for group in one:
        count = min(len(group.times), len(known.get(_source(group), ())))
        if count and group.kind != "sample":
            both = np.stack([group.times[:count], known[_source(group)][:count]], axis=1)
            pairs.append(np.sort(both, axis=1) + [-near, near])
    return between(t, np.concatenate(pairs))


def _source(group: EventGroup) -> tuple[str, str, int]:
    return group.kind, group.name, 0 if group.span is None else group.span.line


def between(t: Array, times: Array) -> Array:
    """The difference (N,) of the two times of an event, at times t (N,) between them; 0 elsewhere [s]."""
    late = np.zeros(len(t))
    low, high = times.min(axis=1), times.max(axis=1)
    some = np.flatnonzero(high > low)
    first, last = np.searchsorted(t, low[some], side="left"), np.searchsorted(t, high[some], side="right")
    for k, start, end in zip(some[last > first], first[last > first], last[last > first], strict=True):
        late[start:end] = np.maximum(late[start:end], high[k] - low[k])
    return late
