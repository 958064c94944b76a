"""States of a mechanism in space that is solved in a plane: from the assembly in space to the plane, and back.

Attitudes are R = E Rz(phi) A, see :mod:`mbdsl.mechanism.reduction.plane`. The plane is verified at the assembled state:
the constraints of a joint also hold in a mirrored pose, which may be another plane.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from mbdsl.initial.consistent import InitialState
from mbdsl.kernels.arrays import Array
from mbdsl.mechanism.graph import GROUND
from mbdsl.mechanism.reduction import Flattened
from mbdsl.mechanism.reduction.planar_motion import PlanarMotion
from mbdsl.numerics import rotation_arrays
from mbdsl.system import System, build
from mbdsl.system.body_models import body_pose
from mbdsl.system.signals import values

FITS = 1e-9  #: displacement from the plane, in the mechanism's size and in radians, that the assembly leaves
TURN = 2.0 * np.pi


class OutOfPlane(Exception):
    """The assembled state is not in the plane, or angles there do not have the turns of those in space."""


class PlanarBody(NamedTuple):
    """A body in space that moves in a plane."""

    name: str
    A: Array  #: (3, 3) from body axes to axes of the plane
    height: float  #: of the centre of mass [m]
    turns: bool


class PlanarStates:
    """The maps between the states of a mechanism in space and its planar states.

    Parameters
    ----------
    flat : Flattened
        The mechanism.
    parts : sequence of System
        Those of the parts of its planar scene.
    size : float [m]
        Of the whole mechanism.

    Attributes
    ----------
    system : System
        That of the planar scene, before its reduction.
    axes : (3, 3) array
        E: from axes of the plane to those of the world.
    bodies : list of PlanarBody
    """

    def __init__(self, flat: Flattened, parts: Sequence[System], size: float) -> None:
        motion = flat.motion
        assert isinstance(motion, PlanarMotion)
        planar, scene = motion.reduced, motion.graph.scene
        self.flat, self._motion = flat, motion
        self.system = parts[0] if flat.reduction.nothing_done else build(planar.scene, planar, size=size)
        plane = motion.plane
        self.axes = np.array(plane.axes).reshape(3, 3).T
        self.bodies = []
        for c in scene.bodies():
            A = np.array(plane.bodies[c.name]).reshape(3, 3).T
            height = plane.frames[f"{c.name}.c"].height
            self.bodies.append(PlanarBody(c.name, A, height, len(c.coordinates) > 3))

    # -- from space --------------------------------------------------------------------------------------------
    def of(self, space: System, state: InitialState) -> tuple[Array, Array]:
        """The planar q and v (n,) of an assembled state.

        Raises
        ------
        OutOfPlane
            If it is not in the plane.
        """
        E, size = self.axes, space.tables.size
        q, v = np.zeros(self.system.n), np.zeros(self.system.n)
        fastest = float(np.abs(state.v * space.tables.scale).max(initial=0.0))
        off, off_rate = [0.0], [0.0]
        for body in self.bodies:
            d, k = space.tables.coordinates[body.name], self.system.tables.coordinates[body.name]
            place, rate = E.T @ state.q[d : d + 3], E.T @ state.v[d : d + 3]
            q[k : k + 2], v[k : k + 2] = place[:2], rate[:2]
            off.append(abs(place[2] - body.height) / size)
            off_rate.append(abs(rate[2]) / size)
            if body.turns:
                turn = E.T @ rotation_arrays.matrices(state.q[None, d + 3 : d + 6])[0] @ body.A.T
                spin = body.A @ state.v[d + 3 : d + 6]
                q[k + 2], v[k + 2] = np.arctan2(turn[1, 0], turn[0, 0]), spin[2]
                c, s = np.cos(q[k + 2]), np.sin(q[k + 2])
                off.append(float(np.abs(turn - np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])).max()))
                off_rate.append(float(np.abs(spin[:2]).max()))
        if max(off) > FITS or max(off_rate) > FITS * fastest:
            raise OutOfPlane
        for name, number in self._turns(space, state, q).items():
            q[self.system.tables.coordinates[name] + 2] += TURN * number
        return q, v

    def _turns(self, space: System, state: InitialState, q: Array) -> dict[str, int]:
        """The turns of each body with which angles in the plane are those in space."""
        angles, tables = self._motion.angles, self.system.tables
        turning = {body.name for body in self.bodies if body.turns}
        nodes = [x.node for x in angles if x.node is not None]
        found = values(space, nodes, np.array([state.t]), state.q[None], state.v[None])
        known = {node: float(x[0]) for node, x in zip(nodes, found, strict=True)}
        turns = dict.fromkeys((GROUND, *turning), 0)
        group = {name: {name} for name in turns}

        def end(frame: str | None) -> tuple[str, float]:
            """The body of a frame, and the angle of the frame."""
            if frame is None:
                return GROUND, 0.0
            at = self.system.scene.frames[frame]
            return (at.body, q[tables.coordinates[at.body] + 2] + at.phi) if at.body in turning else (GROUND, at.phi)

        for x in sorted(angles, key=lambda x: (x.node is not None, not x.needed)):
            (i, before), (j, after) = end(x.a), end(x.b)
            apart = x.sign * (known[x.node] if x.node is not None else 0.0) - (after - before)
            number = round(apart / TURN)
            if group[i] is group[j]:
                if x.needed and turns[j] - turns[i] != number:
                    raise OutOfPlane
                continue
            shift = number - (turns[j] - turns[i])
            mine, other = group[j], group[i]
            if GROUND in mine:
                mine, other, shift = other, mine, -shift
            for name in mine:
                turns[name] += shift
            other |= mine
            group |= dict.fromkeys(mine, other)
        return {name: number for name, number in turns.items() if name != GROUND}

    def of_part(self, part: System, q: Array, v: Array) -> tuple[Array, Array]:
        """q and v (n,) of a part of the reduced planar scene from those of the whole one."""
        own_q, own_v = np.zeros(part.n), np.zeros(part.n)
        for c in part.scene.bodies():
            d, k = self.system.tables.coordinates[c.name], part.tables.coordinates[c.name]
            frame = f"{c.name}.c"
            x, y, phi = body_pose(c, part.scene.frames[frame])  # of the body as written on the merged one
            if part.tables.models[c.name].n == 2:
                own_q[k : k + 2], own_v[k : k + 2] = q[d : d + 2], v[d : d + 2]
                continue
            angle, w = q[d + 2] + (self.system.scene.frames[frame].phi - phi), v[d + 2]
            cos, sin = np.cos(angle), np.sin(angle)
            lever = np.array([cos * x - sin * y, sin * x + cos * y])
            own_q[k : k + 3] = *(q[d : d + 2] - lever), angle
            own_v[k : k + 3] = v[d] + w * lever[1], v[d + 1] - w * lever[0], w
        return own_q, own_v

    # -- to space ----------------------------------------------------------------------------------------------
    def write(self, whole: System, planar_q: Array, planar_v: Array, q: Array, v: Array) -> None:
        """Write the states (N, n) of the bodies to q and v (N, n) of the scene of ``whole``."""
        E = self.axes
        first = rotation_arrays.quaternions(rotation_arrays.of_matrix(E))
        for body in self.bodies:
            d, k = whole.tables.coordinates[body.name], self.system.tables.coordinates[body.name]
            q[:, d : d + 3] = planar_q[:, k : k + 2] @ E[:, :2].T + body.height * E[:, 2]
            v[:, d : d + 3] = planar_v[:, k : k + 2] @ E[:, :2].T
            if body.turns:
                half = 0.5 * planar_q[:, k + 2]
                turn = np.zeros((len(q), 4))
                turn[:, 0], turn[:, 3] = np.cos(half), np.sin(half)
                last = rotation_arrays.quaternions(rotation_arrays.of_matrix(body.A))
                p = rotation_arrays.times(rotation_arrays.times(first, turn), last)
                q[:, d + 3 : d + 6] = rotation_arrays.vectors(p)
                v[:, d + 3 : d + 6] = planar_v[:, k + 2, None] * body.A[2]
