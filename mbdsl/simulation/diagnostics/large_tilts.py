"""Warnings about bushings in space that tilt beyond half a turn.

The tilt of frame_b is a rotation vector of at most half a turn. Beyond it the vector jumps to the opposite one, and the
torque with it: the spring pushes on where it has pulled back. Steps may pass the jump without an error.
"""

from __future__ import annotations

from math import pi

import numpy as np

from mbdsl.simulation.examined_run import ExaminedRun


def warnings(run: ExaminedRun) -> list[str]:
    """A warning for each bushing in space whose tilt, with stiffness or damping, passes half a turn.

    The shorter way between two tilts that differ by more than pi leads through half a turn.
    """
    trajectory = run.trajectory
    scene, t, found = trajectory.scene, trajectory.t, []
    for name, c in scene.components.items() if scene.spatial else ():
        if c.kind.name != "Bushing" or not any(c.values["k_phi"][:2] + c.values["c_phi"][:2]):
            continue
        tilt = np.column_stack([trajectory[f"{name}.phi_x"], trajectory[f"{name}.phi_y"]])
        far = np.flatnonzero(np.linalg.norm(np.diff(tilt, axis=0), axis=1) > pi)
        if len(far):
            where = f"{c.span}: " if c.span is not None else ""
            found.append(
                f"{where}Bushing {name} tilts by more than half a turn after t = {t[far[0]]:g} s, where its "
                "torque jumps: later results are wrong; turn its frames so that z of frame_a is the axis of rotation"
            )
    return found
