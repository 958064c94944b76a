"""Mode shapes as complex displacements of tracks and beams, and one cycle of a mode as a motion.

A mode of eigenvalue s displaces a pose p by Re(u exp(i theta)), where u is complex and theta is the phase. The picture
leaves out decay and growth, so that every mode is a cycle.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from mbdsl.kernels.arrays import Array, Complex
from mbdsl.simulation.trajectory import Trajectory
from mbdsl.system.system import System
from mbdsl.viewing.motion import NEGLIGIBLE, is_apart, motion
from mbdsl.viewing.space import shapes as solids
from mbdsl.viewing.tracks import GROUND, AnyMotion, SpaceMotion

STEP = 1e-4  #: part of a shape by which the state is displaced: poses of beams are not linear in their coordinates
LARGEST, TURN = 0.1, 0.6  #: largest displacement in the picture relative to its extent, largest rotation [rad]
PHASES = 24  #: of the cycle that determines the extent of the picture
SECONDS, PICTURES = 2.0, 50  #: duration of a cycle in a film, and its number of pictures


@dataclass(frozen=True)
class ModeShapes:
    """Displacements of M modes about a state."""

    rest: AnyMotion  #: the state, one row
    #: (M, T, 3) complex [m, m, rad] or (M, T, 7) complex [m, 1]: displacements of the tracks, in space of their
    #: quaternions, scaled to the picture
    tracks: Complex
    #: lists of (M, K, 2) complex [m] and of (M, K) complex [rad]: displacements of the beams
    points: list[Complex]
    angles: list[Complex]
    largest: Array  #: (M,) [m]: largest displacement of a point of the picture

    def cycle(self, mode: int, phases: Array, amplitude: float = 1.0) -> AnyMotion:
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
        if self.rest.scene.spatial:
            poses[..., 3:] /= np.linalg.norm(poses[..., 3:], axis=-1, keepdims=True)
        return replace(self.rest, t=t, rows=np.arange(len(t)), poses=poses, curves=curves)

    def together(self) -> AnyMotion:
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


def mode_shapes(system: System, t: float, q: Array, shapes: Complex) -> ModeShapes:
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
    ModeShapes
        Displacements of tracks and beams by central differences, which are exact for rigid bodies, each mode scaled so
        that its largest displacement is a tenth of the extent of the mechanism.
    """
    rest = _states(system, t, q[None])
    tracks, points, angles, largest = [], [[] for _ in rest.curves], [[] for _ in rest.curves], []
    spots = _spots(rest)
    size = _extent(rest, spots)
    for shape in shapes:
        parts = STEP * np.array([shape.real, -shape.real, shape.imag, -shape.imag])
        near = _states(system, t, system.moved(np.repeat(q[None], 4, axis=0), parts))
        u = _difference(near.poses)
        beams = [(_difference(c.points), _difference(c.angles)) for c in near.curves]
        moved = np.array([rest.displaced(spot, u) for spot in spots]).reshape(-1, rest.dimensions)
        most = max((_length(x) for x in (moved, *(p for p, _ in beams)) if x.size), default=0.0)
        if most < NEGLIGIBLE * size * np.abs(shape).max(initial=0.0):  # rounding: the mode turns bodies about points
            most = 0.0
        # the derivative of a unit quaternion is half the rotation
        turns = 2.0 * np.linalg.norm(u[:, 3:], axis=1) if rest.scene.spatial else np.abs(u[:, 2])
        turn = float(turns.max(initial=0.0))
        factor = min(LARGEST * size / most if most > 0.0 else np.inf, TURN / turn if turn > 0.0 else np.inf)
        factor = factor if np.isfinite(factor) else 1.0
        tracks.append(factor * u)
        for j, (p, a) in enumerate(beams):
            points[j].append(factor * p)
            angles[j].append(factor * a)
        largest.append(factor * most)
    return ModeShapes(
        rest,
        np.array(tracks).reshape(-1, *rest.poses.shape[1:]),
        [np.array(x) for x in points],
        [np.array(x) for x in angles],
        np.array(largest),
    )


def _states(system: System, t: float, q: Array) -> AnyMotion:
    """States (N, n) at one time as a motion."""
    N = len(q)
    return motion(Trajectory(system, np.full(N, t), q, np.zeros_like(q), None, {"status": "done"}), N)


def _spots(rest: AnyMotion) -> list[Any]:
    """Frames, and in space the edges of bodies, whose displacements are seen."""
    sized = solids.drawing(rest).sized if isinstance(rest, SpaceMotion) else []
    edges = [place for solid in sized for place in solids.edge(solid)]
    return [spot for spot in [*rest.spots.values(), *edges] if spot.track != GROUND]


def _difference(values: Array) -> Complex:
    """The derivative (...) along a shape, from values (4, ...) at + and - its real part and its imaginary part."""
    return ((values[0] - values[1]) + 1j * (values[2] - values[3])) / (2 * STEP)


def _length(u: Complex) -> float:
    """The largest displacement of points (..., 2) over a cycle.

    |Re(u exp(i theta))|^2 = (|u|^2 + Re(u.u exp(2 i theta)))/2, so that its maximum is (|u|^2 + |u.u|)/2.
    """
    return float(np.sqrt((np.sum(np.abs(u) ** 2, axis=-1) + np.abs(np.sum(u * u, axis=-1))) / 2).max())


def _extent(rest: AnyMotion, moving: Sequence[Any]) -> float:
    """The diagonal of the box of all points and beams [m]; 1 if it is a point."""
    fixed = [spot for spot in rest.spots.values() if spot.track == GROUND]
    every = [rest.positions(spot)[:1] for spot in [*fixed, *moving]]
    points = np.concatenate([*every, *(c.points[0] for c in rest.curves), np.zeros((0, rest.dimensions))])
    points = points[np.isfinite(points).all(axis=1)]
    extent = float(np.linalg.norm(np.ptp(points, axis=0))) if len(points) else 0.0
    return extent if is_apart(extent, points) else 1.0
