"""A flexible beam in a floating frame of reference: the body model for :mod:`mbdsl.bodies.floating_beam_kernels`."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from mbdsl.bodies import floating_beam_kernels as kernels
from mbdsl.bodies.beam_stations import on_axis
from mbdsl.bodies.contract import Described, Pose
from mbdsl.bodies.floating_beam_integrals import Floating, discretise
from mbdsl.bodies.uniform_beam import UniformBeam
from mbdsl.kernels.arrays import Array
from mbdsl.numerics.banded_cholesky import cholesky

E_X = np.array([1.0, 0.0])


def turned(phi):
    """A(phi) (2, 2), or (N, 2, 2) for angles (N,)."""
    c, s = np.cos(phi), np.sin(phi)
    return np.moveaxis(np.array([[c, -s], [s, c]]), (0, 1), (-2, -1))


J = turned(np.pi / 2).round()


class FloatingBody:
    """A flexible beam with the coordinates x, y and angle of its floating frame, and k elastic coordinates."""

    deforms = True
    turn, counter = 0.0, -1

    def __init__(self, component: Described) -> None:
        v = component.values
        self.length = float(v["length"])
        uniform = UniformBeam(
            self.length,
            v["mass"] / self.length,
            v["E"] * v["S"],
            v["E"] * v["I"],
            J=v["rotary"],
            elements=int(v["elements"]),
            modes=None if v["modes"] is None else int(v["modes"]),
            axial=None if v["axial"] is None else int(v["axial"]),
            basis=v["basis"],
            reference=v["reference"],
            zeta=v["zeta"],
            alpha=v["alpha"],
            beta=v["beta"],
            stiffening=bool(v["stiffening"]),
        )
        self.beam: Floating = discretise(uniform)
        self._last: tuple = (None, None)
        self.k = len(self.beam.names)
        self.n = 3 + self.k
        b = self.beam
        self.H = b.H - b.N_hat  # geometric stiffening contributes to all inertia terms except M_ff
        self._slopes = b.bending[1::2]  # (elements + 1, k) slopes at the nodes, which the theory assumes to be small
        # largest displacement by a unit of each coordinate: at a node; by slopes, about h/4 between nodes
        moved = np.concatenate([b.axial, b.bending[0::2], b.bending[1::2] * self.length / b.elements / 4])
        self._shapes = np.abs(moved).max(axis=0)

    # -- masses --------------------------------------------------------------------------------------------------
    def mass(self) -> Array:
        return np.concatenate([[self.beam.m, self.beam.m, self.beam.I0], self.beam.M_ff.diagonal()])

    def couplings(self) -> list[tuple[int, int, float]]:
        i, j = np.nonzero(np.triu(self.beam.M_ff, 1))
        return [(3 + a, 3 + b, float(self.beam.M_ff[a, b])) for a, b in zip(i.tolist(), j.tolist(), strict=True)]

    def weight(self, g: Array) -> Array:
        return np.concatenate([self.beam.m * g, np.zeros(1 + self.k)])

    def scale(self, size: float) -> Array:
        return np.concatenate([[1.0 / size, 1.0 / size, 1.0], self._shapes / size])

    def eliminate(self) -> Sequence[int]:
        return [*range(3, self.n), 0, 1, 2]

    def _parts(self, q: Array):
        """c (N, 2), c_j (N, 2, k), P (N,), b (N, k) at states q (N, n)."""
        b, e = self.beam, q[:, 3:]
        c_j = b.S_bar[None] - E_X[:, None] * (e @ b.N_bar)[:, None, :]
        c = e @ b.S_bar.T - 0.5 * E_X * (e * (e @ b.N_bar)).sum(axis=1)[:, None]
        P = b.I0 + e @ (2.0 * b.h1) + (e * (e @ self.H)).sum(axis=1)
        return c, c_j, P, b.g0 + e @ b.G

    def M(self, q: Array) -> Array:
        (c,), (c_j,), (P,), (b,) = self._parts(np.asarray(q)[None])
        A = turned(q[2])
        M = np.zeros((self.n, self.n))
        M[0, 0] = M[1, 1] = self.beam.m
        M[:2, 2], M[:2, 3:], M[2, 2], M[2, 3:] = A @ J @ c, A @ c_j, P, b
        M[3:, 3:] = self.beam.M_ff
        return np.triu(M) + np.triu(M, 1).T

    # -- frames --------------------------------------------------------------------------------------------------
    def _station(self, pose: Pose) -> tuple[Array, Array]:
        x = on_axis(pose, self.length)
        if self._last[0] != x:  # the coordinates of a frame are asked for one after the other
            self._last = x, self.beam.station(x)
        return self._last[1]

    def _which(self, pose: Pose) -> list[int]:
        U, N = self._station(pose)
        return np.flatnonzero((U != 0.0).any(axis=0) | (N != 0.0).any(axis=0)).tolist()

    def dofs(self, pose: Pose) -> tuple[int, ...]:
        return (0, 1, 2, *(3 + j for j in self._which(pose)))

    def record(self, buffers, d: int, first: int, poses: Sequence[Pose], g: Array) -> list[int]:
        b, k = self.beam, self.k
        lists = np.concatenate([b.S_bar[0], b.S_bar[1], b.h1, b.g0])
        constants = buffers.floats([b.m, b.I0, *g, *lists])
        inertial = self._entries(buffers, d, self.H, b.G, b.N_bar)
        elastic = self._entries(buffers, d, b.K, b.D)
        elastic_coordinates = range(d + 3, d + self.n)
        border = buffers.slots((d, d + 1), (d + 2,))
        buffers.slots((d + 2,), (d, d + 1, d + 2))
        for j in elastic_coordinates:
            buffers.slots((d, d + 1), (j,))
            buffers.slots((j,), (d, d + 1))
            buffers.slots((d + 2,), (j,))
            buffers.slots((j,), (d + 2,))
        now, held, past = (buffers.floats([0.0] * (kernels.LISTS + 7 * k + 6)) for _ in range(3))
        frames = [value for pose in poses for value in self._frame_record(buffers, d, pose)]
        band, factor = cholesky(b.M_ff)
        scratch = buffers.floats([0.0] * 8 * k)
        head = [d, first, len(poses), k, constants, *inertial, *elastic, border, now, held, past]
        return [buffers.ints([*head, buffers.ints(frames), band, buffers.floats(factor), scratch])]

    @staticmethod
    def _entries(buffers, d: int, *matrices: Array) -> tuple[int, int, int]:
        """The number of entries that are nonzero in any matrix; offsets of (i, j, slot) and of their values."""
        i, j = np.nonzero(np.abs(np.array(matrices)).sum(axis=0))
        ints = []
        for a, b in zip(i.tolist(), j.tolist(), strict=True):
            ints += [a, b, buffers.slots((d + 3 + a,), (d + 3 + b,))]
        values = np.stack([m[i, j] for m in matrices], axis=1) if len(i) else np.zeros((0, len(matrices)))
        return len(i), buffers.ints(ints), buffers.floats(values.ravel().tolist())

    def _frame_record(self, buffers, d: int, pose: Pose) -> list[int]:
        U, N = self._station(pose)
        which = self._which(pose)
        k = len(which)
        constants = buffers.floats([*pose, *U[:, which].ravel().tolist()])
        curved = bool(N.any())
        second = buffers.floats(N[np.ix_(which, which)].ravel().tolist()) if curved else -1
        columns, past = buffers.floats([0.0] * 2 * k), buffers.floats([0.0] * 2 * k)
        slot = buffers.slots((d + 2,), (d + 2,))
        elastic = [d + 3 + j for j in which]
        for j in elastic:
            buffers.slots((d + 2,), (j,))
            buffers.slots((j,), (d + 2,))
        if curved:
            buffers.slots(elastic, elastic)
        return [k, buffers.ints(which), constants, second, columns, past, slot]

    def frame(self, pose: Pose, key: str, q: Array, v: Array, t: Array | None = None) -> Array:
        U, N = self._station(pose)
        e, rate, phi = q[:, 3:], v[:, 3:], q[:, 2]
        if key in ("phi", "w"):
            return phi + pose[2] + e @ U[2] if key == "phi" else v[:, 2] + rate @ U[2]
        Ne = e @ N
        u = pose[0] + e @ U[0] - 0.5 * (e * Ne).sum(axis=1), pose[1] + e @ U[1]
        c, s = np.cos(phi), np.sin(phi)
        lx, ly = c * u[0] - s * u[1], s * u[0] + c * u[1]
        if key in ("x", "y"):
            return q[:, 0] + lx if key == "x" else q[:, 1] + ly
        du = rate @ U[0] - (rate * Ne).sum(axis=1), rate @ U[1]
        if key == "vx":
            return v[:, 0] - ly * v[:, 2] + c * du[0] - s * du[1]
        return v[:, 1] + lx * v[:, 2] + s * du[0] + c * du[1]

    def gradient(self, pose: Pose, q: Array, v: Array) -> tuple[Array, Array]:
        U, N = self._station(pose)
        e, rate, A = q[3:], v[3:], turned(q[2])
        columns = A @ (U[:2] - np.outer(E_X, N @ e))
        l = A @ (np.array(pose[:2]) + U[:2] @ e - 0.5 * E_X * (e @ N @ e))
        B, B_rate = np.zeros((3, self.n)), np.zeros((3, self.n))
        B[:, :3] = np.eye(3)
        B[:2, 2], B[:2, 3:], B[2, 3:] = J @ l, columns, U[2]
        B_rate[:2, 2] = -l * v[2] + J @ (columns @ rate)
        B_rate[:2, 3:] = v[2] * (J @ columns) - np.outer(A @ E_X, N @ rate)
        return B, B_rate

    def placed(self, pose: Pose) -> tuple[Array, Array]:
        return np.concatenate([pose, np.zeros(self.k)]), np.eye(self.n, 3)

    def rigid(self, q: Array) -> Array:
        return np.eye(self.n, 3)

    # -- energies ------------------------------------------------------------------------------------------------
    def energies(self, q: Array, v: Array, g: Array) -> tuple[Array, Array]:
        b = self.beam
        c, c_j, P, of_phi = self._parts(q)
        A, w, R, e, rate = turned(q[:, 2]), v[:, 2], v[:, :2], q[:, 3:], v[:, 3:]
        in_frame = np.einsum("tij,ti->tj", A, R)
        dc = np.einsum("tij,tj->ti", c_j, rate)
        kinetic = 0.5 * b.m * (R**2).sum(axis=1) + 0.5 * P * w**2 + w * (of_phi * rate).sum(axis=1)
        kinetic += 0.5 * (rate * (rate @ b.M_ff)).sum(axis=1)
        kinetic += (in_frame * (w[:, None] * (c @ J.T) + dc)).sum(axis=1)
        height = b.m * q[:, :2] + np.einsum("tij,tj->ti", A, c)
        return kinetic, 0.5 * (e * (e @ b.K)).sum(axis=1) - height @ g

    def bend(self, q: Array) -> Array:
        return np.abs(q[:, 3:] @ self._slopes.T).max(axis=1, initial=0.0)


MODEL = FloatingBody
