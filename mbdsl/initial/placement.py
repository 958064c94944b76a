"""Initial placement of bodies, from the ground outwards: at initial values, else as the joints require.

A joint's kind declares the motions that place a body by it as ``angle`` and ``along``, or as ``moves``.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from math import atan2, hypot
from typing import NamedTuple

import numpy as np

from mbdsl.elements.kind import JointKind
from mbdsl.expressions.spatial_coordinates import CARDAN, named
from mbdsl.expressions.symbolic import Expr, expr, leaves
from mbdsl.initial.counted_angles import count_from, nearest, turn_of
from mbdsl.kernels.arrays import Array
from mbdsl.mechanism.given_attitudes import given_attitudes
from mbdsl.mechanism.graph import MechanismGraph, Placement
from mbdsl.mechanism.poses import PlanarPose, Pose, SpatialPose, pose, turned_successively
from mbdsl.mechanism.scene import Component, InitialValue, Scene
from mbdsl.system.body_models import body_pose
from mbdsl.system.signals import values
from mbdsl.system.system import System


def place(system: System, graph: MechanismGraph, t: float, given: list[InitialValue]) -> Array:
    """Coordinates (n,) of all bodies, from the ground outwards: at initial values, else as the joints require."""
    placed = _Placed(system, t, given)
    for placement in graph.tree():
        placed.put(placement)
    if system.scene.spatial:
        angles = {driver.component.name: driver.value for driver in placed.drivers if driver.turns}
        count_from(system, t, placed.q, placed.said, placed.turns, angles)
    return placed.q


class _Driver(NamedTuple):
    """A joint that prescribes a coordinate: whether it is an angle, its name, and its value at the start."""

    component: Component
    turns: bool
    name: str
    value: float


class _Motion(NamedTuple):
    """A motion that a joint leaves: the signals and parameters that are its coordinate, and the way of frame_b."""

    names: tuple[str, ...]
    way: str  #: along or about an axis: "x", "rz"


def _motions(kind: JointKind) -> tuple[_Motion, ...]:
    """One after the other; by default one along x and one about z."""
    if kind.placing.moves:
        return tuple(_Motion((name,), way) for name, way in kind.placing.moves)
    return _Motion(kind.placing.along, "x"), _Motion(kind.placing.angle, "rz")


class _JoinedBody(NamedTuple):
    """A body at a joint: the joint, whether the body is on its frame_b, the frame on the other body, the own frame."""

    joint: Component
    forward: bool
    other: str
    own: str


class _Placed:
    """The bodies that have been placed, and what they are placed by."""

    def __init__(self, system: System, t: float, given: list[InitialValue]) -> None:
        self.system, self.scene, self.t = system, system.scene, t
        self.said: dict[Expr | None, float] = {x.target: x.value for x in sorted(given, key=lambda x: x.fixed)}
        #: signals are evaluated only where initial values contain the coordinates that they depend on
        self.named = {leaf.value for x in given for leaf in leaves(x.target) if leaf.op == "coordinate"}
        self.near = {frame for frame, _ in self.named}
        self.drivers = list(self._prescribed())
        self.attitudes = _attitudes(self.scene, given)
        self.poses: dict[str, Pose] = {}
        self.turns: dict[str, float] = {}  #: body -> its rotation about the z axis, with turns
        self.q = np.zeros(system.n)

    def put(self, placement: Placement) -> None:
        """Place a body after the bodies that it hangs on."""
        scene, body = self.scene, self.scene.components[placement.body]
        origin = [self._given(body, key, key) for key in ("xyz" if scene.spatial else "xy")]
        phi = self._given(body, "phi", "xx" if scene.spatial else "phi")
        attitude = self._attitude(body, placement.joint)
        turn = phi or 0.0
        found: Pose = self._turned(turn)
        if placement.joint is not None:
            held = self._held(placement.joint, body.name)
            driven = self._driven(held.joint)
            if driven is not None:
                origin, phi = [None] * len(origin), None  # a driver has priority over a guess
            elif attitude is None and phi is None and origin[0] is not None and origin[1] is not None:
                phi = self._aimed(held, origin[0], origin[1])
            if phi is not None and not scene.spatial:
                attitude = self._turned(phi)
            found, turn = self._by_joint(held, attitude, phi, driven)
        if attitude is not None:
            found = found.turned_to(attitude)
            if isinstance(attitude, SpatialPose):
                turn = nearest(atan2(attitude.axes[1], attitude.axes[0]), turn)
        found = found.moved_to(origin)
        self.turns[body.name] = turn
        self.poses[body.name] = found
        d, model = self.system.tables.coordinates[body.name], self.system.tables.models[body.name]
        self.q[d : d + model.n] = model.placed(found)[0]
        if not scene.spatial:
            self.system.set_turn(body.name, found[2])

    def _given(self, body: Component, key: str, leaf: str) -> float | None:
        """The initial value of a signal of a body that depends on the coordinate ``leaf`` of its centre of mass."""
        near = (f"{body.name}.c", leaf) in self.named
        return self.said.get(self.scene.signal_of(body, key)) if near else None

    def _by_joint(
        self, held: _JoinedBody, attitude: Pose | None, phi: float | None, driven: float | None
    ) -> tuple[Pose, float]:
        """The pose of a body at which the frames of its joint fit, and its angle about z with turns."""
        joint, forward, other, own = held
        assert isinstance(joint.kind, JointKind)
        motions = _motions(joint.kind)
        moves = [self._known(joint, motion) for motion in motions]
        angle = motions.index(of_angle) if (of_angle := _Motion(joint.kind.placing.angle, "rz")) in motions else None
        between = self._turn(other) - turn_of(self.scene.frames[own])  # of the body if that of the joint is zero
        if angle is not None:
            if driven is not None:
                moves[angle] = driven
            if phi is not None and not moves[angle]:
                moves[angle] = (phi - between) if forward else (between - phi)
        turned = 0.0 if angle is None else moves[angle]
        turn = phi if phi is not None else between + (turned if forward else -turned)
        if attitude is None and phi is not None and "tau" not in joint.kind.reaction:
            attitude = self._turned(turn)  # the joint fixes the position only
        frame, target = self._on_body(own), self._frame(other)
        if attitude is not None and not forward:
            target = target.turned_to(attitude @ frame)
        for k in range(len(motions)) if forward else reversed(range(len(motions))):
            way = motions[k].way
            if moves[k] and (forward or attitude is None or way[0] != "r"):
                target = target.step(way, moves[k] if forward else -moves[k])
        return target.carrying(frame) if attitude is None else target.holding(frame, attitude), turn

    def _known(self, joint: Component, motion: _Motion) -> float:
        """A coordinate of a joint at the start: as given, as driven, or a parameter of the joint; else 0."""
        near = not self.near.isdisjoint(joint.ports.values())
        found = [self.said.get(self.scene.signal_of(joint, name)) for name in motion.names] if near else []
        for driver in self.drivers:
            drives = driver.name in motion.names or (not motion.names and driver.turns == (motion.way == "rz"))
            if drives and driver.component.ports == joint.ports:
                found.append(driver.value)
        found += [x for name in motion.names if isinstance(x := joint.values.get(name), float)]
        return next((float(value) for value in found if value is not None), 0.0)

    def _driven(self, joint: Component) -> float | None:
        """The angle of a joint that a driver between the same frames, in space between the same bodies, prescribes."""
        ends = self._ends(joint)
        for driver in self.drivers:
            own = self._ends(driver.component)
            if driver.turns and own in (ends, ends[::-1]):
                return driver.value if own == ends else -driver.value
        return None

    def _ends(self, c: Component) -> list[str]:
        frames = [c.ports[port] for port in ("frame_a", "frame_b")]
        return [self.scene.frames[name].body for name in frames] if self.scene.spatial else frames

    def _attitude(self, body: Component, joint: str | None) -> Pose | None:
        """The attitude that a body in space has by its initial values; None if the joint determines it."""
        if not self.scene.spatial:
            return None
        angles = [self.said.get(named(f"{body.name}.c", key)) for key in CARDAN]
        found = self.attitudes.get(body.name)
        if found is None and angles.count(None) < 3 and _turns_freely(self.scene, joint):
            # the others are zero: not those of another body, where a part of the angles may be undetermined
            found = SpatialPose.of_axes(turned_successively([x or 0.0 for x in angles]))
        return found

    def _aimed(self, held: _JoinedBody, x: float, y: float) -> float | None:
        """The angle at which a body with a known centre of mass points at its joint, in the plane of x and y."""
        (sx, sy), place = self._on_body(held.own)[:2], self._frame(held.other)
        dx, dy = place[0] - x, place[1] - y
        return atan2(dy, dx) - atan2(sy, sx) if hypot(sx, sy) * hypot(dx, dy) > 0.0 else None

    def _held(self, joint: str, body: str) -> _JoinedBody:
        component = self.scene.components[joint]
        a, b = (component.ports[port] for port in ("frame_a", "frame_b"))
        forward = self.scene.frames[b].body == body
        return _JoinedBody(component, forward, a, b) if forward else _JoinedBody(component, forward, b, a)

    def _turned(self, phi: float) -> Pose:
        return SpatialPose.turn(phi) if self.scene.spatial else PlanarPose.turn(phi)

    def _turn(self, frame: str) -> float:
        """The angle of a frame about the z axis, with turns."""
        if not self.scene.spatial:
            return float(self._frame(frame)[2])
        return self.turns.get(self.scene.frames[frame].body, 0.0) + turn_of(self.scene.frames[frame])

    def _frame(self, name: str) -> Pose:
        """The pose of a frame on a body that has been placed, or on the ground."""
        frame = self.scene.frames[name]
        if frame.motion is not None:
            return pose(self._now(frame.motion))
        own = self._on_body(name)
        return self.poses[frame.body] @ own if frame.body in self.poses else own

    def _on_body(self, name: str) -> Pose:
        frame = self.scene.frames[name]
        return pose(body_pose(self.scene.components[frame.body], frame))

    def _prescribed(self) -> Iterator[_Driver]:
        for c in self.scene.components.values():
            if isinstance(c.kind, JointKind) and c.kind.driver is not None and c.ports:
                (u,) = self._now([expr(c.values[c.kind.driver])])
                yield _Driver(c, c.kind.driver in c.kind.placing.angle, c.kind.driver, u)

    def _now(self, laws: Sequence[Expr]) -> list[float]:
        """The values of laws of time at the start."""
        nowhere = np.zeros((1, self.system.n))
        return [float(x[0]) for x in values(self.system, laws, np.array([self.t]), nowhere, nowhere)]


def _attitudes(scene: Scene, given: list[InitialValue]) -> dict[str, SpatialPose]:
    """The attitudes that initial values give to bodies; fixed values have priority over guesses."""
    found: dict[str, SpatialPose] = {}
    for attitude in given_attitudes(given) if scene.spatial else ():
        frame = scene.frames[attitude.frame]
        own = SpatialPose(body_pose(scene.components[frame.body], frame)[:12]).attitude
        found.setdefault(frame.body, SpatialPose.of_axes(attitude.axes).carrying(own).attitude)
    return found


def _turns_freely(scene: Scene, joint: str | None) -> bool:
    """Whether a body that is placed at a joint may have any attitude."""
    kind = None if joint is None else scene.components[joint].kind
    return kind is None or (isinstance(kind, JointKind) and kind.rows <= 3 and not kind.placing.aligned)
