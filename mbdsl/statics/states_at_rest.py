"""Equilibria of models with states: f(t, q, 0, x, lam) = 0 for each state x, beside the equilibrium of forces.

In the scene of this search a state is the position of its body, where it is a velocity otherwise: the leaf vx of its
frame is replaced by x. The search for equilibria then finds states as it finds positions.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from mbdsl.errors import MbdslError
from mbdsl.expressions.symbolic import Expr, coordinate, expr, substitute
from mbdsl.initial.consistent import initial_position
from mbdsl.mechanism import graph as mechanism_graph
from mbdsl.mechanism.scene import Component, Scene
from mbdsl.numerics.saddle_point import Array, Saddle, dense, row_size
from mbdsl.system import System, build

MOST = 100  #: Newton steps
DONE = 1e-12  #: scaled change that ends them
FAR = 1e6  #: scaled change that shows that there is no solution
RANK, MISFIT = (
    1e-9,
    1e-6,
)  #: singular values that are zero, and misfit of equations that contradict each other, relative


def with_positions(scene: Scene) -> Scene:
    """The scene in which the value of each state is the position x of its body."""
    own = {coordinate(f"{c.name}.c", "vx"): coordinate(f"{c.name}.c", "x") for c in scene.states()}

    def moved(x: Any) -> Any:
        if isinstance(x, Expr):
            return substitute(x, own.get)
        return tuple(map(moved, x)) if isinstance(x, tuple) else x

    def part(c: Component) -> Component:
        values = {name: moved(x) for name, x in c.values.items()}
        rows = {key: moved(getattr(c, key)) for key in ("velocity_constraints", "friction_rows", "relations")}
        return replace(c, values=values, friction=moved(c.friction), **rows)

    return replace(
        scene,
        components={name: part(c) for name, c in scene.components.items()},
        initial=tuple(replace(x, target=moved(expr(x.target))) for x in scene.initial),
        variables={},
        steady=False,
    )


def prepared(system: System, t: float, q: Array) -> tuple[System, Array]:
    """The system of :func:`with_positions`, and the positions from which the search begins.

    ``q`` are those of bodies; states begin at their initial values, or where Newton's method leads from there.
    """
    scene = with_positions(system.scene)
    mechanism = mechanism_graph.build(scene)
    found = build(scene, mechanism, size=system.tables.size)
    bodies = system.n - system.tables.states
    start = np.append(q[:bodies], initial_position(found, mechanism, t)[bodies:])
    _scale(found, start[bodies:])
    return found, _newton(found, t, start)


def split(system: System, found: Array) -> tuple[Array, Array]:
    """q and v (n,) of the system at an equilibrium of the other one."""
    bodies, q, v = system.n - system.tables.states, found.copy(), np.zeros(system.n)
    v[bodies:], q[bodies:] = found[bodies:], 0.0
    return q, v


def _scale(system: System, x: Array) -> None:
    """Let states count relative to `nominal`, or to their values at the start."""
    from mbdsl.bodies.state import State

    states = [body for body in system.tables.models.values() if isinstance(body, State)]
    for body, value in zip(states, x, strict=True):
        body.unit = body.nominal or abs(float(value)) or 1.0
    system.tables.resize(system.tables.size)


def _newton(system: System, t: float, q: Array) -> Array:
    """The end of Newton's method from q, or q: overdamped motion may lead away from equilibria of controllers.

    Where nothing resists a motion, as a turn of a shaft whose speed is controlled, the step is the shortest one.
    """
    n, rest, scale = system.n, np.zeros(system.n), system.tables.scale
    lam, here, size = np.zeros(system.m + system.p), q, np.inf
    for _ in range(MOST):
        A = system.tangent(t, here, rest, lam, cK=1.0, cL=1.0, cP=1.0, cV=1.0)
        f, phi, _ = system.evaluate(t, here, rest, lam)
        right = np.concatenate([f, -phi, np.zeros(system.p)])
        try:
            step, more = Saddle(A[:n, :n], A[:n, n:], A[n:, :n], scale).solve(f, right[n:])
            length = float(np.abs(step * scale).max(initial=0.0))
        except (MbdslError, np.linalg.LinAlgError):
            length = np.inf
        if not length <= FAR:
            step, more = _shortest(dense(A), right, scale)
            length = float(np.abs(step * scale).max(initial=0.0))
        if not length <= FAR:
            return q
        if length <= DONE:
            return system.moved(here, step)
        part = min(1.0, 1.0 / length) if length > 0.5 * size else 1.0
        here, lam, size = system.moved(here, part * step), lam + part * more, length
    return q


def _shortest(A: Array, right: Array, scale: Array) -> tuple[Array, Array]:
    """The solution of A x = right with the least scaled x, as two parts of the size of coordinates and multipliers;
    infinite if there is none."""
    n = len(scale)
    columns = np.concatenate([1.0 / scale, np.ones(len(A) - n)])
    A = A * columns
    columns[n:] /= row_size(A[:, n:].T)
    A[:, n:] /= row_size(A[:, n:].T)
    rows = row_size(A)
    x = np.linalg.lstsq(A / rows[:, None], right / rows, rcond=RANK)[0]
    if np.abs(A @ x - right).max(initial=0.0) > MISFIT * np.abs(A * x).max(initial=0.0):
        x = np.full(len(x), np.inf)
    x = x * columns
    return x[:n], x[n:]
