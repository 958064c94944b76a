"""Angles in space that count turns: their values at the start, up to less than half a turn."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from math import atan2, pi
from typing import NamedTuple

import numpy as np

from mbdsl.elements.kind import JointKind
from mbdsl.expressions.formulas import evaluate
from mbdsl.expressions.spatial_coordinates import CARDAN, LOCAL, QUATERNION, named
from mbdsl.expressions.symbolic import Expr
from mbdsl.kernels.arrays import Array
from mbdsl.mechanism.scene import Component, Frame, Scene
from mbdsl.mechanism.scene_parts import SpatialFrame
from mbdsl.mechanism.signals import ComponentFormulas
from mbdsl.numerics.saddle_point import dense
from mbdsl.system.signals import gradients, values
from mbdsl.system.system import System

PARALLEL = 1e-9  #: difference of rates about two axes, per unit of velocity, that is rounding
#: signals of bodies and joints that are no angles with turns, and take long to write as expressions
NEVER_COUNTED = {*CARDAN, *LOCAL, *QUATERNION}


def nearest(angle: float, to: float) -> float:
    """The angle, up to whole turns, that is nearest to another one."""
    return angle + 2.0 * pi * round((to - angle) / (2.0 * pi))


def turn_of(frame: Frame) -> float:
    """The angle of a frame about the z axis of its body, with the turns that the model gives it."""
    return nearest(atan2(frame.axes[1], frame.axes[0]), frame.phi) if isinstance(frame, SpatialFrame) else frame.phi


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


def count_from(
    system: System, t: float, q: Array, said: Mapping[Expr | None, float], turns: Mapping[str, float], drivers: Mapping
) -> None:
    """Set the value at the start, up to less than half a turn, of every angle that counts turns.

    Parameters
    ----------
    q : ndarray of shape (n,)
        The coordinates of all bodies at the time t [s].
    said : mapping
        Expression -> its initial value.
    turns : mapping
        Body -> its rotation about the z axis [rad], with turns.
    drivers : mapping
        Name of a driver of an angle -> the prescribed angle [rad].

    Turns belong to a joint and its axis: those of drivers and joints are found first, then those of whatever acts on
    the same bodies about the same axis.
    """
    for name, frame in system.scene.frames.items():
        node = named(name, "phi")
        system.set_first_angle(node, said.get(node, turns.get(frame.body, 0.0) + turn_of(frame)))
    scene, known, rest = system.scene, dict[Expr, float](), list[_Angle]()
    joints = dict[frozenset[str], list[_Angle]]()
    angles = list(_counted_angles(scene))
    for x in angles:
        kind = x.component.kind
        if isinstance(kind, JointKind) and x.component.name in drivers and x.key in kind.placing.angle:
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


def _between(scene: Scene, c: Component, turns: Mapping[str, float]) -> float:
    """The angle about z between the frames of a component, from the turns of both bodies."""
    a, b = (scene.frames[c.ports[port]] for port in ("frame_a", "frame_b"))
    return turns.get(b.body, 0.0) + turn_of(b) - turns.get(a.body, 0.0) - turn_of(a)


def _as_joint(system: System, t: float, q: Array, x: _Angle, joint: _Angle, known: dict[Expr, float]) -> float | None:
    """The angle ``x`` counted as that of a joint between the same bodies; None if it is about another axis."""
    if x.node.args == joint.node.args:
        return known[joint.node]
    still, rates = np.zeros(system.n), [x.node.value, joint.node.value]
    a, b = dense(gradients(system, rates, t, q, still)[2])
    if (way := next((w for w in (1.0, -1.0) if np.allclose(a, w * b, rtol=0.0, atol=PARALLEL)), None)) is None:
        return None
    first, second = (float(y[0]) for y in values(system, [x.node, joint.node], np.array([t]), q[None], still[None]))
    there = way * known[joint.node]
    return there + nearest(first - way * second, 0.0)


def _by_formula(system: System, c, key: str, t: float, q: Array) -> float:
    """The angle at the start that follows from those of the frames."""
    formulas = ComponentFormulas(c.kind, c.name, c.values.get, lambda port, name: named(c.ports[port], name))
    root = evaluate(c.kind.first_angles[key], formulas)
    return float(values(system, [root], np.array([t]), q[None], np.zeros((1, system.n)))[0][0])
