"""Whether a model has to be assembled to find errors in its initial state, from its structure alone."""

from __future__ import annotations

from mbdsl.elements.kind import JointKind
from mbdsl.expressions.derivatives import der
from mbdsl.expressions.symbolic import RATE as RATES
from mbdsl.expressions.symbolic import Expr, is_const, is_velocity_level
from mbdsl.mechanism.graph import GROUND, MechanismGraph
from mbdsl.mechanism.scene import Component

#: parameters of rigid bodies that are zero if a coordinate has no mass
MASSES = ("m", "I")


def has_to_be_assembled(graph: MechanismGraph) -> bool:
    """Whether the initial state of a model may be inconsistent, or has rates that are not given.

    It cannot be if the joints form a tree, no body that starts with a velocity carries another one, each fixed initial
    value is that of another degree of freedom of the tree, every coordinate has a mass, and no law is evaluated. A
    model whose size is not that of its bodies is assembled as well, because ``check`` states the size.

    Parameters
    ----------
    graph : MechanismGraph
        The structure of the model.
    """
    return (
        graph.loops > 0
        or bool(graph.velocity_rows)
        or any(_is_driven(c) or _has_a_law(c) for c in graph.scene.components.values())
        or any(frame.motion is not None for frame in graph.scene.frames.values())
        or not all(_has_masses(body) for body in graph.bodies.values())
        or _may_carry_others(graph)
        or not _has_lengths(graph)
        or not _values_are_independent(graph)
    )


def _may_carry_others(graph: MechanismGraph) -> bool:
    """Whether a body may start with a velocity and carry a joint, whose rate may not be given."""
    moving = any(x.value and is_velocity_level(x.target) for x in graph.scene.initial)
    return moving and any(GROUND not in (e.body_i, e.body_j) for e in graph.joints)


def _has_lengths(graph: MechanismGraph) -> bool:
    """Whether a joint has a length, or a body a frame away from its reference point: the mechanism's size."""
    own = (frame for frame in graph.scene.frames.values() if frame.body in graph.bodies)
    away = any(frame.x or frame.y or getattr(frame, "z", 0.0) for frame in own)
    return away or any(c.values.get(c.kind.size) for c in graph.scene.components.values())


def _is_driven(c: Component) -> bool:
    return isinstance(c.kind, JointKind) and (c.kind.driver is not None or c.friction is not None)


def _has_a_law(c: Component) -> bool:
    return any(isinstance(value, Expr) and not is_const(value) for value in c.values.values())


def _has_masses(body: Component) -> bool:
    return not body.deforms and all(body.values.get(name) != 0.0 for name in MASSES)


def _values_are_independent(graph: MechanismGraph) -> bool:
    """Whether every fixed initial value is that of the degree of freedom of a joint of the tree, or of a body that no
    joint holds, and each of them is fixed once."""
    scene, freedoms = graph.scene, dict[Expr | None, tuple[str, str, bool]]()
    if scene.spatial:  # the freedoms of joints and of bodies in space are not single signals
        return False
    of_joints: list[tuple[Expr, str, str]] = []
    for body, _, joint in graph.tree():
        own = scene.components[body]
        if joint is None:
            for key in own.coordinates:
                freedoms[scene.signal_of(own, key)] = body, key, False
                freedoms[scene.signal_of(own, RATES[key])] = body, key, True
            continue
        holder = scene.components[joint]
        kind = holder.kind
        if not isinstance(kind, JointKind) or kind.placing.pose is None or "phi" not in own.coordinates:
            return False
        if not kind.placing.free:
            continue
        target = scene.signal_of(holder, kind.placing.free)
        assert target is not None
        freedoms[target] = joint, kind.placing.free, False
        of_joints.append((target, joint, kind.placing.free))
        if kind.placing.free in kind.placing.angle:
            freedoms[scene.signal_of(own, "phi")] = joint, kind.placing.free, False
            freedoms[scene.signal_of(own, RATES["phi"])] = joint, kind.placing.free, True
    fixed = [x.target for x in scene.initial if x.fixed]
    if any(target not in freedoms for target in fixed):  # perhaps velocities of joints; derivatives take long
        freedoms |= {der(target): (joint, free, True) for target, joint, free in of_joints}
    found = [freedoms.get(target) for target in fixed]
    return None not in found and len(set(found)) == len(found)
