"""The motion of a trajectory as tracks of its bodies, in the plane and in space."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from mbdsl.errors import UsageError
from mbdsl.mechanism.scene import Component, Scene
from mbdsl.numerics.rotation_arrays import of_matrix, quaternions
from mbdsl.simulation.trajectory import Trajectory
from mbdsl.system.body_models import at_rest, body_pose
from mbdsl.system.system import System
from mbdsl.viewing.rope_lines import add_lines
from mbdsl.viewing.tracks import GROUND, UNTURNED, AnyMotion, Array, Curve, Motion, Place, SpaceMotion, Spot

NEGLIGIBLE = 1e-9  #: distance [m] that counts as zero, relative to the distance from the origin if this is larger
STATIONS = 25  #: number of sampled points on a beam
#: limits of a page: frames of a motion, and numbers of all poses together
MOST_FRAMES, MOST_NUMBERS = 3000, 12_500_000


def motion(trajectory: Trajectory, most: int = MOST_FRAMES) -> AnyMotion:
    """The motion of a trajectory, with at most ``most`` frames.

    Parameters
    ----------
    trajectory : Trajectory
        The states over time.
    most : int, optional
        Largest number of frames.

    Returns
    -------
    Motion or SpaceMotion
        Tracks and beams.

    Raises
    ------
    UsageError
        If the trajectory is empty.
    """
    found = (_in_space if trajectory.scene.spatial else _in_plane)(trajectory, most)
    add_lines(found)
    return found


def _in_plane(trajectory: Trajectory, most: int) -> Motion:
    system, scene = trajectory.system, without_states(trajectory.scene)
    owners = frames_of_bodies(scene)
    models = system.tables.models
    size = sum(3 * len(owners[name]) + 2 * STATIONS if body.deforms else 3 for name, body in models.items())
    rows = shown_rows(trajectory, most, size)
    states = _ShownStates(system, trajectory.t, trajectory.q, trajectory.v, rows)
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


def _in_space(trajectory: Trajectory, most: int) -> SpaceMotion:
    scene, system = without_states(trajectory.scene), trajectory.system
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
    rows = nearest(t, np.linspace(t[0], t[-1], most))
    rows[-1] = len(t) - 1
    return np.unique(rows)


def without_states(scene: Scene) -> Scene:
    """The scene as it is drawn: states have no place."""
    names = {c.name for c in scene.states()}
    if not names:
        return scene
    frames = {name: frame for name, frame in scene.frames.items() if frame.body not in names}
    others = (c for c in scene.components.values() if frames.keys() >= {*c.ports.values()})
    return replace(scene, components={c.name: c for c in others if c.name not in names}, frames=frames)


def nearest(t: Array, wanted: Array) -> NDArray[np.int64]:
    """The rows of at least two times (N,) that are the nearest to the wanted ones."""
    after = np.searchsorted(t, wanted).clip(1, len(t) - 1)
    return np.where(wanted - t[after - 1] <= t[after] - wanted, after - 1, after)


def frames_of_bodies(scene: Scene) -> dict[str, list[str]]:
    """Body -> its frames, in the order of the scene."""
    found: dict[str, list[str]] = {}
    for name, frame in scene.frames.items():
        found.setdefault(frame.body, []).append(name)
    return found


class _ShownStates:
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


def _curve(states: _ShownStates, component: Component) -> Curve:
    half = float(component.values["length"]) / 2
    along = np.linspace(-half, half, STATIONS)
    poses = np.stack([states.frame(component.name, (x, 0.0, 0.0)) for x in along.tolist()], axis=1)
    edge = float(np.sqrt(3.0 * component.values["I"] / component.values["S"]))
    return Curve(component.name, along, poses[:, :, :2], poses[:, :, 2], edge)
