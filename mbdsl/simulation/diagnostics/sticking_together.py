"""Warnings about joints and contacts whose friction holds the same motion, so that the part of each is unknown."""

from __future__ import annotations

from mbdsl.messages import few
from mbdsl.simulation.examined_run import ExaminedRun

OF_STREAMS = True


def warnings(run: ExaminedRun) -> list[str]:
    """A warning that names the joints of the first time at which several hold the same motion, and one the contacts."""
    events = run.motion.event_set
    if events is None:
        return []
    own = (
        (events.friction, "in proportion to mu_s times the normal force, or others that hold if these do not"),
        (events.contacts, "with which each of them holds"),
    )
    return [
        f"friction of {few(of.shared[0][1], 4)} is not unique from t = {of.shared[0][0]:.9g} s on: they hold the same "
        f"motion, so that the equations of motion do not say how much each of them carries; the results have shares "
        f"{how}"
        for of, how in own
        if of is not None and of.shared
    ]
