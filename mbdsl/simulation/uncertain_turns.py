"""Warnings about angles of models in space whose turns between output times are uncertain.

Coordinates in space do not contain turns: those of results follow from the mean of the rates at two output times
(:func:`mbdsl.expressions.array_operations.counted`). Where the rates differ by more than a turn per interval, or their
mean predicts an angle that differs by more than a quarter turn from the nearest possible one, the count may be wrong,
although the motion is right.
"""

from __future__ import annotations

from math import pi

import numpy as np

from mbdsl.simulation.trajectory import Trajectory
from mbdsl.system.signals import values


def uncertain_turns(trajectory: Trajectory) -> list[str]:
    """A warning about the first angle of a joint or force whose turns may be counted wrong; none in the plane."""
    scene, t = trajectory.scene, trajectory.t
    found = scene.components.values() if scene.spatial and len(t) > 1 else ()
    for c, key in ((x, key) for x in found if x.ports for key in x.signals):
        node = scene.signal_of(c, key)
        if node is None or node.op != "angle":
            continue
        angle, rate = values(trajectory.system, [node, node.value], t, trajectory.q, trajectory.v)  # type: ignore[list-item]
        doubt = np.abs(0.5 * (rate[1:] + rate[:-1]) * np.diff(t) - np.diff(angle)) > 0.5 * pi
        far = np.flatnonzero(doubt | (0.5 * np.abs(np.diff(rate)) * np.diff(t) > pi))
        if len(far):
            k = int(far[0])
            where = f"{c.span}: " if c.span is not None else ""
            return [
                f"{where}{c.name}.{key} may be wrong by whole turns after t = {t[k]:g} s: its rate changes from "
                f"{rate[k]:.3g} to {rate[k + 1]:.3g} rad/s until the next output; take a shorter interval"
            ]
    return []
