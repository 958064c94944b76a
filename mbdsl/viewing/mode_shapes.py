"""Mode shapes as complex displacements of tracks and beams, and one cycle of a mode as a motion.

A mode of eigenvalue s displaces a pose p by Re(u exp(i theta)), where u is complex and theta is the phase. The picture
leaves out decay and growth, so that every mode is a cycle.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from mbdsl.simulation.trajectory import Trajectory
from mbdsl.system.system import System
from mbdsl.viewing.motion import NEGLIGIBLE, Motion, is_apart
from mbdsl.viewing.projection import pictured

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]

STEP = 1e-4  #: part of a shape by which the state is displaced: poses of beams are not linear in their coordinates
LARGEST, TURN = 0.1, 0.6  #: largest displacement in the picture relative to its extent, largest rotation [rad]
PHASES = 24  #: of the cycle that determines the extent of the picture
SECONDS, PICTURES = 2.0, 50  #: duration of a cycle in a film, and its number of pictures


@dataclass(frozen=True)
class Shapes:
    """Displacements of M modes about a state.

    Attributes
    ----------
    rest : Motion
        The state, one row.
    tracks : (M, T, 3) complex [m, m, rad]
        Displacements of the tracks, scaled to the picture.
    points, angles : list of (M, K, 2) complex [m] and of (M, K) complex [rad]
        Displacements of the beams.
    largest : (M,) [m]
        Largest displacement of a point of the picture.
    """

    rest: Motion
    tracks: Complex
    points: list[Complex]
    angles: list[Complex]
    largest: Array

    def cycle(self, mode: int, phases: Array, amplitude: float = 1.0) -> Motion:
        """A mode at phases (N,) [rad], as a motion; its times are those of a film."""
        turn = amplitude * np.exp(1j * phases)

        def moved(rest: Array, u: Complex) -> Array:
            return rest + (turn.reshape(-1, *[1] * u.ndim) * u).real

        curves = [
            replace(c, points=moved(c.points, p[mode]), angles=moved(c.angles, a[mode]))
            for c, p, a in zip(self.rest.curves, self.points, self.angles, strict=True)
        ]
        t = SECONDS * phases / (2 * np.pi)
        poses = moved(self.rest.poses, self.tracks[mode])
        return replace(self.rest, t=t, rows=np.arange(len(t)), poses=poses, curves=curves)

    def together(self) -> Motion:
        """All modes, one after the other: the extent of the picture."""
        phases = np.linspace(0.0, 2 * np.pi, PHASES)
        cycles = [self.cycle(k, phases) for k in range(len(self.tracks))]
        if not cycles:
            return self.rest
        curves = [
            replace(
                c,
                points=np.concatenate([x.curves[j].points for x in cycles]),
                angles=np.concatenate([x.curves[j].angles for x in cycles]),
            )
            for j, c in enumerate(self.rest.curves)
        ]
        t = np.arange(float(len(cycles) * PHASES))
        return replace(
            self.rest, t=t, rows=np.arange(len(t)), poses=np.concatenate([x.poses for x in cycles]), curves=curves
        )


def mode_shapes(system: System, t: float, q: Array, shapes: Complex) -> Shapes:
    """Displacements of the picture in the modes of a mechanism.

    Parameters
    ----------
    system : System
        The equations of motion.
    t : float [s]
        Time of the state.
    q : (n,) [m, rad]
        Coordinates of the state.
    shapes : (M, n) complex [m, rad]
        Displacements of the coordinates.

    Returns
    -------
    Shapes
        Displacements of tracks and beams by central differences, which are exact for rigid bodies, each mode scaled so
        that its largest displacement is a tenth of the extent of the mechanism.
    """
    rest = _states(system, t, q[None])
    tracks, points, angles, largest = [], [[] for _ in rest.curves], [[] for _ in rest.curves], []
    size = _extent(rest)
    for shape in shapes:
        parts = STEP * np.array([shape.real, -shape.real, shape.imag, -shape.imag])
        near = _states(system, t, system.moved(np.repeat(q[None], 4, axis=0), parts))
        u = _difference(near.poses)
        beams = [(_difference(c.points), _difference(c.angles)) for c in near.curves]
        # a spot is a rigid part of its track: it moves with the track and turns about it
        at = [(s.track, rest.pose(s)[0, :2] - rest.poses[0, s.track, :2]) for s in rest.points if s.track >= 0]
        arms = np.array([arm for _, arm in at]).reshape(-1, 2)
        own = u[[track for track, _ in at]]
        moved = own[:, :2] + own[:, 2:] * np.stack([-arms[:, 1], arms[:, 0]], axis=1)
        most = max((_length(x) for x in (moved, *(p for p, _ in beams)) if x.size), default=0.0)
        if most < NEGLIGIBLE * size * np.abs(shape).max(initial=0.0):  # rounding: the mode turns bodies about points
            most = 0.0
        turn = float(np.abs(u[:, 2]).max(initial=0.0))
        factor = min(LARGEST * size / most if most > 0.0 else np.inf, TURN / turn if turn > 0.0 else np.inf)
        factor = factor if np.isfinite(factor) else 1.0
        tracks.append(factor * u)
        for j, (p, a) in enumerate(beams):
            points[j].append(factor * p)
            angles[j].append(factor * a)
        largest.append(factor * most)
    return Shapes(
        rest,
        np.array(tracks).reshape(-1, *rest.poses.shape[1:]),
        [np.array(x) for x in points],
        [np.array(x) for x in angles],
        np.array(largest),
    )


def _states(system: System, t: float, q: Array) -> Motion:
    """States (N, n) at one time as a motion; in space its projection."""
    N = len(q)
    states = Trajectory(system, np.full(N, t), q, np.zeros_like(q), None, {"status": "done"})
    return pictured(states, N)


def _difference(values: Array) -> Complex:
    """The derivative (...) along a shape, from values (4, ...) at + and - its real part and its imaginary part."""
    return ((values[0] - values[1]) + 1j * (values[2] - values[3])) / (2 * STEP)


def _length(u: Complex) -> float:
    """The largest displacement of points (..., 2) over a cycle.

    |Re(u exp(i theta))|^2 = (|u|^2 + Re(u.u exp(2 i theta)))/2, so that its maximum is (|u|^2 + |u.u|)/2.
    """
    return float(np.sqrt((np.sum(np.abs(u) ** 2, axis=-1) + np.abs(np.sum(u * u, axis=-1))) / 2).max())


def _extent(rest: Motion) -> float:
    """The diagonal of the rectangle of all points and beams [m]; 1 if it is a point."""
    low, high = rest.extremes(rest.points)
    ends = [low, high, *(c.points[0] for c in rest.curves)]
    every = np.concatenate(ends)
    every = every[np.isfinite(every).all(axis=1)]
    extent = float(np.hypot(*np.ptp(every, axis=0))) if len(every) else 0.0
    return extent if is_apart(extent, every) else 1.0
