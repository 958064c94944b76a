"""Pictures of models in space: a parallel projection to the plane of the picture, whose points are then drawn as in it.

With the direction c towards the viewer, a point p has the picture coordinates (r . p, u . p), r to the right and u
upwards: unit vectors with r x u = c. In the isometric view the three axes make equal angles with the picture.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from math import asin, cos, hypot, pi, radians, sin, sqrt
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from mbdsl.elements.kind import BodyKind
from mbdsl.errors import UsageError
from mbdsl.mechanism.scene import Component, Scene
from mbdsl.messages import did_you_mean
from mbdsl.simulation.trajectory import Trajectory
from mbdsl.system.body_models import body_pose
from mbdsl.system.tables import gravity
from mbdsl.viewing.motion import GROUND, MOST_FRAMES, Motion, Spot, frames_of_bodies, is_apart, motion, shown_rows
from mbdsl.viewing.shape import Shape
from mbdsl.viewing.space.motion import SpaceMotion
from mbdsl.viewing.space.vectors import FORCE, SpaceVector
from mbdsl.viewing.vectors import Vector

Array = NDArray[np.float64]

#: view -> azimuth and elevation of the viewer [rad]; the front is seen from -y where z is vertical
VIEWS = {
    "iso": (radians(-45), asin(1 / sqrt(3))),
    "front": (radians(-90), 0.0),
    "side": (0.0, 0.0),
    "top": (radians(-90), radians(90)),
}
FLAT = 1.2  #: ratio of moments of inertia up to which a body counts as a thin disc
RIM = 24  #: number of points of a disc's edge
#: drawings of elements that are drawn as a pin, that are not drawn, between both frames, at frame_b; others as a mark
PINS = ("hinge", "ball", "cross")
HIDDEN = ("nothing", "turning", "spiral")
BETWEEN = ("rope", "rod", "actuator")
AT_B = ("bushing",)


class View(NamedTuple):
    """Unit vectors (3,) of the picture: to the right, upwards, and towards the viewer."""

    right: Array
    up: Array
    towards: Array

    def of(self, points: Array) -> Array:
        """Picture coordinates and nearness (..., 3) of points (..., 3)."""
        return np.stack([points @ axis for axis in self], axis=-1)


def view(scene: Scene, name: str) -> View:
    """A view of a model; vertical is the direction opposite to gravity, or z without gravity.

    Raises
    ------
    UsageError
        If there is no such view.
    """
    if name not in VIEWS:
        raise UsageError(f"there is no view `{name}`", hint=did_you_mean(name, VIEWS, "views"))
    g = np.array(gravity(scene), float)
    vertical = -g / np.linalg.norm(g) if g.any() else np.array([0.0, 0.0, 1.0])
    start = np.eye(3)[0] if abs(vertical[0]) < 0.9 else np.eye(3)[1]
    x = start - (start @ vertical) * vertical
    x = x / np.linalg.norm(x)
    y = np.cross(vertical, x)
    azimuth, elevation = VIEWS[name]
    towards = cos(elevation) * (cos(azimuth) * x + sin(azimuth) * y) + sin(elevation) * vertical
    right = -sin(azimuth) * x + cos(azimuth) * y
    return View(right, np.cross(towards, right), towards)


@dataclass
class SpatialMotion(Motion):
    """A motion whose tracks are the projected frames of bodies, and points on the edges of discs and plates.

    Attributes
    ----------
    seen : View
        The view.
    near : (T,) [m]
        Mean position of the tracks towards the viewer.
    rims : dict of str to list of Spot
        The edge of a disc or a plate, by the name of the body.
    """

    seen: View = field(default_factory=lambda: View(*np.eye(3)))
    near: Array = field(default_factory=lambda: np.zeros(0))
    rims: dict[str, list[Spot]] = field(default_factory=dict)

    @property
    def points(self) -> list[Spot]:
        """All frames, and the edges of discs and plates."""
        return [*self.spots.values(), *(spot for rim in self.rims.values() for spot in rim)]


def projected(trajectory: Trajectory, name: str = "iso", most: int = MOST_FRAMES) -> SpatialMotion:
    """The projected motion of a trajectory of a model in space.

    Raises
    ------
    UsageError
        If the trajectory is empty, or if there is no such view.
    """
    scene, system = trajectory.scene, trajectory.system
    seen = view(scene, name)
    owners = frames_of_bodies(scene)
    count = sum(len(frames) for frames in owners.values()) + RIM * len(scene.components)
    rows = shown_rows(trajectory, most, 3 * count)
    t, q, v = trajectory.t[rows], trajectory.q[rows], trajectory.v[rows]
    tracks: list[str] = []
    places: list[Array] = []
    spots: dict[str, Spot] = {}
    rims: dict[str, list[Spot]] = {}
    discs = dict(_discs(scene))
    if not any(_has_arms(scene.components[body], scene, frames) for body, frames in owners.items()):
        discs = dict(_plates(scene)) | discs
    for body, frames in owners.items():
        component, model = scene.components[body], system.tables.models.get(body)
        d = system.tables.coordinates.get(body, 0)

        def place(pose, model=model, d=d) -> Array:
            own = slice(d, d + model.n)
            return np.stack([model.frame(pose, key, q[:, own], v[:, own], t) for key in "xyz"], axis=-1)

        for frame in frames:
            pose = body_pose(component, scene.frames[frame])
            if model is None:
                x, y, _ = seen.of(np.array(pose[:3], float))
                spots[frame] = Spot(GROUND, float(x), float(y))
            else:
                spots[frame] = Spot(len(tracks))
                tracks.append(frame)
                places.append(place(pose))
        if model is not None and body in discs:
            rims[body] = [Spot(len(tracks) + k) for k in range(len(discs[body]))]
            for point in discs[body]:
                tracks.append(f"{body}.rim")
                places.append(place((*point.tolist(), *np.eye(3).ravel().tolist())))
    all_places = np.stack(places, axis=1) if places else np.zeros((len(rows), 0, 3))
    picture = seen.of(all_places)
    poses = np.concatenate([picture[..., :2], np.zeros_like(picture[..., :1])], axis=-1)
    near = np.nan_to_num(picture[..., 2]).mean(axis=0)
    return SpatialMotion(scene, np.asarray(t), rows, tracks, poses, spots, owners, seen=seen, near=near, rims=rims)


def pictured(trajectory: Trajectory, most: int = MOST_FRAMES) -> Motion:
    """The motion of a trajectory in a picture: of a model in space its isometric view."""
    return projected(trajectory, most=most) if trajectory.scene.spatial else motion(trajectory, most)


def _discs(scene: Scene) -> Iterator[tuple[str, Array]]:
    """Bodies that are shown as discs, and points (RIM, 3) of their edges relative to the centre of mass."""
    for c in scene.components.values():
        if c.kind.name == "RollingDisc":
            frame = scene.frames[c.ports["frame_b"]]
            body, radius = scene.components[frame.body], c.values["radius"]
            pose = np.array(body_pose(body, frame), float)
            axes = pose[3:].reshape(3, 3).T  # from the frame's axes, whose x axis is that of the disc
            yield frame.body, pose[:3] + _circle(axes @ np.array([1.0, 0.0, 0.0]), radius)
        elif c.kind.name == "Cylinder" and c.values["length"] < 2 * c.values["radius"]:
            yield c.name, _circle(np.array(c.values["n"], float), c.values["radius"])
        elif c.kind.name == "Body" and c.values["m"] > 0.0 and not isinstance(c.values["I"][0], tuple):
            low, middle, high = np.sort(c.values["I"])
            if low > 0.0 and middle < FLAT * low and high > (low + middle) / FLAT:  # as of a thin disc: C = A + B
                axis = np.eye(3)[int(np.argmax(c.values["I"]))]
                yield c.name, _circle(axis, sqrt(2 * high / c.values["m"]))


def _has_arms(c: Component, scene: Scene, frames: Sequence[str]) -> bool:
    """Whether a body that moves has frames apart from its centre of mass."""
    arms = [hypot(*body_pose(c, scene.frames[name])[:3]) for name in frames]
    return bool(c.kind.coordinates) and is_apart(max(arms), np.zeros(0))


def _plates(scene: Scene) -> Iterator[tuple[str, Array]]:
    """Bodies that turn, and the corners (4, 3) of the largest section of the cuboid with their moments of inertia."""
    for c in scene.bodies():
        m, *J = c.kind.table(dict(c.values))  # type: ignore[attr-defined]
        if "rx" not in c.kind.coordinates or m <= 0.0:
            continue
        moments, axes = np.linalg.eigh(np.array(J, float).reshape(3, 3))  # the least is that about the longest edge
        edges = np.sqrt(np.maximum(6.0 * (moments.sum() - 2.0 * moments) / m, 0.0))  # J_x = m (b^2 + c^2)/12
        if moments[0] > 0.0:
            signs = np.array([[1.0, 1.0], [-1.0, 1.0], [-1.0, -1.0], [1.0, -1.0]])
            yield c.name, (signs * edges[:2] / 2) @ axes[:, :2].T


def _circle(normal: Array, radius: float) -> Array:
    n = normal / np.linalg.norm(normal)
    a = np.cross(n, np.eye(3)[int(np.abs(n).argmin())])
    a = a / np.linalg.norm(a)
    angle = 2 * pi * np.arange(RIM) / RIM
    return radius * (np.outer(np.cos(angle), a) + np.outer(np.sin(angle), np.cross(n, a)))


def shapes(motion: SpatialMotion) -> list[Shape]:
    """Bodies as bars between their frames, discs by their edges, joints and forces by symbols; far ones first."""
    scene = motion.scene
    ports = {frame for c in scene.components.values() for frame in c.ports.values()}
    found = [shape for c in scene.bodies() for shape in _body(c, motion, ports)]
    found += [shape for c in scene.components.values() for shape in _element(c, motion)]
    grounded = dict.fromkeys(motion.spot_of(frame) for frame in sorted(ports))
    found += [Shape("weld", "", (spot,)) for spot in grounded if spot.track == GROUND]

    def key(shape: Shape) -> tuple[int, float]:
        moving = [motion.near[spot.track] for spot in shape.at if spot.track != GROUND]
        return shape.draw in ("pin", "mark", "weld"), float(np.mean(moving)) if moving else -np.inf

    return sorted(found, key=key)


def _body(c: Component, motion: SpatialMotion, ports: set[str]) -> Iterator[Shape]:
    centre = motion.spots[f"{c.name}.c"]
    if c.name in motion.rims:
        yield Shape("disc", c.name, tuple(motion.rims[c.name]))
    if "rx" not in c.kind.coordinates:
        yield Shape("mass", c.name, (centre,))
        return
    named = [name for name in motion.frames[c.name] if name != f"{c.name}.c"]
    held = [motion.spots[name] for name in named if _apart(motion, centre, motion.spots[name])]
    if len(held) == 2 and f"{c.name}.c" not in ports and c.name not in motion.rims:
        yield Shape("bar", c.name, (held[0], held[1]))
        return
    for spot in held:
        yield Shape("bar", c.name, (centre, spot))
    if not held and len(motion.rims.get(c.name, ())) != RIM:
        yield Shape("mass", c.name, (centre,))


def _apart(motion: SpatialMotion, a: Spot, b: Spot) -> bool:
    """Whether two places of a body ever differ; joints add frames at places of others."""
    away = motion.poses[:, a.track] - motion.poses[:, b.track]
    return bool(np.nanmax(np.abs(away), initial=0.0) > 1e-9 * np.nanmax(np.abs(motion.poses), initial=0.0))


def _element(c: Component, motion: SpatialMotion) -> Iterator[Shape]:
    if isinstance(c.kind, BodyKind) or len(c.ports) != 2 or c.kind.drawing in HIDDEN:
        return
    a, b = (motion.spot_of(frame) for frame in c.ports.values())
    drawing = c.kind.drawing
    if drawing in BETWEEN:
        yield Shape(drawing, c.name, (a, b))
    elif drawing == "spring":
        k, damping = c.values.get("k"), c.values.get("c")
        draw = "spring" if not damping else "damper" if not k else "spring-damper"
        pa, pb = motion.pose(a), motion.pose(b)
        length = np.hypot(pb[:, 0] - pa[:, 0], pb[:, 1] - pa[:, 1])
        length = length[np.isfinite(length)] if np.isfinite(length).any() else np.zeros(1)
        data = {"low": float(length.min()), "high": float(length.max()), "mean": float(length.mean())}
        yield Shape(draw, c.name, (a, b), data)
    elif drawing in AT_B:
        yield Shape(drawing, c.name, (b, a))
    elif drawing in PINS:
        yield Shape("pin", c.name, (a,))
    else:
        yield Shape("mark", c.name, (b, a))


def projected_vectors(found: Sequence[SpaceVector], motion: SpatialMotion, solid: SpaceMotion) -> list[Vector]:
    """Forces in the plane of the picture, at the rows of the projected motion."""
    rows = np.searchsorted(solid.t, motion.t).clip(0, len(solid.t) - 1)
    names = {place: name for name, place in solid.spots.items()}
    values = [motion.seen.of(v.values[rows])[:, :2] for v in found]
    return [
        Vector(v.name, v.group, motion.spots[names[v.at]], flat)
        for v, flat in zip(found, values, strict=True)
        if v.kind == FORCE and np.isfinite(flat).any() and np.nanmax(np.abs(flat)) > 0.0
    ]
