"""Warnings about laws and conditions that read reactions which rigid contacts share, so that they are not unique."""

from __future__ import annotations

from mbdsl.integrators.event_list import place
from mbdsl.messages import few
from mbdsl.simulation.examined_run import ExaminedRun

OF_STREAMS = True


def warnings(run: ExaminedRun) -> list[str]:
    """A warning for each law or condition, with the contacts and joints that share the load."""
    events = run.motion.event_set
    if events is None or events.contacts is None:
        return []
    return [
        f"{x.reader.name} ({place(x.reader.span)}) reads reactions that are not unique from t = {x.t:.9g} s on: "
        f"{few([f'`{name}`' for name in x.among], 4)} carry the same load, and the run uses one possible share; "
        "give the contacts a stiffness `k`, or read only the load that they carry together"
        for x in events.contacts.read.found
    ]
