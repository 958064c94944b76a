"""Bodies in space that joints hold in parallel planes: the proof, and how their frames lie in these planes.

The proof has two steps, both from the ground outwards. A body turns about the normal k only, if a joint connects it
with such a body and leaves no other rotation: a hinge or a cylindrical joint about k, a slider, a planar joint, a weld.
If all bodies do, one stays in its planes, if a joint keeps a point of it at the height of a point of another such body:
a hinge, a ball joint, a slider across k. What a joint leaves free follows from its rows. Forces hold no body: motions
out of the plane that happen not to be excited are no proof.

Attitudes of held bodies are R = E Rz(phi) A: E has the columns e1, e2, k, the angle phi is the coordinate in the plane,
and A, which maps body axes to axes of the plane at phi = 0, is constant. With the ground at phi = 0, its A is E^T.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from math import atan2, cos, hypot, sin

from mbdsl.elements.kind import Kind
from mbdsl.elements.row_derivatives import Freedom, freedom
from mbdsl.mechanism.edge import Edge
from mbdsl.mechanism.energies import gravity
from mbdsl.mechanism.graph import GROUND, MechanismGraph
from mbdsl.mechanism.poses import turned
from mbdsl.mechanism.scene import Frame
from mbdsl.mechanism.scene_parts import SpatialFrame

Vector = tuple[float, ...]

RIGID, POINT = 6, 3  #: coordinates of a rigid body and of a point mass in space
SAME = 1e-12  #: difference of axes, and of heights relative to the largest distance in a body, that is rounding
AXES = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))


@dataclass(frozen=True)
class InPlane:
    """A frame or body in the plane: its pose in the planar axes of its body, and what is constant out of the plane.

    With phi the planar angle of the frame, its axes are E Rz(phi) C, where ``axes`` are the columns of C (9).
    """

    x: float
    y: float
    phi: float
    axes: Vector
    height: float  #: of its origin along k, in the world [m]

    @property
    def k(self) -> Vector:
        """k in the axes of the frame."""
        return self.axes[2], self.axes[5], self.axes[8]


@dataclass(frozen=True)
class Plane:
    """The planes with the normal k that a group of bodies moves in."""

    axes: Vector  #: e1, e2 and k in world axes
    bodies: Mapping[str, Vector]  #: A of each body, as its columns
    frames: Mapping[str, InPlane]  #: all frames of these bodies and of the ground

    @property
    def normal(self) -> Vector:
        return self.axes[6:]

    @cached_property
    def _size(self) -> float:
        return max((abs(x) for f in self.frames.values() for x in (f.x, f.y, f.height)), default=0.0)

    def same_height(self, a: str, b: str) -> bool:
        """Whether two frames are in the same plane."""
        return abs(self.frames[a].height - self.frames[b].height) <= SAME * self._size


def plane_of(graph: MechanismGraph) -> Plane | None:
    """The planes that all bodies of a mechanism in space are held in; None if some body is not held in any."""
    scene = graph.scene
    if any(len(c.coordinates) not in (RIGID, POINT) for c in graph.bodies.values()):
        return None
    at: dict[str, list[Edge]] = {GROUND: [], **{body: [] for body in graph.bodies}}
    for e in graph.joints:
        if in_plane(e.component.kind) and e.body_i != e.body_j:
            at[e.body_i].append(e)
            at[e.body_j].append(e)
    normal = _normal(graph, at)
    k = None if normal is None else _normals(graph, at, normal)
    heights = None if k is None else _heights(graph, at, k)
    if k is None or heights is None:
        return None
    maps = {body: _map(own) for body, own in k.items()}
    frames = {}
    for name, frame in scene.frames.items():
        owner = frame.body if frame.body in graph.bodies else GROUND
        assert isinstance(frame, SpatialFrame)
        frames[name] = _in_plane(frame, maps[owner], heights[owner])
    ground = maps.pop(GROUND)
    return Plane(tuple(ground[3 * j + i] for i in range(3) for j in range(3)), maps, frames)


#: numbers of axes along which, and about which, joints leave motions that have counterparts in a plane
IN_PLANE = ((0, 0), (0, 1), (0, 3), (1, 0), (1, 1), (1, 3), (2, 1), (2, 3))


def in_plane(kind: Kind) -> tuple[int, int] | None:
    """The entry of ``IN_PLANE`` of a joint in space; None if it may have no counterpart in a plane."""
    free = freedom(kind)
    found = None if free is None else (len(free.slides), len(free.turns))
    return found if found in IN_PLANE else None


def _freedom(e: Edge) -> Freedom:
    """The freedom of a joint that may have a counterpart in a plane."""
    free = freedom(e.component.kind)
    assert free is not None
    return free


def is_point(graph: MechanismGraph, body: str) -> bool:
    """Whether it is a point mass, which does not turn."""
    return body in graph.bodies and len(graph.bodies[body].coordinates) == POINT


def aligned(plane: Plane, a: str, b: str) -> bool:
    """Whether k has the same components in the axes of two frames."""
    return all(abs(x - y) <= SAME for x, y in zip(plane.frames[a].k, plane.frames[b].k, strict=True))


def _normals(graph: MechanismGraph, at: Mapping[str, Sequence[Edge]], normal: Vector) -> dict[str, Vector] | None:
    """k in the axes of each body; None if some body may turn about another axis. Point masses do not turn."""
    frames = graph.scene.frames
    found = {GROUND: normal, **{body: normal for body in graph.bodies if is_point(graph, body)}}
    pending = list(found)
    for body in pending:
        for e in at[body]:
            other = e.other(body)
            turns = _freedom(e).turns
            if other in found or len(turns) > 1:
                continue
            own, far = _ends(frames, e, body)
            along = tuple(_dot(axis, found[body]) for axis in _axes(own))
            if not turns or all(abs(x) <= SAME for i, x in enumerate(along) if i not in turns):
                found[other] = _unit(turned(far.axes, along))
                pending.append(other)
    return found if len(found) > len(graph.bodies) else None


def _heights(
    graph: MechanismGraph, at: Mapping[str, Sequence[Edge]], k: Mapping[str, Vector]
) -> dict[str, float] | None:
    """The height of each body's reference point along k [m]; None if some body may move along k."""
    frames = graph.scene.frames
    found = {GROUND: 0.0}
    pending = [GROUND]
    for body in pending:
        for e in at[body]:
            other = e.other(body)
            if other in found:
                continue
            own, far = _ends(frames, e, body)
            first, owner = (own, body) if body == e.body_i else (far, other)
            along = tuple(_dot(axis, k[owner]) for axis in _axes(first))
            if all(abs(along[i]) <= SAME for i in _freedom(e).slides):
                found[other] = found[body] + _dot(k[body], _origin(own)) - _dot(k[other], _origin(far))
                pending.append(other)
    return found if len(found) > len(graph.bodies) else None


