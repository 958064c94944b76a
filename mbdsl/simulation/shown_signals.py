"""The positions that show a motion best: those of joints, drivers and free bodies, and those of other bodies."""

from __future__ import annotations

from mbdsl.elements.kind import JointKind
from mbdsl.mechanism.graph import MechanismGraph
from mbdsl.mechanism.scene import Component
from mbdsl.mechanism.signal_names import QUATERNION


def shown(graph: MechanismGraph) -> list[list[str]]:
    """Names of positions and angles, without those that the name of another one says.

    Coordinates of a joint are the signals by which it places a body. It describes a body if they are at least as many
    as it leaves free: a hinge does, and the distance of a rod does not.

    Parameters
    ----------
    graph : MechanismGraph
        The structure of a model.

    Returns
    -------
    list of list of str
        The coordinates of joints, of drivers, and of bodies that no joint describes; and those of all other bodies.
    """
    spatial = graph.scene.spatial
    joints, drivers, described = [], [], set()
    for e in graph.joints:
        kind, own = e.component.kind, _positions(e.component)
        assert isinstance(kind, JointKind)
        if kind.driver:
            drivers += own
        elif len(own) >= (6 if spatial else 3) - e.rows - e.velocity_rows:
            joints += own
            described.add(e.name)
    free = {p.body for p in graph.tree() if p.joint not in described}
    bodies = {name: _coordinates(body, spatial) for name, body in graph.bodies.items()}
    first = [name for body in bodies if body in free for name in bodies[body]]
    return [[*joints, *drivers, *first], [name for body in bodies if body not in free for name in bodies[body]]]


def _positions(joint: Component) -> list[str]:
    kind = joint.kind
    assert isinstance(kind, JointKind)
    placing = (*kind.placing.along, *kind.placing.angle, *(signal for signal, _ in kind.placing.moves))
    return [f"{joint.name}.{s.name}" for s in kind.signals if s.name in placing]


def _coordinates(body: Component, spatial: bool) -> list[str]:
    """The position of a body and, if it can turn, its angle or quaternion, which is continuous in all attitudes."""
    turns = len(body.kind.coordinates) > (3 if spatial else 2)
    attitude = (QUATERNION if spatial else ("phi",)) if turns else ()
    return [f"{body.name}.{key}" for key in (*("xyz" if spatial else "xy"), *attitude)]
