"""Shapes of gears, racks, belts, ropes, cams and circles in contact, from the radii and laws of their elements.

The gears of a train have teeth of one module, about a dozen of them on the smallest gear, and mesh in the first frame.
The teeth only show the motion; their flanks are not involutes.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np

from mbdsl.elements import profile
from mbdsl.elements.kind import JointKind
from mbdsl.expressions.array_operations import ARRAY_OPERATIONS, table_value
from mbdsl.expressions.symbolic import Expr, coordinate, evaluate, expr, leaves
from mbdsl.kernels.arrays import Array
from mbdsl.mechanism.scene import Component
from mbdsl.viewing.display import (
    ALONG,
    FORCE,
    ON,
    PAPER,
    Circle,
    DrawnPath,
    Item,
    Points,
    Shape,
    Size,
    colour_of,
)
from mbdsl.viewing.tracks import GROUND, Motion, Spot

ADDENDUM, DEDENDUM, RIM = 0.8, 1.0, 2.6  #: height and depth of teeth, and thickness of a ring, in modules
FEWEST, MOST = 11, 24  #: teeth of the smaller gear of a pair
ROUND, ARC = 60, 40  #: corners of a circle, points of the part of a belt on a pulley
CAM = 120  #: points of a cam


def rounded(points: Array, digits: int | None = None) -> Points:
    """Corners (n, 2) with some digits after the point, or with five digits of the largest."""
    if digits is None:
        digits = 5 - int(np.floor(np.log10(np.abs(points).max() or 1.0)))
    return tuple((round(x, digits), round(y, digits)) for x, y in points.tolist())


def wheel(c: Component, at: Spot, radius: float, motion: Motion) -> Shape:
    """A wheel with a dot at its edge."""
    own = colour_of(motion, at)
    items: tuple[Item, ...] = (
        Circle((at,), Size(metres=radius), (own, PAPER, 0.85), own, Size(2.0)),
        DrawnPath((at,), metres=((0.0, -radius), (0.0, radius)), stroke=(own, PAPER, 0.5)),
        DrawnPath((at,), metres=((-radius, 0.0), (radius, 0.0)), stroke=own),
        Circle((at.moved(0.78 * radius),), Size(1.5, 0.0, 0.07 * radius), own, None),
        Circle((at,), Size(2.0, 0.25), PAPER),
    )
    return Shape("wheel", c.name, (at,), items, radius)


def _area(at: Spot, points: Array, motion: Motion) -> DrawnPath:
    own = colour_of(motion, at)
    return DrawnPath((at,), metres=rounded(points), closed=True, fill=(own, PAPER, 0.78), stroke=own, width=Size(1.5))


def _plate(c: Component, at: Spot, points: Array, radius: float, motion: Motion) -> Shape:
    """A disc with an edge of any shape, a line to its first corner, and a hole for its axle."""
    area = _area(at, points, motion)
    line = DrawnPath((at,), metres=((0.0, 0.0), area.metres[0]), stroke=(colour_of(motion, at), PAPER, 0.3))
    return Shape("plate", c.name, (at,), (area, line, Circle((at,), Size(2.0, 0.3), PAPER)), radius)


def _ring(c: Component, at: Spot, hole: Array, radius: float, motion: Motion) -> Shape:
    """A ring with a hole of any shape."""
    own = colour_of(motion, at)
    disc = Circle((at,), Size(metres=radius), (own, PAPER, 0.78), own, Size(1.5))
    inner = DrawnPath((at,), metres=rounded(hole), closed=True, fill=PAPER, stroke=own, width=Size(1.5))
    return Shape("ring", c.name, (at,), (disc, inner), radius)


def _polar(radius: Array | float, angle: Array) -> Array:
    return np.stack([radius * np.cos(angle), radius * np.sin(angle)], axis=1)


def circle(radius: float) -> Array:
    """Corners (n, 2) [m] of a circle."""
    return _polar(radius, np.linspace(0.0, 2 * np.pi, ROUND, endpoint=False))


def toothed(radius: float, module: float, first: float) -> Array:
    """Corners (n, 2) [m] of a gear with this pitch radius, one of whose teeth is at the angle ``first``."""
    count = max(3, round(2 * radius / module))
    flank = np.array([-0.35, -0.15, 0.15, 0.35])  # of a tooth: root, tip, tip, root, in pitches
    height = np.array([-DEDENDUM, ADDENDUM, ADDENDUM, -DEDENDUM]) * module
    angle = first + 2 * np.pi / count * (np.arange(count)[:, None] + flank)
    return _polar((radius + np.broadcast_to(height, angle.shape)).ravel(), angle.ravel())


def _module(small: float, large: float) -> float:
    """A module that gives both gears nearly whole numbers of teeth."""
    counts = np.arange(FEWEST, MOST + 1)
    off = np.abs(counts * large / small - np.rint(counts * large / small))
    return 2 * small / int(counts[np.argmin(off + 1e-3 * counts)])


def _teeth(motion: Motion) -> dict[str, tuple[float, float]]:
    """Frame of a gear -> its module and the angle of one of its teeth, in the axes of the frame."""
    found: dict[str, tuple[float, float]] = {}
    for c in motion.scene.components.values():
        if c.kind.name != "GearPair":
            continue
        (a, b), r_a, r_b = c.ports.values(), float(c.values["r_a"]), float(c.values["r_b"])
        pa, pb = (motion.pose(motion.spot_of(frame))[0] for frame in (a, b))
        inside = c.values["internal"]
        known = found.get(a) or found.get(b)
        module = known[0] if known else _module(min(r_a, r_b), max(r_a, r_b))
        line = np.arctan2(pb[1] - pa[1], pb[0] - pa[0])
        at_a, at_b = line + np.pi * inside - pa[2], line + np.pi - pb[2]  # where the circles touch
        sense = 1.0 if inside else -1.0
        # teeth are in gaps; the polygon of a ring is its hole, which has teeth at the angles of those of a
        half = 0.0 if inside else np.pi * module / 2
        if a not in found and b not in found:
            found[a] = (module, 0.0)
        if b not in found:
            found[b] = (module, float(at_b - (sense * (at_a - found[a][1]) * r_a + half) / r_b))
        elif a not in found:
            found[a] = (module, float(at_a - (sense * (at_b - found[b][1]) * r_b + half) / r_a))
    return found


def gears(c: Component, a: Spot, b: Spot, motion: Motion, unit: float) -> Iterator[Shape]:
    """The two gears of a GearPair."""
    teeth = _teeth(motion)
    for frame, spot, key in zip(c.ports.values(), (a, b), ("r_a", "r_b"), strict=True):
        radius, (module, first) = float(c.values[key]), teeth[frame]
        points = toothed(radius, module, first)
        if c.values["internal"] and key == "r_b":
            yield _ring(c, spot, points, radius + RIM * module, motion)
        else:
            yield _plate(c, spot, points, radius + ADDENDUM * module, motion)


def rack(c: Component, a: Spot, b: Spot, motion: Motion, unit: float) -> Iterator[Shape]:
    """A pinion and the part of its rack that it rolls on."""
    radius = float(c.values["radius"])
    module = 2 * radius / 14
    pitch = np.pi * module
    s = motion.along(a, b)
    s = s[np.isfinite(s)] if np.isfinite(s).any() else np.zeros(1)
    down = -np.pi / 2 + motion.pose(a)[0, 2] - motion.pose(b)[0, 2]  # where the pinion touches, in its own axes
    first = s[0] + radius * down  # a tooth of the pinion at the angle 0 is at this place along the rack
    low = np.floor((s.min() - radius - first) / pitch)
    k = np.arange(low, np.ceil((s.max() + radius - first) / pitch))
    x = first + pitch * (k[:, None] + 0.5 + np.array([-0.35, -0.15, 0.15, 0.35]))
    y = np.broadcast_to(np.array([-DEDENDUM, ADDENDUM, ADDENDUM, -DEDENDUM]) * module, x.shape)
    base = np.array([(x[-1, -1], -RIM * module), (x[0, 0], -RIM * module)])
    points = np.concatenate([np.stack([x.ravel(), y.ravel()], axis=1), base])
    yield Shape("plate", c.name, (a,), (_area(a, points, motion),))
    yield _plate(c, b, toothed(radius, module, 0.0), radius + ADDENDUM * module, motion)


def belt(c: Component, a: Spot, b: Spot, motion: Motion, unit: float) -> Iterator[Shape]:
    """Two pulleys, and a belt that leaves them where it does at their mean distance."""
    r_a, r_b = float(c.values["r_a"]), float(c.values["r_b"])
    for spot, radius in ((a, r_a), (b, r_b)):
        yield wheel(c, spot, radius, motion)
    length = float(motion.apart(a, b).mean())
    r_b = -r_b if c.values["crossed"] else r_b
    if length <= abs(r_a - r_b):
        return
    lean = float(np.arccos((r_a - r_b) / length))
    half = lean if r_b > 0.0 else np.pi - lean
    arc_a, arc_b = np.linspace(lean, 2 * np.pi - lean, ARC), np.linspace(-half, half, ARC)
    arc_b = arc_b if r_b > 0.0 else arc_b[::-1]
    points = np.concatenate([_polar(r_a, arc_a), _polar(abs(r_b), arc_b)])
    share = (0.0,) * ARC + (1.0,) * ARC
    look: dict[str, Any] = {"closed": True, "stroke": FORCE, "width": Size(2.0, 0.2)}
    yield Shape("belt", c.name, (a, b), (DrawnPath((a, b), ALONG, metres=rounded(points), share=share, **look),))


def _law(c: Component, motion: Motion, angle: Array) -> Array:
    """The function of a cam at angles (n,) [rad] of its argument."""
    assert isinstance(c.kind, JointKind) and c.kind.coupling is not None
    law, argument = expr(c.values[c.kind.coupling[0]]), motion.scene.signal_of(c, c.kind.coupling[1])
    assert argument is not None
    turning = coordinate(c.ports["frame_a"], "phi")  # the argument is this angle plus terms that are 0 here

    def at(leaf: Expr) -> object:
        return angle if leaf is turning else 0.0

    with np.errstate(all="ignore"):
        (found,) = evaluate([law], at, ARRAY_OPERATIONS, table_value)
    return np.broadcast_to(np.asarray(found, float), angle.shape)


def cam(c: Component, a: Spot, b: Spot, motion: Motion, unit: float) -> Iterator[Shape]:
    """A cam with the path of its follower's point as its edge."""
    angle = np.linspace(0.0, 2 * np.pi, CAM, endpoint=False)
    lift = _law(c, motion, angle)
    if np.isfinite(lift).all():
        yield _plate(c, a, _polar(lift, -angle), float(np.abs(lift).max()), motion)
    yield Shape("pin", c.name, (b,), (Circle((b,), Size(1.5, 0.27), PAPER),))


