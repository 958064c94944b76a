"""Point masses that joints turn.

A point mass has no attitude of its own: its frames keep the attitude that the model gives them. A weld or a sliding
joint to a body that turns gives it the attitude of this body: it is then a body without a moment of inertia. A weld
adds its mass, and transmits forces and torques from one side of the point to the other.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

from mbdsl.elements import find
from mbdsl.elements.kind import BodyKind, JointKind, is_point
from mbdsl.mechanism.connected_groups import connected
from mbdsl.mechanism.scene import Component, Frame


def turned_by_joints(components: Mapping[str, Component], frames: Mapping[str, Frame]) -> dict[str, Component]:
    """The components, with a ``Body`` in place of every point mass that welds and sliding joints turn."""
    points = {name for name, c in components.items() if is_point(c.kind)}
    keeping = [c for c in components.values() if isinstance(c.kind, JointKind) and c.kind.placing.keeps_attitude]
    ends = [[frames[frame].body for frame in c.ports.values()] for c in keeping]
    found = dict(components)
    for group in connected(components, ends) if points else ():
        held = points.intersection(group)
        near = [c for c, (body, _) in zip(keeping, ends, strict=True) if body in group]
        if held and (any(_turns(components[name]) for name in group) or any(_inclined(c, frames) for c in near)):
            found |= {name: _body(components[name]) for name in held}
    return found


def _turns(c: Component) -> bool:
    return isinstance(c.kind, BodyKind) and not c.kind.is_frame


def _inclined(joint: Component, frames: Mapping[str, Frame]) -> bool:
    """Whether its frames have different attitudes if those of their bodies are that of the world."""
    a, b = (frames[frame] for frame in joint.ports.values())
    angle = any(joint.values[p.name] for p in joint.kind.parameters if p.unit == "rad")
    return angle or a.pose[3:] != b.pose[3:] or a.phi != b.phi


def _body(point: Component) -> Component:
    kind = find("Body", point.kind.spatial)
    assert isinstance(kind, BodyKind)
    n = 3 if kind.spatial else 2
    values = {"m": point.values["m"], "I": (0.0,) * 3 if kind.spatial else 0.0, "length": None, "com": (0.0,) * n}
    signals = tuple(x.name for x in kind.signals)
    return replace(point, kind=kind, values={**values, "frames": ()}, signals=signals)
