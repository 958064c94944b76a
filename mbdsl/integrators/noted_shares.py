"""Friction and reactions that are not unique, as they were noted in a run: plain values that a checkpoint keeps.

They are warned of at the end of a run, which may be one that continues from a checkpoint.
"""

from __future__ import annotations

from math import isfinite
from typing import Any

from mbdsl.integrators.contact_set import ContactSet
from mbdsl.integrators.friction_set import FrictionSet
from mbdsl.integrators.shared_reactions import Shared
from mbdsl.system import System


def saved(friction: FrictionSet | None, contacts: ContactSet | None) -> list[list[Any]]:
    """The notes of joints, of contacts, and of what reads reactions, the last ones with the number of the reader."""
    found = [[-1, t, list(names)] for t, names in (friction.shared if friction is not None else ())]
    if contacts is not None:
        number = {id(reader): k for k, reader in enumerate(contacts.read.readers)}
        found += [[-2, t, list(names)] for t, names in contacts.shared]
        found += [[number[id(x.reader)], x.t, list(x.among)] for x in contacts.read.found]
    return found


def restore(system: System, friction: FrictionSet | None, contacts: ContactSet | None, kept: Any) -> None:
    """Return to the notes of a checkpoint.

    Raises
    ------
    TypeError, ValueError
        If they are not those of this model.
    """
    known = {name.rsplit(".", 1)[0] for name in system.constraint_names()}
    known |= {x.name for x in system.scene.sticking} | {x.name for x in system.scene.contacts}
    readers = contacts.read.readers if contacts is not None else []
    of: dict[int, list[tuple[float, tuple[str, ...]]]] = {k: [] for k in range(-2, len(readers))}
    for k, t, names in kept:
        fits = type(k) is int and k in of and isinstance(t, float) and isfinite(t) and known.issuperset(names)
        if not fits:
            raise ValueError("a note of shared friction or reactions does not belong to this model")
        of[k].append((t, tuple(names)))
    if friction is not None:
        friction.shared = of[-1]
    if contacts is not None:
        contacts.shared = of[-2]
        contacts.read.found = [Shared(t, reader, x) for k, reader in enumerate(readers) for t, x in of[k]]
