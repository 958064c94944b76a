"""Shapes that the model gives for its bodies, placed on their tracks."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from mbdsl.kernels.arrays import Array
from mbdsl.mechanism.drawn_shapes import DrawnShape
from mbdsl.mechanism.scene import Component, Frame
from mbdsl.system.body_models import body_pose
from mbdsl.viewing.display import PAPER, DrawnPath, Shape, Size, colour_of
from mbdsl.viewing.tracks import GROUND, Motion, Spot

ELLIPSE = 96  #: number of points of an ellipse


def given_shapes(c: Component, motion: Motion) -> Iterator[Shape]:
    """The shapes of a body or of the ground.

    Yields
    ------
    Shape
        "outline" of a body, "backdrop" of the ground.
    """
    at, own = _reference(c, motion), colour_of(motion, c.name)
    for shape in motion.scene.shapes.get(c.name, ()):
        parts = [_ellipse(shape)] if shape.form == "ellipse" else list(shape.parts)
        path = DrawnPath(
            (at,),
            metres=tuple((float(x), float(y)) for part in parts for x, y in part),
            cuts=tuple(int(k) for k in np.cumsum([len(part) for part in parts])[:-1]),
            closed=shape.form != "line",
            fill=None if shape.form == "line" or shape.fill == "none" else shape.fill or (own, PAPER, 0.72),
            stroke=None if shape.line == "none" else shape.line or own,
            width=Size(1.2, 0.0, shape.width),
        )
        yield Shape("backdrop" if at.track == GROUND else "outline", c.name, (at,), (path,))


def extent(name: str, at: Spot, motion: Motion) -> tuple[Array, Array] | None:
    """The least and the largest coordinates (2,) [m] of a body's shapes in the axes of a frame, at the start; None if
    no shape is given."""
    if not (shapes := motion.scene.shapes.get(name)):
        return None
    own = _reference(motion.scene.components[name], motion)
    parts = [x for shape in shapes for x in ([_ellipse(shape)] if shape.form == "ellipse" else shape.parts)]
    points = [own.moved(x, y) for part in parts for x, y in part]
    x, y, phi = motion.pose(at)[0]
    away = motion.places(points, 0)[:, :2] - (x, y)
    found = away @ np.array([(np.cos(phi), -np.sin(phi)), (np.sin(phi), np.cos(phi))])
    return found.min(axis=0), found.max(axis=0)


def _reference(c: Component, motion: Motion) -> Spot:
    """The reference point of a body; of a beam its middle."""
    centre = motion.spots[f"{c.name}.c"]
    if centre.track == GROUND or any(curve.body == c.name for curve in motion.curves):
        return centre
    return Spot(centre.track, *body_pose(c, Frame("", c.name)))


def _ellipse(shape: DrawnShape) -> Sequence[tuple[float, float]]:
    (x, y), (a, b, phi) = shape.parts[0][0], shape.axes
    u = 2 * np.pi * np.arange(ELLIPSE) / ELLIPSE
    px, py = a * np.cos(u), b * np.sin(u)
    return list(zip(x + np.cos(phi) * px - np.sin(phi) * py, y + np.sin(phi) * px + np.cos(phi) * py, strict=True))
