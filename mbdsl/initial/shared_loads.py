"""Reactions of over-constrained mechanisms in space: constraints that follow from others share the load with them.

The equations of motion determine the constraint force J^T lam, but lam only up to the null space of J^T. A run leaves
out the redundant rows, whose reactions are then zero. Results have the lam of least norm instead: the smallest sum of
squares of all forces, times the mechanism's size, and torques. It depends neither on the units nor on the rows that
were left out. A mechanism whose bodies bend has other reactions: how joints share the load follows from stiffness.
"""

from __future__ import annotations

import numpy as np

from mbdsl.elements.kind import JointKind
from mbdsl.initial.dependent_rows import pose_nearby
from mbdsl.kernels.arrays import Array
from mbdsl.numerics.saddle_point import dense
from mbdsl.system.signals import values
from mbdsl.system.system import System

ZERO = 1e-7  #: part of the largest reaction, below which one that shares no load is rounding: poses hold to 1e-10


def shares(system: System, left_out: tuple[int, ...]) -> bool:
    """Whether results have the reactions of least norm.

    In the plane they are those of the run. Where forces depend on reactions, as friction does, the motion belongs to
    the reactions of the run, too.
    """
    return bool(left_out) and system.scene.spatial and not system.of_multipliers


def least(system: System, t: Array, q: Array, lam: Array, left_out: tuple[int, ...]) -> Array:
    """The multipliers (N, m + p) of least norm with the constraint forces of ``lam``, at N states."""
    found, rank = lam.copy(), lam.shape[1] - len(left_out)
    for i in np.flatnonzero(np.isfinite(lam).all(axis=1)):
        left, weight = _directions(system, t[i], q[i])
        carried = left[:, :rank]
        found[i] = carried @ (carried.T @ (weight * lam[i])) / weight
    return found


def free(system: System, t: Array, q: Array, left_out: tuple[int, ...]) -> Array:
    """Some multipliers (N, m + p) that cause no constraint force, of norm 1, at N states."""
    found = np.zeros((len(t), system.m + system.p))
    for i in range(len(t)):
        left, weight = _directions(system, t[i], q[i])
        found[i] = _free(left, weight, left_out)
        found[i] /= np.linalg.norm(found[i])
    return found


def _free(left: Array, weight: Array, left_out: tuple[int, ...]) -> Array:
    directions = left[:, len(weight) - len(left_out) :]
    return directions @ np.random.default_rng(1).normal(size=directions.shape[1]) / weight


def _directions(system: System, t: float, q: Array) -> tuple[Array, Array]:
    """Left singular vectors of the rows (as columns), largest first, and the weights of their multipliers: the size of
    the mechanism for forces, 1 for torques."""
    J = dense(system.velocity_jacobian(t, q, np.zeros(system.n)))
    of_force = (J[:, system.tables.lengths] != 0.0).any(axis=1)
    weight = np.where(of_force, system.tables.size, 1.0)
    return np.linalg.svd(J / system.tables.scale / weight[:, None])[0], weight


def undetermined(system: System, t: float, q: Array, left_out: tuple[int, ...]) -> list[str]:
    """Names of the reactions, as "pin.fz", that the equations of motion do not determine.

    A pose nearby decides: in a special pose, axes may be parallel by chance.
    """
    at_times = list(system.tables.switchable)  # rows that hold at times only say nothing about others
    if set(left_out) <= set(at_times):
        return []
    near = pose_nearby(system, t, q) if system.m else None
    q = q if near is None else near
    left, weight = _directions(system, t, q)
    some = _free(left, weight, left_out)
    some[at_times] = 0.0
    nodes, names, sizes = [], [], []
    for c in system.scene.components.values():
        if isinstance(c.kind, JointKind):
            for x in c.kind.outputs:
                if x.unit in ("N", "N.m") and (node := system.scene.signal_of(c, x.name)) is not None:
                    nodes.append(node)
                    names.append(f"{c.name}.{x.name}")
                    sizes.append(system.tables.size if x.unit == "N" else 1.0)
    rest = np.zeros((1, system.n))
    found = np.array([x[0] for x in values(system, nodes, np.array([t]), q[None], rest, some[None])]) * sizes
    return [name for name, x in zip(names, found, strict=True) if abs(x) > ZERO * np.abs(found).max()]
