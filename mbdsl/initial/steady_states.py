"""States that begin with a given derivative: ``der(x) = 0`` among the initial equations."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from mbdsl.errors import InitialisationError
from mbdsl.initial.dependent_rows import redundant_rows
from mbdsl.kernels.arrays import Array
from mbdsl.mechanism.scene import Component
from mbdsl.messages import few
from mbdsl.numerics.saddle_point import null_space
from mbdsl.system.accelerations import accelerations
from mbdsl.system.system import System

ITERATIONS = 60
#: change of the states, relative to their sizes, that ends the iteration; step of the differences
DONE, STEP = 1e-12, 1e-7
RANK = 1e-9  #: singular values of their Jacobian that are zero, relative to the largest


def steady(system: System, t: float, q: Array, v: Array) -> Array:
    """Velocities (n,) in which the states with a given derivative have the values for which they have it; of several,
    those with the smallest accelerations.

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

    def miss(x: Array) -> tuple[Array, Array]:
        """What the derivatives miss, and all accelerations."""
        there = np.array(v)
        there[own] = x
        a = accelerations(system, t, q, there, redundant)[0]
        return a[own] - given, a * system.tables.scale

    x, size = v[own], np.array([c.values["nominal"] or 1.0 for c in states])
    r, a = miss(x)
    for _ in range(ITERATIONS):
        size = np.maximum(size, np.abs(x))
        ends = [(miss(x + STEP * e), miss(x - STEP * e)) for e in np.diag(size)]
        J, A = (np.stack([(x[k] - y[k]) / (2 * STEP) for x, y in ends], axis=1) for k in (0, 1))
        step, free = _newton(J, r, A, a)
        if step is None:
            raise _not_found(states, "their derivatives do not depend on them")
        step = size * step
        if np.abs(step / size).max() <= DONE:
            return _with(v, own, x + step)
        for _ in range(30):
            there = miss(x + step)
            if np.isfinite(there[0]).all() and (free or np.linalg.norm(there[0]) < np.linalg.norm(r)):
                break
            step = 0.5 * step
        else:
            if np.abs(r).max() <= DONE * np.abs(J).max():  # rounding
                return _with(v, own, x)
            break
        x, (r, a) = x + step, there
    raise _not_found(states, "Newton's method does not converge")


def _newton(J: Array, r: Array, A: Array, a: Array) -> tuple[Array | None, bool]:
    """The step x with J x = -r, and whether others are possible; None if there is none.

    The derivative of an integrated error is zero at any value of the integral, if the motion has no error. Of several
    steps the one with the smallest accelerations a + A x is taken: that of steady motion.
    """
    try:
        return np.asarray(-np.linalg.solve(J, r), np.float64), False
    except np.linalg.LinAlgError:
        step: Array = np.asarray(-np.linalg.lstsq(J, r, rcond=RANK)[0], np.float64)
        if np.abs(J @ step + r).max() > DONE * max(1.0, np.abs(J).max()):
            return None, False
    free = null_space(J)
    return np.asarray(step - free @ np.linalg.lstsq(A @ free, a + A @ step, rcond=RANK)[0], np.float64), True


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
