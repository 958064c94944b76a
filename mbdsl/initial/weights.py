"""The objective of the assembly: the distance of a state from its initial guess."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from copy import copy

import numpy as np

from mbdsl.elements.kind import JointKind, is_point
from mbdsl.expressions.symbolic import RATE, Expr, coordinate
from mbdsl.kernels.arrays import Array
from mbdsl.mechanism.reduction import Reduction
from mbdsl.mechanism.scene import Component, Scene
from mbdsl.system.signals import Matrix, gradients
from mbdsl.system.system import System

UNSAID = 1e-4  #: weight of a coordinate without a guess
UNDECIDED = 1e-6  #: relative weight of velocities in the world, if those of joints count, and leave something undecided


def members_of(reduction: Reduction, system: System) -> dict[str, list[str]]:
    """The frames at the centres of mass of welded bodies of a part, by the name of their merged body."""
    merged = [note.names for note in reduction.notes if note.action == "merged"]
    own = system.tables.coordinates
    return {names[0]: [f"{name}.c" for name in names] for names in merged if names[0] in own}


class Metric:
    """The distance from a guess, or from rest, of coordinates without an initial value: a sum over all bodies.

    Each body of a group of welded bodies counts: ``members`` are the frames at their centres of mass, by the name of
    the merged body.
    """

    def __init__(self, system: System, members: Mapping[str, Sequence[str]]) -> None:
        self.weight = np.full(system.n, UNSAID)  #: weight of coordinates measured in ``scale``
        size, self.positions, self.velocities = 1.0 / system.tables.size, [], []
        for body, frames in members.items():
            first = system.tables.coordinates[body]
            self.weight[first : first + 3] = 0.0
            for frame in frames:
                self.positions += [coordinate(frame, key) for key in RATE]
                self.velocities += [coordinate(frame, key) for key in RATE.values()]
        self.row_weight = UNSAID * np.tile([size, size, 1.0], len(self.positions) // 3)[:, None]
        self.rate_weight, self.system = self.row_weight, system

    def relative(self) -> Metric:
        """The same with the velocities of joints in place of those of bodies: a body on a driven one moves with it."""
        found, size, scene = copy(self), 1.0 / self.system.tables.size, self.system.scene
        lengths, angles = list[Expr](), list[Expr]()
        for c in scene.components.values():
            if isinstance(c.kind, JointKind) and c.kind.driver is None and (c.kind.rows > 1 or c.kind.placing.along):
                a, b = sorted(c.ports.values(), key=lambda name: is_point(_body_of(scene, name).kind))
                lengths += slip(a, b, scene.spatial)
                if not is_point(_body_of(scene, b).kind):
                    angles += [coordinate(b, key) - coordinate(a, key) for key in _spin(scene.spatial)]
        found.weight, found.velocities = UNDECIDED * self.weight, [*self.velocities, *lengths, *angles]
        weights = [*(UNDECIDED * self.row_weight[:, 0]), *[UNSAID * size] * len(lengths), *[UNSAID] * len(angles)]
        found.rate_weight = np.array(weights)[:, None]
        return found

    def positions_at(self, t: float, q: Array) -> tuple[Array, Matrix]:
        """Weighted coordinates of members, and their gradient with respect to q."""
        value, d_q, _ = gradients(self.system, self.positions, t, q, np.zeros(self.system.n))
        return self.row_weight[:, 0] * value, scaled(d_q, self.row_weight, np.ones(self.system.n))

    def velocities_at(self, t: float, q: Array) -> tuple[Array, Matrix]:
        """Weighted velocities of members at v = 0, and their gradient with respect to v."""
        value, _, d_v = gradients(self.system, self.velocities, t, q, np.zeros(self.system.n))
        return self.rate_weight[:, 0] * value, scaled(d_v, self.rate_weight, np.ones(self.system.n))


def _body_of(scene: Scene, frame: str) -> Component:
    return scene.components[scene.frames[frame].body]


def _spin(spatial: bool) -> tuple[str, ...]:
    return ("wx", "wy", "wz") if spatial else ("w",)


def slip(a: str, b: str, spatial: bool) -> list[Expr]:
    """The velocity of the origin of frame b relative to the body of frame a, in world axes."""
    axes = "xyz" if spatial else "xy"
    d, v = ([coordinate(b, key + i) - coordinate(a, key + i) for i in axes] for key in ("", "v"))
    if not spatial:
        w = coordinate(a, "w")
        return [v[0] + w * d[1], v[1] - w * d[0]]
    w3 = [coordinate(a, key) for key in _spin(True)]
    return [v[k] - (w3[k - 2] * d[k - 1] - w3[k - 1] * d[k - 2]) for k in range(3)]


def scaled(J: Matrix, rows: Array, columns: Array) -> Matrix:
    if isinstance(J, np.ndarray):
        return rows * J / columns
    from scipy.sparse import diags_array

    return diags_array(rows[:, 0]) @ J @ diags_array(1.0 / columns)