def circles(c: Component, a: Spot, b: Spot, motion: Motion, unit: float) -> Iterator[Shape]:
    """Two discs, or a disc in a hole."""
    r_a, r_b = float(c.values["r_a"]), float(c.values["r_b"])
    if c.values["internal"]:
        yield _ring(c, a, circle(r_a), r_a + 0.15 * r_b, motion)
    else:
        yield _plate(c, a, circle(r_a), r_a, motion)
    yield _plate(c, b, circle(r_b), r_b, motion)


def closed_profile(c: Component, a: Spot, b: Spot, motion: Motion, unit: float) -> Iterator[Shape]:
    """A plate, or a hole in a ring, with any edge; and a circle on it."""
    points = np.array(profile.outline(c.values["points"], c.values["arcs"], c.values["smooth"]))
    size, radius = float(np.hypot(*points.T).max()), float(c.values["radius"])
    if c.values["hole"]:
        yield _ring(c, a, points, 1.1 * size, motion)
    else:
        yield Shape("plate", c.name, (a,), (_area(a, points, motion),), size)
    if radius:
        yield Shape("wheel", c.name, (b,), (Circle((b,), Size(metres=radius), PAPER, width=Size(1.5)),), radius)


def stop(c: Component, a: Spot, b: Spot, motion: Motion, unit: float) -> Iterator[Shape]:
    """The limits of a sliding joint as short walls across the x axis of frame_a."""
    for key, side in (("s_min", 1), ("s_max", -1)):
        if c.values[key] is not None:
            at = a.moved(float(c.values[key]))
            yield Shape("wall", c.name, (at,), (DrawnPath((at,), units=((0.0, -1.3), (0.0, 1.3)), hatch=side),))


