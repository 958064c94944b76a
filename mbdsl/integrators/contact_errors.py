"""Errors of rigid contacts in a run: the contact with its line, the reason, and a remedy."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from mbdsl.errors import InitialisationError
from mbdsl.integrators.touching import Touching
from mbdsl.mechanism.contacts import Contact
from mbdsl.system.driven_contacts import Driver
from mbdsl.system.tables import Tables

Array = NDArray[np.float64]


FLAT = 1e-6  #: change of a gap with the positions, relative to the size of the mechanism, that counts as none


class UnsolvedContactsError(InitialisationError):
    """No impulses or reactions satisfy the laws of the contacts."""


def unsolvable(what: str, contacts: Sequence[Contact], when: str, drivers: Sequence[Driver]) -> UnsolvedContactsError:
    """The error of ``contacts`` whose laws have no solution, because of the ``drivers`` if there are some."""
    names = ", ".join(f"`{c.name}`" for c in contacts)
    message = f"no {what} satisfy the laws of the contacts {names}{when}"
    hint = "the bodies that touch are jammed between others: leave a gap, or take a contact with stiffness `k`"
    if not drivers:
        return UnsolvedContactsError(message, contacts[0].span, hint)
    moving = ", ".join(f"`{c.name}`" for c in drivers)
    verb = "prescribes a motion that continues" if len(drivers) == 1 else "prescribe motions that continue"
    message += f": {moving} {verb} through the contact"
    hint = (
        "end this motion before the bodies touch; or push the body with a SpringDamper or a Force in place of "
        f"{drivers[0].kind.name}; or give the contact a stiffness `k`"
    )
    notes = tuple((f"{c.kind.name} `{c.name}` is here", c.span) for c in drivers[:3] if c.span is not None)
    return UnsolvedContactsError(message, contacts[0].span, hint, notes)


def no_value(contact: Contact, t: float) -> UnsolvedContactsError:
    """The error of a contact whose gap is no finite number at time t."""
    message = f"the gap of `{contact.name}` has no value at t = {t:.9g} s"
    hint = "write a gap that has a value at all positions, and is negative where the bodies overlap"
    return UnsolvedContactsError(message, contact.span, hint)


def check_jumps(contacts: Sequence[Contact], gaps: Array, before: Array, least: float, t: float) -> None:
    """Check that no gap has become negative by a jump, from ``before`` (k,) to ``gaps`` (k,), by more than ``least``.

    Raises
    ------
    UnsolvedContactsError
        If one has.
    """
    for k in np.flatnonzero((gaps < -least) & (gaps < before - least)).tolist():
        c = contacts[k]
        if not c.absent:
            message = f"the gap of `{c.name}` jumps from {before[k]:.6g} to {gaps[k]:.6g} {c.unit} at t = {t:.9g} s"
            hint = "the bodies overlap then: move a body by a driver, or let the gap jump only where it stays positive"
            raise UnsolvedContactsError(message, c.span, hint)


def check_gradients(contacts: Sequence[Contact], touching: Touching, tables: Tables, t: float) -> None:
    """Check that the gaps that are closed change with the positions: else neither an impulse nor a force acts there.

    Raises
    ------
    UnsolvedContactsError
        If one does not; a gap that depends on time alone is another error.
    """
    change = np.linalg.norm(touching.W[touching.normals] / tables.scale, axis=1)
    for k in np.flatnonzero((change > 0.0) & (change < FLAT * max(1.0, tables.size))):
        contact = contacts[int(touching.which[k])]
        if change[k] < FLAT * (1.0 if contact.unit == "rad" else tables.size):
            message = f"the gap of `{contact.name}` hardly changes with the positions where it closes, at t = {t:.9g} s"
            hint = "write a distance, such as `b.x` in place of `b.x^3`"
            raise UnsolvedContactsError(message, contact.span, hint)


def unsettled(contact: Contact, t: float) -> UnsolvedContactsError:
    """The error of a cylinder whose points of contact do not settle at time t."""
    name = contact.name.rpartition(".")[0]
    message = f"no point of the rim of `{name}` was found at which it carries its load at t = {t:.9g} s"
    return UnsolvedContactsError(message, contact.span, "give the contact a stiffness `k`")


def too_rough(contact: Contact, t: float, mu: float) -> UnsolvedContactsError:
    """The error of a contact whose reaction is not unique from the coefficient of friction ``mu`` on."""
    return UnsolvedContactsError(
        f"friction of `{contact.name}` is too large at t = {t:.9g} s: with mu = {contact.mu:g} its reaction does "
        f"not exist or is not unique, from mu = {mu:.6g} on (Painleve's paradox)",
        contact.span,
        "take a smaller mu, or a contact with stiffness `k`",
    )
