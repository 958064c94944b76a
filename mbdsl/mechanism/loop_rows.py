"""Joints in loops of moving bodies in space get rows in axes of the joint: see ``JointKind.in_axes``.

Planar loops with the ground as a link keep their plane, and the rows of all their joints are in axes of the world.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

from mbdsl.elements import of_variant
from mbdsl.elements.kind import BodyKind, JointKind
from mbdsl.mechanism.scene import Component, Frame


def with_rows_in_axes(components: dict[str, Component], frames: Mapping[str, Frame]) -> dict[str, Component]:
    """The components, with variants of the joints that are part of a closed loop."""
    looped = in_loops(components, frames)
    found = {name: c for name, c in components.items() if name in looped and c.kind.in_loops}
    return components | {name: replace(c, kind=of_variant(c.kind.in_loops, True).KIND) for name, c in found.items()}


def in_loops(components: Mapping[str, Component], frames: Mapping[str, Frame]) -> set[str]:
    """The joints in loops of moving bodies: without the ground, and drivers do not connect."""
    ends = {}
    for name, c in components.items():
        if isinstance(c.kind, JointKind) and c.kind.driver is None and c.kind.rows:
            bodies = [_body(components, frames[frame].body) for frame in c.ports.values()]
            if len(bodies) == 2 and bodies[0] != bodies[1] and all(bodies):
                ends[name] = bodies
    above: dict[str, tuple[str, str] | None] = {}  # body -> the body and the joint before it in a spanning tree
    depth: dict[str, int] = {}
    at: dict[str, list[tuple[str, str]]] = {}
    for name, (a, b) in ends.items():
        at.setdefault(a, []).append((name, b))
        at.setdefault(b, []).append((name, a))
    tree = set()
    for root in at:
        if root in depth:
            continue
        above[root], depth[root], pending = None, 0, [root]
        for body in pending:  # grows while bodies are found
            for name, other in at[body]:
                if other not in depth:
                    above[other], depth[other] = (body, name), depth[body] + 1
                    tree.add(name)
                    pending.append(other)
    found = set()
    for name in ends.keys() - tree:
        found.add(name)
        a, b = ends[name]
        while a != b:  # up to where both ways meet
            if depth[a] < depth[b]:
                a, b = b, a
            step = above[a]
            assert step is not None
            a, joint = step
            found.add(joint)
    return found


def _body(components: Mapping[str, Component], body: str) -> str:
    """A body, or "" for the ground."""
    kind = components[body].kind
    return body if isinstance(kind, BodyKind) and kind.coordinates else ""
