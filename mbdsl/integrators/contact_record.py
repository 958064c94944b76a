"""What contacts do in the steps of a method that solves them itself, entered into their numbers and the history.

The numbers have the same meaning as in runs that locate events (:mod:`mbdsl.mechanism.contacts`): signals and
accelerations follow from them. The friction of a contact that slides is its number COEFFICIENT times the normal force,
that of one that sticks is the multiplier of its slip.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from mbdsl.integrators.event_set import EventSet
from mbdsl.mechanism.contacts import (
    ALONG,
    ALONG_2,
    CLOSED,
    COEFFICIENT,
    COUNT,
    HELD,
    IMPULSE,
    MODE,
    SLIDING,
    SLOW,
    number,
)
from mbdsl.mechanism.contacts import OPEN as NO_CONTACT
from mbdsl.numerics.contact_modes import OPEN, SENSE, STICK, Modes
from mbdsl.system import System

Array = NDArray[np.float64]

SLIP = 1e-9  #: speed of slip that has no direction, relative to the size of the mechanism over the run
OF_FRICTION = (COEFFICIENT, SLIDING, HELD, ALONG, ALONG_2)


class ContactStep(NamedTuple):
    """The contacts (numbers) that are closed in a step, their coefficients of friction, and for their rows (r,) the
    velocities before and behind it, and the impulses; ``slow``: the speed of a gap that counts as rest."""

    which: NDArray[np.int64]
    mu: Array
    before: Array
    behind: Array
    P: Array
    modes: Modes
    slow: float


class ContactRecord:
    """The numbers of the contacts of a run.

    Attributes
    ----------
    multipliers : (m + p,)
        Those of the rows of contacts, times the length of the last step.
    """

    def __init__(self, system: System, events: EventSet | None, span: float) -> None:
        self.contacts, self.rows, self.events = system.scene.contacts, system.tables.contact_rows, events
        self.multipliers = np.zeros(system.m + system.p)
        self._slow = SLIP * system.tables.size / (span or 1.0)

    def first_modes(self) -> NDArray[np.int64]:
        """Which contacts stick behind the event at the start; the others count as open."""
        values = {} if self.events is None else self.events.values
        found = [values[number(c.name, HELD)] if c.slips else 0.0 for c in self.contacts]
        return np.where(np.array(found) != 0.0, STICK, OPEN).astype(np.int64)

    def enter(self, t: float, step: ContactStep) -> None:
        """Enter a step that ends at time t."""
        self.multipliers[:] = 0.0
        if self.events is None:
            return
        values, first, done = self.events.values, 0, self._open()
        for i, mode, mu in zip(step.which.tolist(), step.modes, step.mu.tolist(), strict=True):
            contact, rows = self.contacts[i], self.rows[i]
            own = slice(first, first + len(rows))
            P, u = step.P[own], step.behind[own]
            lasts = mode != OPEN and abs(u[0]) <= step.slow
            was_closed = values[number(contact.name, MODE)] == CLOSED
            if P[0] > 0.0 and not was_closed and step.before[first] < -step.slow:
                count = number(contact.name, COUNT)
                done |= {count: values[count] + 1.0, number(contact.name, IMPULSE): float(P[0])}
            done[number(contact.name, MODE)] = CLOSED if lasts else NO_CONTACT
            slides = bool(contact.slips) and mode not in (OPEN, STICK)
            self.multipliers[list(rows)] = -P
            if slides:
                self.multipliers[list(rows[1:])] = 0.0
                done |= self._sliding(contact.name, mode, mu, lasts, u[1:])
            elif contact.slips and lasts:
                done[number(contact.name, HELD)] = 1.0
            first += len(rows)
        if any(values[name] != x for name, x in done.items()):
            values |= done
            self.events.note(t)

    def _open(self) -> dict[str, float]:
        """The numbers of contacts all of which are open."""
        found = {number(c.name, MODE): NO_CONTACT for c in self.contacts}
        for c in self.contacts:
            if c.slips:
                found |= {number(c.name, x): 0.0 for x in OF_FRICTION}
                found[number(c.name, SLOW)] = self._slow
        return found

    def _sliding(self, name: str, mode: int, mu: float, lasts: bool, slip: Array) -> dict[str, float]:
        """The numbers of a contact that slides."""
        found = {number(name, COEFFICIENT): -SENSE[mode] * mu, number(name, SLIDING): SENSE[mode] if lasts else 0.0}
        if len(slip) > 1:
            speed = float(np.linalg.norm(slip))
            found |= {number(name, x): float(u) / (speed or 1.0) for x, u in zip((ALONG, ALONG_2), slip, strict=True)}
        return found
