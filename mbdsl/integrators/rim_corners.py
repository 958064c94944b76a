"""Rigid cylinders that stand on a plane: where the corners of their lower end are.

A standing cylinder touches the plane at four points of its rim, its corners (:mod:`mbdsl.elements.cylinder_rims`), but
it tips where the load leaves the circle, not the square of corners. With the load outside of the square, one corner or
two neighbours carry all of it. Then the first corner moves to the load, to the centre of the forces that would hold all
corners, and the forces are computed again: a load within the circle is carried, and one outside of it turns the
cylinder about the point of the rim that is nearest to it. Impulses are treated in the same way, with the centre of
the impulses of the two corners. The first corner of a cylinder that leans is its lowest point.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from mbdsl.integrators import contact_errors
from mbdsl.mechanism.contacts import LEANS
from mbdsl.numerics.contact_modes import STICK, Contacts
from mbdsl.numerics.friction_shares import exerted
from mbdsl.numerics.saddle_point import least_squares
from mbdsl.system import System
from mbdsl.system.signals import values

Array = NDArray[np.float64]

CARRIES = 1e-9  #: part of the largest force that counts as zero
MOST, TURNED = 60, 1e-6  #: most turns of the corners at one time, and an angle [rad] that counts as zero


class Rim(NamedTuple):
    """A cylinder: its first contact, and the names of the numbers that are the direction of its first corner."""

    first: int
    corner: tuple[str, ...]


class RimCorners:
    """The corners of all rigid cylinders of a system."""

    def __init__(self, system: System) -> None:
        self.system, self.turns, self.t = system, 0, 0.0
        self.rims = [Rim(k, c.corner) for k, c in enumerate(system.scene.contacts) if c.aim]
        self._aims = [x for rim in self.rims for x in system.scene.contacts[rim.first].aim]

    def lean(self, t: float, q: Array, v: Array, numbers: dict[str, float]) -> None:
        """At the start of an event, set the first corners of cylinders that lean to their lowest points."""
        self.turns, self.t = 0, t
        if not self.rims:
            return
        found = np.array([float(x[0]) for x in values(self.system, self._aims, np.array([t]), q[None], v[None])])
        for rim, aim in zip(self.rims, found.reshape(-1, 2), strict=True):
            if (size := float(np.hypot(*aim))) > LEANS:
                self._set(rim, -aim / size, numbers)

    def turned(
        self,
        which: NDArray[np.int64],
        P: Array,
        numbers: dict[str, float],
        forces: tuple[Contacts, Array] | None = None,
    ) -> bool:
        """Whether corners of standing cylinders have moved, by the forces or impulses P (k,) of the contacts
        ``which``. ``forces``, the problem and the accelerations (r,) without forces, give the place of the load.

        Raises
        ------
        UnsolvedContactsError
            If the corners still move after ``MOST`` turns.
        """
        moved = False
        for rim in self.rims:
            on = dict(zip((which - rim.first).tolist(), P.tolist(), strict=True))
            ends = [k for k in (0, 1) if k in on]
            if len(ends) != 1 or any(k not in on for k in (2, 3, 4)):
                continue  # it does not stand
            N = np.array([on[k] for k in (*ends, 2, 3, 4)])
            carry = np.flatnonzero(CARRIES * N.max(initial=0.0) < N)
            if len(carry) > 2 or not len(carry) or (len(carry) == 2 and carry[1] - carry[0] == 2):
                continue
            centre = complex(N[carry] @ 1j**carry)
            if forces is not None:
                held = _held(*forces)
                load = np.array([held[list(on).index(k)] for k in (*ends, 2, 3, 4)])
                centre = complex(load @ 1j ** np.arange(4)) if load.sum() > 0.0 else centre
            if abs(np.angle(centre)) > TURNED:
                if self.turns == MOST:
                    raise contact_errors.unsettled(self.system.scene.contacts[rim.first], self.t)
                c, s = (numbers[x] for x in rim.corner)
                along = complex(c, s) * centre / abs(centre)
                self._set(rim, np.array([along.real, along.imag]), numbers)
                moved = True
        self.turns += moved
        return moved

    def _set(self, rim: Rim, along: Array, numbers: dict[str, float]) -> None:
        for name, x in zip(rim.corner, along.tolist(), strict=True):
            numbers[name] = x
            self.system.set_input(name, x)


def _held(contacts: Contacts, b: Array) -> Array:
    """The normal forces (k,), pulling ones too, with which contacts that touch or stick have no accelerations."""
    modes = tuple(STICK if STICK in x else x[-1] for x in map(contacts.choices, range(len(contacts.sizes))))
    rows = contacts.held(modes)
    C = exerted(contacts, modes, rows)
    return (C @ least_squares((contacts.G @ C)[rows], -b[rows], 1e-10))[contacts.first]
