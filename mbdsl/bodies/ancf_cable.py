"""A flexible beam in absolute nodal coordinates: the body model for :mod:`mbdsl.bodies.ancf_cable_kernels`.

Axial strain is integrated with three Lobatto points per element, curvature with three Gauss points. In a bent element,
a cubic r cannot have |r'| = 1 everywhere. Requiring eps = 0 at Gauss points, however many, therefore couples bending to
stretching, and errors decrease as Le^2 until Le^2 EA/EI is small (axial locking). The three Lobatto points are the
nodes, which neighbouring elements share, and the midpoint, whose condition only fixes the length of the element: errors
decrease as Le^4, for any EA/EI. Fewer points would leave modes of zero energy: a straight element has three axial and
two bending modes.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from mbdsl.bodies.beam_stations import on_axis
from mbdsl.bodies.contract import Described, Pose
from mbdsl.kernels.arrays import Array
from mbdsl.numerics.banded_cholesky import cholesky

#: quadrature points and weights on [0, 1]
LOBATTO3 = np.array([0.0, 0.5, 1.0]), np.array([1.0, 4.0, 1.0]) / 6
GAUSS3 = 0.5 + np.sqrt(0.15) * np.array([-1.0, 0.0, 1.0]), np.array([5.0, 8.0, 5.0]) / 18
GAUSS4 = tuple(0.5 * x for x in (1.0 + np.polynomial.legendre.leggauss(4)[0], np.polynomial.legendre.leggauss(4)[1]))
STRETCH, BEND, INERTIA = LOBATTO3, GAUSS3, GAUSS4


def shapes(s: Array, L: float) -> tuple[Array, Array, Array]:
    """S, S' and S'' at x = s L of the Hermite polynomials for r, r' at 0, r, r' at L: (..., 4) each."""
    s = np.asarray(s, float)
    S = [1 - s**2 * (3 - 2 * s), L * s * (1 - s) ** 2, s**2 * (3 - 2 * s), L * s**2 * (s - 1)]
    d = [6 * s * (s - 1) / L, (1 - s) * (1 - 3 * s), 6 * s * (1 - s) / L, s * (3 * s - 2)]
    dd = [(12 * s - 6) / L**2, (6 * s - 4) / L, (6 - 12 * s) / L**2, (6 * s - 2) / L]
    return np.stack(S, -1), np.stack(d, -1), np.stack(dd, -1)


def _turning(slope: Array, rate: Array) -> Array:
    """Angular velocities (N,) of slopes (N, 2) with these rates."""
    return (slope[:, 0] * rate[:, 1] - slope[:, 1] * rate[:, 0]) / (slope**2).sum(axis=1)


