"""Contacts that a run touches or misses by less than its error.

If a path turns back at a distance from a stop that is smaller than its error, runs with different tolerances may agree
with each other and all miss a stop that the motion touches. The distance d of each close approach
(:mod:`mbdsl.system.close_approaches`) is compared with that in the run before; the difference e estimates its error. If
d is not larger, the contact is undecided, and the change of velocity that it can cause bounds the error:

    min(|da| T, |da|/|dg| 2 sqrt(2 c p)),   T = 2 sqrt(2 p/c), p = |d| + e,

where c is the curvature of the approach, da the change of the accelerations by the condition at the depth p, T the
duration of the contact, and dg the acceleration that da gives to the argument. The second bound applies to a stop that
returns the whole velocity of the path at d = 0.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from mbdsl.errors import InitialisationError
from mbdsl.integrators import Run
from mbdsl.system import System
from mbdsl.system.accelerations import accelerations
from mbdsl.system.close_approaches import Approach, Approaches
from mbdsl.system.signals import gradients

Array = NDArray[np.float64]

#: factor by which a distance has to exceed the difference of two runs
MARGIN = 2.0
#: the same approach of two runs takes place within this part of the run
TOGETHER = 0.01
#: most contacts for which the effect is computed
MOST = 100


class Undecided(NamedTuple):
    """A contact at ``time`` [s] that may or may not take place, and its ``effect`` in the norm of
    :mod:`mbdsl.numerics.error_norm`."""

    time: float
    effect: float


def undecided(run: Run, before: Run, left_out: tuple[int, ...], speed: float, span: float) -> list[Undecided]:
    """The undecided contacts of a run, by comparison with the run before.

    Parameters
    ----------
    run, before : Run
        Runs of the same system, ``before`` with the larger tolerance.
    left_out : tuple of int
        Redundant constraints.
    speed : float [1/s]
        The largest scaled velocity.
    span : float [s]
        The duration of the run.
    """
    present: Sequence[Approach] = getattr(run, "approaches", ())
    former: Sequence[Approach] = getattr(before, "approaches", ())
    found = []
    for x in present:
        near = [abs(x.d - y.d) for y in former if _same(x, y, span)]
        e = min(near, default=2.0 * abs(x.d)) + x.error
        if abs(x.d) <= MARGIN * e:
            found.append((x, abs(x.d) + e))
    found.sort(key=lambda pair: -pair[1] * pair[0].curvature)
    system = run.system
    return [Undecided(x.t, _effect(system, x, depth, left_out) / speed) for x, depth in found[:MOST]]


def _same(x: Approach, y: Approach, span: float) -> bool:
    return (x.number, x.side) == (y.number, y.side) and abs(x.t - y.t) <= TOGETHER * span


def _effect(system: System, x: Approach, depth: float, left_out: tuple[int, ...]) -> float:
    """The largest scaled change of a velocity that a contact of this depth causes [1/s]."""
    scale, (q, v) = system.tables.scale, np.array(x.state).reshape(2, -1)
    g, g_q, _ = gradients(system, system.kept(Approaches).arguments[x.number : x.number + 1], x.t, q, v)
    g_q = g_q.ravel() if isinstance(g_q, np.ndarray) else g_q.toarray().ravel()
    J = system.Phi_q(x.t, q)
    J = (J if isinstance(J, np.ndarray) else J.toarray()) / scale
    rows = np.vstack([J, g_q / scale])
    way = np.zeros(len(rows))
    way[-1] = 1.0
    unit = np.linalg.lstsq(rows, way, rcond=1e-9)[0] / scale  # the shift that changes g by 1 and keeps the constraints
    try:
        there = [
            accelerations(system, x.t, q + (to - g[0]) * unit, v, left_out)[0]
            for to in (x.side * depth, 0.0, -x.side * depth)
        ]
    except InitialisationError:
        return np.inf
    change = there[2] - 2.0 * there[1] + there[0]  # the change by the condition: smooth forces are nearly linear
    size, along = float(np.abs(scale * change).max(initial=0.0)), abs(float(g_q @ change))
    if size == 0.0:
        return 0.0
    duration = 2.0 * np.sqrt(2.0 * depth / x.curvature)
    rebound = 2.0 * np.sqrt(2.0 * x.curvature * depth)
    return size * min(duration, rebound / along if along > 0.0 else np.inf)
