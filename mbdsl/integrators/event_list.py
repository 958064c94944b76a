"""The events of a run as a list: times, kinds, and places in the text.

What when-equations did is recorded by an :class:`EventSet`; what happened to rigid contacts and to joints that stick is
seen from their numbers in its history.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Collection, Iterator
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray

from mbdsl.errors import Span
from mbdsl.expressions.symbolic import leaves
from mbdsl.mechanism.contacts import COUNT, HELD, MODE, OPEN, number
from mbdsl.mechanism.sticking import SLIDING

if TYPE_CHECKING:
    from mbdsl.integrators.event_set import EventSet
    from mbdsl.mechanism.events import Action, Branch, Clock, Events

Array = NDArray[np.float64]
ROUNDING = 1e-12  #: difference of the time of an event and of a tick, of times of size 1, that is rounding
IMPULSES = ("impact", "contact", "reinit")  #: kinds of events at which velocities jump


class Happened(NamedTuple):
    """An event: time [s], kind, place of what has acted, and the name of a contact or joint."""

    t: float
    kind: str
    span: Span | None
    name: str = ""

    @property
    def line(self) -> str:
        """Its file and line; "" of an event of a Builder."""
        return "" if self.span is None else f"{self.span.file}:{self.span.line}"


class EventGroup(NamedTuple):
    """The events of one kind, place and component: times (k,) [s], ascending."""

    kind: str
    span: Span | None
    times: Array
    name: str = ""


def place(span: Span | None) -> str:
    """Where an event is written: "line model.mbd:9", the condition of a Builder, or nothing."""
    if span is None:
        return ""
    own = span.file.startswith("<") and span.file != "<text>"
    return f"`{span.text.strip()}`" if own else f"line {span.file}:{span.line}"


def groups(found: EventSet) -> list[EventGroup]:
    """The events so far, by what has acted."""
    times: dict[int, list[float]] = {}
    for event in found.acted:
        for branch in event.branches:
            times.setdefault(id(branch), []).append(event.t)
    ticks: dict[int, list[Array]] = {}
    for branch, done in found.ticks_done():
        ticks.setdefault(id(branch), []).append(done)
    start = found.table()[0][0]
    touches = Counter(_component(b) for b in found.events.branches if found.events.of_component(b))
    several = {name for name, count in touches.items() if count > 1}
    own = [
        EventGroup(name, b.span, *_of_touch(b, own, start, several) if name == "touch" else (own,))
        for b in found.events.branches
        if any(action.what != "assert" and not (action.what == "set" and action.text) for action in b.actions)
        for name, own in _by_kind(
            b, found.events, np.sort(np.concatenate([times.get(id(b), []), *ticks.get(id(b), [])]))
        )
    ]
    return [group for group in [*own, *_of_numbers(found)] if len(group.times)]


def happened(found: list[EventGroup]) -> list[Happened]:
    """All events of groups, in the order of time."""
    every = [Happened(t, group.kind, group.span, group.name) for group in found for t in group.times.tolist()]
    return sorted(every, key=lambda x: x.t)


def times(found: list[EventGroup], impulses: bool = False) -> Array:
    """The times (k,) of the events of groups [s], ascending; only of those at which velocities jump, if asked."""
    chosen = [group.times for group in found if not impulses or group.kind in IMPULSES]
    return np.unique(np.concatenate(chosen)) if chosen else np.empty(0)


def warned(found: EventSet) -> Iterator[tuple[Action, Array]]:
    """The assertions that are warnings, and the times (k,) at which they were false."""
    for action in (a for b in found.events.branches for a in b.actions if a.what == "set" and a.text):
        times, rows = found.table()
        yield action, times[np.diff(rows[:, found.names.index(action.target)], prepend=0.0) > 0.0]


def _of_numbers(found: EventSet) -> Iterator[EventGroup]:
    """The warnings of assertions, and the events of rigid contacts and of joints that stick."""
    scene = found.system.scene
    for action, false in warned(found):
        yield EventGroup("warning", action.span, false)
    if not (scene.contacts or scene.sticking):
        return
    times, rows = found.table()
    column = dict(zip(found.names, rows.T, strict=True))
    for contact in scene.contacts:
        struck, mode = (column[number(contact.name, x)] for x in (COUNT, MODE))
        struck = np.diff(struck, prepend=0.0 if found.from_start else struck[:1]) > 0.0
        closed = mode != OPEN
        yield EventGroup("impact", contact.span, times[struck], contact.name)
        yield EventGroup("contact", contact.span, times[1:][closed[1:] & ~closed[:-1]], contact.name)
        yield EventGroup("lift-off", contact.span, times[1:][closed[:-1] & ~closed[1:]], contact.name)
        if contact.slips:
            sticks = column[number(contact.name, HELD)] != 0.0
            yield EventGroup("stick", contact.span, times[1:][sticks[1:] & ~sticks[:-1]], contact.name)
            yield EventGroup("slip", contact.span, times[1:][sticks[:-1] & ~sticks[1:] & closed[1:]], contact.name)
    for joint in scene.sticking:
        held = np.diff((column[number(joint.name, SLIDING)] == 0.0).astype(float))
        yield EventGroup("stick", joint.span, times[1:][held > 0.0], joint.name)
        yield EventGroup("slip", joint.span, times[1:][held < 0.0], joint.name)


def kind(branch: Branch, events: Events) -> str:
    """The kind of an event: "terminate" or "reinit" by what it does, "touch" of a component that keeps the speed of a
    touch, else "sample", "initial" or "when"."""
    does = {action.what for action in branch.actions}
    if found := does & {"terminate", "reinit"}:
        return min(found, key=("terminate", "reinit").index)
    if events.of_component(branch):
        return "touch"
    return "sample" if _clocks(branch, events) else _other(branch, events)


def _component(branch: Branch) -> str:
    """The component of which a branch sets a number."""
    return branch.actions[0].target.rpartition(".")[0]


def _of_touch(branch: Branch, times: Array, start: float, several: Collection[str]) -> tuple[Array, str]:
    """The times (k,) at which a component begins to touch, without the ``start``, at which its number is set whether it
    touches or not; and its name, with the number of the point if it is one of those with ``several`` points."""
    name = _component(branch)
    point = branch.actions[0].target.rpartition("[")[2].rstrip("]")
    return times[times != start], f"{name}.{point}" if name in several else name


def _by_kind(branch: Branch, events: Events, times: Array) -> Iterator[tuple[str, Array]]:
    """The times (k,) of a branch, by kinds: with other conditions beside a clock, it acts between its ticks, too."""
    name = kind(branch, events)
    if name != "sample" or len(branch.conditions) == 1:
        yield name, times
        return
    at_tick = np.zeros(len(times), bool)
    for clock in _clocks(branch, events):
        start, period = float(clock.start), float(clock.period)
        k = np.round((times - start) / period)
        at_tick |= (k >= 0) & (np.abs(start + k * period - times) <= ROUNDING * np.maximum(1.0, np.abs(times)))
    yield name, times[at_tick]
    yield _other(branch, events), times[~at_tick]


def _read(branch: Branch) -> set[str]:
    return {str(leaf.value) for leaf in leaves(*branch.conditions) if leaf.op == "input"}


def _clocks(branch: Branch, events: Events) -> list[Clock]:
    read = _read(branch)
    return [clock for clock in events.clocks if clock.name in read]


def _other(branch: Branch, events: Events) -> str:
    return "initial" if events.initial in _read(branch) else "when"
