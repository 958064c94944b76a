"""Ropes in pictures: the line between the discs of a span, which sags where the rope is slack.

The ends of the line, and its middle, are tracks of their own. A rope that is longer than the distance l of its ends by
e sags like a parabola, by sqrt(3/8 l e).
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from functools import partial
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from mbdsl.elements.rope_path import Disc, Span
from mbdsl.expressions.array_operations import ARRAY_OPERATIONS
from mbdsl.expressions.symbolic import Expr, coordinate, evaluate
from mbdsl.mechanism.energies import gravity
from mbdsl.mechanism.scene import Component
from mbdsl.viewing import display
from mbdsl.viewing.display import ON, Path, Shape, Size
from mbdsl.viewing.gear_shapes import wheel
from mbdsl.viewing.space.solid import FORCE, Solid
from mbdsl.viewing.tracks import Motion, Place, SpaceMotion, Spot

Array = NDArray[np.float64]


def line(c: Component, motion: Motion | SpaceMotion, at: Callable[[str, str], Array]) -> tuple[Array, Array, Array]:
    """Both ends (N, 2 or 3) [m] of a span, and its middle; ``at`` gives coordinates (N,) of frames by their keys."""

    def values(roots: list[Expr]) -> Array:
        def leaf(n: Expr) -> Array:
            if n.op == "start":
                return values([n.value])[0, :1]  # type: ignore[list-item]
            return at(*n.value) if n.op == "coordinate" else np.zeros(len(motion.t))  # type: ignore[misc]

        def angle(_: Expr, y: Array, x: Array) -> Array:
            return np.unwrap(np.arctan2(y, x))

        with np.errstate(all="ignore"):
            found = evaluate(roots, leaf, ARRAY_OPERATIONS, angle=angle)  # type: ignore[arg-type]
        return np.array([np.broadcast_to(x, len(motion.t)) for x in found])

    spatial = motion.scene.spatial
    a, b = (
        Disc(partial(coordinate, frame), radius, spatial)
        for frame, radius in zip(c.ports.values(), c.values["ends"], strict=True)
    )
    dimensions = 3 if spatial else 2
    x = values([*Span(a, b).points[0], *Span(a, b).points[1], c.values["longer"]]).T
    first, last, slack = x[:, :dimensions], x[:, dimensions : 2 * dimensions], np.maximum(0.0, -x[:, -1])
    depth = np.sqrt(0.375 * np.linalg.norm(last - first, axis=1) * slack)
    return first, last, 0.5 * (first + last) + depth[:, None] * _across(last - first, np.array(gravity(motion.scene)))


def _across(d: Array, field: Array) -> Array:
    """Unit vectors across vectors d (N, 2 or 3), downwards; sideways if these are vertical."""
    u = d / np.maximum(np.linalg.norm(d, axis=1), 1e-300)[:, None]
    side = np.eye(d.shape[1])[int(np.abs(field).argmin())]
    down = field / max(float(np.linalg.norm(field)), 1e-300) + 0.1 * side
    across = down - (u @ down)[:, None] * u
    return across / np.maximum(np.linalg.norm(across, axis=1), 1e-300)[:, None]


def rope(c: Component, a: Spot, b: Spot, motion: Motion, unit: float) -> Iterator[Shape]:
    """A span in the plane, and its discs."""
    for spot, radius in zip((a, b), c.values.get("ends", ()), strict=False):
        if radius:
            yield wheel(c, spot, abs(radius), motion)
    at = (a, b)
    if len(motion.t) > 1 and "longer" in c.values:
        index = {"x": 0, "y": 1, "phi": 2}

        def key(frame: str, key: str) -> Array:
            return motion.pose(motion.spot_of(frame))[:, index[key]]

        at = tuple(Spot(k) for k in _tracks(c, motion, line(c, motion, key), (0.0,)))
    line_ = Path(at, ON, curved=len(at) == 3, stroke=display.FORCE, width=Size(1.5, 0.14))
    yield Shape("rope", c.name, at, (line_,))


def rope_in_space(c: Component, a: Place, b: Place, motion: SpaceMotion, unit: float) -> Iterator[Solid]:
    """A span in space, in two straight parts, and its discs."""
    for place, radius in zip((a, b), c.values.get("ends", ()), strict=False):
        if radius:
            size = (abs(radius), abs(radius), 0.3 * unit)
            yield Solid("cylinder", FORCE, c.name, (place,), size)
    places = [a, b]
    if len(motion.t) > 1 and "longer" in c.values:

        def at(frame: str, key: str) -> Array:
            place = motion.spot_of(frame)
            if key in "xyz":
                return motion.positions(place)[:, "xyz".index(key)]
            found = motion.turned(place, np.eye(3)["xyz".index(key[0])])
            return np.broadcast_to(found, (len(motion.t), 3))[:, "xyz".index(key[1])]

        first, last, middle = _tracks(c, motion, line(c, motion, at), (1.0, 0.0, 0.0, 0.0))
        places = [Place(first), Place(middle), Place(last)]
    for one, other in pairwise(places):
        yield Solid("cylinder", FORCE, c.name, (one, other), (0.12 * unit, 0.12 * unit))


def _tracks(
    c: Component, motion: Motion | SpaceMotion, points: tuple[Array, ...], turn: tuple[float, ...]
) -> tuple[int, ...]:
    """The numbers of new tracks of points (N, 2 or 3), which do not turn."""
    first = len(motion.tracks)
    motion.tracks.extend([f"{c.name}.line"] * len(points))
    new = [np.hstack([x, np.tile(turn, (len(x), 1))]) for x in points]
    motion.poses = np.concatenate([motion.poses, np.stack(new, axis=1)], axis=1)
    return tuple(range(first, first + len(points)))
