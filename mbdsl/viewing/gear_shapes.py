"""Shapes of gears, racks, belts, cams and circles in contact, from the radii and laws of their elements.

The gears of a train have teeth of one module, about a dozen of them on the smallest gear, and mesh in the first frame.
The teeth only show the motion; their flanks are not involutes.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mbdsl.elements.kind import JointKind
from mbdsl.expressions.array_operations import ARRAY_OPERATIONS, table_value
from mbdsl.expressions.symbolic import Expr, coordinate, evaluate, expr
from mbdsl.mechanism.scene import Component
from mbdsl.viewing.motion import Motion, Spot
from mbdsl.viewing.shape import Shape

Array = NDArray[np.float64]

ADDENDUM, DEDENDUM, RIM = 0.8, 1.0, 2.6  #: height and depth of teeth, and thickness of a ring, in modules
FEWEST, MOST = 11, 24  #: teeth of the smaller gear of a pair
ROUND = 60  #: corners of a circle
CAM = 120  #: points of a cam


def _shape(draw: str, c: Component, at: tuple[Spot, ...], **data: Any) -> Shape:
    return Shape(draw, c.name, at, data)


def _points(points: Array) -> list[tuple[float, float]]:
    """Corners (n, 2) as the page needs them, with five digits of the largest."""
    digits = 5 - int(np.floor(np.log10(np.abs(points).max() or 1.0)))
    return [(round(x, digits), round(y, digits)) for x, y in points.tolist()]


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


def gears(c: Component, a: Spot, b: Spot, motion: Motion) -> Iterator[Shape]:
    """The two gears of a GearPair."""
    teeth = _teeth(motion)
    for frame, spot, key in zip(c.ports.values(), (a, b), ("r_a", "r_b"), strict=True):
        radius, (module, first) = float(c.values[key]), teeth[frame]
        points = _points(toothed(radius, module, first))
        if c.values["internal"] and key == "r_b":
            yield _shape("ring", c, (spot,), points=points, radius=radius + RIM * module)
        else:
            yield _shape("plate", c, (spot,), points=points, radius=radius + ADDENDUM * module)


def rack(c: Component, a: Spot, b: Spot, motion: Motion) -> Iterator[Shape]:
    """A pinion and the part of its rack that it rolls on."""
    radius = float(c.values["radius"])
    module = 2 * radius / 14
    pitch = np.pi * module
    pa, pb = motion.pose(a), motion.pose(b)
    s = np.cos(pa[:, 2]) * (pb[:, 0] - pa[:, 0]) + np.sin(pa[:, 2]) * (pb[:, 1] - pa[:, 1])
    s = s[np.isfinite(s)] if np.isfinite(s).any() else np.zeros(1)
    down = -np.pi / 2 + pa[0, 2] - pb[0, 2]  # where the pinion touches, in its own axes
    first = s[0] + radius * down  # a tooth of the pinion at the angle 0 is at this place along the rack
    low = np.floor((s.min() - radius - first) / pitch)
    k = np.arange(low, np.ceil((s.max() + radius - first) / pitch))
    x = first + pitch * (k[:, None] + 0.5 + np.array([-0.35, -0.15, 0.15, 0.35]))
    y = np.broadcast_to(np.array([-DEDENDUM, ADDENDUM, ADDENDUM, -DEDENDUM]) * module, x.shape)
    base = np.array([(x[-1, -1], -RIM * module), (x[0, 0], -RIM * module)])
    points = np.concatenate([np.stack([x.ravel(), y.ravel()], axis=1), base])
    yield _shape("plate", c, (a,), points=_points(points), bare=True)
    yield _shape("plate", c, (b,), points=_points(toothed(radius, module, 0.0)), radius=radius + ADDENDUM * module)


def belt(c: Component, a: Spot, b: Spot, motion: Motion) -> Iterator[Shape]:
    """Two pulleys and the strands between them."""
    r_a, r_b = float(c.values["r_a"]), float(c.values["r_b"])
    for spot, radius in ((a, r_a), (b, r_b)):
        yield _shape("wheel", c, (spot,), radius=radius)
    yield _shape("belt", c, (a, b), r_a=r_a, r_b=-r_b if c.values["crossed"] else r_b)


def _law(c: Component, motion: Motion, angle: Array) -> Array:
    """The function of a cam at angles (n,) [rad] of its argument."""
    assert isinstance(c.kind, JointKind) and c.kind.coupling is not None
    law, argument = expr(c.values[c.kind.coupling[0]]), motion.scene.signal_of(c, c.kind.coupling[1])
    assert argument is not None
    turning = coordinate(c.ports["frame_a"], "phi")  # the argument is this angle plus terms that are 0 here

    def at(leaf: Expr) -> object:
        return angle if leaf is turning else 0.0

    with np.errstate(all="ignore"):
        (found,) = evaluate([law], at, ARRAY_OPERATIONS, table_value)  # type: ignore[arg-type]
    return np.broadcast_to(np.asarray(found, float), angle.shape)


def cam(c: Component, a: Spot, b: Spot, motion: Motion) -> Iterator[Shape]:
    """A cam with the path of its follower's point as its edge."""
    angle = np.linspace(0.0, 2 * np.pi, CAM, endpoint=False)
    lift = _law(c, motion, angle)
    if np.isfinite(lift).all():
        yield _shape("plate", c, (a,), points=_points(_polar(lift, -angle)), radius=float(np.abs(lift).max()))
    yield _shape("pin", c, (b,))


def circles(c: Component, a: Spot, b: Spot, motion: Motion) -> Iterator[Shape]:
    """Two discs, or a disc in a hole."""
    r_a, r_b = float(c.values["r_a"]), float(c.values["r_b"])
    if c.values["internal"]:
        yield _shape("ring", c, (a,), points=_points(circle(r_a)), radius=r_a + 0.15 * r_b)
    else:
        yield _shape("plate", c, (a,), points=_points(circle(r_a)), radius=r_a)
    yield _shape("plate", c, (b,), points=_points(circle(r_b)), radius=r_b)


def stop(c: Component, a: Spot, b: Spot, motion: Motion) -> Iterator[Shape]:
    """The limits of a sliding joint as short walls across the x axis of frame_a."""
    limits = [float(c.values[key]) for key in ("s_min", "s_max") if c.values[key] is not None]
    x, y = np.cos(a.phi), np.sin(a.phi)
    for key, side in (("s_min", 1.0), ("s_max", -1.0)):
        if c.values[key] is not None:
            s, inwards = float(c.values[key]), side * (max(map(abs, limits)) or 1.0)
            spots = (Spot(a.track, a.x + d * x, a.y + d * y, a.phi) for d in (s, s + inwards))
            yield _shape("wall", c, tuple(spots))


SYMBOLS = {"gears": gears, "rack": rack, "belt": belt, "cam": cam, "circles": circles, "stop": stop}
