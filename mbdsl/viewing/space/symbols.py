"""Symbols of joints and forces in space: solids at or between the two frames of an element, by its kind.

A kind names one of ``SYMBOLS`` as its ``drawing``; without it an element is drawn as a small cube.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from itertools import pairwise
from math import sqrt

import numpy as np

from mbdsl.mechanism.scene import Component
from mbdsl.viewing.space.solid import BODY, DRIVE, FORCE, JOINT, SUPPORT, Solid
from mbdsl.viewing.symbols import nature
from mbdsl.viewing.tracks import GROUND, UNTURNED, Place, SpaceMotion

#: radius of coils in units, their pitch relative to it, and numbers of turns
COIL, PITCH, LEAST_TURNS, MOST_TURNS = 0.8, 1.6, 5, 30
MOST_POINTS = 400  #: of a wire
ROUND_ENDS = ("LineContact", "SphereCapsuleContact")  #: contacts whose bodies end in half balls
WIDTH, RIM = 1.2, 1.15  #: width of wheels in units, and outer radius of a ring relative to its pitch radius
HALF = sqrt(0.5)
#: quaternion that turns the z axis to the x axis: cylinders, rings and coils have the axis z
TO_X = (HALF, 0.0, HALF, 0.0)


Symbol = Callable[[Component, Place, Place, SpaceMotion, float], Iterator[Solid]]


def symbol(c: Component, motion: SpaceMotion, unit: float) -> Iterator[Solid]:
    """The symbol of an element between two frames; ``unit`` is the size of symbols [m]."""
    a, b = (motion.spot_of(frame) for frame in c.ports.values())
    yield from SYMBOLS.get(c.kind.drawing, _mark)(c, a, b, motion, unit)


def bodies_shown(c: Component, motion: SpaceMotion) -> set[int]:
    """Tracks of the bodies that the symbol of an element shows, as gears and pulleys do."""
    a, b = (motion.spot_of(frame).track for frame in c.ports.values())
    name = c.kind.drawing
    if name == "surface":
        return {b} if any(c.values.get(x) for x in ("radius", "length")) else set()
    return {b} if name == "rack" else {a, b} if name in ("gears", "belt", "circles", "ball on solid") else set()


def _one(draw: str, role: str, size: Sequence[float], p: tuple[float, ...] = UNTURNED, on_b: bool = False) -> Symbol:
    """A symbol at frame_a or frame_b; ``size`` is in units."""

    def solids(c: Component, a: Place, b: Place, motion: SpaceMotion, unit: float) -> Iterator[Solid]:
        yield Solid(draw, role, c.name, ((b if on_b else a).moved(p=p),), tuple(unit * x for x in size))

    return solids


def _cross(c: Component, a: Place, b: Place, motion: SpaceMotion, unit: float) -> Iterator[Solid]:
    """The cross of a Cardan joint: its axes are z of frame_a and x of frame_b."""
    size = (0.32 * unit, 0.32 * unit, 2.0 * unit)
    yield Solid("cylinder", JOINT, c.name, (a,), size)
    yield Solid("cylinder", JOINT, c.name, (b.moved(p=TO_X),), size)


def _guide(c: Component, a: Place, b: Place, motion: SpaceMotion, unit: float) -> Solid:
    """The part of the x axis of frame_a that frame_b travels on."""
    low, high = motion.travel(a, b)
    low, high = low - 1.2 * unit, high + 1.2 * unit
    size = (0.25 * unit, 0.25 * unit, high - low)
    return Solid("cylinder", JOINT, c.name, (a.moved(((low + high) / 2, 0.0, 0.0), TO_X),), size)


def _slider(c: Component, a: Place, b: Place, motion: SpaceMotion, unit: float) -> Iterator[Solid]:
    yield _guide(c, a, b, motion, unit)
    yield Solid("box", JOINT, c.name, (b,), (1.5 * unit, unit, unit))


def _sleeve(c: Component, a: Place, b: Place, motion: SpaceMotion, unit: float) -> Iterator[Solid]:
    yield _guide(c, a, b, motion, unit)
    yield Solid("cylinder", JOINT, c.name, (b.moved(p=TO_X),), (0.5 * unit, 0.5 * unit, 1.6 * unit))


def _bead(c: Component, a: Place, b: Place, motion: SpaceMotion, unit: float) -> Iterator[Solid]:
    yield _guide(c, a, b, motion, unit)
    yield Solid("ball", JOINT, c.name, (b,), (0.5 * unit,) * 3)


def _plate(c: Component, a: Place, b: Place, motion: SpaceMotion, unit: float) -> Iterator[Solid]:
    yield Solid("box", JOINT, c.name, (a,), (3.0 * unit, 3.0 * unit, 0.12 * unit))
    yield Solid("ball", JOINT, c.name, (b,), (0.4 * unit,) * 3)


def _form(c: Component, at: Place, radius: float, motion: SpaceMotion, unit: float) -> Iterator[Solid]:
    """What touches in a contact, at its frame: a cuboid, or a ball, a cylinder, a capsule or an edge of a radius."""
    length, width, height = (float(c.values.get(name) or 0.0) for name in ("length", "width", "height"))
    name, upright = motion.owner(at), at.moved(p=TO_X)
    if height:
        yield Solid("box", BODY, name, (at,), (length, width, height))
        return
    if length:
        thin = radius or 0.1 * unit
        yield Solid("cylinder", BODY, name, (upright,), (thin, thin, length))
    if radius and (not length or c.kind.name in ROUND_ENDS):
        for x in (-length / 2, length / 2) if length else (0.0,):
            yield Solid("ball", BODY, name, (at.moved((x, 0.0, 0.0)),), (radius,) * 3)


def _surface(c: Component, a: Place, b: Place, motion: SpaceMotion, unit: float) -> Iterator[Solid]:
    """The plane of a contact or constraint, and what touches it."""
    radius = float(c.values.get("radius") or 0.0)
    if "n" in c.values:
        reach = 2.0 * float(motion.apart(a, b).max()) + 2.0 * unit
        yield Solid("box", JOINT, c.name, (a,), (reach, reach, 0.02 * unit))
    yield from _form(c, b, radius, motion, unit)


def _ball_on_solid(c: Component, a: Place, b: Place, motion: SpaceMotion, unit: float) -> Iterator[Solid]:
    yield from _form(c, a, float(c.values.get("R") or 0.0), motion, unit)
    yield Solid("ball", BODY, motion.owner(b), (b,), (float(c.values["radius"]),) * 3)


def _stop(c: Component, a: Place, b: Place, motion: SpaceMotion, unit: float) -> Iterator[Solid]:
    """Walls at the limits on the x axis of frame_a."""
    for name in ("s_min", "s_max"):
        limit = c.values.get(name)
        if limit is not None and np.isfinite(limit):
            place = a.moved((float(limit), 0.0, 0.0))
            yield Solid("box", FORCE, c.name, (place,), (0.2 * unit, 2.0 * unit, 2.0 * unit))


def _between(*parts: tuple[str, float], role: str = FORCE, ends: float = 0.0) -> Symbol:
    """Shapes (name, radius in units) from frame_a to frame_b, with balls at the ends."""

    def solids(c: Component, a: Place, b: Place, motion: SpaceMotion, unit: float) -> Iterator[Solid]:
        for draw, radius in parts:
            yield Solid(draw, role, c.name, (a, b), (radius * unit, radius * unit))
        if ends:
            for place in (a, b):
                yield Solid("ball", JOINT, c.name, (place,), (ends * unit,) * 3)

    return solids


def _spring_damper(c: Component, a: Place, b: Place, motion: SpaceMotion, unit: float) -> Iterator[Solid]:
    """A coil, a dashpot or both, by the constants that are not zero; or an actuator."""
    draw = nature(c)
    if draw == "actuator":
        yield from SYMBOLS[draw](c, a, b, motion, unit)
    if draw.startswith("spring"):
        radius = COIL * unit
        turns = min(MOST_TURNS, max(LEAST_TURNS, round(float(motion.apart(a, b).mean()) / (PITCH * radius))))
        yield Solid("coil", FORCE, c.name, (a, b), (radius, radius), {"turns": turns})
    if draw.endswith("damper"):
        yield from _between(("piston", 0.36))(c, a, b, motion, unit)


def _turning_spring(c: Component, a: Place, b: Place, motion: SpaceMotion, unit: float) -> Iterator[Solid]:
    """A spiral, the drum of a damper, or the ring of a torque that does not depend on the angle."""
    draw = {"actuator": "turning", "damper": "drum"}.get(nature(c), "spiral")
    yield from SYMBOLS[draw](c, a, b, motion, unit)


def _track(c: Component, a: Place, b: Place, motion: SpaceMotion, unit: float) -> Iterator[Solid]:
    """The path of frame_b in the axes of frame_a as a wire, and a bead on it."""
    path = motion.inverse(a, motion.positions(b))
    path = path[np.isfinite(path).all(axis=1)]
    kept = [0] if len(path) else []
    for k, point in enumerate(path):
        if np.linalg.norm(point - path[kept[-1]]) > 0.5 * unit and len(kept) < MOST_POINTS:
            kept.append(k)
    if len(kept) > 2:
        data = {"points": path[kept].tolist(), "radius": 0.16 * unit}
        yield Solid("wire", JOINT, c.name, (a,), (1.0, 1.0, 1.0), data)
    yield Solid("ball", JOINT, c.name, (b,), (0.5 * unit,) * 3)


def _nothing(c: Component, a: Place, b: Place, motion: SpaceMotion, unit: float) -> Iterator[Solid]:
    yield from ()


def _wheel(place: Place, radius: float, motion: SpaceMotion, unit: float) -> Solid:
    """A disc of the body that a frame belongs to, about the z axis of the frame."""
    return Solid("cylinder", BODY, motion.owner(place), (place,), (radius, radius, WIDTH * unit))


def _gears(c: Component, a: Place, b: Place, motion: SpaceMotion, unit: float) -> Iterator[Solid]:
    """Pitch cylinders; a gear with internal teeth is a ring outside of its own."""
    v = c.values
    yield _wheel(a, v["r_a"], motion, unit)
    wheel = _wheel(b, v["r_b"], motion, unit)
    if v["internal"]:
        size = (RIM * v["r_b"], RIM * v["r_b"], WIDTH * unit)
        wheel = Solid("tube", BODY, wheel.name, wheel.at, size, {"bore": 1.0 / RIM})
    yield wheel


def _pulleys(c: Component, a: Place, b: Place, motion: SpaceMotion, unit: float) -> Iterator[Solid]:
    yield _wheel(a, c.values["r_a"], motion, unit)
    yield _wheel(b, c.values["r_b"], motion, unit)


def _rack(c: Component, a: Place, b: Place, motion: SpaceMotion, unit: float) -> Iterator[Solid]:
    """The pinion, and the part of the x axis of frame_a that it travels on."""
    low, high = motion.travel(a, b)
    low, high = low - unit, high + unit
    at = a.moved(((low + high) / 2, 0.0, 0.0))
    yield Solid("box", JOINT, c.name, (at,), (high - low, 0.3 * unit, WIDTH * unit))
    yield _wheel(b, c.values["radius"], motion, unit)


def _balls(c: Component, a: Place, b: Place, motion: SpaceMotion, unit: float) -> Iterator[Solid]:
    """The balls of a contact; not the hole that contains a ball."""
    for place, radius in ((a, c.values["r_a"]), (b, c.values["r_b"])):
        if not (place is a and c.values["internal"]):
            yield Solid("ball", BODY, motion.owner(place), (place,), (radius,) * 3)


def _rope(c: Component, a: Place, b: Place, motion: SpaceMotion, unit: float) -> Iterator[Solid]:
    """A span in two straight parts, and its discs."""
    for place, radius in zip((a, b), c.values.get("ends", ()), strict=False):
        if radius:
            yield Solid("cylinder", FORCE, c.name, (place,), (abs(radius), abs(radius), 0.3 * unit))
    first, last, *middle = motion.lines.get(c.name, (a, b))
    for one, other in pairwise((first, *middle, last)):
        yield Solid("cylinder", FORCE, c.name, (one, other), (0.12 * unit, 0.12 * unit))


def support(place: Place, unit: float) -> Solid:
    """The mark of a frame of the ground that an element is attached to."""
    assert place.track == GROUND
    return Solid("box", SUPPORT, "", (place,), (1.1 * unit,) * 3)


_mark = _one("box", JOINT, (0.7, 0.7, 0.7), on_b=True)

SYMBOLS: dict[str, Symbol] = {
    "hinge": _one("cylinder", JOINT, (0.55, 0.55, 1.7)),
    "ball": _one("ball", JOINT, (0.6, 0.6, 0.6)),
    "cross": _cross,
    "slider": _slider,
    "sleeve": _sleeve,
    "bead": _bead,
    "plate": _plate,
    "point": _one("ball", JOINT, (0.4, 0.4, 0.4), on_b=True),
    "weld": _one("box", JOINT, (0.8, 0.8, 0.8), on_b=True),
    "blade": _one("box", JOINT, (3.0, 0.12, 1.2), on_b=True),
    "rod": _between(("cylinder", 0.22), role=BODY, ends=0.34),
    "actuator": _between(("piston", 0.36), role=DRIVE, ends=0.36),
    "spring": _spring_damper,
    "turning spring": _turning_spring,
    "spiral": _one("spiral", FORCE, (1.2, 1.2, 1.2)),
    "drum": _one("cylinder", FORCE, (0.9, 0.9, 0.6)),
    "turning": _one("ring", DRIVE, (1.0, 1.0, 1.0)),
    "stop": _stop,
    "turning stop": _nothing,
    "track": _track,
    "cam": _track,
    "dashed": _between(("cylinder", 0.1)),
    "gears": _gears,
    "belt": _pulleys,
    "rack": _rack,
    "circles": _balls,
    "surface": _surface,
    "ball on solid": _ball_on_solid,
    "rope": _rope,
    "bushing": _one("ball", FORCE, (0.7, 0.7, 0.7)),
    "mark": _mark,
    "nothing": _nothing,
}
