"""Sizes of the values of states, by which their errors are divided: `nominal`, else the largest value of a run.

A state x is a velocity, and the scale of a coordinate divides its velocities as well. Therefore a state has the scale
w/X, with its size X and the largest scaled velocity w [1/s] of the bodies: it then counts as much as a velocity.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from mbdsl.bodies.state import State
from mbdsl.kernels.arrays import Array
from mbdsl.system.tables import Tables

LEAST = 1e-9  #: smallest size of a state without `nominal`, in its SI unit: smaller values are rounding
APART = 8.0  #: ratio of an estimated size to that of a run from which on the run is repeated


class Weights(NamedTuple):
    """Factors (n,) that make positions and velocities comparable, and the largest scaled velocity of bodies [1/s].

    The factors of velocities are to be divided by the latter. Integrals of states do not count.
    """

    q: Array
    v: Array
    speed: float


def weights(tables: Tables, v: Array, span: float) -> Weights:
    """The weights for a motion with velocities v (N, n) that takes ``span`` [s]."""
    scale, bodies = tables.scale, tables.n - tables.states
    speed = _fastest(scale[:bodies], v[:, :bodies], span)
    if not tables.states:
        return Weights(scale, scale, speed)
    q, own = scale.copy(), scale.copy()
    q[bodies:], own[bodies:] = 0.0, speed / _largest(tables, v)
    return Weights(q, own, speed)


def estimate(tables: Tables, v: Array, a: Array, span: float) -> None:
    """Set the scales of the states from velocities and accelerations (n,) at the start of a run."""
    if not tables.states:
        return
    scale, bodies = tables.scale, tables.n - tables.states
    pace = float(np.abs(a * scale)[:bodies].max(initial=0.0)) ** 0.5
    rate = max(_fastest(scale[:bodies], v[None, :bodies], span), pace)
    sizes = np.maximum(np.abs(v[bodies:]), np.abs(a[bodies:]) / rate)
    _set(tables, _given(tables, np.where(sizes > LEAST, sizes, 1.0)), rate)  # a state that begins at rest and at zero


def measured(tables: Tables, v: Array, span: float) -> bool:
    """Set the scales of the states by the velocities v (N, n) of a run; whether they were far from it."""
    if not tables.states:
        return False
    before, bodies = tables.scale[tables.n - tables.states :].copy(), tables.n - tables.states
    _set(tables, _largest(tables, v), _fastest(tables.scale[:bodies], v[:, :bodies], span))
    ratio = tables.scale[bodies:] / before
    return bool(((ratio > APART) | (ratio < 1.0 / APART)).any())


def _fastest(scale: Array, v: Array, span: float) -> float:
    return max(float(np.abs(v * scale).max(initial=0.0)), 1.0 / span if span > 0.0 else 1.0)


def _models(tables: Tables) -> list[State]:
    return [body for body in tables.models.values() if isinstance(body, State)]


def _given(tables: Tables, sizes: Array) -> Array:
    """The sizes, and `nominal` where it is given."""
    return np.array([x.nominal or size for x, size in zip(_models(tables), sizes, strict=True)])


def _largest(tables: Tables, v: Array) -> Array:
    """The sizes of the states in velocities v (N, n)."""
    return _given(tables, np.maximum(np.abs(v[:, tables.n - tables.states :]).max(axis=0, initial=0.0), LEAST))


def _set(tables: Tables, sizes: Array, rate: float) -> None:
    for body, size in zip(_models(tables), sizes, strict=True):
        body.unit = size / rate
    tables.resize(tables.size)
