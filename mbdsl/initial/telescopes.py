"""Telescopic legs: of two assemblies, the one in which the parts of a leg point at each other's end.

A leg of two parts that slide on each other, between hinges or balls, reaches its ends with s > 0, or turned round with
both parts pointing away and a large s < 0. Where the model gives no position, the first one is meant.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from mbdsl.elements.kind import JointKind
from mbdsl.expressions.symbolic import Expr, coordinate, leaves
from mbdsl.kernels.arrays import Array
from mbdsl.numerics.rotation_arrays import matrices
from mbdsl.system.signals import values
from mbdsl.system.system import System

TAKEN = "{}: assembled with {:.4g} m; with its parts turned round it would be {:.4g} m. A guess of its position decides"
SAME = 1e-6  #: difference of two positions, in the mechanism's size, that is rounding


def positions(system: System) -> dict[str, Expr]:
    """The positions of joints that slide between two moving bodies, without a driver or an initial value, by name."""
    scene = system.scene
    said = {x.target for x in scene.initial}
    frames = {leaf.value[0] for x in said for leaf in leaves(x) if leaf.op == "coordinate"}
    driven = [set(c.ports.values()) for c in scene.components.values() if getattr(c.kind, "driver", None)]
    found = {}
    for c in scene.components.values():
        if not (isinstance(c.kind, JointKind) and c.kind.placing.along and c.kind.rows >= 2 and c.kind.driver is None):
            continue
        bodies = [scene.frames[name].body for name in c.ports.values()]
        moving = all(scene.components[body].coordinates for body in bodies) and bodies[0] != bodies[1]
        given = any(scene.frames[name].body in bodies for name in frames if name in scene.frames)
        s = scene.signal_of(c, c.kind.placing.along[0])
        if moving and not given and s is not None and s not in said and set(c.ports.values()) not in driven:
            found[f"{c.name}.{c.kind.placing.along[0]}"] = s
    return found


def values_at(system: System, found: dict[str, Expr], t: float, q: Array) -> Array:
    """These positions (k,) [m] at the pose q (n,)."""
    still = np.zeros((1, system.n))
    return np.array([float(x[0]) for x in values(system, list(found.values()), np.array([t]), q[None], still)])


def turned_round(system: System, legs: Sequence[str], t: float, q: Array) -> Array:
    """The pose q (n,) with both parts of some legs turned by half a turn about the joints at their ends."""
    scene, change = system.scene, np.zeros(system.n)
    for name in legs:
        leg = scene.components[name.rpartition(".")[0]]
        for frame in leg.ports.values():
            body = scene.frames[frame].body
            end = _other_end(system, leg.name, body)
            if end is None:
                continue
            axes = "xyz" if scene.spatial else "xy"
            names = [coordinate(f, key) for f in (f"{body}.c", end) for key in axes]
            found = np.array([x[0] for x in values(system, names, np.array([t]), q[None], np.zeros((1, system.n)))])
            arm, d = found[: len(axes)] - found[len(axes) :], system.tables.coordinates[body]
            if not scene.spatial:
                change[d : d + 3] = *(-2.0 * arm), np.pi
            elif len(scene.components[body].coordinates) > 3 and (size := np.linalg.norm(arm)) > 0.0:
                across = np.cross(arm / size, np.eye(3)[np.abs(arm).argmin()])
                R = matrices(q[None, d + 3 : d + 6])[0]
                change[d : d + 3], change[d + 3 : d + 6] = -2.0 * arm, np.pi * (R.T @ (across / np.linalg.norm(across)))
    return system.moved(q, change)


def _other_end(system: System, leg: str, body: str) -> str | None:
    """The frame of another joint on a body."""
    for c in system.scene.components.values():
        if isinstance(c.kind, JointKind) and c.name != leg and c.kind.driver is None:
            for name in c.ports.values():
                if system.scene.frames[name].body == body:
                    return name
    return None
