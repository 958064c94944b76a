"""Ropes in pictures: the line between the discs of a span, which sags where the rope is slack.

The ends of the line, and its middle, are tracks of their own. A rope that is longer than the distance l of its ends by
e sags like a parabola, by sqrt(3/8 l e).
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

import numpy as np

from mbdsl.elements.rope_path import Disc, RopeSpan
from mbdsl.expressions.array_operations import ARRAY_OPERATIONS
from mbdsl.expressions.symbolic import Expr, coordinate, evaluate
from mbdsl.kernels.arrays import Array
from mbdsl.mechanism.energies import gravity
from mbdsl.mechanism.scene import Component
from mbdsl.viewing.tracks import UNTURNED, AnyMotion, Motion, Place, Spot


def line(c: Component, motion: AnyMotion, at: Callable[[str, str], Array]) -> tuple[Array, Array, Array]:
    """Both ends (N, 2 or 3) [m] of a span, and its middle; ``at`` gives coordinates (N,) of frames by their keys."""

    def values(roots: list[Expr]) -> Array:
        def leaf(n: Expr) -> Array:
            if n.op == "start":
                return values([n.value])[0, :1]
            return at(*n.value) if n.op == "coordinate" else np.zeros(len(motion.t))

        def angle(_: Expr, y: Array, x: Array) -> Array:
            return np.unwrap(np.arctan2(y, x))

        with np.errstate(all="ignore"):
            found = evaluate(roots, leaf, ARRAY_OPERATIONS, angle=angle)
        return np.array([np.broadcast_to(x, len(motion.t)) for x in found])

    spatial = motion.scene.spatial
    a, b = (
        Disc(partial(coordinate, frame), radius, spatial)
        for frame, radius in zip(c.ports.values(), c.values["ends"], strict=True)
    )
    dimensions = 3 if spatial else 2
    x = values([*RopeSpan(a, b).points[0], *RopeSpan(a, b).points[1], c.values["longer"]]).T
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


def add_lines(motion: AnyMotion) -> None:
    """Add the tracks of the lines of ropes: their ends and middles. At one time turns around discs are unknown."""
    if motion.t[-1] <= motion.t[0]:
        return

    def at(frame: str, key: str) -> Array:
        spot = motion.spot_of(frame)
        if key == "phi" and isinstance(motion, Motion):
            return motion.pose(spot)[:, 2]
        if key in "xyz":
            return motion.positions(spot)[:, "xyz".index(key)]
        found = motion.turned(spot, np.eye(3)["xyz".index(key[0])])
        return np.broadcast_to(found, (len(motion.t), 3))[:, "xyz".index(key[1])]

    spatial = motion.scene.spatial
    new, frame = [], Place if spatial else Spot
    for c in motion.scene.components.values():
        if "longer" in c.values and "ends" in c.values:
            first = len(motion.tracks)
            motion.tracks.extend([f"{c.name}.line"] * 3)
            motion.lines[c.name] = (frame(first), frame(first + 1), frame(first + 2))
            new += line(c, motion, at)
    if new:
        unturned = np.tile(UNTURNED if spatial else (0.0,), (len(motion.t), len(new), 1))
        poses = np.concatenate([np.stack(new, axis=1), unturned], axis=2)
        motion.poses = np.concatenate([motion.poses, poses], axis=1)
