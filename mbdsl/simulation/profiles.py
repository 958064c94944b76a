"""Profiles of a run: signals along arrays, and along rods and beams, at one or more times."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from mbdsl.bodies.contract import SPATIAL_VELOCITIES
from mbdsl.errors import UsageError
from mbdsl.kernels.arrays import Array
from mbdsl.mechanism import sections
from mbdsl.mechanism.scene import Component, Scene
from mbdsl.mechanism.signal_names import SPATIAL_UNITS, UNITS, SignalNames
from mbdsl.simulation.section_forces import Sections

if TYPE_CHECKING:
    from mbdsl.plotting.profiles import Profile


STATIONS = 41  #: sections of a rod or beam
SIDE = 1e-7  #: distance of the sections on both sides of a load, over the length


def check(names: SignalNames, patterns: Sequence[str]) -> None:
    """Check patterns before a run.

    Raises
    ------
    UsageError
        If one is neither an array of signals nor a signal along a rod or beam.
    """
    from mbdsl.plotting.profiles import elements

    known = [*names.names, *names.unlisted]
    for pattern in patterns:
        if beam(names.scene, pattern) is None:
            elements(pattern, known, names.scene.name)


def beam(scene: Scene, pattern: str) -> tuple[Component, str] | None:
    """The rod or beam, and the key of its signal, that a pattern without a slice names: ``beam.M``."""
    owner, _, key = pattern.rpartition(".")
    c = scene.components.get(owner)
    if c is None or not sections.has_sections(c):
        return None
    if key not in _units(scene):
        raise UsageError(f"there is no signal `{key}` along {owner}", hint=f"along it are {', '.join(_units(scene))}")
    return c, key


def _units(scene: Scene) -> dict[str, str]:
    """The signals of a section and their units: forces, and coordinates."""
    units = {key: SPATIAL_UNITS[key] for key in (*"xyz", *SPATIAL_VELOCITIES)} if scene.spatial else UNITS
    return {**sections.keys(scene.spatial), **units}


def along(trajectory: Any, patterns: Sequence[str], at: Sequence[float] | None) -> Profile:
    """Signals along arrays, rods and beams.

    Parameters
    ----------
    trajectory : Trajectory
        A run.
    patterns : sequence of str
        Names of signals with a slice in the place of an index, or of a signal in the sections of a rod or beam.
    at : sequence of float or None [s]
        Times; None: the end of the run.

    Raises
    ------
    UsageError
        If a pattern is neither, or a time is outside of the run.
    """
    from mbdsl.plotting.profiles import LINEAR, Line, of_arrays, profile, times_inside, weights
    from mbdsl.plotting.signal_panels import Horizontal

    scene, t = trajectory.scene, trajectory.t
    names = SignalNames(scene)
    check(names, patterns)
    if not len(t):
        raise UsageError("the trajectory is empty: it has no profile")
    times = times_inside(at, float(t[0]), float(t[-1]))
    rows = [weights(t, time) for time in times]
    parts = [(trajectory[float(t[i]) : float(t[j])], w) for i, j, w in rows]

    def columns(asked: Sequence[str]) -> dict[str, Array]:
        return {name: np.array([_at(part[name], w) for part, w in parts]) for name in asked}

    arrays = [p for p in patterns if beam(scene, p) is None]
    lines = of_arrays(arrays, [*names.names, *names.unlisted], scene.name, trajectory.unit, columns)
    known: dict[str, list[Sections]] = {}
    for pattern in patterns:
        if (found := beam(scene, pattern)) is not None:
            bodies = known.setdefault(found[0].name, [Sections(part, found[0]) for part, _ in parts])
            x = _stations(bodies, found[1])
            values = [_values(b, x, w, found[1]) for b, (_, w) in zip(bodies, parts, strict=True)]
            axis = Horizontal(f"distance from {found[0].name}.a", "m")
            lines[pattern] = Line(axis, x + bodies[0].length / 2, np.array(values), _units(scene)[found[1]])
    lines = {pattern: lines[pattern] for pattern in patterns}
    return profile(scene.name, lines, times, [LINEAR] if any(w for _, w in parts) else [], trajectory.display)


def _at(values: Array, weight: float) -> float:
    """The value between the first and the last row."""
    return float(values[0] if weight == 0.0 else (1.0 - weight) * values[0] + weight * values[-1])


def _stations(bodies: Sequence[Sections], key: str) -> Array:
    """Distances (K,) from the middle, with both sides of the loads at all times."""
    length = bodies[0].length
    at = np.linspace(-length / 2, length / 2, STATIONS)
    if key not in sections.keys(bodies[0].states.scene.spatial):
        return at
    loaded = np.concatenate([[], *(np.atleast_1d(load.x) for body in bodies for load in body.loads)])
    loaded = loaded[abs(loaded) < length / 2 * (1.0 - SIDE)]
    return np.unique(np.concatenate([at[~np.isin(at, loaded)], loaded - SIDE * length, loaded + SIDE * length]))


def _values(body: Sections, at: Array, weight: float, key: str) -> Array:
    """The values (K,) of a signal in sections."""
    if key in sections.keys(body.states.scene.spatial):
        return np.array([_at(body.section(x)[key], weight) for x in at])
    return np.array([_at(body.coordinate(x, key), weight) for x in at])
