"""Exact derivatives of applied forces with respect to inputs, and of signals with respect to all that they depend on.

A law s of a force acts along the gradient of its coordinate g, so that Q_u = sign g_q^T s_u.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import NamedTuple

import numpy as np

from mbdsl.bodies.contract import POSITIONS
from mbdsl.elements.kind import ForceKind
from mbdsl.expressions.derivatives import diff
from mbdsl.expressions.symbolic import Expr, coordinate, input_signal, leaves
from mbdsl.kernels.columns import columns_of
from mbdsl.mechanism.scene import Component
from mbdsl.numerics import rotation_arrays
from mbdsl.numerics.saddle_point import Array, dense
from mbdsl.system import System
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
                found.lam[i, system.tables.multipliers[leaf.value] - system.n] += partial[leaf]
            elif leaf.op == "input" and leaf.value in places:
                found.u[i, places[str(leaf.value)]] += partial[leaf]
    return found


def input_forces(system: System, inputs: Sequence[str], t: float, q: Array, v: Array, lam: Array) -> Array:
    """Q_u (n, i): the derivatives of the applied forces with respect to inputs."""
    found = np.zeros((system.n, len(inputs)))
    wanted = [input_signal(name) for name in inputs]
    for block, c, table in _tables(system, t, q, v, lam):
        if block.role != "law" or not any(leaf in wanted for leaf in leaves(*law_expressions(c))):
            continue
        sign = c.kind.sign if isinstance(c.kind, ForceKind) else -1.0
        slopes = signal_derivatives(system, law_expressions(c), inputs, t, q, v, lam).u
        found += sign * _directions(system, c, table, t, q, v).T @ slopes
    return found


def forces_of(system: System, c: Component, place: int, t: float, q: Array, v: Array, lam: Array) -> Array:
    """The generalised forces (n,) of a unit of the magnitude s of a force element in row ``place``."""
    table = next(table for _, other, table in _tables(system, t, q, v, lam) if other is c)
    return np.asarray(c.kind.sign * _directions(system, c, table, t, q, v)[place])  # type: ignore[attr-defined]


def _tables(system: System, t: float, q: Array, v: Array, lam: Array) -> Iterator[tuple[Block, Component, Array]]:
    """The rows of the gradient table of all components."""
    system.evaluate(t, q, v, lam)
    table, row = system.gradient_table().copy(), 0
    for block in system.tables.blocks:
        for c in block.components if block.role in ("joint", "spring", "law") else ():
            yield block, c, table[row : row + block.rows]
            row += block.rows


def _directions(system: System, c: Component, table: Array, t: float, q: Array, v: Array) -> Array:
    """The derivatives (rows, n) of the coordinates g of a component whose rows of the gradient table are ``table``."""
    motion = np.vstack([_motion(system, c.ports[port], t, q, v) for port in c.kind.ports])
    return np.asarray(table[:, : columns_of(system.scene.spatial).PAIR_POSE] @ motion)


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
