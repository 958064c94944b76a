"""Pictures of models in space: the solids of the stage in a parallel projection to the plane of the picture.

With the direction c towards the viewer, a point p has the picture coordinates (r . p, u . p), r to the right and u
upwards: unit vectors with r x u = c. In the isometric view the three axes make equal angles with the picture.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from math import asin, cos, radians, sin, sqrt
from typing import Any, NamedTuple

import numpy as np

from mbdsl.errors import UsageError
from mbdsl.kernels.arrays import Array, Integers
from mbdsl.mechanism.scene import Scene
from mbdsl.messages import did_you_mean
from mbdsl.simulation.trajectory import Trajectory
from mbdsl.system.tables import gravity
from mbdsl.viewing import shapes
from mbdsl.viewing.display import ON, PALE, PAPER, ROD, Circle, DrawnPath, Item, Shape, Size, colour_of
from mbdsl.viewing.motion import MOST_FRAMES, is_apart, motion
from mbdsl.viewing.shapes import OF_EXTENT, Drawing
from mbdsl.viewing.space.shapes import drawing as solids_of
from mbdsl.viewing.space.shapes import edge, rounded
from mbdsl.viewing.space.solid import BODY, DRIVE, JOINT, SUPPORT, Solid
from mbdsl.viewing.symbols import PISTON, beside, coils, dashpot, placed, zigzag
from mbdsl.viewing.tracks import GROUND, AnyMotion, Motion, Place, SpaceMotion, Tracks, rotated
from mbdsl.viewing.vectors import FORCE, Vector

#: view -> azimuth and elevation of the viewer [rad]; the front is seen from -y where z is vertical
VIEWS = {
    "iso": (radians(-45), asin(1 / sqrt(3))),
    "front": (radians(-90), 0.0),
    "side": (0.0, 0.0),
    "top": (radians(-90), radians(90)),
}
PALER = 0.7  #: part of the paper's colour in that of areas


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


class Projection(Tracks):
    """The picture of a motion in space: its frames have coordinates in the plane of the picture, and no angles."""

    def __init__(self, solid: SpaceMotion, seen: View) -> None:
        super().__init__(solid.scene, solid.t, solid.rows, solid.tracks, solid.poses, solid.spots, solid.frames)
        self.solid, self.seen = solid, seen
        self._known: dict[int, tuple[Sequence[Place], Integers, Array]] = {}

    def positions(self, spot: Place) -> Array:
        return self.seen.of(self.solid.positions(spot))[:, :2]

    def nearness(self, shape: Shape) -> float:
        """Mean position [m] towards the viewer; things on the ground are behind all others."""
        moving = [place for place in shape.at if isinstance(place, Place) and place.track != GROUND]
        near = [self.solid.positions(place) @ self.seen.towards for place in moving]
        return float(np.nan_to_num(near).mean()) if near else -np.inf

    def places(self, at: Sequence[Place], row: int) -> Array:
        """The places (n, 3) of n frames in the picture [m], and zero for their angles."""
        if id(at) not in self._known:
            tracks, r = np.array([place.track for place in at]), np.array([place.r for place in at], float)
            self._known[id(at)] = at, tracks, r
        _, tracks, r = self._known[id(at)]
        found, moving = r.copy(), tracks != GROUND
        poses = self.poses[row, tracks[moving]]
        found[moving] = poses[:, :3] + rotated(poses[:, 3:], r[moving])
        return self.seen.of(found) * (1.0, 1.0, 0.0)


def projected(trajectory: Trajectory, name: str = "iso", most: int = MOST_FRAMES) -> Projection:
    """The projected motion of a trajectory of a model in space.

    Raises
    ------
    UsageError
        If the trajectory is empty, or if there is no such view.
    """
    seen = view(trajectory.scene, name)
    solid = motion(trajectory, most)
    assert isinstance(solid, SpaceMotion)
    return Projection(solid, seen)


def pictured(trajectory: Trajectory, most: int = MOST_FRAMES) -> Motion | Projection:
    """The motion of a trajectory in a picture: of a model in space its isometric view."""
    return flat(motion(trajectory, most))


def flat(found: AnyMotion, name: str = "iso") -> Motion | Projection:
    """A motion in a picture: of a model in space a view of it."""
    return Projection(found, view(found.scene, name)) if isinstance(found, SpaceMotion) else found


def drawing(motion: Tracks) -> Drawing:
    """The shapes of a mechanism in the plane of the picture."""
    if isinstance(motion, Projection):
        return _projected(motion)
    assert isinstance(motion, Motion)
    return shapes.drawing(motion)


def _projected(motion: Projection) -> Drawing:
    """The solids of a mechanism as areas and lines, far ones first."""
    drawn = solids_of(motion.solid)
    springs, dampers = ({s.name for s in drawn.solids if s.draw == draw} for draw in ("coil", "piston"))
    both = springs & dampers  # which are within each other on the stage
    found = [
        Shape(s.draw, s.name, s.at, tuple(_items(s, motion, drawn.unit, s.name in both)))
        for s in drawn.solids
        if s.draw != "piston" or s.name not in both
    ]
    ports = {frame for c in motion.scene.components.values() for frame in c.ports.values()}
    bounding = [spot for name, spot in motion.spots.items() if spot.track != GROUND or name in ports]
    bounding += [place for solid in drawn.sized for place in edge(solid)]
    at = [motion.positions(place) for place in dict.fromkeys(bounding)]
    points = np.concatenate([*at, np.zeros((0, 2))])
    points = points[np.isfinite(points).all(axis=1)] if np.isfinite(points).any() else np.zeros((1, 2))
    low, high = points.min(axis=0), points.max(axis=0)
    extent = float(np.hypot(*(high - low)))
    if not is_apart(extent, motion.poses[..., :3]):
        low, extent = high, 0.0
    bounds = (*low.tolist(), *high.tolist())
    return Drawing(sorted(found, key=motion.nearness), bounds, 0.6 * OF_EXTENT * extent or 1.0)


def _items(solid: Solid, motion: Projection, unit: float, both: bool) -> Iterator[Item]:
    """A solid as what is seen of it: of convex ones the area, of the others lines."""
    own = {JOINT: PALE, SUPPORT: PALE, BODY: ROD}.get(solid.role, solid.role)
    if solid.role == BODY and solid.name in motion.order:
        own = colour_of(motion, solid.name)
    pale, at, radius = (own, PAPER, PALER), solid.at, solid.size[0]
    area: dict[str, Any] = {"fill": pale, "stroke": own}
    if len(at) == 2:
        if solid.draw in ("coil", "piston"):
            count = coils(*at, motion, unit)
            spring = beside(count) if both else zigzag(count)
            parts = spring if solid.draw == "coil" else PISTON if solid.role == DRIVE else dashpot()
            yield from placed(parts, *at, motion)
        else:
            yield DrawnPath(at, ON, stroke=own, width=Size(1.0, 0.0, 2 * radius))
    elif solid.draw == "bar":
        yield DrawnPath(edge(solid), ON, stroke=pale, edge=own, width=Size(3.0, 0.0, 2 * radius))
    elif solid.draw == "ball":
        yield Circle((at[0],), Size(1.5, 0.0, radius), **area)
    elif solid.draw == "wire":
        path = tuple(at[0].moved(point) for point in solid.data["points"])
        yield DrawnPath(path, ON, stroke=own, width=Size(1.0, 0.0, 2 * solid.data["radius"]))
    elif solid.draw in ("ring", "spiral"):
        turns = 3 if solid.draw == "spiral" else 1
        path = rounded(at[0], radius, turns=turns)
        yield DrawnPath(path, ON, closed=turns == 1, stroke=own, width=Size(1.0, 0.0, 0.14 * radius))
    elif solid.draw == "wheel":
        rim = edge(solid)
        yield DrawnPath(rim, ON, closed=True, fill=(own, PAPER, 0.85), stroke=own, width=Size(2.0, 0.0, 0.09 * radius))
        half = len(rim) // 2
        yield from (DrawnPath((rim[k], rim[k + half]), ON, stroke=own) for k in range(0, half, half // 4))
    else:
        yield DrawnPath(edge(solid), ON, hull=True, closed=True, **area)


def projected_vectors(found: Sequence[Vector], motion: Projection) -> list[Vector]:
    """Forces in the plane of the picture."""
    flat = [replace(v, values=motion.seen.of(v.values)[:, :2]) for v in found if v.kind == FORCE]
    return [v for v in flat if np.isfinite(v.values).any() and np.nanmax(np.abs(v.values)) > 0.0]
