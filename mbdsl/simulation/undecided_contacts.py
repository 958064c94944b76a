"""Contacts that a run touches or misses by less than its error.

If a path turns back at a distance from a stop that is smaller than its error, runs with different tolerances may agree
with each other and all miss a stop that the motion touches. The distance d of each close approach
(:mod:`mbdsl.system.close_approaches`) is compared with that in the run before; the difference e estimates its error. An
approach that the run before does not have is at most as uncertain as the states of the two runs differ. If d is not
larger, the contact is undecided, and the change of velocity that it can cause bounds the error:

    min(|da| T, |da|/|dg| 2 sqrt(2 c p)),   T = 2 sqrt(2 p/c), p = |d| + e,

where c is the curvature of the approach, da the change of the accelerations by the condition at the depth p, T the
duration of the contact, and dg the acceleration that da gives to the argument. The second bound applies to a stop that
returns the whole velocity of the path at d = 0; conditions on velocities and reactions have the first bound only.
"""

from __future__ import annotations

from bisect import bisect_left, bisect_right
from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np

from mbdsl.errors import InitialisationError
from mbdsl.expressions.derivatives import diff
from mbdsl.expressions.symbolic import Expr, leaves
from mbdsl.integrators import Run
from mbdsl.kernels.arrays import Array
from mbdsl.numerics.saddle_point import dense
from mbdsl.simulation.calibration_runs import Trial
from mbdsl.simulation.part_run import PartRun
from mbdsl.system import System
from mbdsl.system.accelerations import accelerations, equations, solve_motion
from mbdsl.system.close_approaches import Approach, Approaches, of_positions
from mbdsl.system.signals import gradients, values

#: factor by which a distance has to exceed the difference of two runs
MARGIN = 2.0
#: the same approach of two runs takes place within this part of the run
TOGETHER = 0.01
#: most contacts for which the effect is computed
MOST = 100
#: where accelerations are compared: twice on the side of the path, once behind zero, in depths
PLACES = 2.0, 1.0, -1.0


class Undecided(NamedTuple):
    """A contact at ``time`` [s] that may or may not take place, and its ``effect`` in the norm of
    :mod:`mbdsl.numerics.error_norm`."""

    time: float
    effect: float


