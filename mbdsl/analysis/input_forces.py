"""Exact derivatives of applied forces with respect to inputs, and of signals with respect to all that they depend on.

A law s of a force acts along the gradient of its coordinate g, so that Q_u = sign g_q^T s_u.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np

from mbdsl.bodies.contract import POSITIONS
from mbdsl.elements.kind import ForceKind
from mbdsl.errors import UsageError
from mbdsl.expressions.symbolic import Expr, coordinate, diff, input_signal, leaves
from mbdsl.numerics import rotation_arrays
from mbdsl.numerics.saddle_point import Array, dense
from mbdsl.system import System
from mbdsl.system.in_space import layout_of
from mbdsl.system.signals import gradients, values
from mbdsl.system.structure import Block, law_expressions


class Derivatives(NamedTuple):
    """Values (k,) of signals, and their derivatives with respect to q, v (k, n), lam (k, m + p) and inputs (k, i)."""

    value: Array
    q: Array
    v: Array
    lam: Array
    u: Array


def signal_derivatives(
    system: System, roots: Sequence[Expr], inputs: Sequence[str], t: float, q: Array, v: Array, lam: Array
) -> Derivatives:
    """The derivatives of expressions at a state, in which inputs have their start values."""
    shape = len(roots)
    found = Derivatives(
        np.zeros(shape),
        np.zeros((shape, system.n)),
        np.zeros((shape, system.n)),
        np.zeros((shape, system.m + system.p)),
        np.zeros((shape, len(inputs))),
    )
    places: Mapping[str, int] = {name: k for k, name in enumerate(inputs)}
    at = np.array([t]), q[None], v[None], lam[None]
    for i, root in enumerate(roots):
        variables = [leaf for leaf in leaves(root) if leaf.op != "time"]
        numbers = values(system, [root, *diff(root, *variables)], *at)
        found.value[i] = numbers[0][0]
        moving = [leaf for leaf in variables if leaf.op == "coordinate"]
        _, d_q, d_v = gradients(system, moving, t, q, v)
        partial = dict(zip(variables, (float(x[0]) for x in numbers[1:]), strict=True))
        weights = np.array([partial[leaf] for leaf in moving])
        found.q[i], found.v[i] = weights @ dense(d_q), weights @ dense(d_v)
        for leaf in variables:
            if leaf.op == "multiplier":
                found.lam[i, system.tables.multipliers[leaf.value] - system.n] += partial[leaf]  # type: ignore[index]
            elif leaf.op == "input" and leaf.value in places:
                found.u[i, places[str(leaf.value)]] += partial[leaf]
    return found


def input_forces(system: System, inputs: Sequence[str], t: float, q: Array, v: Array, lam: Array) -> Array:
    """Q_u (n, i): the derivatives of the applied forces with respect to inputs.

    Raises
    ------
    UsageError
        If an input prescribes a velocity.
    """
    for c in system.scene.components.values():
        used = {leaf.value for leaf in leaves(*c.velocity_constraints) if leaf.op == "input"}
        for name in inputs:
            if name in used:
                raise UsageError(
                    f"the input `{name}` prescribes a velocity in `{c.name}`, which jumps with it",
                    hint="inputs of a linear model act by forces; choose them with `inputs`",
                )
    found = np.zeros((system.n, len(inputs)))
    system.evaluate(t, q, v, lam)
    table = system.gradient_table().copy()
    row = 0
    for block in system.tables.blocks:
        if block.role not in ("joint", "spring", "law"):
            continue
        for c in block.components:
            if block.role == "law":
                _add_laws(system, block, c, table[row : row + block.rows], inputs, (t, q, v, lam), found)
            row += block.rows
    return found


def _add_laws(system: System, block: Block, c, table: Array, inputs: Sequence[str], state: tuple, found: Array) -> None:
    """Add the part of a component whose rows of the gradient table are ``table``."""
    laws = law_expressions(c)
    wanted = [input_signal(name) for name in inputs]
    if not any(leaf in wanted for leaf in leaves(*laws)):
        return
    t, q, v, lam = state
    sign = c.kind.sign if isinstance(c.kind, ForceKind) else -1.0
    ports = [c.ports[port] for port in c.kind.ports]
    motion = np.vstack([_motion(system, name, t, q, v) for name in ports])
    slopes = signal_derivatives(system, laws, inputs, t, q, v, lam).u
    found += sign * (table[:, : layout_of(system.scene.spatial).PAIR_POSE] @ motion).T @ slopes


def _motion(system: System, name: str, t: float, q: Array, v: Array) -> Array:
    """Virtual motion of a frame by dq: (3, n) in the plane, displacement and rotation in world axes (6, n) in space."""
    if not system.scene.spatial:
        return dense(gradients(system, [coordinate(name, key) for key in POSITIONS], t, q, v)[1])
    found = np.zeros((6, system.n))
    found[:3] = dense(gradients(system, [coordinate(name, key) for key in "xyz"], t, q, v)[1])
    body = system.scene.frames[name].body
    first = system.tables.coordinates.get(body, 0) + 3
    if body in system.tables.coordinates and first in system.tables.rotations[:, 0]:
        found[3:, first : first + 3] = rotation_arrays.matrices(q[None, first : first + 3])[0]
    return found
