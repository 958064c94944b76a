"""Bases of the directions that the constraints allow, at rest and along a motion.

:mod:`mbdsl.analysis.eigenmodes` defines Z, T and S and uses them.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np

from mbdsl.bodies.contract import POSITIONS, Pose
from mbdsl.elements.kind import JointKind
from mbdsl.errors import UsageError
from mbdsl.expressions.derivatives import der
from mbdsl.expressions.symbolic import Expr, coordinate, is_velocity_level, leaves
from mbdsl.mechanism.scene import STATE, Component
from mbdsl.numerics import rotation_arrays
from mbdsl.numerics.saddle_point import RANK, Array, dense, null_space, row_size, scaled
from mbdsl.system import System
from mbdsl.system.signals import gradients

CENTRE: Pose = (0.0, 0.0, 0.0)  #: centre of a beam: its frame c

LEAST = 1e-3  #: sine of the angle below which a row does not separate directions


def named_coordinates(body: Component) -> tuple[str, ...]:
    """The coordinates of a body that are signals: in space without rotations; of a state its integral."""
    if body.kind.variant == STATE:
        return ("x",)
    return tuple(key for key in body.kind.coordinates if key not in ("rx", "ry", "rz"))


def of_positions(expression: Expr) -> bool:
    found = leaves(expression)
    return all(x.op in ("coordinate", "time") for x in found) and not is_velocity_level(expression)


def spins(system: System, v: Array) -> Array:
    """X (n, n) of dv = (dq)' + X dq: zero in the plane.

    In space dq contains rotations in body axes; the variation of the angular velocity W is their rate plus W x dq.
    """
    X = np.zeros((system.n, system.n))
    for d in system.tables.rotations[:, 0] if len(system.tables.rotations) else ():
        x, y, z = v[d : d + 3]
        X[d : d + 3, d : d + 3] = [[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]]
    return X


class Still:
    """Bases at rest: the constant Z spans the directions that all constraints, of positions and velocities, allow."""

    def __init__(self, system: System, J: Array) -> None:
        scale = system.tables.scale
        bodies = system.n - system.tables.states
        J = scaled(J, np.ones(len(J)), 1.0 / scale)[:, :bodies]
        free = null_space(J / row_size(J)[:, None]) / scale[:bodies, None]
        r = free.shape[1] + system.tables.states
        self.Z = np.zeros((system.n, r))
        self.Z[:bodies, : free.shape[1]], self.Z[bodies:, free.shape[1] :] = free, np.eye(system.tables.states)
        self.integrals = list(range(free.shape[1], r))  #: coordinates that are integrals of states, which nothing reads
        self.Z1 = self.Z2 = self.W = self.W1 = np.zeros_like(self.Z)
        self.T, self.S = np.eye(r), np.zeros((r, r))
        self.T1, self.S1 = np.zeros((r, r)), np.zeros((r, r))
        self.rate, self.given = 0.0, 0


class Released(NamedTuple):
    """Constraints whose values are given functions of time, by their rows: of positions, and of velocities."""

    positions: tuple[int, ...] = ()
    velocities: tuple[int, ...] = ()


NOTHING = Released()


class Moving:
    """Bases along the motion q(t + s) = q + s v + s^2 a/2, with their derivatives.

    dv = Z y' + W y and dv' = Z y'' + (Z' + W) y' + W' y, with W = Z' + X Z; in the plane, W is Z'.

    With released constraints, y ends with their given values w, and u with the given rates w', then with the given
    values of the constraints of velocities. ``given`` is the number of these speeds.
    """

    #: weights of the differences at s = -3e ... 3e of a first derivative, to order e^6
    WEIGHTS = np.array([-1.0, 9.0, -45.0, 0.0, 45.0, -9.0, 1.0]) / 60.0

    def __init__(self, system: System, t: float, q: Array, v: Array, a: Array, released: Released = NOTHING) -> None:
        self.system, self.scale, self.released = system, system.tables.scale, released
        self.given = sum(map(len, released))
        if system.scene.spatial:
            self.path = lambda s: (t + s, system.moved(q, s * v + s * s / 2.0 * a), v + s * a)
        else:
            self.path = lambda s: (t + s, q + s * v + s * s / 2.0 * a, v + s * a)
        self.bends = [name for name, body in system.tables.models.items() if body.deforms]
        self.targets, self.turned = self._coordinates(t, q, v)
        bodies = system.n - system.tables.states
        speed, pace = (float(np.abs(x * self.scale)[:bodies].max(initial=0.0)) for x in (v, a))
        #: rate of change of the bases [1/s]
        self.rate = max(speed, float(np.sqrt(pace)), 1e-6)
        self.e = 1e-2 / self.rate
        self.H: Array | None = None
        self.Z, W, self.T, self.S = self._at(0.0)
        self.Z1, self.W = W - spins(system, v) @ self.Z, W
        _, self.W1, self.T1, self.S1 = self._derivative(self._at, 0.0)

    @property
    def integrals(self) -> list[int]:
        """Coordinates that are integrals of states, which nothing reads."""
        own = {coordinate(f"{c.name}.c", "x") for c in self.system.scene.states()}
        return [k for k, target in enumerate(self.targets) if target in own]

    def _coordinates(self, t: float, q: Array, v: Array) -> tuple[list[Expr], list[int]]:
        """Targets whose variations are independent and determine all others: signals, and rows of :meth:`_of_beams`.

        Signals of joints come first, then coordinates of beams in their own axes, then coordinates of bodies.
        """
        scene, system = self.system.scene, self.system
        J = dense(system.Phi_q(t, q)) / self.scale
        free = null_space(J / row_size(J)[:, None])
        joints = [c for c in scene.components.values() if isinstance(c.kind, JointKind)]
        # positions in fixed axes are not constant for a rotating beam: its own axes replace them; Cardan angles are not
        # suitable coordinates of bodies that spin: rotations about the axes of the world replace them
        own = [
            e
            for c in joints
            for key, e in scene.signals_of(c).items()
            if of_positions(e) and e.op != "atan2"
            if not (c.kind.name == "FreeMotion" and key in ("x", "y") and self._of_a_beam(e))
        ]
        bodies = [coordinate(f"{b.name}.c", key) for b in scene.with_coordinates() for key in named_coordinates(b)]
        bodies = [e for e in bodies if not self._of_a_beam(e)]
        chosen: list[Expr] = []
        turned: list[int] = []
        for candidates in (own, bodies):
            if candidates and free.shape[1]:
                rows = dense(gradients(system, candidates, t, q, v)[1]) / self.scale
                which, free = self._independent(rows / row_size(rows)[:, None], free)
                chosen += [candidates[k] for k in which]
            if candidates is bodies and scene.spatial and free.shape[1]:
                turned, free = self._independent(self._of_rotations(q), free)
            if candidates is own and self.bends and free.shape[1]:
                elastic, pose = self._of_beams(q, v)
                for rows, first in ((elastic, 0), (pose, len(elastic))):
                    which, free = self._independent(rows, free)
                    turned += [first + k for k in which]
        if free.shape[1]:
            raise UsageError(
                f"the mechanism has {free.shape[1]} more degrees of freedom than its joint and body coordinates",
                hint="another state",
            )
        return chosen, turned

    @staticmethod
    def _independent(rows: Array, free: Array) -> tuple[list[int], Array]:
        """Rows (m, n), of size one, that separate the directions ``free`` (n, k), and the directions that remain."""
        found: list[int] = []
        while free.shape[1] and len(rows):  # the most independent one first
            size = np.linalg.norm(rows @ free, axis=1)
            k = int(np.argmax(np.round(size, 9)))
            if size[k] < LEAST:
                break
            found.append(k)
            free = free @ null_space((rows[k] @ free)[None])
        return found, free

    def _of_a_beam(self, expression: Expr) -> bool:
        frames = self.system.scene.frames
        names = (x.value[0] for x in leaves(expression) if x.op == "coordinate")
        return any(frames[name].body in self.bends for name in names)

    def _of_beams(self, q: Array, v: Array) -> tuple[Array, Array]:
        """Gradients of elastic coordinates, or nodes and slopes, of beams in their rotating axes, and of frames c.

        By scaled coordinates; (m, n), and (k, n) for the positions and angles of the frames.
        """
        system, scale = self.system, self.scale
        elastic, pose = [np.zeros((0, system.n))], [np.zeros((0, system.n))]
        for name in self.bends:
            body, d = system.tables.models[name], system.tables.coordinates[name]
            own = slice(d, d + body.n)
            B = body.gradient(CENTRE, q[own], v[own])[0]
            phi = float(body.frame(CENTRE, "phi", q[own][None], v[own][None])[0])
            A = np.array([[np.cos(phi), np.sin(phi)], [-np.sin(phi), np.cos(phi)]])
            rigid = body.rigid(q[own])
            if not rigid[3:].any():  # q contains the pose of the floating frame and the coordinates relative to it
                rows = np.eye(body.n)[3:] * scale[own]
            else:  # q contains pairs in fixed axes; the motion of the frame c is subtracted
                x, y = (float(body.frame(CENTRE, key, q[own][None], v[own][None])[0]) for key in POSITIONS[:2])
                rigid = rigid @ np.array([[1.0, 0.0, y], [0.0, 1.0, -x], [0.0, 0.0, 1.0]])  # about c
                rows = np.kron(np.eye(body.n // 2), A) @ (np.eye(body.n) - rigid @ B) * scale[own][:, None]
            place = np.vstack([A @ B[:2] * scale[d], B[2:]])
            for found, part in ((elastic, rows), (pose, place)):
                whole = np.zeros((len(part), system.n))
                whole[:, own] = part
                found.append(whole / scale)
        return np.vstack(elastic), np.vstack(pose)

    def _of_rotations(self, q: Array) -> Array:
        """Rotations of bodies in space about the axes of the world, by scaled coordinates (k, n).

        A symmetric top has constant equations in these, however fast it spins.
        """
        d = self.system.tables.rotations[:, 0] if len(self.system.tables.rotations) else np.zeros(0, int)
        rows = np.zeros((3 * len(d), self.system.n))
        for k, first in enumerate(d):
            rows[3 * k : 3 * k + 3, first : first + 3] = rotation_arrays.matrices(q[None, first : first + 3])[0]
        return rows / self.scale

    def _gradient(self, t: float, q: Array, v: Array) -> Array:
        """The targets' gradient (r, n), by scaled coordinates."""
        G = np.zeros((0, self.system.n))
        if self.targets or not self.system.scene.spatial:
            G = dense(gradients(self.system, self.targets, t, q, v)[1]) / self.scale
        if self.system.scene.spatial:
            return np.vstack([G, self._of_rotations(q)[self.turned]]) if self.turned else G
        return np.vstack([G, np.vstack(self._of_beams(q, v))[self.turned]]) if self.turned else G

    def _at(self, s: float) -> tuple[Array, Array, Array, Array]:
        """Z and W (n, r), T (r, d) and S (r, r) at the time ``s`` from now."""
        system, (t, q, v) = self.system, self.path(s)
        J, G = dense(system.Phi_q(t, q)) / self.scale, self._gradient(t, q, v)
        size, r = row_size(J)[:, None], len(G)
        inverse = np.linalg.pinv(np.vstack([J / size, G]), rcond=RANK) / self.scale[:, None]
        Z, (free, rates) = inverse[:, len(J) :], self.released
        if free:
            Z = np.hstack([Z, inverse[:, free] / size[free, 0]])
        # Phi_q dv + (Phi_q v)_q dq = 0, and y' = G dv + (G v)_q dq
        turned = np.vstack([dense(system.Phi_v_q(t, q, v)) / size, self._rate_gradient(s)])
        W = -inverse @ turned @ Z
        if not system.p:
            return Z, W, np.eye(r + len(free)), np.zeros((r + len(free), r + len(free)))
        # S belongs to y' = T u + S y: of Gam_v (Z y' + W y) + Gam_q Z y = 0
        B = dense(system.Gam_v(t, q, v))
        C = B @ W + dense(system.Gam_q(t, q, v)) @ Z
        B = B @ Z
        size = row_size(B)[:, None]
        B, C = B / size, C / size
        if self.H is None:
            self.H = self._speeds(B[:, :r])
        chosen = self.H
        if free:
            chosen = np.zeros((len(self.H) + len(free), r + len(free)))
            chosen[: len(self.H), :r], chosen[len(self.H) :, r:] = self.H, np.eye(len(free))
        inverse = np.linalg.pinv(np.vstack([B, chosen]), rcond=RANK)
        T = inverse[:, len(B) :]
        if rates:
            T = np.hstack([T, inverse[:, rates] / size[rates, 0]])
        return Z, W, T, -inverse[:, : len(B)] @ C

    def _speeds(self, B: Array) -> Array:
        """Combinations (d, r) of the rates y' whose values are the speeds u that the constraints B y' = 0 allow."""
        return null_space(B).T

    def _rate_gradient(self, s: float) -> Array:
        """Derivatives (r, n) of the targets' rates G v by coordinates; for rotations, y' is G dv alone."""
        system, (t, q, v) = self.system, self.path(s)
        if self.bends:
            return self._derivative(lambda s: (self._gradient(*self.path(s)),), s)[0] * self.scale
        G1 = dense(gradients(system, [der(x) for x in self.targets], t, q, v)[1])
        return np.vstack([G1, np.zeros((len(self.turned), system.n))])

    def _derivative(self, of: Callable[[float], Sequence[Array]], s: float) -> list[Array]:
        """Derivatives of arrays along the motion at the time ``s`` from now, by differences."""
        line = zip(*(of(s + k * self.e) for k in range(-3, 4)), strict=True)
        return [np.tensordot(self.WEIGHTS, np.array(x), 1) / self.e for x in line]
