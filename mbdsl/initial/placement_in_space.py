"""Initial placement of bodies in space, from the ground outwards: at initial values, else as the joints require."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from math import atan2, hypot, pi
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from mbdsl.elements.kind import JointKind
from mbdsl.expressions.formulas import evaluate
from mbdsl.expressions.spatial_coordinates import CARDAN, LOCAL, QUATERNION, named
from mbdsl.expressions.symbolic import Expr, expr
from mbdsl.mechanism.given_attitudes import given_attitudes
from mbdsl.mechanism.graph import MechanismGraph
from mbdsl.mechanism.poses_in_space import about, composed, inverse, turned_successively
from mbdsl.mechanism.scene import Component, InitialValue, Scene
from mbdsl.mechanism.signals import Formulas
from mbdsl.numerics.saddle_point import dense
from mbdsl.system.body_models import body_pose
from mbdsl.system.signals import gradients
from mbdsl.system.signals import values as values_of
from mbdsl.system.system import System

Array = NDArray[np.float64]
Z = (0.0, 0.0, 1.0)
PARALLEL = 1e-9  #: difference of rates about two axes, per unit of velocity, that is rounding
#: signals of bodies and joints that are no angles with turns, and take long to write as expressions
NEVER_COUNTED = {*CARDAN, *LOCAL, *QUATERNION}


def place(system: System, graph: MechanismGraph, t: float, given: list[InitialValue]) -> Array:
    """Positions and attitudes of all bodies (n,)."""
    scene, tables = system.scene, system.tables
    said: dict[Expr | None, float] = {x.target: x.value for x in sorted(given, key=lambda x: x.fixed)}
    poses: dict[str, tuple[float, ...]] = {}
    turns: dict[str, float] = {}  # body -> its rotation about the z axis, with turns
    drivers = {c.name: _prescribed(system, c, t) for c in scene.components.values() if _drives_angle(c)}
    attitudes = _attitudes(scene, given)
    q = np.zeros(system.n)

    def frame_pose(name: str) -> tuple[float, ...]:
        frame = scene.frames[name]
        own = body_pose(scene.components[frame.body], frame)
        return composed(poses[frame.body], own) if frame.body in poses else own

    for placement in graph.tree():
        body = scene.components[placement.body]
        values = [said.get(scene.signal_of(body, key)) for key in ("x", "y", "z", "phi")]
        pose, turn = (0.0, 0.0, 0.0, *about(Z, values[3] or 0.0)), values[3] or 0.0
        attitude = attitudes.get(body.name)
        angles = [said.get(named(f"{body.name}.c", key)) for key in CARDAN]
        if attitude is None and angles.count(None) < 3 and _turns_freely(scene, placement.joint):
            # the others are zero: not those of another body, where a part of the angles may be undetermined
            attitude = turned_successively([x or 0.0 for x in angles])
        if placement.joint is not None:
            joint = scene.components[placement.joint]
            assert isinstance(joint.kind, JointKind)
            a, b = (joint.ports[port] for port in ("frame_a", "frame_b"))
            forward = scene.frames[b].body == body.name
            other, own = (a, b) if forward else (b, a)
            own_pose = body_pose(body, scene.frames[own])
            between = turns.get(scene.frames[other].body, 0.0) + _turn_of(scene.frames[other])
            between -= _turn_of(scene.frames[own])  # the angle of the body if that of the joint is zero
            ways, angle = joint.kind.moves or _simple(joint.kind), next(iter(joint.kind.angle), None)
            moves = {name: _known(system, joint, said, name, t) for name, _ in ways}
            driven = _driven(scene, joint, drivers) if angle else None
            if angle and driven is not None:
                values, moves[angle] = [None] * 4, driven  # a driver has priority over a guess
            elif attitude is None and values[3] is None and values[0] is not None and values[1] is not None:
                values[3] = _aimed(frame_pose(other), own_pose, values[0], values[1])
            if values[3] is not None and angle and not moves[angle]:
                moves[angle] = (values[3] - between) if forward else (between - values[3])
            if values[3] is None:
                turned = moves.get(angle, 0.0) if angle else 0.0
                turn = between + (turned if forward else -turned)
            else:
                turn = values[3]
            relative = _moved(ways, moves)
            target = composed(frame_pose(other), relative if forward else inverse(relative))
            free = attitude
            if free is None and values[3] is not None and "tau" not in joint.kind.reaction:
                free = about(Z, turn)
            if free is not None:  # the joint fixes the position only
                target = (*target[:3], *composed((0.0, 0.0, 0.0, *free), own_pose)[3:])
            pose = composed(target, inverse(own_pose))
        if attitude is not None:
            pose = (*pose[:3], *attitude)
            turn = _nearest(atan2(attitude[1], attitude[0]), turn)
        origin = (old if new is None else new for new, old in zip(values[:3], pose, strict=False))
        turns[body.name] = turn
        poses[body.name] = pose = (*origin, *pose[3:])
        d, model = tables.coordinates[body.name], tables.models[body.name]
        q[d : d + model.n] = model.placed(pose)[0]
    for name, frame in scene.frames.items():
        node = named(name, "phi")
        system.set_first_angle(node, said.get(node, turns.get(frame.body, 0.0) + _turn_of(frame)))
    _count_from(system, t, q, said, turns, drivers)
    return q


def _attitudes(scene: Scene, given: list[InitialValue]) -> dict[str, tuple[float, ...]]:
    """The axes (9) of bodies with a given attitude, by body; fixed values have priority over guesses."""
    found: dict[str, tuple[float, ...]] = {}
    for attitude in given_attitudes(given):
        frame = scene.frames[attitude.frame]
        back = inverse((0.0, 0.0, 0.0, *body_pose(scene.components[frame.body], frame)[3:]))
        found.setdefault(frame.body, composed((0.0, 0.0, 0.0, *attitude.axes), back)[3:])
    return found


def _turns_freely(scene: Scene, joint: str | None) -> bool:
    """Whether a body that is placed at a joint may have any attitude."""
    kind = None if joint is None else scene.components[joint].kind
    return kind is None or (isinstance(kind, JointKind) and kind.rows <= 3 and not kind.aligned)


def _simple(kind: JointKind) -> tuple[tuple[str, str], ...]:
    """A motion along x and one about z, of those that the joint has."""
    return (*((name, "x") for name in kind.along[:1]), *((name, "rz") for name in kind.angle[:1]))


def _moved(moves: tuple[tuple[str, str], ...], values: Mapping[str, float]) -> tuple[float, ...]:
    """The pose of frame_b relative to frame_a after the motions of a joint, one after the other."""
    pose = (0.0, 0.0, 0.0, *about(Z, 0.0))
    for name, way in moves:
        unit = tuple(float(i == way[-1]) for i in "xyz")
        x = values[name]
        shift = (0.0, 0.0, 0.0) if way[0] == "r" else tuple(x * e for e in unit)
        pose = composed(pose, (*shift, *about(unit, x if way[0] == "r" else 0.0)))
    return pose


def _nearest(angle: float, to: float) -> float:
    """The angle, up to whole turns, that is nearest to another one."""
    return angle + 2.0 * pi * round((to - angle) / (2.0 * pi))


def _driven(scene, joint, drivers: dict[str, float]) -> float | None:
    """The angle of a joint that a driver between the same bodies prescribes."""
    ends = [scene.frames[joint.ports[port]].body for port in ("frame_a", "frame_b")]
    for driver, u in drivers.items():
        own = [scene.frames[scene.components[driver].ports[port]].body for port in ("frame_a", "frame_b")]
        if own in (ends, ends[::-1]):
            return u if own == ends else -u
    return None


def _aimed(frame: tuple[float, ...], own: tuple[float, ...], x: float, y: float) -> float | None:
    """The angle at which a body with a known centre of mass points at its joint, in the plane of x and y."""
    sx, sy = own[:2]
    dx, dy = frame[0] - x, frame[1] - y
    return atan2(dy, dx) - atan2(sy, sx) if hypot(sx, sy) * hypot(dx, dy) > 0.0 else None


def _turn_of(frame) -> float:
    """The angle of a frame about the z axis of its body, with the turns that the model gives it."""
    return _nearest(atan2(frame.axes[1], frame.axes[0]), frame.phi)


def _drives_angle(c) -> bool:
    return isinstance(c.kind, JointKind) and c.kind.driver is not None and c.kind.driver in c.kind.angle


def _prescribed(system: System, c, t: float) -> float:
    nowhere = np.zeros((1, system.n))
    return float(values_of(system, [expr(c.values[c.kind.driver])], np.array([t]), nowhere, nowhere)[0][0])


class _Angle(NamedTuple):
    """An angle that counts turns: the component and the name of the signal, and its expression."""

    component: Component
    key: str
    node: Expr


def _counted_angles(scene: Scene) -> Iterator[_Angle]:
    for c in scene.components.values():
        for key in c.signals:
            formula = c.kind.formulas.get(key, "")
            if key in NEVER_COUNTED or formula.startswith(("atan2(", "der(")) or c.kind.unit_of(key) != "rad":
                continue  # as a torque of 1 N.m/rad times an angle
            node = scene.signal_of(c, key)
            if node is not None and node.op == "angle":
                yield _Angle(c, key, node)


def _count_from(system: System, t: float, q: Array, said, turns: dict[str, float], drivers: dict[str, float]) -> None:
    """Set the value at the start, up to less than half a turn, of every angle that counts turns.

    Turns belong to a joint and its axis: those of drivers and joints are found first, then those of whatever acts on
    the same bodies about the same axis.
    """
    scene, known, rest = system.scene, dict[Expr, float](), list[_Angle]()
    joints = dict[frozenset[str], list[_Angle]]()
    angles = list(_counted_angles(scene))
    for x in angles:
        if isinstance(x.component.kind, JointKind) and x.component.name in drivers and x.key in x.component.kind.angle:
            known[x.node] = drivers[x.component.name]
    for x in angles:
        c, own = x.component, x.node
        if isinstance(c.kind, JointKind) and c.kind.driver is None:
            joints.setdefault(_bodies(scene, c), []).append(x)
        if own in known or own in said:
            known.setdefault(own, said.get(own, 0.0))
        elif x.key in c.kind.first_angles:
            known[own] = _by_formula(system, c, x.key, t, q)
        elif not c.ports:
            known[own] = turns.get(c.name, 0.0)
        elif isinstance(c.kind, JointKind) and c.kind.driver is None:
            known[own] = _between(scene, c, turns) if x.key == "phi" else 0.0
        else:
            rest.append(x)
    for x in rest:
        if x.node in known:
            continue
        around = joints.get(_bodies(scene, x.component), ())
        found = next((y for y in (_as_joint(system, t, q, x, joint, known) for joint in around) if y is not None), None)
        if found is None:
            found = _between(scene, x.component, turns) if x.key == "phi" else 0.0
        known[x.node] = found
    for node, angle in known.items():
        system.set_first_angle(node, angle)


def _bodies(scene: Scene, c: Component) -> frozenset[str]:
    return frozenset(scene.frames[name].body for name in c.ports.values())


def _between(scene: Scene, c: Component, turns: dict[str, float]) -> float:
    """The angle about z between the frames of a component, from the turns of both bodies."""
    a, b = (scene.frames[c.ports[port]] for port in ("frame_a", "frame_b"))
    return turns.get(b.body, 0.0) + _turn_of(b) - turns.get(a.body, 0.0) - _turn_of(a)


def _as_joint(system: System, t: float, q: Array, x: _Angle, joint: _Angle, known: dict[Expr, float]) -> float | None:
    """The angle ``x`` counted as that of a joint between the same bodies; None if it is about another axis."""
    if x.node.args == joint.node.args:
        return known[joint.node]
    still, rates = np.zeros(system.n), [x.node.value, joint.node.value]
    a, b = dense(gradients(system, rates, t, q, still)[2])  # type: ignore[arg-type]
    if (way := next((w for w in (1.0, -1.0) if np.allclose(a, w * b, rtol=0.0, atol=PARALLEL)), None)) is None:
        return None
    first, second = (float(y[0]) for y in values_of(system, [x.node, joint.node], np.array([t]), q[None], still[None]))
    there = way * known[joint.node]
    return there + _nearest(first - way * second, 0.0)


def _by_formula(system: System, c, key: str, t: float, q: Array) -> float:
    """The angle at the start that follows from those of the frames."""
    formulas = Formulas(c.kind, c.name, c.values.get, lambda port, name: named(c.ports[port], name))
    root = evaluate(c.kind.first_angles[key], formulas)
    return float(values_of(system, [root], np.array([t]), q[None], np.zeros((1, system.n)))[0][0])


def _known(system: System, joint, said, name: str, t: float) -> float:
    """A coordinate of a joint at the start: as given, as driven, or a length of the joint; else 0."""
    found = [said.get(system.scene.signal_of(joint, name))]
    for c in system.scene.components.values():
        if isinstance(c.kind, JointKind) and c.kind.driver == name and c.ports == joint.ports:
            found.append(_prescribed(system, c, t))
    if name in joint.kind.along:
        found += [x for key in joint.kind.along if isinstance(x := joint.values.get(key), float)]
    return next((float(value) for value in found if value is not None), 0.0)
