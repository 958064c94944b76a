"""Bodies in space that turn by more than half a turn within a fixed step.

The attitude at the end of a step follows from the rotation vector since its start. The attitude of a body that keeps
its axis is right however far it turns. If the axis moves, a step of half a turn or more shows nothing of its motion,
while neither the energy nor the constraints need to show an error.
"""

from __future__ import annotations

from math import pi

import numpy as np

from mbdsl.kernels import buffer_layout as L
from mbdsl.kernels.arrays import Array
from mbdsl.simulation.run_symptoms import Symptom
from mbdsl.system import System

#: rotation in a step [rad] that resolves a moving axis with errors of about 1e-2 of it
RESOLVED = 0.3


class LargeRotations(Symptom):
    """The largest rotation in a step in the outputs of a run; these are added block by block."""

    KEPT = ("angle", "body", "since")

    def __init__(self, system: System, h: float) -> None:
        layout, self.h = system.tables.layout, h
        names = {d: name for name, d in system.tables.coordinates.items()}
        first = [int(layout[layout[L.ROTATIONS] + 2 * k]) for k in range(layout[L.N_ROTATIONS])]
        self._bodies = {d: names[d - 3] for d in first}  # rotations follow three displacements
        self.angle, self.body, self.since = 0.0, "", 0.0

    def add(self, t: Array, v: Array) -> None:
        """Add outputs at the times t (N,), with velocities v (N, n)."""
        for d, body in self._bodies.items():
            angle = self.h * np.linalg.norm(v[:, d : d + 3], axis=1)
            if len(angle) and (largest := float(angle.max())) > max(self.angle, pi):
                if self.angle == 0.0:
                    self.since = float(t[int(np.argmax(angle > pi))])
                self.angle, self.body = largest, body

    def warning(self) -> str | None:
        """A warning about them; None if no body makes half a turn in a step."""
        if self.angle == 0.0:
            return None
        return (
            f"{self.body} turns by {self.angle:.3g} rad in a step of {self.h:g} s, first by more than half a turn at "
            f"t = {self.since:.6g} s: if its axis moves, the results are wrong; "
            f"try a step of {self.h * RESOLVED / self.angle:.1g} s, or a tolerance instead"
        )
