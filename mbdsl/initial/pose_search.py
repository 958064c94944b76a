"""The search for a pose: fixed values are kept exactly, guesses and coordinates without an initial value change least.

    min 1/2 |W (q - g)|^2   subject to   Phi(q, t0) = 0,  sigma_fixed(q) = its value

by Gauss-Newton steps with the constraints linearised, damped while far from a solution.
"""

from __future__ import annotations

from time import process_time
from typing import NamedTuple

import numpy as np

from mbdsl.initial.contradictions import inconsistent
from mbdsl.initial.dependent_rows import without_units
from mbdsl.initial.in_plane import PlanarUnknowns
from mbdsl.initial.least_steps import constrained, damped, misses, stack, stacked
from mbdsl.initial.undeformed import AsIs, Undeformed
from mbdsl.initial.weights import Metric
from mbdsl.kernels.arrays import Array
from mbdsl.mechanism.scene import InitialValue
from mbdsl.numerics.saddle_point import scaled
from mbdsl.system.signals import Matrix
from mbdsl.system.system import System

Shape = AsIs | PlanarUnknowns | Undeformed

ATTEMPTS, STEPS, DAMPED = 6, 160, 80  #: attempts; steps of each; of them, those that are damped if necessary
LONGEST = 0.5  #: largest change of an angle in one iteration [rad]
FAR = 1e-2  #: violation of the constraints, in the size of the mechanism, that is not that of a pose near a solution


class Task(NamedTuple):
    """What is assembled: a System at a time t, with the initial values of positions, until a time of the processor."""

    system: System
    t: float
    given: list[InitialValue]
    metric: Metric
    until: float = np.inf


class _Linearised(NamedTuple):
    """The constraints with fixed values, and the soft values, at some unknowns: Jacobians and residuals."""

    q: Array
    J: Matrix
    r_c: Array
    S: Matrix
    r_s: Array


def nearest_pose(task: Task, shape: Shape, nearest: bool = True) -> Array:
    """The y of ``shape`` for the pose, the ``nearest`` to the guess or one that is found by the smallest steps.

    Raises
    ------
    TimeoutError
        If none was found in time; its argument is the InitialisationError of the best one.
    InitialisationError
        If no pose satisfies the constraints and fixed values, or none was found.
    """
    search = _Search(task, shape, nearest)
    rng = None  # imported late, because numpy loads its generators on first use
    for attempt in range(ATTEMPTS):
        y = shape.start
        if attempt:  # at a singular pose there is no direction of descent: later attempts start near it
            rng = rng or np.random.default_rng(0)
            y = shape.moved(y, rng.normal(size=len(y)) * 0.1 * attempt / shape.scale)
        found = search.descend(y, again=attempt > 0)
        if found is not None:
            return found
    if nearest and isinstance(shape, AsIs) and task.system.scene.spatial:
        # The rotation from the guess is not linear: Gauss-Newton steps may not converge if the guess is far from all
        # poses. Steps that only close the joints end at a pose that is near, but not the nearest.
        return nearest_pose(task._replace(given=search.fixed), shape, nearest=False)
    raise inconsistent(task.system, task.t, shape.expand(search.best), search.fixed, velocity=None)


class _Search:
    """Gauss-Newton steps from several starts, and the best pose so far."""

    def __init__(self, task: Task, shape: Shape, nearest: bool) -> None:
        self.task, self.shape, self.nearest = task, shape, nearest
        self.fixed = [x for x in task.given if x.fixed]
        self.soft = [x for x in task.given if not x.fixed]
        self.weight = shape.weights(task.metric.weight)
        self.tolerance = 1e-13 * (1.0 + np.abs(shape.start * shape.scale).max(initial=0.0))
        self.best, self.least = shape.start, np.inf
        self.members, _d = task.metric.positions_at(task.t, shape.expand(shape.start))

    def descend(self, y: Array, again: bool) -> Array | None:
        """The y of a pose, by steps from y; None if they do not lead to one."""
        shape, scale, tolerance = self.shape, self.shape.scale, self.tolerance
        shape.begin()
        violation = np.inf
        for k in range(STEPS):
            if process_time() > self.task.until:
                return self._in_time()
            at = self._linearised(y)
            violation = np.abs(at.r_c).max(initial=0.0)
            if y is shape.start and max(violation, np.abs(at.r_s).max(initial=0.0)) <= tolerance:
                return y  # assembled at the initial guess: no solution is nearer
            if violation < self.least:
                self.best, self.least = y, violation
            # Damped while the violation is large, then plain Gauss-Newton: the remaining violation may be that of a
            # solution at a dead centre, to which damped steps do not converge.
            step = self._step(y, at, plain=k >= DAMPED or violation < 1e-6)
            if not np.isfinite(step).all():
                break
            turn = np.abs(step[shape.angles]).max(initial=0.0)
            y = shape.moved(y, step * min(1.0, LONGEST / max(turn, 1e-300)))
            if np.abs(step * scale).max(initial=0.0) <= 10.0 * tolerance:
                if violation <= tolerance:
                    return y
                if k >= DAMPED and violation > 1e3 * tolerance:
                    break  # the constraints contradict each other: this is the nearest compromise
            if k == DAMPED and again and violation > FAR and self.task.system.scene.spatial:
                break  # plain steps converge near a solution only; in space they take long
        return y if violation <= 1e3 * tolerance else None

    def _linearised(self, y: Array) -> _Linearised:
        system, t, shape = self.task.system, self.task.t, self.shape
        q, at_rest = shape.expand(y), np.zeros(system.n)
        value, d_q, _v = stack(system, self.fixed, t, q, at_rest)
        r_c = np.concatenate([system.Phi(t, q), misses(value, self.fixed)])
        if system.tables.angles:
            system.count_angles()  # from iterate to iterate, which are less than half a turn apart
        soft_value, soft_q, _v = stack(system, self.soft, t, q, at_rest)
        r_s = misses(soft_value, self.soft)
        J, r_c = without_units(shape.reduce(y, stacked(system.Phi_q(t, q), d_q)), r_c, shape.scale)
        S, r_s = without_units(shape.reduce(y, soft_q), r_s, shape.scale)
        return _Linearised(q, J, r_c, S, r_s)

    def _step(self, y: Array, at: _Linearised, plain: bool) -> Array:
        """The change of y."""
        shape, scale = self.shape, self.shape.scale
        value, d_q = self.task.metric.positions_at(self.task.t, at.q)
        d_y = scaled(shape.reduce(y, d_q), np.ones(len(value)), 1.0 / scale)
        S, r_s = stacked(at.S, d_y), np.concatenate([at.r_s, value - self.members])
        away = self.weight * shape.difference(y, shape.start) * scale if self.nearest else np.zeros(len(y))
        solve = constrained if plain else damped
        return solve(self.weight, away, S, r_s, at.J, at.r_c) / scale

    def _in_time(self) -> Array:
        """The best pose when the time has ended."""
        if self.least <= self.tolerance:
            return self.best
        system, t = self.task.system, self.task.t
        raise TimeoutError(inconsistent(system, t, self.shape.expand(self.best), self.fixed, None, interrupted=True))
