"""States of a mechanism with gyrostats: from the assembly of the mechanism as written to those of its gyrostats, and
back.

The attitude of a rotor is R Q(theta) P, with the attitude R of its carrier, the rotation Q about the axle n, and the
attitude P of the rotor in axes of the carrier at the angle zero (:mod:`mbdsl.mechanism.reduction.gyrostats`).
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from mbdsl.bodies.gyrostat_kernels import ANGLES
from mbdsl.expressions.symbolic import Expr
from mbdsl.initial.consistent import InitialState
from mbdsl.kernels.arrays import Array
from mbdsl.mechanism.reduction import Flattened
from mbdsl.mechanism.reduction.gyrostats import Gyrostats
from mbdsl.numerics import rotation_arrays
from mbdsl.system import System, build


class Placed(NamedTuple):
    """A body of the mechanism, on the body ``on`` of the reduced scene: a rotor, a carrier, or the same body."""

    name: str
    on: str
    lever: Array  #: (3,) its centre of mass, from that of the gyrostat in the carrier's axes [m]
    rotor: int  #: the number of the rotor, from zero on; -1 if it is none
    n: Array  #: (3,) the axle, in the carrier's axes
    P: Array  #: (3, 3)


class GyrostatStates:
    """The maps between the states of a mechanism and those of the mechanism with gyrostats.

    Parameters
    ----------
    flat : Flattened
        The mechanism.
    parts : sequence of System
        Those of the parts of its reduced scene.
    size : float [m]
        Of the whole mechanism.

    Attributes
    ----------
    system : System
        That of the reduced scene.
    bodies : list of Placed
    """

    def __init__(self, flat: Flattened, parts: Sequence[System], size: float) -> None:
        motion = flat.motion
        assert isinstance(motion, Gyrostats)
        reduced, scene = motion.reduced, motion.graph.scene
        self.flat = flat
        self.system = parts[0] if flat.reduction.nothing_done else build(reduced.scene, reduced, size=size)
        rotors = {r.name: r for r in motion.rotors}
        numbers: dict[str, int] = {}  # carrier -> rotors so far
        of = {}
        for r in motion.rotors:
            of[r.name] = numbers[r.carrier] = numbers.get(r.carrier, -1) + 1
        self._angles: dict[Expr, float] = {}
        self.bodies = []
        for c in scene.bodies():
            on = rotors[c.name].carrier if c.name in rotors else c.name
            place = reduced.scene.frames[f"{c.name}.c"].pose[:3]
            centre = reduced.scene.components[on].kind.com(reduced.scene.components[on].values)  # type: ignore
            lever = np.array(place) - centre
            n, P = np.zeros(3), np.eye(3)
            if c.name in rotors:
                n, P = np.array(rotors[c.name].n), np.array(rotors[c.name].pose[3:]).reshape(3, 3).T
            self.bodies.append(Placed(c.name, on, lever, of.get(c.name, -1), n, P))

    def of(self, space: System, state: InitialState) -> tuple[Array, Array]:
        """q and v (n,) with gyrostats, of an assembled state."""
        self._angles = space.tables.first_angles
        q, v = np.zeros(self.system.n), np.zeros(self.system.n)
        for body in sorted(self.bodies, key=lambda body: body.rotor >= 0):  # carriers before rotors
            d, k = space.tables.coordinates[body.name], self.system.tables.coordinates[body.on]
            count = space.tables.models[body.name].n
            own_q, own_v = state.q[d : d + count], state.v[d : d + count]
            if count < ANGLES:
                q[k : k + count], v[k : k + count] = own_q, own_v
                continue
            R = rotation_arrays.matrices(own_q[None, 3:])[0]
            if body.rotor < 0:
                q[k : k + ANGLES], v[k : k + ANGLES] = own_q, own_v
                q[k : k + 3] -= R @ body.lever
                v[k : k + 3] -= R @ np.cross(own_v[3:], body.lever)
                continue
            R_c, spin = rotation_arrays.matrices(q[None, k + 3 : k + ANGLES])[0], v[k + 3 : k + ANGLES]
            Q = R_c.T @ R @ body.P.T  # about n: 2 n sin(theta) is the vector of Q - Q^T
            twice = np.array([Q[2, 1] - Q[1, 2], Q[0, 2] - Q[2, 0], Q[1, 0] - Q[0, 1]])
            at = k + ANGLES + body.rotor
            q[at] = np.arctan2(body.n @ twice, np.trace(Q) - 1.0)
            v[at] = body.n @ (R_c.T @ R @ own_v[3:] - spin)
        return q, v

    def of_part(self, part: System, q: Array, v: Array) -> tuple[Array, Array]:
        """q and v (n,) of a part of the reduced scene from those of the whole one; its angles that count turns start
        with the values of the assembled state."""
        for node in part.tables.angles:
            part.set_first_angle(node, self._angles.get(node, 0.0))
        own_q, own_v = np.zeros(part.n), np.zeros(part.n)
        for name, k in part.tables.coordinates.items():
            d, count = self.system.tables.coordinates[name], part.tables.models[name].n
            own_q[k : k + count], own_v[k : k + count] = q[d : d + count], v[d : d + count]
        return own_q, own_v

    def write(self, whole: System, own_q: Array, own_v: Array, q: Array, v: Array) -> None:
        """Write the states (N, n) of the bodies to q and v (N, n) of the scene of ``whole``."""
        for body in self.bodies:
            d, k = whole.tables.coordinates[body.name], self.system.tables.coordinates[body.on]
            count = whole.tables.models[body.name].n
            if count < ANGLES:
                q[:, d : d + count], v[:, d : d + count] = own_q[:, k : k + count], own_v[:, k : k + count]
                continue
            psi, spin = own_q[:, k + 3 : k + ANGLES], own_v[:, k + 3 : k + ANGLES]
            R = rotation_arrays.matrices(psi)
            q[:, d : d + 3] = own_q[:, k : k + 3] + R @ body.lever
            v[:, d : d + 3] = own_v[:, k : k + 3] + np.einsum("nij,nj->ni", R, np.cross(spin, body.lever))
            q[:, d + 3 : d + ANGLES], v[:, d + 3 : d + ANGLES] = psi, spin
            if body.rotor >= 0:
                half = 0.5 * own_q[:, k + ANGLES + body.rotor, None]
                Q = np.hstack([np.cos(half), np.sin(half) * body.n])
                P = rotation_arrays.quaternions(rotation_arrays.of_matrix(body.P))
                p = rotation_arrays.times(rotation_arrays.times(rotation_arrays.quaternions(psi), Q), P)
                q[:, d + 3 : d + ANGLES] = rotation_arrays.vectors(p)
                # Q^T (Omega + theta' n), as n is the axis of Q
                along = spin + own_v[:, k + ANGLES + body.rotor, None] * body.n
                turn = rotation_arrays.matrices(rotation_arrays.vectors(Q))
                v[:, d + 3 : d + ANGLES] = np.einsum("nji,nj->ni", turn, along) @ body.P
