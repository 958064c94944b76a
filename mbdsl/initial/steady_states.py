"""States that begin with a given derivative: ``der(x) = 0`` among the initial equations."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from mbdsl.errors import InitialisationError
from mbdsl.initial.dependent_rows import redundant_rows
from mbdsl.kernels.arrays import Array
from mbdsl.mechanism.scene import Component
from mbdsl.messages import few
from mbdsl.system.accelerations import accelerations
from mbdsl.system.system import System

ITERATIONS = 60
#: change of the states, relative to their sizes, that ends the iteration; step of the differences
DONE, STEP = 1e-12, 1e-7


def steady(system: System, t: float, q: Array, v: Array) -> Array:
    """Velocities (n,) in which the states with a given derivative have the values for which they have it.

    The derivatives may depend on reactions; therefore their Jacobian follows from differences of accelerations.

    Raises
    ------
    InitialisationError
        If no such values are found; it names the states.
    """
    states = [c for c in system.scene.states() if c.values["rate"] is not None]
    if not states:
        return v
    own = np.array([system.tables.coordinates[c.name] for c in states])
    given = np.array([c.values["rate"] for c in states])
    redundant = redundant_rows(system, t, q, v)

    def miss(x: Array) -> Array:
        there = np.array(v)
        there[own] = x
        return accelerations(system, t, q, there, redundant)[0][own] - given

    x, size = v[own], np.array([c.values["nominal"] or 1.0 for c in states])
    r = miss(x)
    for _ in range(ITERATIONS):
        size = np.maximum(size, np.abs(x))
        J = np.stack([(miss(x + STEP * e) - miss(x - STEP * e)) / (2 * STEP) for e in np.diag(size)], axis=1)
        try:
            step = -size * np.linalg.solve(J, r)
        except np.linalg.LinAlgError:
            raise _not_found(states, "their derivatives do not depend on them") from None
        if np.abs(step / size).max() <= DONE:
            return _with(v, own, x + step)
        for _ in range(30):
            there = miss(x + step)
            if np.isfinite(there).all() and np.linalg.norm(there) < np.linalg.norm(r):
                break
            step = 0.5 * step
        else:
            if np.abs(r).max() <= DONE * np.abs(J).max():  # rounding
                return _with(v, own, x)
            break
        x, r = x + step, there
    raise _not_found(states, "Newton's method does not converge")


def _with(v: Array, own: NDArray[np.intp], x: Array) -> Array:
    found = np.array(v)
    found[own] = x
    return found


def _not_found(states: list[Component], why: str) -> InitialisationError:
    names = few([f"der({c.name}) = {c.values['rate']:g}" for c in states])
    return InitialisationError(
        f"no initial values of states found for which {names}: {why}",
        span=states[0].span,
        hint="give a start near the value, `Real x(start = ...)`, or the value itself under `initial equation`",
    )