def undecided(
    run: Run,
    before: Run,
    left_out: tuple[int, ...],
    speed: float,
    span: float,
    apart: Callable[[float], float] = lambda t: np.inf,
) -> list[Undecided]:
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
    apart : function of time [s]
        The largest difference between the states of both runs up to a time, in the norm of
        :mod:`mbdsl.numerics.error_norm`.
    """
    present: Sequence[Approach] = getattr(run, "approaches", ())
    former = sorted(getattr(before, "approaches", ()), key=lambda y: y.t)
    times = [y.t for y in former]
    found = []
    for x in present:
        some = former[bisect_left(times, x.t - TOGETHER * span) : bisect_right(times, x.t + TOGETHER * span)]
        near = [abs(x.d - y.d) for y in some if (x.number, x.side) == (y.number, y.side)]
        e = (min(near) if near else min(2.0 * abs(x.d), _sensitivity(run.system, x, speed) * apart(x.t))) + x.error
        if abs(x.d) <= MARGIN * e:
            found.append((x, abs(x.d) + e))
    found.sort(key=lambda pair: -pair[1] * pair[0].curvature)
    system = run.system
    return [Undecided(x.t, _effect(system, x, depth, left_out) / speed) for x, depth in found[:MOST]]


def undecided_effect(parts: Sequence[PartRun], last: Trial, before: Trial, speed: float, span: float) -> Array:
    """The effect (N,) of contacts that two calibration runs leave undecided, up to each time of the last one."""
    effect = np.zeros(len(last.t))

    def apart(t: float) -> float:
        at = int(np.searchsorted(last.t, t))  # the first output behind it, which a difference there has reached
        return float(last.difference[at]) if at < len(last.difference) else np.inf

    for part, run, other in zip(parts, last.kept.integrations, before.kept.integrations, strict=True):
        for x in undecided(run, other, part.initial.redundant, speed, span, apart):
            later = last.t >= x.time
            effect[later] = np.maximum(effect[later], x.effect)
    return effect


def _effect(system: System, x: Approach, depth: float, left_out: tuple[int, ...]) -> float:
    """The largest scaled change of a velocity that a contact of this depth causes [1/s]."""
    if x.number in system.kept(Approaches).of_events or not np.isfinite(depth):
        return np.inf  # what a when-equation does has no bound
    if (contact := system.kept(Approaches).contacts.get(x.number)) is not None:
        return _strike(system, x, system.tables.rows[contact.name], depth, left_out)
    scale, (q, v), argument = system.tables.scale, np.array(x.state).reshape(2, -1), _argument(system, x)
    positions = of_positions(argument)
    g_q = np.zeros(system.n)
    try:
        if any(leaf.op == "multiplier" for leaf in leaves(argument)):
            there = _with_reactions(system, argument, x, q, v, depth, left_out)
        else:
            g, *by = gradients(system, [argument], x.t, q, v)
            g_q = dense(by[0 if positions else 1]).ravel()
            J = dense(system.Phi_q(x.t, q) if positions else system.velocity_jacobian(x.t, q, v)) / scale
            rows = np.vstack([J, g_q / scale])
            way = np.zeros(len(rows))
            way[-1] = 1.0
            unit = np.linalg.lstsq(rows, way, rcond=1e-9)[0] / scale  # changes g by 1 and keeps the constraints
            shifts = [(x.side * depth * k - g[0]) * unit for k in PLACES]
            if positions:
                there = [accelerations(system, x.t, q + shift, v, left_out)[0] for shift in shifts]
            else:
                there = [accelerations(system, x.t, q, v + shift, left_out)[0] for shift in shifts]
    except InitialisationError:
        return np.inf
    # the change by the condition: smooth forces are nearly linear, and sign(g) has a third value at zero
    change = there[2] - 3.0 * there[1] + 2.0 * there[0]
    size, along = float(np.abs(scale * change).max(initial=0.0)), abs(float(g_q @ change))
    if size == 0.0:
        return 0.0
    duration = 2.0 * np.sqrt(2.0 * depth / x.curvature)
    rebound = 2.0 * np.sqrt(2.0 * x.curvature * depth)
    return size * min(duration, rebound / along if positions and along > 0.0 else np.inf)


def _strike(system: System, x: Approach, row: int, depth: float, left_out: tuple[int, ...]) -> float:
    """The largest scaled change of a velocity by an impact of a rigid contact, which may return the whole velocity of
    the path at d = 0 [1/s]."""
    n, (q, v) = system.n, np.array(x.state).reshape(2, -1)
    matrix = dense(system.tangent(x.t, q, v, cM=1.0, cP=1.0, cV=1.0))
    others = [n + k for k in {*left_out, *(k for rows in system.tables.contact_rows for k in rows)}]
    kept = np.setdiff1d(np.arange(system.unknowns), others)
    W, right = matrix[n + row, :n], np.zeros(len(kept))
    right[:n] = W
    X = np.linalg.lstsq(matrix[np.ix_(kept, kept)], right, rcond=None)[0][:n]
    speed = np.sqrt(2.0 * x.curvature * depth)
    return 2.0 * float(speed * np.abs(system.tables.scale * X).max() / max(float(W @ X), 1e-300))


def _sensitivity(system: System, x: Approach, speed: float) -> float:
    """The largest difference of the argument between two states whose difference is 1 in the norm; infinite if it
    depends on reactions."""
    argument = _argument(system, x)
    if any(leaf.op == "multiplier" for leaf in leaves(argument)):
        return np.inf
    q, v = np.array(x.state).reshape(2, -1)
    _, by_q, by_v = gradients(system, [argument], x.t, q, v)
    by_q, by_v = (np.abs(dense(by)).ravel() / system.tables.scale for by in (by_q, by_v))
    return float(by_q.sum() + speed * by_v.sum())


def _argument(system: System, x: Approach) -> Expr:
    return system.kept(Approaches).arguments[x.number]


def _with_reactions(
    system: System, argument: Expr, x: Approach, q: Array, v: Array, depth: float, left_out: tuple[int, ...]
) -> list[Array]:
    """Accelerations (n,) with reactions in the laws for which the argument is PLACES times ``depth`` on its side."""
    lam = accelerations(system, x.t, q, v, left_out)[1]
    reactions = [leaf for leaf in leaves(argument) if leaf.op == "multiplier"]
    one = np.array([x.t]), q[None], v[None], lam[None]
    g, *by = (float(y[0]) for y in values(system, [argument, *diff(argument, *reactions)], *one))
    at = [system.tables.multipliers[leaf.value] - system.n for leaf in reactions]
    unit = np.zeros(len(lam))
    np.add.at(unit, at, np.array(by) / max(float(np.square(by).sum()), 1e-300))
    motion = equations(system, x.t, q, v, left_out)
    return [solve_motion(system, motion, lam + (x.side * depth * k - g) * unit)[0] for k in PLACES]
