"""Signals at states: expressions over frames evaluated for arrays of states, and differentiated for assembly."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import TYPE_CHECKING, TypeAlias

import numpy as np

from mbdsl.bodies.contract import POSITIONS, SPATIAL_POSITIONS, SPATIAL_VELOCITIES, VELOCITIES, Pose
from mbdsl.bodies.rigid_body import Rigid
from mbdsl.expressions.array_operations import ARRAY_OPERATIONS, counted, table_value
from mbdsl.expressions.derivatives import der, diff
from mbdsl.expressions.symbolic import COORDINATES, RATE, Expr, evaluate, leaves, walk
from mbdsl.kernels.arrays import Array, Integers
from mbdsl.mechanism.scene import Scene
from mbdsl.system.body_models import at_rest, body_pose
from mbdsl.system.system import DENSE_LIMIT, System

if TYPE_CHECKING:
    from scipy.sparse import csr_array

_RATES = tuple(RATE.values())
Matrix: TypeAlias = "Array | csr_array"
#: rows, columns and numbers
Entries: TypeAlias = tuple[Integers, Integers, Array]


def frame_coordinate(
    system: System,
    name: str,
    key: str,
    q: Array,
    v: Array,
    t: Array | None = None,
    known: dict[str, tuple[Array, Array]] | None = None,
) -> Array:
    """Coordinate ``key`` of frame ``name`` for states q, v of shape (N, n) at times t (N,); shape (N,).

    ``known``: q and v of bodies. With the same arrays, a body computes its attitudes once for all its frames.
    """
    scene: Scene = system.scene
    frame = scene.frames[name]
    component = scene.components[frame.body]
    body = system.tables.models.get(frame.body)
    if body is None:
        return np.full(len(q), at_rest(component, frame, key))
    d = system.tables.coordinates[frame.body]
    known = {} if known is None else known
    if frame.body not in known:
        known[frame.body] = q[:, d : d + body.n], v[:, d : d + body.n]
    return body.frame(body_pose(component, frame), key, *known[frame.body], t)


def values(
    system: System,
    roots: Sequence[Expr],
    t: Array,
    q: Array,
    v: Array,
    lam: Array | None = None,
    inputs: Mapping[str, Array] | None = None,
    order: list[Expr] | None = None,
) -> list[Array]:
    """Expressions at N states: t (N,), q and v (N, n), lam (N, m + p), inputs by name (N,); each result is (N,).

    Inputs that are not given have their start value. ``order``: ``walk(*roots)``, if it is known.
    """

    known: dict[str, tuple[Array, Array]] = {}

    def leaf(node: Expr) -> Array:
        if node.op == "time":
            return t
        if node.op == "multiplier":
            assert lam is not None, "reactions need multipliers"
            return lam[:, system.tables.multipliers[node.value] - system.n]
        if node.op == "start":
            return np.full(len(t), system.tables.first_angles.get(node, 0.0))
        if node.op == "input":
            name = str(node.value)
            return inputs[name] if inputs and name in inputs else np.full(len(t), system.scene.number_starts[name])
        name, key = node.value
        motion = system.scene.frames[name].motion
        if motion is not None:
            moved = motion[tuple(RATE).index(key)] if key in RATE else der(motion[_RATES.index(key)])
            return values(system, [moved], t, q, v)[0]
        return frame_coordinate(system, name, key, q, v, t, known)

    def angle(node: Expr, y: Array, x: Array) -> Array:
        (rate,) = values(system, [node.value], t, q, v, lam, inputs)
        return counted(t, np.arctan2(y, x), rate, system.tables.first_angles.get(node, 0.0))

    with np.errstate(all="ignore"):
        results = evaluate(roots, leaf, ARRAY_OPERATIONS, table_value, angle, order)
    return [np.broadcast_to(np.asarray(r, float), (len(t),)) for r in results]


def begin(system: System, t: float, q: Array, v: Array) -> None:
    """Make q, v (n,) at time t the start from which expressions take their values at the start."""
    nodes = _begun(system)
    found = values(system, [n.value for n in nodes], np.array([t]), q[None], v[None]) if nodes else []
    for node, value in zip(nodes, found, strict=True):
        system.set_first_angle(node, float(value[0]))
    for node in system.tables.angles if nodes else ():
        if any(n.op == "start" for n in walk(node)):  # it is measured from the start
            system.set_first_angle(node, 0.0)


def _begun(system: System) -> list[Expr]:
    """The expressions of which laws take the value at the start, and signals of components along a path."""
    paths = [c.values for c in system.scene.components.values() if c.kind.computed]
    roots = [x for given in paths for x in given.values() if isinstance(x, Expr)]
    return list(dict.fromkeys([*system.tables.starts, *(n for n in walk(*roots) if n.op == "start")]))


def gradients(system: System, roots: Iterable[Expr], t: float, q: Array, v: Array) -> tuple[Array, Matrix, Matrix]:
    """Values (k,), and derivatives with respect to q (k, n) and v (k, n) of expressions at one state.

    The derivatives are dense for small systems and sparse for large ones, like those of the System.
    """
    roots = list(roots)
    value = np.zeros(len(roots))
    d_q: list[tuple[int, int, float]] = []
    d_v: list[tuple[int, int, float]] = []
    tt, qq, vv = np.array([t]), q[None, :], v[None, :]
    rigid: list[tuple[int, Pose, int, int]] = []  # row, pose of the frame, first coordinate of the body, index of key
    for i, root in enumerate(roots):
        if root.op == "coordinate" and system.scene.frames[root.value[0]].motion is None:
            name, key = root.value
            frame = system.scene.frames[name]
            body = system.tables.models.get(frame.body)
            if isinstance(body, Rigid) and body.n == 3:
                pose = body_pose(system.scene.components[frame.body], frame)
                rigid.append((i, pose, system.tables.coordinates[frame.body], COORDINATES.index(key)))
                continue
            value[i] = frame_coordinate(system, name, key, qq, vv, tt)[0]
            _chain(system, root, 1.0, q, v, i, d_q, d_v)
            continue
        variables = [leaf for leaf in leaves(root) if leaf.op == "coordinate"]
        found = values(system, [root, *diff(root, *variables)], tt, qq, vv)
        value[i] = found[0][0]
        for leaf, partial in zip(variables, found[1:], strict=True):
            _chain(system, leaf, partial[0], q, v, i, d_q, d_v)
    many_q, many_v = _of_rigid_bodies(rigid, q, v, value) if rigid else (None, None)
    return value, _matrix(system, len(roots), d_q, many_q), _matrix(system, len(roots), d_v, many_v)


def _of_rigid_bodies(
    found: list[tuple[int, Pose, int, int]], q: Array, v: Array, value: Array
) -> tuple[Entries, Entries]:
    """Values, and the entries (rows, columns, numbers) of both derivatives, of coordinates of frames on rigid bodies:
    of all at once, because large models have many of them."""
    row, poses, first, key = (np.array(x) for x in zip(*found, strict=True))
    columns, all_of = first[:, None] + np.arange(3), np.arange(len(row))
    z, rates, B, rate = Rigid.gradients(poses, q[columns], v[columns])
    value[row] = np.concatenate([z, rates], axis=1)[all_of, key]
    velocity = key >= len(POSITIONS)

    def entries(numbers: Array) -> Entries:
        at, k = np.nonzero(numbers)
        return row[at], columns[at, k], numbers[at, k]

    same, of_rate = B[all_of, key % 3], rate[all_of, key % 3]
    return entries(np.where(velocity[:, None], of_rate, same)), entries(np.where(velocity[:, None], same, 0.0))


def _matrix(system: System, rows: int, entries: list[tuple[int, int, float]], more: Entries | None) -> Matrix:
    i = np.array([e[0] for e in entries], int)
    j = np.array([e[1] for e in entries], int)
    x = np.array([e[2] for e in entries])
    if more is not None:
        i, j, x = (np.concatenate(both) for both in zip((i, j, x), more, strict=True))
    if system.n + system.m > DENSE_LIMIT:
        from scipy.sparse import csr_array

        return csr_array((x, (i, j)), shape=(rows, system.n))
    dense = np.zeros((rows, system.n))
    np.add.at(dense, (i, j), x)
    return dense


def _chain(system: System, leaf: Expr, partial: float, q: Array, v: Array, row: int, d_q: list, d_v: list) -> None:
    """Entries of partial * d(frame coordinate)/d(q, v)."""
    name, key = leaf.value
    frame = system.scene.frames[name]
    body = system.tables.models.get(frame.body)
    if body is None:
        return  # the ground
    d = system.tables.coordinates[frame.body]
    pose = body_pose(system.scene.components[frame.body], frame)
    found: tuple[Array, ...] = body.gradient(pose, q[d : d + body.n], v[d : d + body.n])
    B, G, rate = found if len(found) == 3 else (found[0], *found)
    positions, velocities = POSITIONS, VELOCITIES
    if system.scene.spatial:
        positions, velocities = SPATIAL_POSITIONS, SPATIAL_VELOCITIES
    velocity = key in velocities
    k = (velocities if velocity else positions).index(key)
    entries = (G if velocity else B)[k].tolist()
    (d_v if velocity else d_q).extend((row, d + j, partial * x) for j, x in enumerate(entries) if x)
    if velocity:
        d_q.extend((row, d + j, partial * x) for j, x in enumerate(rate[k].tolist()) if x)