def _normal(graph: MechanismGraph, at: Mapping[str, Sequence[Edge]]) -> Vector | None:
    """The only direction that k can have: that of the first hinge or planar joint on bodies that do not turn; if there
    is none, of a cylindrical joint there, or else one across all sliders."""
    frames = graph.scene.frames
    attitude: dict[str, Vector] = {GROUND: sum(AXES, ())}
    pending, slides, others = [GROUND], list[Vector](), list[Vector]()
    for body in pending:
        for e in at[body]:
            own, far = _ends(frames, e, body)
            world = tuple(turned(attitude[body], axis) for axis in _axes(own))
            free, turn = _freedom(e)
            other = e.other(body)
            if len(turn) == 1 and turn[0] not in free:
                return _signed(world[turn[0]])
            slides += [world[i] for i in free if not turn]
            others += [world[i] for i in free if turn == free]
            if other not in attitude and not turn:
                pending.append(other)
                # R own = R' far
                columns = zip(*(_axes(far)), strict=True)
                attitude[other] = sum((turned(sum(world, ()), row) for row in columns), ())
    if others:
        return _signed(others[0])
    if not slides:
        return None
    for other_axis in (*slides[1:], gravity(graph.scene), *AXES):
        across = _cross(slides[0], other_axis)
        if hypot(*across) > 1e-6 * hypot(*other_axis):
            return _signed(across)
    return None


def _signed(k: Vector) -> Vector:
    """The unit vector along k or -k whose largest component is positive; components that are rounding become zero."""
    largest = max(k, key=abs)
    return _unit(tuple(x / largest if abs(x) > SAME * abs(largest) else 0.0 for x in k))


def _map(k: Vector) -> Vector:
    """The columns of the rotation whose third row is k, and whose first row is near the x axis, or else the y axis."""
    start = AXES[0] if hypot(k[1], k[2]) > 1e-3 else AXES[1]
    along = _dot(start, k)
    p = _unit(tuple(x - along * y for x, y in zip(start, k, strict=True)))
    q = _cross(k, p)
    return tuple(row[i] for i in range(3) for row in (p, q, k))


def _in_plane(frame: SpatialFrame, A: Vector, height: float) -> InPlane:
    x, y, z = turned(A, _origin(frame))
    columns = [turned(A, axis) for axis in _axes(frame)]
    first = columns[0] if hypot(*columns[0][:2]) > 1e-3 else columns[1]
    phi = atan2(first[1], first[0])
    c, s = cos(phi), sin(phi)
    if abs(s) <= SAME:
        c, s = (1.0, 0.0) if c > 0.0 else (-1.0, 0.0)
    axes = sum(((c * a + s * b, c * b - s * a, d) for a, b, d in columns), ())
    return InPlane(x, y, phi, axes, height + z)


def _ends(frames: Mapping[str, Frame], e: Edge, body: str) -> tuple[SpatialFrame, SpatialFrame]:
    """The frames of a joint on ``body`` and on the other one."""
    a, b = (frames[e.component.ports[port]] for port in e.component.kind.ports)
    assert isinstance(a, SpatialFrame) and isinstance(b, SpatialFrame)
    return (a, b) if body == e.body_i else (b, a)


def _axes(frame: SpatialFrame) -> tuple[Vector, Vector, Vector]:
    return frame.axes[:3], frame.axes[3:6], frame.axes[6:]


def _origin(frame: SpatialFrame) -> Vector:
    return frame.x, frame.y, frame.z


def _dot(a: Iterable[float], b: Iterable[float]) -> float:
    return sum(x * y for x, y in zip(a, b, strict=True))


def _cross(a: Vector, b: Vector) -> Vector:
    return a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]


def _unit(a: Vector) -> Vector:
    length = hypot(*a)
    return tuple(x / length for x in a)
