"""Warnings about angles of models in space whose turns between output times are uncertain.

Coordinates in space do not contain turns: those of results follow from the mean of the rates at two output times
(:func:`mbdsl.expressions.array_operations.counted`). Where the rates differ by more than a turn per interval, the count
may be wrong, although the motion is right.
"""

from __future__ import annotations

from math import pi

import numpy as np

from mbdsl.simulation.trajectory import Trajectory
from mbdsl.system.signals import values


def uncertain_turns(trajectory: Trajectory) -> list[str]:
    """A warning about the first angle of a joint or force whose turns may be counted wrong; none in the plane."""
    scene, t = trajectory.scene, trajectory.t
    for c in scene.components.values() if scene.spatial and len(t) > 1 else ():
        node = scene.signal_of(c, "phi") if c.ports else None
        if node is None or node.op != "angle":
            continue
        (rate,) = values(trajectory.system, [node.value], t, trajectory.q, trajectory.v)  # type: ignore[list-item]
        far = np.flatnonzero(0.5 * np.abs(np.diff(rate)) * np.diff(t) > pi)
        if len(far):
            k = int(far[0])
            where = f"{c.span}: " if c.span is not None else ""
            return [
                f"{where}{c.name}.phi may be wrong by whole turns after t = {t[k]:g} s: its rate changes from "
                f"{rate[k]:.3g} to {rate[k + 1]:.3g} rad/s until the next output; take a shorter interval"
            ]
    return []
