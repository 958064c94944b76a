"""Velocities at the start: fixed values exactly, then the given ones, then those nearest to rest."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from mbdsl.errors import InitialisationError
from mbdsl.initial.contradictions import inconsistent
from mbdsl.initial.dependent_rows import without_units
from mbdsl.initial.in_plane import PlanarUnknowns
from mbdsl.initial.least_steps import constrained, stack, stacked, velocity_residual
from mbdsl.initial.undeformed import AsIs, Undeformed
from mbdsl.initial.weights import Metric
from mbdsl.kernels.arrays import Array
from mbdsl.mechanism.scene import InitialValue
from mbdsl.numerics.saddle_point import dense, least_squares, scaled
from mbdsl.system.signals import Matrix
from mbdsl.system.system import System

Shape = AsIs | PlanarUnknowns | Undeformed

FIRST_OF_ALL = 1e-6  #: weight of rest while given velocities are met as well as possible
KEPT = 1e-9  #: change of a given velocity, relative to the largest, that is rounding
LIGHTEST = 1e-6  #: least effective mass of a given velocity, relative to the largest


class _WantedVelocity(NamedTuple):
    """Velocities with the values that they should have."""

    items: list[InitialValue]
    values: Array


def velocities(
    system: System, t: float, q: Array, y: Array, shape: Shape, given: list[InitialValue], metric: Metric
) -> Array:
    """The velocities (n,): fixed values exactly, then the given ones, then those nearest to rest.

    Given values that agree with each other and with the constraints are kept. If they do not, they change as by an
    impulse: the sum of m (v - given)^2 is least, with the effective mass m of each given velocity.

    Raises
    ------
    InitialisationError
        If no velocities satisfy the constraints and fixed values; it names them.
    """
    fixed, soft = (_WantedVelocity(x, np.array([i.value for i in x])) for x in _parted(given))
    pose = _Pose(system, t, q, y, shape, metric)
    if not soft.items or len(soft.items) >= len(y):
        return pose.nearest_rates(fixed, soft)
    v = pose.nearest_rates(fixed, soft, FIRST_OF_ALL)
    reached = stack(system, soft.items, t, q, v)[0]
    size = np.abs([*soft.values, *reached]).max(initial=0.0)
    reached = np.where(np.abs(reached - soft.values) <= KEPT * size, soft.values, reached)
    every = _WantedVelocity([*fixed.items, *soft.items], np.append(fixed.values, reached))
    return pose.nearest_rates(every, _WantedVelocity([], np.empty(0)))


def _parted(given: list[InitialValue]) -> tuple[list[InitialValue], list[InitialValue]]:
    return [x for x in given if x.fixed], [x for x in given if not x.fixed]


class _Pose:
    """An assembled pose, whose rates are sought: w, of the unknowns y, in the mechanism's size and in radians."""

    def __init__(self, system: System, t: float, q: Array, y: Array, shape: Shape, metric: Metric) -> None:
        self.system, self.t, self.q, self.y, self.shape, self.metric = system, t, q, y, shape, metric
        self.scale = shape.scale

    def nearest_rates(self, fixed: _WantedVelocity, soft: _WantedVelocity, rest: float = 1.0) -> Array:
        """Velocities (n,) with ``fixed`` values, nearest to ``soft`` values and, with the weight ``rest``, to rest."""
        system, t, q, y, shape, scale = self.system, self.t, self.q, self.y, self.shape, self.scale
        w = np.zeros(len(y))
        complete = len(soft.items) >= len(y)  # the state of another run: nothing remains to be nearest to rest
        driven = not complete and bool(velocity_residual(system, t, q, np.zeros(system.n)).any())
        metric = self.metric.relative() if driven else self.metric
        weight, asked, near = rest * shape.weights(metric.weight), 0.0, np.zeros(len(y))
        at_rest, rates = metric.velocities_at(t, q)  # linear in v
        R = rest * scaled(shape.reduce(y, rates, q), np.ones(len(at_rest)), 1.0 / scale)
        masses: Array | None = None
        for k in range(20 if system.p else 3):  # mostly linear in v: the second pass refines, the third confirms
            v = shape.rates(y, w / scale, q)
            soft_value, _q, soft_v = stack(system, soft.items, t, q, v)
            r_s = soft_value - soft.values
            J, r_c = self._constraints(v, fixed)
            if not r_c.any() and not r_s.any():
                return v  # at rest, as intended
            if not _finite(J, r_c):
                if k or not (fixed.items or soft.items):
                    raise self._not_finite(v)
                w = self._as_given(v, fixed, soft_v, r_s)  # sqrt(v^2) has no derivative at rest
                continue
            if masses is None and soft.items:
                masses = np.sqrt(_effective_masses(system, t, q, soft_v))
            J, r_c = without_units(shape.reduce(y, J, q), r_c, scale)
            S, r_s = without_units(shape.reduce(y, soft_v, q), r_s, scale)
            if masses is not None:
                S, r_s = scaled(S, masses, np.ones(len(y))), masses * r_s
            asked = max(asked, np.abs(r_c).max(initial=0.0))
            S, r_s = stacked(S, R), np.append(r_s, rest * (at_rest + rates @ v))
            step = constrained(weight, weight * (w - near), S, r_s, J, r_c)
            w = w + step
            if driven or complete:  # not nearest to rest in the world
                near = w
            if np.abs(step).max(initial=0.0) <= 1e-15 * np.abs(w).max(initial=0.0):
                break
        return self._checked(w, fixed, asked)

    def _constraints(self, v: Array, fixed: _WantedVelocity) -> tuple[Matrix, Array]:
        """Jacobian with respect to v, and residual, of the constraints and of fixed values."""
        value, _q, d_v = stack(self.system, fixed.items, self.t, self.q, v)
        r = np.concatenate([velocity_residual(self.system, self.t, self.q, v), value - fixed.values])
        return stacked(self.system.velocity_jacobian(self.t, self.q, v), d_v), r

    def _as_given(self, v: Array, fixed: _WantedVelocity, soft_v: Matrix, r_s: Array) -> Array:
        """The rates w nearest to all given values, without the constraints."""
        value, _q, d_v = stack(self.system, fixed.items, self.t, self.q, v)
        J, r = stacked(soft_v, d_v), np.concatenate([r_s, value - fixed.values])
        J, r = without_units(self.shape.reduce(self.y, J, self.q), r, self.scale)
        return least_squares(dense(J), -r)

    def _not_finite(self, v: Array) -> InitialisationError:
        bad = np.flatnonzero(~np.isfinite(velocity_residual(self.system, self.t, self.q, v)))
        names = [self.system.constraint_names()[k] for k in bad[:3]]
        return InitialisationError(
            f"the constraints are not finite numbers in the initial pose{': ' * bool(names)}{', '.join(names)}",
            hint="give initial values that lead to another pose; a rolling disc, for example, must not lie flat",
        )

    def _checked(self, w: Array, fixed: _WantedVelocity, asked: float) -> Array:
        """The velocities (n,) of the rates w, if they satisfy the constraints and fixed values."""
        v = self.shape.rates(self.y, w / self.scale, self.q)
        J, r_c = self._constraints(v, fixed)
        _, r_c = without_units(self.shape.reduce(self.y, J, self.q), r_c, self.scale)
        if np.abs(r_c).max(initial=0.0) > 1e-9 * max(asked, np.abs(w).max(initial=0.0)):
            raise inconsistent(self.system, self.t, self.q, [x for x in fixed.items if x.fixed], velocity=v)
        return v


def _finite(J: Matrix, r: Array) -> bool:
    return bool(np.isfinite(r).all() and np.isfinite(J if isinstance(J, np.ndarray) else J.data).all())


def _effective_masses(system: System, t: float, q: Array, rows: Matrix) -> Array:
    """1/(g M^{-1} g^T) of each row g of ``rows`` (k, n), relative to the largest and at least ``LIGHTEST``."""
    found = np.array([1.0 / max(g @ system.solve_mass(t, q, g), 1e-300) for g in np.atleast_2d(dense(rows))])
    return np.clip(found / found.max(initial=1e-300), LIGHTEST, 1.0)
