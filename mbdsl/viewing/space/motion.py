"""Poses of bodies in space over time. A track is a position and a unit quaternion over time; every body has one."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mbdsl.mechanism.scene import Scene
from mbdsl.numerics.rotation_arrays import of_matrix, quaternions, times
from mbdsl.simulation.trajectory import Trajectory
from mbdsl.system.body_models import body_pose
from mbdsl.viewing.motion import GROUND, MOST_FRAMES, frames_of_bodies, shown_rows

Array = NDArray[np.float64]

UNTURNED = (1.0, 0.0, 0.0, 0.0)
CONJUGATE = np.array([1.0, -1.0, -1.0, -1.0])


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


@dataclass
class SpaceMotion:
    """Tracks of a mechanism in space.

    Attributes
    ----------
    scene : Scene
        The model.
    t : (N,) [s]
        Times of the frames.
    rows : (N,) of int
        Rows of the trajectory that the frames show.
    tracks : list of str
        Names of bodies.
    poses : (N, T, 7) [m, 1]
        Positions of the centres of mass and unit quaternions (w, x, y, z) of the tracks.
    spots : dict of str to Place
        All frames of the model.
    frames : dict of str to list of str
        Names of the frames of each body.
    """

    scene: Scene
    t: Array
    rows: NDArray[np.int64]
    tracks: list[str]
    poses: Array
    spots: dict[str, Place]
    frames: dict[str, list[str]]

    def spot_of(self, name: str) -> Place:
        """The place of a frame, or of the centre of a component that is a frame, by its name or another name of it."""
        name = self.scene.aliases.get(name, name)
        return self.spots[name] if name in self.spots else self.spots[f"{name}.c"]

    def positions(self, place: Place) -> Array:
        """World positions (N, 3) [m] of a place."""
        if place.track == GROUND:
            return np.tile(place.r, (len(self.t), 1))
        pose = self.poses[:, place.track]
        return pose[:, :3] + rotated(pose[:, 3:], np.array(place.r))

    def turned(self, place: Place, vectors: Array) -> Array:
        """World components (N, 3) of vectors (N, 3) or (3,) in the axes of a place."""
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


def motion(trajectory: Trajectory, most: int = MOST_FRAMES) -> SpaceMotion:
    """The motion of a trajectory of a model in space, with at most ``most`` frames.

    Parameters
    ----------
    trajectory : Trajectory
        The states over time.
    most : int, optional
        Largest number of frames.

    Returns
    -------
    SpaceMotion
        Tracks and frames.

    Raises
    ------
    UsageError
        If the trajectory is empty.
    """
    scene, system = trajectory.scene, trajectory.system
    owners = frames_of_bodies(scene)
    models = system.tables.models
    rows = shown_rows(trajectory, most, 7 * len(models))
    q = trajectory.q[rows]
    tracks: list[str] = []
    poses: list[Array] = []
    spots: dict[str, Place] = {}
    for body, frames in owners.items():
        model = models.get(body)
        for frame in frames:
            x, y, z, *axes = body_pose(scene.components[body], scene.frames[frame])
            p = tuple(quaternions(of_matrix(np.array(axes).reshape(3, 3).T)).tolist())
            spots[frame] = Place(GROUND if model is None else len(tracks), (float(x), float(y), float(z)), p)
        if model is not None:
            d = system.tables.coordinates[body]
            turn = quaternions(q[:, d + 3 : d + 6]) if model.n == 6 else np.tile(UNTURNED, (len(rows), 1))
            tracks.append(body)
            poses.append(np.concatenate([q[:, d : d + 3], turn], axis=1))
    found = np.stack(poses, axis=1) if poses else np.zeros((len(rows), 0, 7))
    return SpaceMotion(scene, np.asarray(trajectory.t)[rows], rows, tracks, found, spots, owners)
