"""Poses of bodies over time, for a picture that moves: rigid bodies as one pose each, beams as sampled curves.

A track is a pose (x, y, phi) over time. Every rigid body has one, that of its centre of mass; frames on it are constant
offsets. A body that deforms has one for each of its frames, and a beam has a curve of sampled points in addition.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from mbdsl.errors import UsageError
from mbdsl.mechanism.scene import Component, Scene
from mbdsl.simulation.trajectory import Trajectory
from mbdsl.system.body_models import at_rest, body_pose
from mbdsl.system.system import System

Array = NDArray[np.float64]

GROUND = -1  #: the track of frames that do not move
TOGETHER = 256  #: number of spots that are evaluated at once
ROUNDING = 1e-10  #: bending strain that counts as zero
NEGLIGIBLE = 1e-9  #: distance [m] that counts as zero, relative to the distance from the origin if this is larger
STATIONS = 25  #: number of sampled points on a beam
#: limits of a page: frames of a motion, and numbers of all poses together
MOST_FRAMES, MOST_NUMBERS = 3000, 12_500_000


@dataclass(frozen=True)
class Spot:
    """A pose (x, y, phi) [m, m, rad] relative to a track, or in world axes on the track ``GROUND``."""

    track: int
    x: float = 0.0
    y: float = 0.0
    phi: float = 0.0


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


@dataclass
class Motion:
    """Tracks of a mechanism.

    Attributes
    ----------
    scene : Scene
        The model.
    t : (N,) [s]
        Times of the frames.
    rows : (N,) of int
        Rows of the trajectory that the frames show.
    tracks : list of str
        Names of bodies, or of frames on bodies that deform.
    poses : (N, T, 3) [m, m, rad]
        Poses of the tracks.
    spots : dict of str to Spot
        Positions of all frames of the model.
    frames : dict of str to list of str
        Names of the frames of each body.
    curves : list of Curve
        Beams.
    """

    scene: Scene
    t: Array
    rows: NDArray[np.int64]
    tracks: list[str]
    poses: Array
    spots: dict[str, Spot]
    frames: dict[str, list[str]]
    curves: list[Curve] = field(default_factory=list)

    @property
    def points(self) -> list[Spot]:
        """All points of the picture that are known by spots."""
        return list(self.spots.values())

    def pose(self, spot: Spot) -> Array:
        """The pose (N, 3) [m, m, rad] of a spot in world axes."""
        if spot.track == GROUND:
            return np.tile((spot.x, spot.y, spot.phi), (len(self.t), 1))
        x, y, phi = self.poses[:, spot.track].T
        c, s = np.cos(phi), np.sin(phi)
        return np.stack([x + c * spot.x - s * spot.y, y + s * spot.x + c * spot.y, phi + spot.phi], axis=1)

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

    def spot_of(self, name: str) -> Spot:
        """The spot of a frame, or of the centre of a component that is a frame, by its name or another name of it."""
        name = self.scene.aliases.get(name, name)
        return self.spots[name] if name in self.spots else self.spots[f"{name}.c"]


def motion(trajectory: Trajectory, most: int = MOST_FRAMES) -> Motion:
    """The motion of a trajectory, with at most ``most`` frames.

    Parameters
    ----------
    trajectory : Trajectory
        The states over time.
    most : int, optional
        Largest number of frames.

    Returns
    -------
    Motion
        Tracks and beams.

    Raises
    ------
    UsageError
        If the trajectory is empty.
    """
    system, scene = trajectory.system, trajectory.scene
    owners = frames_of_bodies(scene)
    models = system.tables.models
    size = sum(3 * len(owners[name]) + 2 * STATIONS if body.deforms else 3 for name, body in models.items())
    rows = shown_rows(trajectory, most, size)
    states = _States(system, trajectory.t, trajectory.q, trajectory.v, rows)
    tracks: list[str] = []
    spots: dict[str, Spot] = {}
    curves: list[Curve] = []
    for name, frames in owners.items():
        component = scene.components[name]
        model = system.tables.models.get(name)
        for k, frame in enumerate(frames):
            pose = body_pose(component, scene.frames[frame])
            if model is None:
                at = [at_rest(component, scene.frames[frame], key) for key in ("x", "y", "phi")]
                spots[frame] = Spot(GROUND, *at)
            elif model.deforms:
                spots[frame] = Spot(len(tracks) + k)
            else:
                spots[frame] = Spot(len(tracks), *pose)
        if model is not None:
            tracks += frames if model.deforms else [name]
            if model.deforms:
                curves.append(_curve(states, component))
    poses = np.empty((len(rows), len(tracks), 3))
    for k, track in enumerate(tracks):
        poses[:, k] = states.track(track)
    return Motion(scene, np.asarray(trajectory.t)[rows], rows, tracks, poses, spots, owners, curves)


def is_apart(length: float, places: Array) -> bool:
    """Whether a length [m] between places (..., d) [m] is more than their rounding."""
    return length > NEGLIGIBLE * max(1.0, float(np.nanmax(np.abs(places), initial=0.0)))


def shown_rows(trajectory: Trajectory, most: int, numbers: int) -> NDArray[np.int64]:
    """The rows that are shown: at most ``most``, and fewer if the ``numbers`` of each are many.

    Raises
    ------
    UsageError
        If the trajectory is empty.
    """
    if not len(trajectory.t):
        raise UsageError(f"there is no motion to show: the trajectory of {trajectory.scene.name} is empty")
    return chosen_rows(trajectory.t, int(max(2, min(most, MOST_NUMBERS // max(1, numbers)))))


def chosen_rows(t: Array, most: int) -> NDArray[np.int64]:
    """Rows of at most ``most`` times (N,) that are evenly distributed over the duration, first and last included."""
    if len(t) <= most:
        return np.arange(len(t))
    even = np.linspace(t[0], t[-1], most)
    after = np.searchsorted(t, even).clip(1, len(t) - 1)
    rows = np.where(even - t[after - 1] <= t[after] - even, after - 1, after)
    rows[-1] = len(t) - 1
    return np.unique(rows)


def frames_of_bodies(scene: Scene) -> dict[str, list[str]]:
    """Body -> its frames, in the order of the scene."""
    found: dict[str, list[str]] = {}
    for name, frame in scene.frames.items():
        found.setdefault(frame.body, []).append(name)
    return found


class _States:
    """States of a trajectory, of which rows are shown; all are used where turns are counted."""

    def __init__(self, system: System, t: Array, q: Array, v: Array, rows: NDArray[np.int64]) -> None:
        self.system, self.rows = system, rows
        self.t, self.q, self.v = t, q, v

    def frame(self, body: str, pose: tuple[float, float, float]) -> Array:
        """Poses (rows, 3) of a frame at ``pose`` on a body."""
        model, d = self.system.tables.models[body], self.system.tables.coordinates[body]
        own = slice(d, d + model.n)
        if model.deforms:  # its angle is continuous over all rows
            q, v = self.q[:, own], self.v[:, own]
            return np.stack([model.frame(pose, key, q, v, self.t)[self.rows] for key in ("x", "y", "phi")], axis=1)
        q, v, t = self.q[self.rows, own], self.v[self.rows, own], self.t[self.rows]
        return np.stack([model.frame(pose, key, q, v, t) for key in ("x", "y", "phi")], axis=1)

    def track(self, name: str) -> Array:
        scene = self.system.scene
        if name in scene.components:
            return self.frame(name, (0.0, 0.0, 0.0))
        frame = scene.frames[name]
        return self.frame(frame.body, body_pose(scene.components[frame.body], frame))


def _curve(states: _States, component: Component) -> Curve:
    half = float(component.values["length"]) / 2
    along = np.linspace(-half, half, STATIONS)
    poses = np.stack([states.frame(component.name, (x, 0.0, 0.0)) for x in along.tolist()], axis=1)
    edge = float(np.sqrt(3.0 * component.values["I"] / component.values["S"]))
    return Curve(component.name, along, poses[:, :, :2], poses[:, :, 2], edge)


def largest_strain(curves: Sequence[Curve]) -> float:
    """The largest bending strain of beams over all times: the end of their common scale of colours."""
    found = [curve.strain() for curve in curves]
    return max((float(np.nanmax(x)) for x in found if np.isfinite(x).any()), default=0.0)
