"""Mirrored poses of joints in space: axes that should have the same sense have opposite ones.

A constraint a . b = 0 of two axes also holds after half a turn. If assembly ends there, it starts again from the pose
in which one of the joint's bodies has made this half turn; if that does not help, the mirrored pose is reported.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator

import numpy as np

from mbdsl.errors import InitialisationError
from mbdsl.kernels.arrays import Array
from mbdsl.numerics.saddle_point import dense
from mbdsl.system.signals import values
from mbdsl.system.system import System

#: a joint whose constraints hold in a pose that is not meant
MIRRORED = "{} is assembled in a mirrored pose: an axis of frame_a and that of frame_b have opposite senses"
MOST = 12  #: most attempts to assemble another pose


def mirrored(system: System, t: float, q: Array) -> list[str]:
    """Names of the joints whose axes have opposite senses."""
    found = {c.name: system.scene.alignment(c) for c in system.scene.components.values()}
    nodes = {name: node for name, node in found.items() if node is not None}
    rest = np.zeros((1, system.n))
    known = values(system, list(nodes.values()), np.array([t]), q[None], rest) if nodes else []
    return [name for name, value in zip(nodes, known, strict=True) if value[0] < 0.0]


def unmirrored(system: System, t: float, q: Array, assemble: Callable[[Array], Array]) -> Array:
    """A pose with fewer mirrored joints than ``q``, if there is one: ``assemble`` maps guesses to poses."""
    attempts = 0
    while bad := mirrored(system, t, q):
        for guess in _half_turns(system, t, q, bad[0]):
            attempts += 1
            if attempts > MOST:
                return q
            try:
                other = assemble(guess)
            except (InitialisationError, TimeoutError):
                continue
            if len(mirrored(system, t, other)) < len(bad):
                q = other
                break
        else:
            return q
    return q


def _half_turns(system: System, t: float, q: Array, joint: str) -> Iterator[Array]:
    """Poses in which a body of ``joint`` has turned by 180 degrees about an axis that the joint's rotations hold."""
    component, tables = system.scene.components[joint], system.tables
    J = dense(system.Phi_q(t, q))[tables.rows[joint] : tables.rows[joint] + component.kind.rows]
    for port in ("frame_b", "frame_a"):
        body = system.scene.frames[component.ports[port]].body
        if body not in tables.coordinates:
            continue
        own = tables.coordinates[body] + np.arange(3, 6)
        for row in J[~(J[:, tables.lengths] != 0.0).any(axis=1)]:
            axis = np.zeros(system.n)
            axis[own] = row[own] / np.linalg.norm(row[own])
            yield system.moved(q, np.pi * axis)
