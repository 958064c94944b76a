"""Forces in the sections of rods and beams: the equilibrium of the part beyond a section.

With the loads F, T at r_f of joints and forces on the part between the section at r_0 and frame b, the mass m per
length and the rotary inertia J per length, the part exerts on the rest

    R = sum F + int m (g - a) dx,   M = sum (T + (r_f - r_0) x F) + int m (r - r_0) x (g - a) dx - int J phi'' dx

For a beam this is more accurate than E I times the curvature of the shape functions, whose second derivatives converge
more slowly than the motion; in statics it is exact.

Joints that slide or roll along a rigid rod act where they touch it; drivers and springs along a line act at their
frames, which they connect. A guide off the axis of the rod, or on a body that deforms, is a part of its own: how the
rod carries it between its frame and the point of contact is not known.
"""

from __future__ import annotations

from functools import cached_property
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from mbdsl.errors import UsageError
from mbdsl.kernels.arrays import Array
from mbdsl.mechanism import scene_parts as scenes
from mbdsl.mechanism import sections
from mbdsl.mechanism.energies import gravity
from mbdsl.mechanism.scene import Component
from mbdsl.mechanism.scene_parts import SpatialFrame
from mbdsl.simulation.frame_accelerations import MotionStates, acceleration

POINTS = 3  #: of Gauss, in each interval: exact for a rigid rod, and for cubic functions of beams times a lever
MOST_INTERVALS = 16  #: of a beam with more elements, an interval is several elements
SAME = 1e-9  #: distance of sections that are one, over the length
ON_AXIS = 1e-4  #: distance of a point from the axis that counts as an error of the constraints, over the length


class AppliedLoad(NamedTuple):
    """What an element exerts: force (N, 2) or (N, 3) and moment (N, 3) about a place, the origin of its frame."""

    element: str
    frame: float  #: distance of the frame from the middle [m]
    x: float | Array  #: that of the point where it acts (N,)
    known: bool | Array  #: whether the load passes to the rod at this point, not between it and the frame (N,)
    force: Array
    moment: Array
    place: Array


