"""Symbols of gears, racks, pulleys and contacts in space: by their radii, in the colours of their bodies."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from mbdsl.mechanism.scene import Component
from mbdsl.viewing.space.solid import BODY, JOINT, Solid
from mbdsl.viewing.tracks import GROUND, Place, SpaceMotion

WIDTH, RIM = 1.2, 1.15  #: width of wheels in units, and outer radius of a ring relative to its pitch radius


def _wheel(place: Place, radius: float, motion: SpaceMotion, unit: float) -> Solid:
    """A disc of the body that a frame belongs to, about the z axis of the frame."""
    owner = "" if place.track == GROUND else motion.tracks[place.track]
    return Solid("cylinder", BODY, owner, (place,), (radius, radius, WIDTH * unit))


def gears(c: Component, a: Place, b: Place, motion: SpaceMotion, unit: float) -> Iterator[Solid]:
    """Pitch cylinders; a gear with internal teeth is a ring outside of its own."""
    v = c.values
    yield _wheel(a, v["r_a"], motion, unit)
    wheel = _wheel(b, v["r_b"], motion, unit)
    if v["internal"]:
        size = (RIM * v["r_b"], RIM * v["r_b"], WIDTH * unit)
        wheel = Solid("tube", BODY, wheel.name, wheel.at, size, {"bore": 1.0 / RIM})
    yield wheel


def pulleys(c: Component, a: Place, b: Place, motion: SpaceMotion, unit: float) -> Iterator[Solid]:
    yield _wheel(a, c.values["r_a"], motion, unit)
    yield _wheel(b, c.values["r_b"], motion, unit)


def rack(c: Component, a: Place, b: Place, motion: SpaceMotion, unit: float) -> Iterator[Solid]:
    """The pinion, and the part of the x axis of frame_a that it travels on."""
    s = motion.inverse(a, motion.positions(b))[:, 0]
    low, high = (float(np.nanmin(s)), float(np.nanmax(s))) if np.isfinite(s).any() else (0.0, 0.0)
    low, high = low - unit, high + unit
    at = a.moved(((low + high) / 2, 0.0, 0.0))
    yield Solid("box", JOINT, c.name, (at,), (high - low, 0.3 * unit, WIDTH * unit))
    yield _wheel(b, c.values["radius"], motion, unit)


def balls(c: Component, a: Place, b: Place, motion: SpaceMotion, unit: float) -> Iterator[Solid]:
    """The balls of a contact; not the hole that contains a ball."""
    for place, radius in ((a, c.values["r_a"]), (b, c.values["r_b"])):
        if not (place is a and c.values["internal"]):
            owner = "" if place.track == GROUND else motion.tracks[place.track]
            yield Solid("ball", BODY, owner, (place,), (radius,) * 3)


SYMBOLS = {"gears": gears, "belt": pulleys, "rack": rack, "circles": balls}
