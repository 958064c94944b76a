"""The assertions of a model with the level AssertionLevel.warning that were false during a run."""

from __future__ import annotations

from mbdsl.integrators.event_list import place, warned
from mbdsl.simulation.examined_run import ExaminedRun


def warnings(run: ExaminedRun) -> list[str]:
    """A warning for each of them, with the first time."""
    if run.motion.event_set is None:
        return []
    found = []
    for action, times in warned(run.motion.event_set):
        if len(times):
            more = f", the first of {len(times)} times" if len(times) > 1 else ""
            found.append(f"the assertion {action.text} ({place(action.span)}, t = {times[0]:.9g} s{more})")
    return found
