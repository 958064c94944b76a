"""A warning about joints whose friction holds the same motion, so that each of them carries an unknown part of it."""

from __future__ import annotations

from mbdsl.messages import few
from mbdsl.simulation.examined_run import ExaminedRun

OF_STREAMS = True


def warnings(run: ExaminedRun) -> list[str]:
    """A warning that names the joints of the first time at which several hold the same motion."""
    events = run.motion.event_set
    if events is None or events.friction is None or not events.friction.shared:
        return []
    t, names = events.friction.shared[0]
    return [
        f"friction of {few(names, 4)} is not unique from t = {t:.9g} s on: they hold the same motion, so that the "
        "equations of motion do not say how much each of them carries; the results have shares in proportion to mu_s "
        "times the normal force, or others that hold if these do not"
    ]
