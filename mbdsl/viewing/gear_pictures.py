"""Gears, cams, rings, belts and ropes in pictures of pixels; the same as ``gears.js``."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from mbdsl.plotting.series_styles import LIGHT_PAPER
from mbdsl.viewing.pixels import FORCE, Pixels, Place, mixed
from mbdsl.viewing.shape import Shape


def _plate(p: Pixels, shape: Shape, place: Place) -> None:
    at, colour = p.axes(place), p.colour(shape)
    points = [at(p.scale * x, -p.scale * y) for x, y in shape.data["points"]]
    p.area(points, mixed(colour, LIGHT_PAPER, 0.78), colour, 1.5)
    if "bare" not in shape.data:
        p.line([at(0, 0), points[0]], p.thin, mixed(colour, LIGHT_PAPER, 0.3))
        p.circle(place, max(2.0, 0.3 * p.U), LIGHT_PAPER)


def _ring(p: Pixels, shape: Shape, place: Place) -> None:
    at, colour = p.axes(place), p.colour(shape)
    points = [at(p.scale * x, -p.scale * y) for x, y in shape.data["points"]]
    p.circle(place, shape.data["radius"] * p.scale, mixed(colour, LIGHT_PAPER, 0.78), colour, 1.5)
    p.area(points, LIGHT_PAPER, colour, 1.5)


def _belt(p: Pixels, shape: Shape, a: Place, b: Place) -> None:
    """The strands between the points of contact, and the arcs on the far sides."""
    (at, length), r_a, r_b = p.between(a, b), shape.data["r_a"] * p.scale, shape.data["r_b"] * p.scale
    if length <= abs(r_a - r_b):
        return
    lean, width = float(np.arccos((r_a - r_b) / length)), max(2.0, 0.2 * p.U)
    for side in (1.0, -1.0):
        x, y = np.cos(lean), side * np.sin(lean)
        p.line([at(r_a * x, r_a * y), at(length + r_b * x, r_b * y)], width, FORCE)
    half = lean if r_b > 0.0 else np.pi - lean
    for centre, radius, first, last in ((0.0, r_a, lean, 2 * np.pi - lean), (length, abs(r_b), -half, half)):
        arc = np.linspace(first, last, 40)
        p.line([at(centre + radius * np.cos(u), radius * np.sin(u)) for u in arc], width, FORCE)


def _rope(p: Pixels, shape: Shape, a: Place, b: Place, middle: Place | None = None) -> None:
    """A parabola through its middle."""
    ends, width = np.array([a[:2], b[:2]]), max(1.5, 0.14 * p.U)
    sag = np.zeros(2) if middle is None else np.array(middle[:2]) - ends.mean(axis=0)
    s = np.linspace(0.0, 1.0, 13 if sag.any() else 2)[:, None]
    p.line((ends[0] + s * (ends[1] - ends[0]) + 4.0 * s * (1.0 - s) * sag).tolist(), width, FORCE)


DRAWN: dict[str, Callable[..., Any]] = {"plate": _plate, "ring": _ring, "belt": _belt, "rope": _rope}