class Sections:
    """The sections of a rod or beam at N states.

    Parameters
    ----------
    states : States
        N states.
    body : Component
        A rod or beam.
    """

    def __init__(self, states: MotionStates, body: Component) -> None:
        self.states, self.body = states, body
        self.n = 3 if states.scene.spatial else 2
        self.length = float(body.values["length"])
        self._points: dict[float, tuple[Array, Array]] = {}  #: accelerations and places of points of integration
        self._known: dict[float, dict[str, Array]] = {}

    @cached_property
    def loads(self) -> list[AppliedLoad]:
        """The loads of all joints and forces on the body, in the order of the model."""
        scene = self.states.scene
        return [self._load(x) for x in scene.loads({k for k, f in scene.frames.items() if f.body == self.body.name})]

    def _load(self, load: scenes.Load) -> AppliedLoad:
        scene, n = self.states.scene, self.n
        keys = [scene.signal(f"{load.frame}.{i}") for i in "xyz"[:n]]
        values = np.column_stack(self.states.evaluate([*load.force, *keys, *load.torque, *load.point]))
        force, place = values[:, :n], values[:, n : 2 * n]
        moment = values[:, 6:9] if n == 3 else _about_z(values[:, 4])
        frame = scene.frames[load.frame].x
        x, known = self._contact(values[:, -n:], frame) if load.point else (frame, True)
        return AppliedLoad(load.element, frame, x, known, force, moment, place)

    def _contact(self, point: Array, frame: float) -> tuple[Array, Array]:
        """Where a point (N, 2) or (N, 3) is along the axis, and whether what slides there loads the body there."""
        d, axis = point - self._place(0.0), self._axes(0.0)[0]
        x = (d * axis).sum(axis=1)
        off = np.linalg.norm(d - x[:, None] * axis, axis=1)
        near = ON_AXIS * self.length
        return np.where(abs(x - frame) < near, frame, x), (off < near) & (not self.body.deforms)

    def section(self, x: float) -> dict[str, Array]:
        """The signals (N,) [N, N.m] of the section at a distance x [m] from the middle, by their keys."""
        if x not in self._known:
            self._known[x] = self._section(x)
        return self._known[x]

    def _section(self, x: float) -> dict[str, Array]:
        states, n, N = self.states, self.n, len(self.states.t)
        origin = self._place(x)
        force, moment = np.zeros((N, n)), np.zeros((N, 3))
        for load in self.loads:
            beyond = _beyond(load.x, x, self.length)
            if np.any(~np.asarray(load.known) & (beyond != _beyond(load.frame, x, self.length))):
                raise self._unknown(load, x)
            if beyond.any():
                force += np.where(beyond[..., None], load.force, 0.0)
                turning = _moment(load.place - origin, load.force) + load.moment
                moment += np.where(beyond[..., None], turning, 0.0)
        mass = float(self.body.kind.table(self.body.values)[0])
        field, rotary = np.array(gravity(states.scene), float), float(self.body.values.get("rotary") or 0.0)
        for at, weight in zip(*_points(self.body, x, self.length), strict=True):
            if at not in self._points:
                self._points[at] = acceleration(states, self.body.name, _pose(at, n)), self._place(at)
            a, place = self._points[at]
            weighs = mass * weight / self.length * (field - a[:, :n])
            force += weighs
            moment += _moment(place - origin, weighs)
            if rotary:
                moment -= _about_z(rotary * weight * a[:, 2])
        return self._components(x, force, moment)

    def coordinate(self, x: float, key: str) -> Array:
        """A coordinate (N,) of the section at x."""
        tables, states = self.states.system.tables, self.states
        model, d = tables.models[self.body.name], tables.coordinates[self.body.name]
        q, v = states.q[:, d : d + model.n], states.v[:, d : d + model.n]
        return model.frame(_pose(x, self.n), key, q, v, states.t)

    def _place(self, x: float) -> Array:
        return np.column_stack([self.coordinate(x, key) for key in "xyz"[: self.n]])

    def _axes(self, x: float) -> list[Array]:
        """The axes (N, 2) or (N, 3) of the section at x."""
        if self.n == 3:
            return [np.column_stack([self.coordinate(x, i + j) for j in "xyz"]) for i in "xyz"]
        phi = self.coordinate(x, "phi")
        c, s = np.cos(phi), np.sin(phi)
        return [np.column_stack([c, s]), np.column_stack([-s, c])]

    def _unknown(self, load: AppliedLoad, x: float) -> UsageError:
        body, why = self.body.name, "off its axis"
        if self.body.deforms:
            why = "which deforms as if the load acted at frame_a"
        return UsageError(
            f"`{load.element}` slides past the section at {x + self.length / 2:.6g} m from {body}.a along {body}, "
            f"{why}: the forces in this section are not known",
            hint="sections that are not between frame_a and the slider are known; on a Rod, all are if the slider is "
            "on the axis of the rod",
        )

    def _components(self, x: float, force: Array, moment: Array) -> dict[str, Array]:
        """Force and moment in the axes of the section, as signals."""
        if self.n == 3:
            axes = self._axes(x)
            found = {key: (force * a).sum(axis=1) for key, a in zip(("N", "Qy", "Qz"), axes, strict=True)}
            found |= {key: (moment * a).sum(axis=1) for key, a in zip(("Mx", "My", "Mz"), axes, strict=True)}
            return found | {"Q": found["Qy"], "M": found["Mz"]}
        phi = self.coordinate(x, "phi")
        c, s = np.cos(phi), np.sin(phi)
        (fx, fy), m = force.T, moment[:, 2]
        return dict(zip(sections.UNITS, (c * fx + s * fy, c * fy - s * fx, m), strict=True))


def of_frame(states: MotionStates, name: str) -> dict[str, Array]:
    """The signals (N,) of the section at a frame of a rod or beam."""
    scene = states.scene
    frame = scene.frames[scene.aliases.get(name, name)]
    found = Sections(states, scene.components[frame.body]).section(frame.x)
    return {f"{name}.{key}": values for key, values in found.items()}


def _beyond(at: float | Array, x: float, length: float) -> NDArray[np.bool_]:
    """Whether loads belong to the part beyond a section; at the section itself, to the nearer end."""
    at = np.asarray(at)
    return np.where(abs(at - x) <= SAME * length, x >= -SAME * length, at > x)


def _points(body: Component, x: float, length: float) -> tuple[Array, Array]:
    """Points of Gauss from the section to frame b, and their weights [m]."""
    elements = int(body.values["elements"]) if body.deforms and body.values["modes"] != 0 else 1
    ends = np.linspace(-length / 2, length / 2, min(elements, MOST_INTERVALS) + 1)
    ends = np.concatenate([[x], ends[ends > x + SAME * length]])
    own, weights = np.polynomial.legendre.leggauss(POINTS)
    half = 0.5 * np.diff(ends)
    places = (ends[:-1] + half)[:, None] + half[:, None] * own
    return places.ravel(), (half[:, None] * weights).ravel()


def _pose(x: float, n: int) -> tuple[float, ...]:
    return (x, 0.0, 0.0) if n == 2 else (x, 0.0, 0.0, *SpatialFrame.axes)


def _moment(lever: Array, force: Array) -> Array:
    """lever x force (N, 3)."""
    if lever.shape[1] == 3:
        return np.cross(lever, force)
    return _about_z(lever[:, 0] * force[:, 1] - lever[:, 1] * force[:, 0])


def _about_z(moment: Array) -> Array:
    return np.column_stack([np.zeros((len(moment), 2)), moment])