def turning_stop(c: Component, a: Spot, b: Spot, motion: Motion, unit: float) -> Iterator[Shape]:
    """The limits of an angle as short walls of frame_a about its origin, and the x axis of frame_b between them."""
    for key, side in (("phi_min", -1), ("phi_max", 1)):
        if c.values[key] is not None:
            ray = rounded(_polar(np.array([1.0, 1.9]), np.full(2, float(c.values[key]))), 4)
            yield Shape("wall", c.name, (a,), (DrawnPath((a,), units=ray, hatch=side),))
    pointer = DrawnPath((b,), units=((0.0, 0.0), (1.6, 0.0)), stroke=colour_of(motion, b), width=Size(2.0))
    yield Shape("stop", c.name, (b,), (pointer,))


def wound(c: Component, motion: Motion) -> Iterator[Shape]:
    """The rope or rack of a coupling, where it has this geometry: the ratio of a position and an angle is the distance
    of the line on which a frame moves from the centre about which another one turns."""
    turning, moving = (_read(c.values[name], motion, keys) for name, keys in (("a", ("phi",)), ("b", ("x", "y"))))
    if len(turning) != 1 or len(moving) != 1:
        return
    (drum,), (end,) = turning, moving
    radius = abs(float(c.values["ratio"]))
    centre, path = motion.positions(drum), motion.positions(end)
    away = path - path[0]
    k = int(np.nan_to_num(np.hypot(*away.T)).argmax())
    length, rounding = float(np.hypot(*away[k])), 1e-6 * radius
    if not length > rounding or not np.abs(centre - centre[0]).max() < rounding:
        return
    along = away[k] / length
    across = np.array([-along[1], along[0]])
    off = (path - centre[0]) @ across
    if not np.abs(np.abs(off) - radius).max() < rounding:
        return
    yield Shape("hub", c.name, (drum,), (Circle((drum,), Size(metres=radius), (FORCE, PAPER, 0.7), FORCE),), radius)
    x, y = centre[0] + off[0] * across
    line = DrawnPath((Spot(GROUND, float(x), float(y)), end), ON, stroke=FORCE, width=Size(1.5, 0.14))
    yield Shape("rope", c.name, line.at, (line,))


def _read(law: Expr, motion: Motion, keys: Sequence[str]) -> set[Spot]:
    """The frames that move of which a law reads a coordinate, if it reads only these ``keys`` of them."""
    read = [leaf.value for leaf in leaves(law) if leaf.op == "coordinate"]
    found = {motion.spot_of(frame): key for frame, key in read if motion.spot_of(frame).track != GROUND}
    return set(found) if set(found.values()) <= set(keys) else set()


def rope(c: Component, a: Spot, b: Spot, motion: Motion, unit: float) -> Iterator[Shape]:
    """A span, and its discs."""
    for spot, radius in zip((a, b), c.values.get("ends", ()), strict=False):
        if radius:
            yield wheel(c, spot, abs(radius), motion)
    at = motion.lines.get(c.name, (a, b))
    line = DrawnPath(at, ON, curved=len(at) == 3, stroke=FORCE, width=Size(1.5, 0.14))
    yield Shape("rope", c.name, at, (line,))


SYMBOLS = {
    "gears": gears,
    "rack": rack,
    "belt": belt,
    "cam": cam,
    "circles": circles,
    "profile": closed_profile,
    "stop": stop,
    "turning stop": turning_stop,
    "rope": rope,
}
