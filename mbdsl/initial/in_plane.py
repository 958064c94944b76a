"""The unknowns of the assembly of a mechanism in space whose guess lies in the x-y plane: motions in this plane.

A guess that is its own mirror image in the plane often has poses out of the plane nearby, as a disc that may lean or a
mass on two links. They are not meant, and no direction leads back from them. Therefore poses in the plane are looked
for first, and others only if there are none.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from mbdsl.kernels.arrays import Array
from mbdsl.numerics import rotation_arrays
from mbdsl.system.signals import values
from mbdsl.system.system import DENSE_LIMIT, System

if TYPE_CHECKING:
    from scipy.sparse import csr_array


#: entries of a gradient in the mechanism's size, and residuals, that count as zero
ZERO = 1e-9


class PlanarUnknowns:
    """y contains x and y of each body, its rotation about the z axis of the world from its guess, and all states."""

    def __init__(self, system: System, q: Array) -> None:
        self.system, self._guess, size = system, q, system.tables.scale
        self._angles = dict(system.tables.first_angles)
        start, keep, entries = list[float](), list[int](), list[tuple[int, int, float]]()
        for name, model in system.tables.models.items():
            d, first = system.tables.coordinates[name], len(start)
            if model.n == 1:  # a state
                entries.append((d, first, 1.0))
                start.append(q[d])
                keep.append(d)
                continue
            entries += [(d, first, 1.0), (d + 1, first + 1, 1.0)]
            start += [q[d], q[d + 1]]
            keep += [d, d + 1]
            if model.n > 3:
                about_z = rotation_arrays.matrices(q[None, d + 3 : d + 6])[0][2]
                entries += [(d + 3 + i, first + 2, about_z[i]) for i in range(3)]
                start.append(0.0)
                keep.append(d + 5)
        self.start, self._of = np.array(start), np.array(keep, int)
        self.scale = size[self._of]
        self.angles = np.array([name.endswith(".rz") for name in system.names()], bool)[self._of]
        rows, columns, numbers = zip(*entries, strict=True) if entries else ((), (), ())
        shape = (system.n, len(start))
        if system.unknowns > DENSE_LIMIT:
            from scipy.sparse import csr_array

            self.directions: Array | csr_array = csr_array((numbers, (rows, columns)), shape=shape)
        else:
            self.directions = np.zeros(shape)
            self.directions[list(rows), list(columns)] = numbers

    def begin(self) -> None:
        """Angles that count turns are those of the guess."""
        for node, angle in self._angles.items():
            self.system.set_first_angle(node, angle)

    def count_turns(self, y: Array) -> None:
        """Count the turns of angles on the way from the guess to y: bodies may have turned by more than half a turn."""
        self.begin()
        change, nodes = y - self.start, list(self._angles)
        steps = 1 + int(np.abs(change[self.angles]).max(initial=0.0))  # of at most a radian
        if steps > 1 and nodes:
            part, rest = np.linspace(0.0, 1.0, steps + 1), np.zeros((steps + 1, self.system.n))
            path = np.array([self.expand(self.start + x * change) for x in part])
            for node, angle in zip(nodes, values(self.system, nodes, 0.0 * part, path, rest), strict=True):
                self.system.set_first_angle(node, float(angle[-1]))

    def expand(self, y: Array) -> Array:
        """q (n,)"""
        return self.system.moved(self._guess, self.directions @ (y - self.start))

    def reduce(self, y: Array, J: Array | csr_array, q: Array | None = None) -> Array | csr_array:
        """J dq/dy for a Jacobian J with respect to q; zero in rows that hold in the plane, without their rounding."""
        found = J @ self.directions
        keep = _largest(found) > ZERO * _largest(J)
        if isinstance(found, np.ndarray):
            return found * keep[:, None]
        from scipy.sparse import diags_array

        return (diags_array(keep.astype(float)) @ found).tocsr()

    def rates(self, y: Array, w: Array, q: Array) -> Array:
        """v (n,) for the rates w of y."""
        return self.directions @ w

    def weights(self, weight: Array) -> Array:
        return weight[self._of]

    def moved(self, y: Array, d: Array) -> Array:
        return y + d

    def difference(self, y: Array, y0: Array) -> Array:
        return y - y0

    def suits(self, J: Array | csr_array, r: Array) -> bool:
        """Whether rows with the gradients J (k, n) and residuals r (k,), in the mechanism's size, are those of a plane.

        Each of them must depend on motions in the plane only, or on others only and be satisfied.
        """
        T = self.directions
        out = J - (J @ T) @ T.T
        inside, outside = _largest(J @ T), _largest(out)
        return not ((outside > ZERO) & ((inside > ZERO) | (np.abs(r) > ZERO))).any()


def _largest(J: Array | csr_array) -> Array:
    """The largest magnitude of each row."""
    if isinstance(J, np.ndarray):
        return np.abs(J).max(axis=1, initial=0.0)
    return abs(J).max(axis=1).toarray().ravel() if J.shape[1] else np.zeros(J.shape[0])
