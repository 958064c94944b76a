"""Warnings about friction in over-constrained mechanisms.

How over-constrained joints share a load does not follow from the equations of motion, and neither does friction that
depends on it. A run takes the reactions of the constraints that it leaves out as zero. Where those of least norm
(:mod:`mbdsl.initial.shared_loads`) would lead to other friction, the choice matters; so it does where a joint has no
friction at all, as a clutch between two shafts that have bearings of their own.
"""

from __future__ import annotations

import numpy as np

from mbdsl.initial import shared_loads
from mbdsl.initial.redundancy import where
from mbdsl.messages import few
from mbdsl.simulation.examined_run import ExaminedRun
from mbdsl.system.signals import values

MOST = 20  #: states that are examined
PART = 1e-3  #: difference of friction, relative to its largest value, that counts: rounding and misfits are far below
NONE = 1e-7  #: friction, relative to that of reactions of the size of all others, that counts as none


def warnings(run: ExaminedRun) -> list[str]:
    """A warning that names the joints whose friction is not determined."""
    trajectory = run.trajectory
    scene, system, left_out = trajectory.scene, trajectory.system, trajectory.left_out
    at_times = list(system.tables.switchable)
    if set(left_out) <= set(at_times) or not len(trajectory.t):
        return []
    nodes = {c.name: c.friction for c in scene.components.values() if c.friction is not None}
    if not nodes:
        return []
    some = np.unique(np.linspace(0, len(trajectory.t) - 1, MOST).astype(int))
    t, q, v, lam = (array[some] for array in (trajectory.t, trajectory.q, trajectory.v, trajectory.lam))
    least = shared_loads.least(system, t, q, lam, left_out)
    others = lam + shared_loads.free(system, t, q, left_out) * (1.0 + np.nanmax(np.abs(lam), initial=0.0))
    for found in (least, others):
        found[:, at_times] = lam[:, at_times]
    own, least, others = (
        np.array(values(system, list(nodes.values()), t, q, v, found)) for found in (lam, least, others)
    )
    size, change, possible = (np.nanmax(np.abs(x), axis=1, initial=0.0) for x in (own, least - own, others - own))
    named = (change > PART * size) | (size < NONE * possible)
    names = [where(system, name) for name, x in zip(nodes, named, strict=True) if x]
    if not names:
        return []
    joints = ", as joints such as Spherical and Cylindrical do" if scene.spatial else ""
    return [
        f"friction of {few(names, 4)} is not determined: it depends on reactions that the equations of motion do not "
        "determine, and the run takes those of the redundant constraints as zero; write it as a law without reactions, "
        f"in a Torque or a Force between the same frames, or remove the redundant constraints{joints}"
    ]