class CableBody:
    """A flexible beam with the coordinates x, y and slopes dx, dy of its nodes, from end a to end b.

    Revolutions are counted from the angle ``turn`` of end a; kernels read theirs from ``numbers`` at ``counter``.
    """

    deforms = True

    def __init__(self, component: Described) -> None:
        v = component.values
        self.length, self.elements = float(v["length"]), int(v["elements"])
        self.EA, self.EI, self.T = v["E"] * v["S"], v["E"] * v["I"], float(v["beta"])
        self.n = 4 * (self.elements + 1)
        self.L = self.length / self.elements
        s, w = INERTIA
        S, d, _ = shapes(s, self.L)
        # Only the component of the rate of r' normal to r' turns the section. The rotary inertia counts the axial one
        # as well: M is then constant, and exact for an inextensible beam.
        self._density = self.L * (v["mass"] / self.length * (S.T * w) @ S + v["rotary"] * (d.T * w) @ d)
        self._first = self.L * v["mass"] / self.length * w @ S
        self.turn, self.counter = 0.0, -1

    def _elements(self, q: Array) -> Array:
        """Coordinates (N, n) element by element: (N, elements, 4, 2)."""
        e = q.reshape(len(q), -1, 2)
        return e[:, 2 * np.arange(self.elements)[:, None] + np.arange(4)]

    # -- masses --------------------------------------------------------------------------------------------------
    def _banded(self) -> Array:
        """The mass matrix (n/2, n/2) of the x coordinates, which is also that of the y coordinates."""
        M = np.zeros((self.n // 2, self.n // 2))
        for i in range(self.elements):
            M[2 * i : 2 * i + 4, 2 * i : 2 * i + 4] += self._density
        return M

    def mass(self) -> Array:
        found = np.zeros(self.n // 2)
        for i in range(self.elements):
            found[2 * i : 2 * i + 4] += self._density.diagonal()
        return np.repeat(found, 2)

    def couplings(self) -> list[tuple[int, int, float]]:
        found: dict[tuple[int, int], float] = {}
        for i in range(self.elements):
            for a in range(4):
                for b in range(a + 1, 4):
                    for axis in range(2):
                        at = 4 * i + 2 * a + axis, 4 * i + 2 * b + axis
                        found[at] = found.get(at, 0.0) + float(self._density[a, b])
        return [(i, j, value) for (i, j), value in found.items()]

    def M(self, q: Array) -> Array:
        return np.asarray(np.kron(self._banded(), np.eye(2)), float)

    def weight(self, g: Array) -> Array:
        found = np.zeros((self.n // 2, 2))
        for i in range(self.elements):
            found[2 * i : 2 * i + 4] += np.outer(self._first, g)
        return found.ravel()

    def scale(self, size: float) -> Array:
        return np.tile([1.0 / size, 1.0 / size, self.L / size, self.L / size], self.elements + 1)

    def eliminate(self) -> Sequence[int]:
        return range(self.n)

    # -- frames --------------------------------------------------------------------------------------------------
    def _station(self, pose: Pose) -> tuple[int, Array, Array]:
        """The first coordinate that a frame depends on, and S and S' there: those of a node, or of an element."""
        x = on_axis(pose, self.length) / self.L
        node = round(x)
        if abs(x - node) <= 1e-9 * self.elements:
            return 4 * node, np.array([1.0, 0.0]), np.array([0.0, 1.0])
        S, d, _ = shapes(np.array(x - int(x)), self.L)
        return 4 * int(x), S, d

    def dofs(self, pose: Pose) -> tuple[int, ...]:
        first, S, _ = self._station(pose)
        return tuple(range(first, first + 2 * len(S)))

    def record(self, buffers, d: int, first: int, poses: Sequence[Pose], g: Array) -> list[int]:
        points = []
        for (s, w), count in ((STRETCH, 1), (BEND, 2)):
            columns = np.hstack([self.L * w[:, None], *shapes(s, self.L)[1 : 1 + count]])
            points += [len(s), buffers.floats(columns.ravel().tolist())]
        material = buffers.floats([self.EA, self.EI, self.T])
        blocks = buffers.requested
        for i in range(self.elements):
            own = range(d + 4 * i, d + 4 * i + 8)
            buffers.slots(own, own)
        self.counter, frames = buffers.floats([self.turn]), list[int]()
        for pose in poses:
            at, S, slope = self._station(pose)
            constants = buffers.floats([pose[2], *S.tolist(), *slope.tolist()])
            own = range(d + at, d + at + 2 * len(S))
            frames += [len(S), at, constants, buffers.slots(own, own)]
        band, factor = cholesky(self._banded())
        head = [d, first, len(poses), self.elements, material, *points, blocks, buffers.ints(frames), band]
        return [*head, buffers.floats(factor), buffers.floats([0.0] * 64), self.counter]

    def frame(self, pose: Pose, key: str, q: Array, v: Array, t: Array | None = None) -> Array:
        """As :meth:`Body.frame`. In the first state, the angle of end a is the value closest to ``turn``; in each later
        state, the value closest to the extrapolation from the previous state. Angles are continuous along the axis."""
        first, S, d = self._station(pose)
        e, rate = (x[:, first : first + 2 * len(S)].reshape(len(x), -1, 2) for x in (q, v))
        if key in ("x", "y", "vx", "vy"):
            return S @ (rate if key[0] == "v" else e)[:, :, "xy".index(key[-1])].T
        slope = d @ e
        if key == "w":
            return _turning(slope, d @ rate)
        nodes = q.reshape(len(q), -1, 2)[:, 1 : first // 2 + 2 : 2]
        along = np.unwrap(np.arctan2(*np.moveaxis(np.concatenate([nodes, slope[:, None]], axis=1), -1, 0)[::-1]))
        return self.turned(self.turn, q, v, t) + along[:, -1] - along[:, 0] + pose[2]

    def turned(self, turn: float, q: Array, v: Array, t: Array | None = None) -> Array:
        slope, rate = q[:, 2:4], v[:, 2:4]
        change = np.diff(np.arctan2(slope[:, 1], slope[:, 0]), prepend=turn)
        expected = np.zeros(len(change))
        if t is not None:
            w = _turning(slope, rate)
            expected[1:] = 0.5 * (w[1:] + w[:-1]) * np.diff(t)
        change += 2.0 * np.pi * np.round((expected - change) / (2.0 * np.pi))
        return turn + np.cumsum(change)

    def gradient(self, pose: Pose, q: Array, v: Array) -> tuple[Array, Array]:
        first, S, d = self._station(pose)
        own = slice(first, first + 2 * len(S))
        (ax, ay), u = d @ q[own].reshape(-1, 2), d @ v[own].reshape(-1, 2)
        p = np.array([-ay, ax]) / (ax**2 + ay**2)
        xx, xy = -2.0 * p[0] * p[1], p[0] ** 2 - p[1] ** 2
        B, B_rate = np.zeros((3, self.n)), np.zeros((3, self.n))
        B[:2, own], B[2, own] = np.kron(S, np.eye(2)), np.kron(d, p)
        B_rate[2, own] = np.kron(d, np.array([[xx, xy], [xy, -xx]]) @ u)
        return B, B_rate

    def placed(self, pose: Pose) -> tuple[Array, Array]:
        x, y, phi = pose
        c, s = np.cos(phi), np.sin(phi)
        along = np.linspace(-self.length / 2, self.length / 2, self.elements + 1)
        one = np.ones_like(along)
        q = np.stack([x + c * along, y + s * along, c * one, s * one], axis=1).ravel()
        turned = np.stack([-s * along, c * along, -s * one, c * one], axis=1).ravel()
        shifts = np.tile([[1.0, 0.0], [0.0, 1.0], [0.0, 0.0], [0.0, 0.0]], (len(one), 1))
        return q, np.column_stack([shifts, turned])

    # -- energies ------------------------------------------------------------------------------------------------
    def strains(self, q: Array) -> tuple[Array, Array]:
        """eps and K at the points of every element (N, elements, points) for states q (N, n)."""
        e = self._elements(q)
        slope = np.einsum("pj,tejc->tepc", shapes(STRETCH[0], self.L)[1], e)
        _, d, dd = shapes(BEND[0], self.L)
        a, b = (np.moveaxis(np.einsum("pj,tejc->tepc", S, e), -1, 0) for S in (d, dd))
        return np.sqrt((slope**2).sum(axis=-1)) - 1.0, (a[0] * b[1] - a[1] * b[0]) / (a**2).sum(axis=0)

    def rigid(self, q: Array) -> Array:
        r = np.asarray(q).reshape(-1, 2, 2)  # node, position or slope, x or y
        ones = np.zeros((len(r), 2, 2, 2))
        ones[:, 0] = np.eye(2)
        turn = r @ np.array([[0.0, 1.0], [-1.0, 0.0]])
        return np.concatenate([ones.reshape(self.n, 2), turn.reshape(self.n, 1)], axis=1)

    def energies(self, q: Array, v: Array, g: Array) -> tuple[Array, Array]:
        rate = self._elements(v)
        kinetic = 0.5 * np.einsum("teic,ij,tejc->t", rate, self._density, rate)
        eps, K = self.strains(q)
        elastic = self.EA * (eps**2).sum(axis=1) @ STRETCH[1] + self.EI * (K**2).sum(axis=1) @ BEND[1]
        return kinetic, 0.5 * self.L * elastic - q @ self.weight(g)

    def bend(self, q: Array) -> Array:
        return np.zeros(len(q))


MODEL = CableBody
