"""Bodies that lie upside down: of two assemblies, the one that is nearer to the documented start, an attitude of zero.

A body without initial values is placed at the angle of the body that it is hinged to. If a loop closes with it in two
attitudes, as a board in a slot does, the nearest to that angle may be half a turn away from zero, and is not meant.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from mbdsl.expressions.spatial_coordinates import named
from mbdsl.expressions.symbolic import coordinate, is_velocity_level, leaves
from mbdsl.kernels.arrays import Array
from mbdsl.mechanism.graph import MechanismGraph, Placement
from mbdsl.numerics.rotation_arrays import matrices
from mbdsl.numerics.saddle_point import dense, null_space
from mbdsl.system.signals import values
from mbdsl.system.system import System

TAKEN = "{}: assembled at {:.4g} deg; turned round at its hinge it would be at {:.4g} deg. A guess of its angle decides"
TURNED = "{}: turned by {:.4g} deg from where it was placed, to be assembled"
MOST = 6  #: most bodies that are turned round
STILL = 1e-6  #: displacement, in the mechanism's size and in radians, that is rounding
UPRIGHT = 0.5 * np.pi + STILL


def in_loops(system: System, graph: MechanismGraph) -> dict[str, Placement]:
    """Bodies with an attitude and without initial values of positions that are part of a loop: their placements."""
    scene, tree = system.scene, {p.body: p for p in graph.tree()}
    targets = [x.target for x in scene.initial if not is_velocity_level(x.target)]
    frames = {leaf.value[0] for x in targets for leaf in leaves(x) if leaf.op == "coordinate"}
    given = {scene.frames[name].body for name in frames if name in scene.frames}
    hung, closed = {p.joint for p in tree.values()}, set[str]()
    for edge in graph.joints:
        if edge.component.name not in hung:
            ways = [set(_up(tree, end)) for end in (edge.body_i, edge.body_j)]
            closed |= ways[0] ^ ways[1]
    return {name: p for name, p in tree.items() if name in closed - given and _turns(system, name) is not None}


def angles(system: System, q: Array) -> dict[str, float]:
    """The angle [rad] between the axes of each body and those of the world, at the pose q (n,); signed in a plane."""
    found = {}
    for name in system.tables.models:
        if (own := _turns(system, name)) is not None:
            x = q[own]
            found[name] = _wrapped(x[0]) if len(x) == 1 else _angle(x)
    return found


def turned_round(system: System, graph: MechanismGraph, placement: Placement, t: float, q: Array) -> Array | None:
    """The displacement (n,) that turns a body, and what hangs on it, by half a turn about its joint; None if it holds
    the attitude."""
    scene, tables = system.scene, system.tables
    if placement.joint is None:
        return None
    joint = scene.components[placement.joint]
    pivot = next(name for name in joint.ports.values() if scene.frames[name].body == placement.body)
    J = dense(system.Phi_q(t, q))[tables.rows[joint.name] :][: joint.kind.rows]
    held = J[~(J[:, tables.lengths] != 0.0).any(axis=1)][:, _turns(system, placement.body)]
    free = null_space(held)
    if free.shape[1] != 1:
        return None
    group = {placement.body}
    for p in graph.tree():
        if p.parent in group:
            group.add(p.body)
    axes, change = "xyz" if scene.spatial else "xy", np.zeros(system.n)
    nodes = [coordinate(frame, key) for frame in (pivot, *(f"{name}.c" for name in group)) for key in axes]
    rows = values(system, nodes, np.array([t]), q[None], np.zeros((1, system.n)))
    places = np.array([x[0] for x in rows]).reshape(-1, len(axes))
    n = np.zeros(len(axes))  # of the plane: arms lie across it
    if scene.spatial:
        own = _turns(system, placement.body)
        n = matrices(q[None, own])[0] @ free[:, 0]
        counted = tables.first_angles.get(named(f"{placement.body}.c", "phi"), 0.0)
        n *= -np.copysign(1.0, counted * n[2] if counted * n[2] else q[own] @ free[:, 0])  # the way back to zero
    for name, arm in zip(group, places[1:] - places[0], strict=True):
        d, own = tables.coordinates[name], _turns(system, name)
        change[d : d + len(axes)] = 2.0 * (n * (n @ arm) - arm)
        if own is not None:
            change[own] = np.pi * (matrices(q[None, own])[0].T @ n) if scene.spatial else -np.copysign(np.pi, q[own])
    return change


def is_upright(system: System, placement: Placement, graph: MechanismGraph, before: Array, after: Array) -> bool:
    """Whether a body is nearer to an attitude of zero in the pose ``after``, and bodies that do not hang on it are
    where they were ``before``."""
    group, moved = {placement.body}, np.abs(system.difference(after, before) * system.tables.scale)
    for p in graph.tree():
        if p.parent in group:
            group.add(p.body)
    for name, model in system.tables.models.items():
        d = system.tables.coordinates[name]
        if name not in group and moved[d : d + model.n].max(initial=0.0) > STILL:
            return False
    old, new = (abs(angles(system, q)[placement.body]) for q in (before, after))
    return new < old - STILL


def follow_turns(system: System, q: Array, change: Array) -> None:
    """Count the turns of angles on the way from q to the pose displaced by ``change``."""
    nodes = list(system.tables.first_angles)
    if nodes:
        part = np.linspace(0.0, 1.0, 5)
        path = np.array([system.moved(q, x * change) for x in part])
        for node, found in zip(nodes, values(system, nodes, 0.0 * part, path, 0.0 * path), strict=True):
            system.set_first_angle(node, float(found[-1]))


def turned(system: System, graph: MechanismGraph, placed: Array, q: Array) -> Iterator[str]:
    """Notes about bodies in loops, without initial values, that are far from zero and from where they were placed."""
    first, last = angles(system, placed), angles(system, q)
    way = system.difference(q, placed)
    for name in in_loops(system, graph):
        x = way[_turns(system, name)]
        by = min(abs(last[name]), abs(_wrapped(x[0])) if len(x) == 1 else _angle(x))
        if by > UPRIGHT and first[name] != last[name]:
            yield TURNED.format(name, np.rad2deg(by))


def _up(tree: dict[str, Placement], body: str) -> Iterator[str]:
    """A body, and those on the way from it to the ground."""
    while body in tree:
        yield body
        body = tree[body].parent


def _turns(system: System, name: str) -> slice | None:
    """The coordinates of the attitude of a rigid body; None for points and for bodies that deform."""
    tables, spatial = system.tables, system.scene.spatial
    model, d = tables.models.get(name), tables.coordinates.get(name, 0)
    if model is None or model.deforms or model.n != (6 if spatial else 3):
        return None
    return slice(d + 3, d + 6) if spatial else slice(d + 2, d + 3)


def _angle(psi: Array) -> float:
    """The angle of a rotation, from its vector (3,)."""
    R = matrices(psi[None])[0]
    return float(np.arccos(np.clip(0.5 * (np.trace(R) - 1.0), -1.0, 1.0)))


def _wrapped(phi: float) -> float:
    """An angle without whole turns, above -pi, up to pi."""
    return float(np.pi - np.remainder(np.pi - phi, 2.0 * np.pi))
