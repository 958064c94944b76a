"""Scales of the quantities of a motion by their units, and the effect of rounding on them.

With L the size of the mechanism, w its fastest rate and J = max m_ii L^2 its largest inertia, angular accelerations are
of the order alpha = max(w^2, g/L), energies and torques of J alpha, forces of J alpha / L. The rounding error of a
position is some eps L. At a step h it causes errors of eps L / h in velocities and of eps J / h^2 in residuals of
accelerations.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import hypot

import numpy as np

from mbdsl.mechanism.scene import ENERGIES
from mbdsl.simulation.trajectory import Trajectory
from mbdsl.system.state_sizes import weights
from mbdsl.system.tables import gravity

ULPS = 64.0  #: assumed rounding error of a position, in units in the last place


@dataclass(frozen=True)
class Scales:
    """Scales of a motion: ``size`` [m], ``rate`` and ``acceleration`` [1/s, 1/s2], ``inertia`` [kg.m2], ``step`` [s].

    ``energy`` [J] is the amount exchanged between its kinds.
    """

    size: float
    rate: float
    acceleration: float
    inertia: float
    step: float
    energy: float

    def of(self, name: str, unit: str) -> float:
        """The order of magnitude of signals with this unit; 0 if unknown."""
        return self.energy if unit == "J" else self._by_unit(name, unit, 1.0, self.rate, self.acceleration)

    def rounding(self, name: str, unit: str) -> float:
        """The change of a signal that rounding may cause."""
        eps, h = ULPS * float(np.finfo(float).eps), self.step
        return eps * self.energy if unit == "J" else self._by_unit(name, unit, eps, eps / h, eps / h**2)

    def whole(self, name: str) -> bool:
        """Whether a signal is the residual of a balance, so that its range is not a scale."""
        return name in ENERGIES or _unit(name, "") != ""

    def _by_unit(self, name: str, unit: str, angle: float, rate: float, acceleration: float) -> float:
        """Factors that convert angles, their rates and accelerations to other quantities."""
        torque = self.inertia * acceleration
        return {
            "m": self.size * angle,
            "rad": angle,
            "m/s": self.size * rate,
            "rad/s": rate,
            "m/s2": self.size * acceleration,
            "rad/s2": acceleration,
            "N": torque / self.size,
            "N.m": torque,
            "W": torque * self.rate,
        }.get(_unit(name, unit), 0.0)


def scales(trajectory: Trajectory, step: float) -> Scales:
    """The scales of a run; ``step`` is the shortest step of the compared runs [s]."""
    tables = trajectory.system.tables
    span = float(trajectory.t[-1] - trajectory.t[0])
    rate = weights(tables, trajectory.v, span).speed
    masses = np.concatenate([body.mass() for body in tables.models.values()] or [np.zeros(0)])
    inertia = float((masses / tables.scale**2)[: tables.n - tables.states].max(initial=0.0))
    acceleration = max(rate**2, hypot(*gravity(trajectory.scene)) / tables.size)
    kinetic, potential = (trajectory[name] for name in ENERGIES[:2])
    energy = float(np.ptp(potential) + kinetic.max(initial=0.0)) if len(kinetic) else 0.0
    return Scales(tables.size, rate, acceleration, inertia, step, energy or inertia * rate**2)


def _unit(name: str, unit: str) -> str:
    """The unit of a constraint violation; violations are treated as lengths."""
    return "m" if ".Phi[" in name else "m/s" if ".dPhi[" in name or ".Gam[" in name else unit
