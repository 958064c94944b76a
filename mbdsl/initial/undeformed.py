"""The unknowns of the assembly: all coordinates, or poses of undeformed bodies.

Flexible bodies could satisfy any constraint by deforming. Therefore they are assembled undeformed, and with all their
coordinates only if that fails, as in a structure that is assembled under stress.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from mbdsl.bodies.contract import POSITIONS, Body
from mbdsl.kernels.arrays import Array
from mbdsl.system.system import DENSE_LIMIT, System

if TYPE_CHECKING:
    from scipy.sparse import csr_array


class AsIs:
    """All coordinates: y = q."""

    def __init__(self, system: System, q: Array) -> None:
        self.system, self.start, self.scale = system, q, system.tables.scale
        self._turns = {name: body.turn for name, body in system.tables.models.items()}
        self._angles = {node: x for node, x in system.tables.first_angles.items() if node in system.tables.angles}
        self.angles = np.array([name.endswith((".phi", ".rx", ".ry", ".rz")) for name in system.names()], bool)

    def begin(self) -> None:
        """Turns are counted from the start on."""
        for name, angle in self._turns.items():
            self.system.set_turn(name, angle)
        for node, angle in self._angles.items():
            self.system.set_first_angle(node, angle)

    def expand(self, y: Array) -> Array:
        """q (n,) from the unknowns y; turns are counted from there on."""
        self.system.count_turns(y, start=True)
        return y

    def reduce(self, y: Array, J: Array | csr_array, q: Array | None = None) -> Array | csr_array:
        """J dq/dy for a Jacobian J with respect to q, in the shape at ``q`` (n,) if that is given."""
        return J

    def rates(self, y: Array, w: Array, q: Array) -> Array:
        """v (n,) for the rates w of y in the shape at q."""
        return w

    def weights(self, weight: Array) -> Array:
        """The weights of y from those of q."""
        return weight

    def moved(self, y: Array, d: Array) -> Array:
        """y after the displacements d."""
        return self.system.moved(y, d)

    def difference(self, y: Array, y0: Array) -> Array:
        """The displacements from y0 to y."""
        return self.system.difference(y, y0)


class Undeformed:
    """y contains the coordinates of rigid bodies and the poses of flexible ones."""

    def __init__(self, system: System, q: Array) -> None:
        tables = system.tables
        self.system, self.parts = system, list[tuple[int, int, Body]]()
        names = list[str]()
        start, scale, keep = list[float](), list[float](), list[int]()
        for name, model in tables.models.items():
            d, first = tables.coordinates[name], len(start)
            if not model.deforms:
                start.extend(q[d : d + model.n])
                scale.extend(tables.scale[d : d + model.n])
                keep.extend(range(d, d + model.n))
            else:
                own = q[None, d : d + model.n]
                start.extend(float(model.frame((0.0, 0.0, 0.0), key, own, own)[0]) for key in POSITIONS)
                scale.extend([tables.scale[d], tables.scale[d], 1.0])
                keep.extend([d, d, d])
                self.parts.append((d, first, model))
                names.append(name)
        self.start, self.scale, self._names = np.array(start), np.array(scale), names
        self._of = np.array(keep, int)
        self._rigid = np.ones(len(start), bool)
        angle = np.array([name.endswith(".phi") for name in system.names()], bool)
        self.angles = angle[self._of]
        for _, first, _ in self.parts:
            self._rigid[first : first + 3] = False
            self.angles[first : first + 3] = False, False, True

    def begin(self) -> None:
        pass

    def expand(self, y: Array) -> Array:
        q = np.zeros(self.system.n)
        q[self._of[self._rigid]] = y[self._rigid]
        for name, (d, first, model) in zip(self._names, self.parts, strict=True):
            q[d : d + model.n] = model.placed(tuple(y[first : first + 3]))[0]
            self.system.set_turn(name, float(y[first + 2]))
        return q

    def _directions(self, y: Array, q: Array | None = None):
        """dq/dy (n, y.size), dense or sparse like the System's matrices, in the shape at ``q`` if that is given."""
        columns = list(np.flatnonzero(self._rigid))
        rows, values = list(self._of[self._rigid]), [1.0] * len(columns)
        for d, first, model in self.parts:
            pose = tuple(y[first : first + 3])
            T = model.placed(pose)[1] if q is None else model.rigid(q[d : d + model.n])
            i, j = np.nonzero(T)
            rows.extend(d + i)
            columns.extend(first + j)
            values.extend(T[i, j])
        shape = (self.system.n, len(y))
        if self.system.unknowns > DENSE_LIMIT:
            from scipy.sparse import csr_array

            return csr_array((values, (rows, columns)), shape=shape)
        T = np.zeros(shape)
        T[rows, columns] = values
        return T

    def reduce(self, y: Array, J: Array | csr_array, q: Array | None = None) -> Array | csr_array:
        return J @ self._directions(y, q)

    def rates(self, y: Array, w: Array, q: Array) -> Array:
        return self._directions(y, q) @ w

    def weights(self, weight: Array) -> Array:
        return weight[self._of]

    def moved(self, y: Array, d: Array) -> Array:
        return y + d  # there are no flexible bodies in space

    def difference(self, y: Array, y0: Array) -> Array:
        return y - y0
