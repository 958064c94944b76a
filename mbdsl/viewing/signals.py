"""Signals of a page: those of a trajectory that it has and those that it shows at first, at the times that it keeps."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field

import numpy as np

from mbdsl.elements.kind import BodyKind, ForceKind, JointKind
from mbdsl.kernels.arrays import Array, Integers
from mbdsl.mechanism.scene import ENERGIES, Description
from mbdsl.plotting.curves import is_held
from mbdsl.simulation.event_marks import Mark
from mbdsl.simulation.trajectory import Trajectory

MOST_POINTS = 2000  #: points of a line; longer ones keep the extremes of each part
MOST_SIGNALS, MOST_SHOWN = 40, 3
#: number of components from which only coordinates are kept: the formulas of all signals would take longer
MANY_COMPONENTS = 300


@dataclass(frozen=True)
class PlottedSignal:
    """A signal at the page's times (P,) in its displayed unit; ``low`` and ``high`` are its extremes over all times."""

    name: str
    unit: str
    values: Array
    low: float
    high: float
    doc: str = ""  #: description of a variable
    held: bool = False  #: whether it is constant between its changes


@dataclass(frozen=True)
class Plots:
    """Signals at common times (P,) [s], the names of those that are plotted at first, and the marks of events."""

    times: Array
    signals: list[PlottedSignal]
    shown: list[str]
    events: list[Mark] = field(default_factory=list)


def signals(trajectory: Trajectory, patterns: Iterable[str] | None) -> Plots:
    """Signals of a page.

    Parameters
    ----------
    trajectory : Trajectory
        The states over time.
    patterns : iterable of str or None
        Names and glob patterns; None: coordinates, velocities and signals of elements that change.

    Returns
    -------
    Plots
        The signals.

    Raises
    ------
    UsageError
        If a pattern matches no name.
    """
    if patterns is not None:
        names = [name for name in trajectory.select(patterns) if name != "time"]
        shown = names[: 2 * MOST_SHOWN]
    else:
        names = list(dict.fromkeys(_names(trajectory)))
        shown = []
    t, rows = thinned(trajectory.t, MOST_POINTS)
    found = [_signal(trajectory, name, rows) for name in names]
    if patterns is None:
        found = list(_changing(found))[:MOST_SIGNALS]
        bodies = {c.name for c in trajectory.scene.bodies()}
        for keys in (("phi",), ("w",), ("x", "y"), ("vx", "vy")):
            own = [s.name.rpartition(".") for s in found]
            chosen = [f"{owner}.{key}" for owner, _, key in own if owner in bodies and key in keys][:MOST_SHOWN]
            shown += chosen if len({name.rpartition(".")[2] for name in shown}) < 2 else []
    return Plots(t, found, shown, trajectory.event_marks(t[0], t[-1])[0])


def _signal(trajectory: Trajectory, name: str, limits: Integers | None) -> PlottedSignal:
    values = np.asarray(trajectory[name], float)
    finite = values[np.isfinite(values)]
    low, high = (float(finite.min()), float(finite.max())) if len(finite) else (np.nan, np.nan)
    unit = trajectory.display.of(trajectory.unit(name), name)
    f = unit.factor
    said = trajectory.scene.descriptions.get(name, Description()).doc
    held = is_held(values)
    return PlottedSignal(name, unit.symbol, extremes(values, limits) / f, low / f, high / f, said, held)


def _changing(found: Iterable[PlottedSignal]) -> Iterator[PlottedSignal]:
    """Signals that change by more than rounding, relative to the largest of the same unit."""
    found = list(found)
    size: dict[str, float] = {}
    for s in found:
        size[s.unit] = float(np.nanmax([size.get(s.unit, 0.0), abs(s.low), abs(s.high)]))
    return (s for s in found if s.high - s.low > 1e-9 * size[s.unit])


def thinned(t: Array, most: int) -> tuple[Array, Integers | None]:
    """Times of two points for each of ``most``/2 parts of equal numbers of rows, and the limits of the parts.

    The limits are None if all rows are kept.
    """
    if len(t) <= most:
        return t, None
    limits = np.linspace(0, len(t), most // 2 + 1).astype(int)
    first, after = limits[:-1], limits[1:]
    times = np.stack([t[first], t[np.minimum((first + after) // 2, len(t) - 1)]], axis=1).ravel()
    times[-1] = t[-1]
    return times, limits


def extremes(values: Array, limits: Integers | None) -> Array:
    """The smallest and the largest value of each part, in the order in which they occur."""
    if limits is None:
        return values
    first = limits[:-1]
    part = np.repeat(np.arange(len(first)), np.diff(limits))
    places = []
    for extreme in (np.fmin.reduceat(values, first), np.fmax.reduceat(values, first)):
        hits = np.flatnonzero(values == extreme[part])
        hits = hits[np.diff(part[hits], prepend=-1) > 0]  # the first one of each part
        place = first.copy()  # of a part without finite values
        place[part[hits]] = hits
        places.append(place)
    return values[np.sort(places, axis=0)].T.ravel()


def _names(trajectory: Trajectory) -> Iterator[str]:
    """Names without patterns: coordinates and velocities, those of forces and joints, variables, energies."""
    scene = trajectory.scene
    if len(scene.components) > MANY_COMPONENTS:
        return
    yield from _of_bodies(trajectory)
    for c in scene.components.values():
        if isinstance(c.kind, ForceKind):
            yield from (f"{c.name}.{key}" for key in c.signals if key not in {x.name for x in c.kind.results})
    yield from (name for name in scene.variables if name in trajectory)
    yield from ENERGIES
    for c in scene.components.values():
        if isinstance(c.kind, JointKind) and not isinstance(c.kind, BodyKind):
            reactions = set(c.kind.reaction)
            yield from (f"{c.name}.{key}" for key in c.signals if key in ("s", "v") and key not in reactions)


def _of_bodies(trajectory: Trajectory) -> list[str]:
    names = trajectory.default_names
    return names if len(names) <= MOST_SIGNALS - 8 else names[: MOST_SIGNALS - 8]
