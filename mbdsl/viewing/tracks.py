"""Poses of bodies over time, for a picture that moves: rigid bodies as one pose each, beams as sampled curves.

A track is a pose over time: (x, y, phi) in the plane, a position and a unit quaternion in space. Every rigid body has
one, that of its centre of mass; frames on it are constant offsets. A body that deforms has one for each of its frames,
and a beam has a curve of sampled points in addition.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from math import cos, sin
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mbdsl.kernels.arrays import Array, Integers
from mbdsl.mechanism.scene import Scene
from mbdsl.numerics.rotation_arrays import times

GROUND = -1  #: the track of frames that do not move
TOGETHER = 256  #: number of spots that are evaluated at once
ROUNDING = 1e-10  #: bending strain that counts as zero
UNTURNED = (1.0, 0.0, 0.0, 0.0)
CONJUGATE = np.array([1.0, -1.0, -1.0, -1.0])


@dataclass(frozen=True)
class Spot:
    """A pose (x, y, phi) [m, m, rad] relative to a track, or in world axes on the track ``GROUND``."""

    track: int
    x: float = 0.0
    y: float = 0.0
    phi: float = 0.0

    def moved(self, x: float, y: float = 0.0) -> Spot:
        """The pose at (x, y) in the axes of this one."""
        c, s = cos(self.phi), sin(self.phi)
        return replace(self, x=self.x + c * x - s * y, y=self.y + s * x + c * y)


@dataclass(frozen=True)
class Curve:
    """The axis of a beam: points (N, K, 2) [m] and angles of the sections (N, K) [rad] at stations (K,) [m].

    ``edge`` is the distance [m] of the edge of the section from the axis, if it is a rectangle: sqrt(3 I/S).
    """

    body: str
    along: Array
    points: Array
    angles: Array
    edge: float = 1.0

    def curvature(self) -> Array:
        """Curvature (N, K) [1/m], by differences of second order of the angles, also at the ends."""
        return np.gradient(self.angles, self.along, axis=1, edge_order=2)

    def strain(self) -> Array:
        """Absolute value of the bending strain (N, K) at the edge of the section; values of rounding are zero."""
        found = np.abs(self.curvature()) * self.edge
        return np.where(found < ROUNDING, 0.0, found)


def largest_strain(curves: Sequence[Curve]) -> float:
    """The largest bending strain of beams over all times: the end of their common scale of colours."""
    found = [curve.strain() for curve in curves]
    return max((float(np.nanmax(x)) for x in found if np.isfinite(x).any()), default=0.0)


@dataclass(frozen=True)
class Place:
    """A position r [m] and a unit quaternion p = (w, x, y, z) relative to a track, or to the world on ``GROUND``."""

    track: int
    r: tuple[float, ...] = (0.0, 0.0, 0.0)
    p: tuple[float, ...] = UNTURNED

    def moved(self, r: Sequence[float] = (0.0, 0.0, 0.0), p: Sequence[float] = UNTURNED) -> Place:
        """The place at ``r`` in the axes of this one, turned by ``p``."""
        own = np.array(self.p)
        at = np.array(self.r) + rotated(own, np.array(r, float))
        return Place(self.track, tuple(at.tolist()), tuple(times(own, np.array(p, float)).tolist()))


Frame = Spot | Place


@dataclass
class Tracks:
    """Tracks of a mechanism; subclasses know the poses of the plane and of space."""

    scene: Scene  #: the model
    t: Array  #: (N,) [s]: times of the frames
    rows: Integers  #: (N,) of int: rows of the trajectory that the frames show
    tracks: list[str]  #: names of bodies, or of frames on bodies that deform
    #: (N, T, 3) [m, m, rad] or (N, T, 7) [m, 1]: poses of the tracks; in space with quaternions (w, x, y, z)
    poses: Array
    spots: dict[str, Any]  #: positions of all frames of the model
    frames: dict[str, list[str]]  #: names of the frames of each body
    curves: list[Curve] = field(default_factory=list)  #: beams
    #: both ends and the middle of the line of each rope, where they are known
    lines: dict[str, tuple[Any, Any, Any]] = field(default_factory=dict)

    @property
    def dimensions(self) -> int:
        """Number of coordinates of a point."""
        return 3 if self.scene.spatial else 2

    @cached_property
    def order(self) -> dict[str, int]:
        """Body -> its number, which selects its colour."""
        return {c.name: k for k, c in enumerate(self.scene.bodies())}

    def owner(self, spot: Frame) -> str:
        """The body on whose track a frame is; empty for the ground."""
        track = "" if spot.track == GROUND else self.tracks[spot.track]
        return track if track in self.order else track.rpartition(".")[0]

    def spot_of(self, name: str) -> Any:
        """The spot of a frame, or of the centre of a component that is a frame, by its name or another name of it."""
        name = self.scene.aliases.get(name, name)
        return self.spots[name] if name in self.spots else self.spots[f"{name}.c"]

    def positions(self, spot: Any) -> Array:
        """World positions (N, d) [m] of a frame."""
        raise TypeError(f"{type(self).__name__} has no positions")

    def turned(self, spot: Any, vectors: Array) -> Array:
        """World components (N, d) of vectors (N, d) or (d,) in the axes of a frame."""
        raise TypeError(f"{type(self).__name__} has no turned")

    def places(self, spots: Sequence[Any], row: int) -> Array:
        """The places and angles (n, 3) [m, m, rad] of n frames in a picture of a row of the motion."""
        raise TypeError(f"{type(self).__name__} has no places")

    def displaced(self, spot: Any, u: NDArray[Any]) -> NDArray[Any]:
        """The displacement (d,) of a moving frame in the first row by those of tracks (T, 3 or 7), to first order."""
        raise TypeError(f"{type(self).__name__} has no displaced")

    def along(self, a: Any, b: Any) -> Array:
        """The coordinates (N,) [m] of ``b`` along the x axis of ``a``."""
        return ((self.positions(b) - self.positions(a)) * self.turned(a, np.eye(self.dimensions)[0])).sum(axis=1)

    def travel(self, a: Any, b: Any) -> tuple[float, float]:
        """The smallest and the largest coordinate [m] of ``b`` along the x axis of ``a``."""
        s = self.along(a, b)
        return (float(np.nanmin(s)), float(np.nanmax(s))) if np.isfinite(s).any() else (0.0, 0.0)

    def apart(self, a: Any, b: Any) -> Array:
        """The finite ones of the distances [m] of two frames over time; [0] if there are none."""
        length = np.linalg.norm(self.positions(b) - self.positions(a), axis=1)
        return length[np.isfinite(length)] if np.isfinite(length).any() else np.zeros(1)


class Motion(Tracks):
    """Tracks (x, y, phi) in the plane."""

    def pose(self, spot: Spot) -> Array:
        """The pose (N, 3) [m, m, rad] of a spot in world axes."""
        if spot.track == GROUND:
            return np.tile((spot.x, spot.y, spot.phi), (len(self.t), 1))
        x, y, phi = self.poses[:, spot.track].T
        c, s = np.cos(phi), np.sin(phi)
        return np.stack([x + c * spot.x - s * spot.y, y + s * spot.x + c * spot.y, phi + spot.phi], axis=1)

    def positions(self, spot: Spot) -> Array:
        return self.pose(spot)[:, :2]

    def turned(self, spot: Spot, vectors: Array) -> Array:
        phi = self.pose(spot)[:, 2]
        (c, s), (x, y) = (np.cos(phi), np.sin(phi)), np.moveaxis(np.asarray(vectors, float), -1, 0)
        return np.stack([c * x - s * y, s * x + c * y], axis=1)

    def displaced(self, spot: Spot, u: NDArray[Any]) -> NDArray[Any]:
        x, y = self.positions(spot)[0] - self.poses[0, spot.track, :2]
        return u[spot.track, :2] + u[spot.track, 2] * np.array([-y, x])

    def places(self, spots: Sequence[Spot], row: int) -> Array:
        found = np.empty((len(spots), 3))
        for k, spot in enumerate(spots):
            if spot.track == GROUND:
                found[k] = spot.x, spot.y, spot.phi
            else:
                x, y, phi = self.poses[row, spot.track].tolist()
                c, s = cos(phi), sin(phi)
                found[k] = x + c * spot.x - s * spot.y, y + s * spot.x + c * spot.y, phi + spot.phi
        return found

    def extremes(self, spots: Sequence[Spot]) -> tuple[Array, Array]:
        """The lowest and highest x and y (S, 2) [m] of S spots over time; infinite for a spot without finite places."""
        low, high = np.full((len(spots), 2), np.inf), np.full((len(spots), 2), -np.inf)
        for first in range(0, len(spots), TOGETHER):
            part = spots[first : first + TOGETHER]
            moving = [k for k, spot in enumerate(part, first) if spot.track != GROUND]
            at = np.array([(spots[k].x, spots[k].y) for k in moving]).reshape(-1, 2)
            x, y, phi = np.moveaxis(self.poses[:, [spots[k].track for k in moving]], -1, 0)
            c, s = np.cos(phi), np.sin(phi)
            places = np.stack([x + c * at[:, 0] - s * at[:, 1], y + s * at[:, 0] + c * at[:, 1]], axis=-1)
            finite = np.isfinite(places)
            low[moving] = places.min(axis=0, initial=np.inf, where=finite)
            high[moving] = places.max(axis=0, initial=-np.inf, where=finite)
        for k, spot in enumerate(spots):
            if spot.track == GROUND:
                low[k] = high[k] = spot.x, spot.y
        return low, high


class SpaceMotion(Tracks):
    """Tracks of positions and unit quaternions in space."""

    def displaced(self, spot: Place, u: NDArray[Any]) -> NDArray[Any]:
        pose, own = self.poses[0, spot.track], u[spot.track]
        turn = 2.0 * times(own[3:], pose[3:] * CONJUGATE)[1:]  # the derivative of a quaternion is half the rotation
        return own[:3] + np.cross(turn, self.positions(spot)[0] - pose[:3])

    def positions(self, place: Place) -> Array:
        if place.track == GROUND:
            return np.tile(place.r, (len(self.t), 1))
        pose = self.poses[:, place.track]
        return pose[:, :3] + rotated(pose[:, 3:], np.array(place.r))

    def turned(self, place: Place, vectors: Array) -> Array:
        own = rotated(np.array(place.p), vectors)
        return own if place.track == GROUND else rotated(self.poses[:, place.track, 3:], own)

    def inverse(self, place: Place, points: Array) -> Array:
        """Coordinates (N, 3) [m] in the axes of a place of points (N, 3) of the world."""
        away = points - self.positions(place)
        if place.track != GROUND:
            away = rotated(self.poses[:, place.track, 3:] * CONJUGATE, away)
        return rotated(np.array(place.p) * CONJUGATE, away)

    def extremes(self, places: Iterable[Place]) -> tuple[Array, Array]:
        """The lowest and highest coordinates (N, 3) [m] of places at each time; infinite without finite ones."""
        low, high = np.full((len(self.t), 3), np.inf), np.full((len(self.t), 3), -np.inf)
        for place in places:
            at = self.positions(place)
            finite = np.isfinite(at)
            np.minimum(low, at, out=low, where=finite)
            np.maximum(high, at, out=high, where=finite)
        return low, high


def rotated(p: Array, v: Array) -> Array:
    """Vectors (..., 3) turned by unit quaternions (..., 4): v + 2 u x (w v + u x v)."""
    w, u = p[..., :1], p[..., 1:]
    return v + 2.0 * np.cross(u, w * v + np.cross(u, v))


AnyMotion = Motion | SpaceMotion
