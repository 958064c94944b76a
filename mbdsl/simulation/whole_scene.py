"""The map from the states of the parts of a reduced scene to those of the scene as written.

Reduction fixes every body of the scene to a body of a part at a constant pose, or prescribes its motion as a function
of time: the frames of the reduced scene contain this information. The map is set up once. Multipliers are copied from
the part that solves for them. Of a mechanism in space that is solved in a plane, or with gyrostats, the state of the
scene that is solved is found first; its multipliers follow from the motion.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from mbdsl.expressions.symbolic import RATE, Expr, coordinate
from mbdsl.kernels.arrays import Array
from mbdsl.mechanism.reduction import Reduction
from mbdsl.simulation.gyrostat_states import GyrostatStates
from mbdsl.simulation.planar_states import PlanarStates
from mbdsl.system import System
from mbdsl.system.signals import values

#: q and v (N, n) and lam (N, m + p) of a part
State = tuple[Array, Array, Array]


class _Body(NamedTuple):
    """A body of the scene: its columns in q and v, its part (None: prescribed), and their source there."""

    name: str
    columns: slice
    part: int | None
    source: slice | list[Expr]  #: columns of the part, or expressions for the positions and then the velocities


class WholeScene:
    """The map to the scene of ``system``.

    Parameters
    ----------
    system : System
        That of the scene as written.
    reduction : Reduction
        Of that scene.
    parts : sequence of System
        Those of its parts.
    solved : sequence of bool
        Whether a part solves for its multipliers; else they follow from the motion.
    reduced : sequence of PlanarStates or GyrostatStates, optional
        Those of the mechanisms in space that parts solve in a plane or with gyrostats.

    Attributes
    ----------
    reduced : tuple of PlanarStates or GyrostatStates
    known : (m + p,) of bool
        The multipliers that the parts solve for.
    """

    def __init__(
        self,
        system: System,
        reduction: Reduction,
        parts: Sequence[System],
        solved: Sequence[bool],
        reduced: Sequence[PlanarStates | GyrostatStates] = (),
    ) -> None:
        self._system, self._parts = system, parts
        self.reduced = tuple(reduced)
        self._reduced = [
            (x, x.flat.numbers, WholeScene(x.system, x.flat.reduction, own, [True] * len(own)))
            for x in reduced
            for own in [[parts[k] for k in x.flat.numbers]]
        ]
        flat = {k for x in reduced for k in x.flat.numbers}
        solved = [own and k not in flat for k, own in enumerate(solved)]
        for part in parts:
            system.tables.first_angles |= part.tables.first_angles
        self.known = np.zeros(system.m + system.p, bool)
        self._rows = []
        for part, own in zip(parts, solved, strict=True):
            full = system.tables.multipliers
            pairs = [(full[key] - system.n, k - part.n) for key, k in part.tables.multipliers.items() if own]
            rows = np.array(pairs, np.int64).reshape(-1, 2)
            self._rows.append(rows)
            self.known[rows[:, 0]] = True
        self._same = bool(parts) and parts[0] is system
        if not self._same:
            self._prescribed = System(reduction.scene, reduction.graph, system.tables)
            self._bodies = self._map(reduction)

    def _map(self, reduction: Reduction) -> list[_Body]:
        system = self._system
        owner = {body: k for k, part in enumerate(self._parts) for body in part.tables.coordinates}
        found = []
        elsewhere = {body for flat in reduction.flattened for body in flat.motion.graph.bodies}
        for body in system.scene.with_coordinates():
            if body.name in elsewhere:
                continue
            frame, keys = f"{body.name}.c", body.coordinates
            k = owner.get(reduction.scene.frames[frame].body)
            d, count = system.tables.coordinates[body.name], system.tables.models[body.name].n
            source: slice | list[Expr]
            if k is not None and (count not in (2, len(RATE)) or system.scene.spatial):  # these are not reduced
                own = self._parts[k].tables.coordinates[body.name]
                source = slice(own, own + count)
            else:
                source = [coordinate(frame, key) for key in (*keys, *(RATE[key] for key in keys))]
            found.append(_Body(body.name, slice(d, d + count), k, source))
        return found

    def state(self, t: Array, states: Sequence[State], own: bool = True) -> State:
        """The state of the scene at N times.

        Parameters
        ----------
        t : (N,) array
            Times [s].
        states : sequence of (q, v, lam)
            Those of the parts at these times, of shapes (N, n), (N, n) and (N, m + p).
        own : bool, optional
            Whether the result has arrays of its own; else they may be those of a part.

        Returns
        -------
        q, v : (N, n) arrays
        lam : (N, m + p) array
            NaN where no part solves for a multiplier.
        """
        if self._same:
            q, v, lam = (x.copy() for x in states[0]) if own else states[0]
            return q, v, lam if self.known.all() else np.where(self.known, lam, np.nan)
        system = self._system
        q, v = np.zeros((len(t), system.n)), np.zeros((len(t), system.n))
        lam = np.full((len(t), system.m + system.p), np.nan)
        for body in self._bodies:
            where, (part_q, part_v) = (
                (self._prescribed, (q, v)) if body.part is None else (self._parts[body.part], states[body.part][:2])
            )
            if isinstance(body.source, slice):
                system.set_turn(body.name, where.tables.models[body.name].turn)
                q[:, body.columns], v[:, body.columns] = part_q[:, body.source], part_v[:, body.source]
            else:
                found = np.transpose(values(where, body.source, t, part_q, part_v))
                q[:, body.columns], v[:, body.columns] = np.split(found, 2, axis=1)
        for reduced, numbers, inner in self._reduced:
            own_q, own_v, _ = inner.state(t, [states[k] for k in numbers])
            reduced.write(system, own_q, own_v, q, v)
        for rows, (_, _, part_lam) in zip(self._rows, states, strict=True):
            lam[:, rows[:, 0]] = part_lam[:, rows[:, 1]]
        return q, v, lam
