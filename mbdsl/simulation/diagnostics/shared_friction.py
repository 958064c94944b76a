"""Warnings about friction in over-constrained mechanisms in space.

How over-constrained joints share a load does not follow from the equations of motion, and neither does friction that
depends on it. A run takes the reactions of the constraints that it leaves out as zero. Where those of least norm
(:mod:`mbdsl.initial.shared_loads`) would lead to other friction, the choice matters.
"""

from __future__ import annotations

import numpy as np

from mbdsl.initial import shared_loads
from mbdsl.messages import few
from mbdsl.simulation.examined_run import ExaminedRun
from mbdsl.system.signals import values

MOST = 20  #: states that are examined
PART = 1e-3  #: difference of friction, relative to its largest value, that counts: rounding and misfits are far below


def warnings(run: ExaminedRun) -> list[str]:
    """A warning that names the joints whose friction is not determined; none in the plane."""
    trajectory = run.trajectory
    scene, system, left_out = trajectory.scene, trajectory.system, trajectory.left_out
    if not (scene.spatial and left_out and len(trajectory.t)):
        return []
    nodes = {c.name: c.friction for c in scene.components.values() if c.friction is not None}
    if not nodes:
        return []
    some = np.unique(np.linspace(0, len(trajectory.t) - 1, MOST).astype(int))
    t, q, v, lam = (array[some] for array in (trajectory.t, trajectory.q, trajectory.v, trajectory.lam))
    own, other = (
        np.array(values(system, list(nodes.values()), t, q, v, found))
        for found in (lam, shared_loads.least(system, t, q, lam, left_out))
    )
    size = np.nanmax(np.abs(own), axis=1, initial=0.0)
    change = np.nanmax(np.abs(other - own), axis=1, initial=0.0)
    names = [name for name, d, s in zip(nodes, change, size, strict=True) if d > PART * s]
    if not names:
        return []
    return [
        f"friction of {few(names, 4)} depends on reactions that the equations of motion do not determine: the run "
        "takes those of the redundant constraints as zero, and those of least norm would lead to other friction; "
        "joints without redundant constraints, such as Spherical and Cylindrical, determine it"
    ]
