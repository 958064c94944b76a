"""Shapes that the model gives for its bodies, placed on their tracks."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from mbdsl.mechanism.drawn_shapes import DrawnShape
from mbdsl.mechanism.scene import Component, Frame
from mbdsl.system.body_models import body_pose
from mbdsl.viewing.motion import GROUND, Motion, Spot
from mbdsl.viewing.shape import Shape

AROUND = (
    12  #: number of points of an ellipse, and largest number of points of an outline, for the extent of the picture
)


def given_shapes(c: Component, motion: Motion) -> Iterator[Shape]:
    """The shapes of a body or of the ground.

    Parameters
    ----------
    c : Component
        The body.
    motion : Motion
        Its motion.

    Yields
    ------
    Shape
        "outline" of a body, "backdrop" of the ground.
    """
    at = _reference(c, motion)
    for shape in motion.scene.shapes.get(c.name, ()):
        data = {"form": shape.form, "parts": shape.parts, "fill": shape.fill, "line": shape.line, "width": shape.width}
        if shape.form == "ellipse":
            data["axes"] = shape.axes
        yield Shape("backdrop" if at.track == GROUND else "outline", c.name, (at,), data)


def around(c: Component, motion: Motion) -> list[Spot]:
    """Points whose extremes are those of the shapes of a body, up to the distance between points of an outline."""
    at = _reference(c, motion)
    cos, sin = np.cos(at.phi), np.sin(at.phi)
    points = [p for shape in motion.scene.shapes.get(c.name, ()) for p in _around(shape)]
    return [Spot(at.track, float(at.x + cos * x - sin * y), float(at.y + sin * x + cos * y)) for x, y in points]


def _reference(c: Component, motion: Motion) -> Spot:
    """The reference point of a body; of a beam its middle."""
    centre = motion.spots[f"{c.name}.c"]
    if centre.track == GROUND or any(curve.body == c.name for curve in motion.curves):
        return centre
    return Spot(centre.track, *body_pose(c, Frame("", c.name)))


def _around(shape: DrawnShape) -> Sequence[tuple[float, float]]:
    if shape.form == "ellipse":
        (x, y), (a, b, phi) = shape.parts[0][0], shape.axes
        u = 2 * np.pi * np.arange(AROUND) / AROUND
        px, py = a * np.cos(u), b * np.sin(u)
        return list(zip(x + np.cos(phi) * px - np.sin(phi) * py, y + np.sin(phi) * px + np.cos(phi) * py, strict=True))
    points = np.array([p for part in shape.parts for p in part])
    turn = 2 * np.pi * np.arange(AROUND) / AROUND
    most = np.argmax(points @ np.stack([np.cos(turn), np.sin(turn)]), axis=0)
    return [(float(x), float(y)) for x, y in points[np.unique(most)]]
