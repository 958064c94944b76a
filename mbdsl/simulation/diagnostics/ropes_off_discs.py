"""Warnings about ropes that leave a disc: the angle by which they are wrapped around it becomes negative.

The path of a rope is that over all of its discs. A rope that leaves one is straight there, and shorter.
"""

from __future__ import annotations

import numpy as np

from mbdsl.simulation.examined_run import ExaminedRun
from mbdsl.system.signals import values

#: angles [rad] below zero by which a rope is wrapped except for rounding
ROUNDING = 1e-9


def warnings(run: ExaminedRun) -> list[str]:
    """A warning for each disc that a rope leaves while it is taut."""
    trajectory = run.trajectory
    t, found = trajectory.t, []
    state = t, trajectory.q, trajectory.v, None, trajectory.inputs
    for name, c in trajectory.scene.components.items():
        if "wrap" not in c.values:
            continue
        wrap, tension = values(trajectory.system, [c.values["wrap"], c.values["tension"]], *state)
        off = np.flatnonzero((wrap < -ROUNDING) & (tension > 0.0))
        if len(off):
            where = f"{c.span}: " if c.span is not None else ""
            found.append(
                f"{where}{c.kind.name} {name.rpartition('.')[0]} leaves the disc at {c.ports['frame_a']} until "
                f"t = {t[off[0]]:g} s: later results are wrong; a rope that is free there has no disc in `over`"
            )
    return found
