"""Growing energy and sudden changes of velocity, searched in the outputs of a run block by block."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from mbdsl.expressions.symbolic import Expr
from mbdsl.kernels.arrays import Array
from mbdsl.simulation.trajectory import Trajectory
from mbdsl.system.signals import values

#: change of velocity between two outputs, relative to the largest velocity, that may be due to a contact
KICK = 0.25
#: most changes of velocity that are kept
PLACES = 8


class Symptom:
    """What is searched in the outputs of a run, which are added block by block."""

    KEPT: tuple[str, ...]  #: names of the attributes that a checkpoint contains

    def state(self) -> dict[str, Any]:
        """The state for a checkpoint."""
        return {name: getattr(self, name) for name in self.KEPT}

    def restore(self, known: dict[str, Any]) -> None:
        """Continue from a state."""
        for name in self.KEPT:
            setattr(self, name, type(getattr(self, name))(known[name]))


class EnergyGrowth(Symptom):
    """The largest growth of the energy above its least value so far.

    Parameters
    ----------
    laws : sequence of Expr
        Outputs at which one of these is not zero are left out.

    Attributes
    ----------
    count : int
        Number of outputs that were compared.
    grown, since, until : float [J, s, s]
        The growth, and the times of the least energy before it and of its end.
    kinetic, size : float [J]
        The largest kinetic energy, and the largest absolute energy.
    speed : float [m/s, rad/s]
        The largest absolute velocity.
    finite : bool
        Whether all energies are finite numbers.
    """

    KEPT = ("count", "grown", "since", "until", "kinetic", "size", "speed", "finite", "least", "least_at")

    def __init__(self, laws: Sequence[Expr]) -> None:
        self._laws = list(laws)
        self.count, self.finite = 0, True
        self.grown, self.since, self.until = -1.0, 0.0, 0.0
        self.kinetic, self.size, self.speed = 0.0, 0.0, 0.0
        self.least, self.least_at = np.inf, 0.0

    def add(self, trajectory: Trajectory) -> None:
        """Add the outputs that follow."""
        t, free = trajectory.t, np.ones(len(trajectory.t), bool)
        if self._laws:
            free = ~np.any(values(trajectory.system, self._laws, t, trajectory.q, trajectory.v), axis=0)
        E, T = trajectory["energy.total"], trajectory["energy.kinetic"]
        self.finite = self.finite and bool(np.isfinite(E).all() and np.isfinite(T).all())
        self.kinetic = max(self.kinetic, float(T.max(initial=0.0)))
        self.speed = max(self.speed, float(np.abs(trajectory.v).max(initial=0.0)))
        E, t = E[free], t[free]
        self.count += len(E)
        if not self.finite or not len(E):
            return
        self.size = max(self.size, float(np.abs(E).max()))
        grown = E - np.minimum(self.least, np.minimum.accumulate(E))
        k = int(np.argmax(grown))
        if grown[k] > self.grown:
            least = int(np.argmin(E[: k + 1]))
            self.grown, self.until = float(grown[k]), float(t[k])
            self.since = float(t[least]) if E[least] < self.least else self.least_at
        least = int(np.argmin(E))
        if E[least] < self.least:
            self.least, self.least_at = float(E[least]), float(t[least])


class Kick(NamedTuple):
    """A change of velocity between two outputs: state before it, and times of the outputs around it [s]."""

    size: float
    row: int
    first: float
    last: float
    q: Array
    v: Array


class Kicks(Symptom):
    """The largest changes of velocity between two outputs, in coordinates multiplied by ``scale`` (n,)."""

    def __init__(self, scale: Array) -> None:
        self._scale = scale
        self._found: list[Kick] = []
        self._speed = 0.0
        self._row = 0  # of the first output in the tail
        self._tail: tuple[Array, Array, Array] | None = None  # the outputs that the next kick needs

    def add(self, t: Array, q: Array, v: Array) -> None:
        """Add the outputs t (N,), q, v (N, n) that follow."""
        self._speed = max(self._speed, float(np.abs(v * self._scale).max(initial=0.0)))
        if self._tail is not None:
            t, q, v = (np.concatenate([a, b]) for a, b in zip(self._tail, (t, q, v), strict=True))
        self._search(t, q, v, len(t) - 2)
        done = max(0, len(t) - 3)
        self._tail = t[done:].copy(), q[done:].copy(), v[done:].copy()
        self._row += done

    def largest(self) -> list[Kick]:
        """The kicks, in the order of their times."""
        if self._tail is not None:
            self._search(*self._tail, len(self._tail[0]) - 1)
            self._tail = None
        return sorted((x for x in self._found if x.size > KICK * self._speed), key=lambda x: x.row)

    def _search(self, t: Array, q: Array, v: Array, end: int) -> None:
        """Search the changes from outputs before ``end`` to the next ones; the first of a tail is known already."""
        begin = 0 if self._row == 0 else 1
        known = {x.row for x in self._found}
        kicks = np.abs(np.diff(v[begin : end + 1], axis=0) * self._scale).max(axis=1, initial=0.0)
        for k in np.argsort(-kicks, kind="stable")[:PLACES]:
            i = begin + int(k)
            if kicks[k] > 0.0 and self._row + i not in known:
                first, last = max(0, i - 1), min(len(t) - 1, i + 2)
                kick = Kick(float(kicks[k]), self._row + i, float(t[first]), float(t[last]), q[first], v[first])
                self._found.append(kick._replace(q=kick.q.copy(), v=kick.v.copy()))
        self._found = sorted(self._found, key=lambda x: -x.size)[:PLACES]

    def state(self) -> dict[str, Any]:
        tail = None if self._tail is None else list(self._tail)
        return {"found": [list(x) for x in self._found], "speed": self._speed, "row": self._row, "tail": tail}

    def restore(self, known: dict[str, Any]) -> None:
        self._found = [Kick(*x) for x in known["found"]]
        self._speed, self._row = float(known["speed"]), int(known["row"])
        self._tail = None if known["tail"] is None else tuple(known["tail"])
