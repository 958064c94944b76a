"""Symbols of joints and forces: what is drawn between the two frames of an element, by its kind.

A kind names one of ``SYMBOLS`` as its ``drawing``; without it a joint is drawn as a mark and a force as a dashed line.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from mbdsl.elements.kind import ForceKind
from mbdsl.expressions.symbolic import expr, leaves
from mbdsl.mechanism.scene import Component
from mbdsl.viewing import gear_shapes
from mbdsl.viewing.display import (
    ALONG,
    DRIVE,
    FORCE,
    INK,
    ON,
    PALE,
    PAPER,
    ROD,
    SHADE,
    TURNED,
    Beam,
    Circle,
    DrawnPath,
    Item,
    Points,
    Shape,
    Size,
    colour_of,
    head,
    square,
)
from mbdsl.viewing.given_shapes import extent
from mbdsl.viewing.tracks import GROUND, Frame, Motion, Spot, Tracks

#: (component, its frames, motion, provisional size of symbols [m]) -> its shapes
Symbol = Callable[[Component, Spot, Spot, Motion, float], Iterator[Shape]]

COIL, FEWEST, MOST = 1.1, 3, 24  #: length of a coil in units, numbers of coils
A, B = Spot(-2), Spot(-3)  #: frame_a and frame_b in templates
DIAMOND = ((0.7, 0.0), (0.0, 0.7), (-0.7, 0.0), (0.0, -0.7))


def symbol(component: Component) -> Symbol:
    """The symbol of a component that has two frames.

    Parameters
    ----------
    component : Component
        A joint or a force.

    Returns
    -------
    callable
        (component, spot of frame_a, spot of frame_b, motion, size of symbols) -> its shapes.
    """
    kind = component.kind
    return SYMBOLS.get(kind.drawing, _dashed if isinstance(kind, ForceKind) else _mark)


def _pin(c: Component, a: Spot, b: Spot, motion: Motion, unit: float) -> Iterator[Shape]:
    if GROUND in (a.track, b.track):
        base, moving = (a, b) if a.track == GROUND else (b, a)
        yield _support(c, base, moving, motion)
    yield pin(c, a)


def pin(c: Component, at: Spot) -> Shape:
    """A pin at a frame."""
    return Shape("pin", c.name, (at,), (Circle((at,), Size(1.5, 0.27), PAPER),))


def _support(c: Component, base: Spot, moving: Spot, motion: Motion) -> Shape:
    """The support of a pin, above it if the body hangs."""
    side = _side(base, moving, motion)
    at = (Spot(GROUND, base.x, base.y),)
    y = 1.25 * side
    triangle = DrawnPath(at, units=((0.0, 0.0), (-0.8, y), (0.8, y)), closed=True, fill=SHADE)
    line = DrawnPath(at, units=((-1.25, y), (1.25, y)), hatch=side)
    return Shape("support", c.name, (base,), (triangle, line))


def _side(base: Spot, moving: Spot, motion: Motion) -> int:
    """-1: the support is below the pin; 1: above it, because the body hangs."""
    if moving.track == GROUND:
        return -1
    places = motion.poses[:, moving.track, :2]
    places = places[np.isfinite(places).all(axis=1)]
    if not len(places):
        return -1
    x, y = (places.mean(axis=0) - (base.x, base.y)).tolist()
    return 1 if y < -0.6 * float(np.hypot(x, y)) - 1e-9 else -1


def wall(c: Component, at: Spot, other: Spot) -> Shape:
    """A wall at a frame, across the line to another."""
    line = DrawnPath((at, other), ALONG, units=((0.0, -1.3), (0.0, 1.3)), hatch=1)
    return Shape("wall", c.name, (at, other), (line,))


def _slider(c: Component, a: Spot, b: Spot, motion: Motion, unit: float) -> Iterator[Shape]:
    low, high, side = _travel(a, b, motion)
    ends, units = ((low, 0.0), (high, 0.0)), ((-2.0, 0.8 * side), (2.0, 0.8 * side))
    if (own := extent(motion.owner(b), b, motion)) is not None and c.kind.name == "Prismatic":
        y = float(own[(side + 1) // 2][1])  # the rail touches the shape
        ends, units = ((low + float(own[0][0]), y), (high + float(own[1][0]), y)), ((-1.0, 0.0), (1.0, 0.0))
    if a.track == GROUND:
        rail = DrawnPath((a,), metres=ends, units=units, hatch=side)
    else:
        rail = DrawnPath((a,), metres=ends, units=units, stroke=PALE, width=Size(units=0.3))
    yield Shape("guide", c.name, (a,), (rail,))
    own = colour_of(motion, b)
    block = DrawnPath(
        (b, a), TURNED, units=square(1.15, 0.78), closed=True, fill=(own, PAPER, 0.6), stroke=(own, INK, 0.4)
    )
    yield Shape("block", c.name, (b, a), (block,))


def _pin_in_slot(c: Component, a: Spot, b: Spot, motion: Motion, unit: float) -> Iterator[Shape]:
    if a.track == GROUND:
        yield from _slider(c, a, b, motion, unit)
    else:
        low, high, _ = _travel(a, b, motion)
        slot = DrawnPath((a,), metres=((low, 0.0), (high, 0.0)), stroke=PAPER, edge=PALE, width=Size(units=0.95))
        yield Shape("slot", c.name, (a,), (slot,))
    yield pin(c, b)


def _travel(a: Spot, b: Spot, motion: Motion) -> tuple[float, float, int]:
    """The part [m] of the x axis of ``a`` that ``b`` travels on; -1: gravity is towards its right side, else 1."""
    low, high = motion.travel(a, b)
    ground = next((x for x in motion.scene.components.values() if "g" in x.values and not x.kind.coordinates), None)
    nx, ny = ground.values["n"] if ground is not None else (0.0, -1.0)
    phi = motion.pose(a)[0, 2]
    return low, high, -1 if -np.sin(phi) * nx + np.cos(phi) * ny <= 1e-9 else 1


def _floor(c: Component, a: Spot, ends: Points) -> Shape:
    """What wheels roll on and contacts touch, between two points in the axes of frame_a."""
    look: dict[str, Any] = {"hatch": -1} if a.track == GROUND else {"width": Size(thin=2.0)}
    return Shape("floor", c.name, (a,), (DrawnPath((a,), metres=ends, **look),))


def _wheel(c: Component, a: Spot, b: Spot, motion: Motion, unit: float) -> Iterator[Shape]:
    radius = float(c.values["radius"])
    low, high, _ = _travel(a, b, motion)
    ends = ((low - radius, 0.0), (high + radius, 0.0))
    yield _floor(c, a, ends)
    yield gear_shapes.wheel(c, b, radius, motion)


def _surface(c: Component, a: Spot, b: Spot, motion: Motion, unit: float) -> Iterator[Shape]:
    """The line of a contact, and what touches it: a circle, an edge, a capsule or a rectangle."""
    v = c.values
    radius, length, width = (float(v.get(name) or 0.0) for name in ("radius", "length", "width"))
    low, high, _ = _travel(a, b, motion)
    reach = radius + float(np.hypot(length, width)) / 2 + unit
    ends = ((low - reach, 0.0), (high + reach, 0.0))
    yield _floor(c, a, ends)
    x, y = length / 2 + radius, width / 2 + radius
    corners = ((-x, -y), (x, -y), (x, y), (-x, y))
    own = colour_of(motion, b)
    if length and y:
        outline = DrawnPath((b,), metres=corners, closed=True, fill=(own, PAPER, 0.6), stroke=(own, INK, 0.4))
        yield Shape("block", c.name, (b,), (outline,))
    elif length:
        yield Shape("block", c.name, (b,), (DrawnPath((b,), metres=((-x, 0.0), (x, 0.0)), stroke=own),))
    elif radius:
        yield gear_shapes.wheel(c, b, radius, motion)


def placed(items: Sequence[Item], a: Frame, b: Frame, motion: Tracks) -> tuple[Item, ...]:
    """Items of a template between frames; strokes are from the smallest to the largest distance of the frames."""
    at: dict[Frame, Frame] = {A: a, B: b}
    length = motion.apart(a, b)
    stroke: dict[str, Any] = {"low": float(length.min()), "high": float(length.max())}

    def one(item: Item) -> Item:
        assert not isinstance(item, Beam)
        if isinstance(item, Circle):
            return replace(item, at=(at[item.at[0]],))
        return replace(item, at=tuple(at[frame] for frame in item.at), **(stroke if item.state else {}))

    return tuple(one(item) for item in items)


def _template(draw: str, *items: Item, pins: bool = False, walls: bool = False) -> Symbol:
    """Items between the frames A and B, with supports and pins or with walls at the ends on the ground."""

    def shapes(c: Component, a: Spot, b: Spot, motion: Motion, unit: float) -> Iterator[Shape]:
        for spot, other in ((a, b), (b, a)):
            if (pins or walls) and spot.track == GROUND and other.track != GROUND:
                yield _support(c, spot, other, motion) if pins else wall(c, spot, other)
        yield Shape(draw, c.name, (a, b), placed(items, a, b, motion))
        if pins:
            yield pin(c, a)
            yield pin(c, b)

    return shapes


def coils(a: Frame, b: Frame, motion: Tracks, unit: float) -> int:
    """The number of coils of a spring, by its mean length."""
    return min(MOST, max(FEWEST, round(float(motion.apart(a, b).mean()) / unit / COIL)))


def zigzag(count: int, y: float = 0.0, height: float = 0.55, start: float = 0.0) -> tuple[Item, ...]:
    """A spring at ``y`` with leads at its ends."""
    inner, part = start + 0.8, (np.arange(2 * count) + 0.5) / (2 * count)
    x = [start, inner, *(inner * (1.0 - 2.0 * part)).tolist(), -inner, -start]
    heights = [y, y, *(y + height * (-1.0) ** (np.arange(2 * count) + 1)).tolist(), y, y]
    look: dict[str, Any] = {"stroke": FORCE, "width": Size(thin=1.3)}
    share = (0.0, 0.0, *part.tolist(), 1.0, 1.0)
    return (DrawnPath((A, B), ALONG, units=tuple(zip(x, heights, strict=True)), share=share, **look),)


def dashpot(y: float = 0.0, height: float = 0.45, start: float = 0.0) -> tuple[Item, ...]:
    """A cylinder at A and a piston at B, at the part of its stroke."""
    left, right, piston = -0.75, 2.25, -0.15
    corners = ((right, y - height), (left, y - height), (left, y + height), (right, y + height))
    head = ((piston, y - 0.75 * height), (piston, y + 0.75 * height))
    return (
        _line(((start, y), (left, y)), (0.0, 0.25)),
        _line(corners, (0.25,) * 4),
        _line(head, (0.25, 0.25), (1.8, 1.8), 2.1),
        _line(((piston, y), (-start, y)), (0.25, 1.0), (1.8, 0.0)),
    )


def beside(count: int) -> tuple[Item, ...]:
    """A spring and a damper beside each other."""
    ends = tuple(
        _line(points, (share, share))
        for x, share in ((0.7, 0.0), (-0.7, 1.0))
        for points in (((0.0, 0.0), (x, 0.0)), ((x, -0.7), (x, 0.7)))
    )
    return (*ends, *zigzag(count, 0.7, 0.42, 0.7), *dashpot(-0.7, 0.36, 0.7))


def _line(points: Points, share: tuple[float, ...], state: tuple[float, ...] = (), thick: float = 1.3) -> DrawnPath:
    return DrawnPath((A, B), ALONG, units=points, share=share, state=state, stroke=FORCE, width=Size(thin=thick))


def nature(c: Component) -> str:
    """What a force between two frames is: "spring", "damper", "spring-damper" or "actuator".

    A law that reads no coordinate of these frames is that of an actuator, any other one that of a spring.
    """
    k, damping = (c.values.get(name) for name in ("k", "c"))
    law = next((c.values[name] for name in ("force", "torque") if c.values.get(name) is not None), None)
    if law is not None:
        own = {*c.ports.values()}
        reads = any(leaf.op == "coordinate" and leaf.value[0] in own for leaf in leaves(expr(law)))
        return "spring" if reads else "actuator"
    return "spring" if not damping else "damper" if not k else "spring-damper"


def _spring_damper(c: Component, a: Spot, b: Spot, motion: Motion, unit: float) -> Iterator[Shape]:
    draw, count = nature(c), coils(a, b, motion, unit)
    if draw == "actuator":
        yield from SYMBOLS[draw](c, a, b, motion, unit)
        return
    items = {"spring": zigzag(count), "damper": dashpot(), "spring-damper": beside(count)}[draw]
    yield from _template(draw, *items, walls=True)(c, a, b, motion, unit)


def _weld(c: Component, a: Spot, b: Spot, motion: Motion, unit: float) -> Iterator[Shape]:
    base, other = (a, b) if a.track == GROUND else (b, a)
    if base.track == GROUND and other.track != GROUND:
        yield wall(c, base, Spot(other.track))
    mark = DrawnPath((b,), units=square(0.32), closed=True, fill=INK, stroke=None)
    yield Shape("weld", c.name, (b,), (mark,))


def _turning_spring(c: Component, a: Spot, b: Spot, motion: Motion, unit: float) -> Iterator[Shape]:
    """A spiral, the drum and vane of a damper, or the arrow of a torque that does not depend on the angle."""
    draw = {"actuator": "turning", "damper": "vane"}.get(nature(c), "spiral")
    yield from SYMBOLS[draw](c, a, b, motion, unit)


def _spiral() -> DrawnPath:
    """From the angle of frame_a to that of frame_b, by two turns and the angle between them."""
    part = np.arange(61) / 60
    radius, turn = 1.55 - 1.15 * part, 4 * np.pi * part
    points = gear_shapes.rounded(np.stack([radius * np.cos(turn), radius * np.sin(turn)], axis=1), 4)
    return DrawnPath((B, A), TURNED, units=points, state=tuple(part.tolist()), stroke=FORCE, width=Size(thin=1.2))


def _arc(radius: float, first: float, last: float) -> Points:
    angle = np.linspace(first, last, 40)
    return gear_shapes.rounded(np.stack([radius * np.cos(angle), radius * np.sin(angle)], axis=1), 4)


def _nothing(c: Component, a: Spot, b: Spot, motion: Motion, unit: float) -> Iterator[Shape]:
    yield from ()


_DRIVE: dict[str, Any] = {"stroke": DRIVE, "width": Size(thin=1.8)}
_HEAD: dict[str, Any] = {"closed": True, "fill": DRIVE, "stroke": None}
_END = (1.75 * float(np.cos(2.6)), 1.75 * float(np.sin(2.6)), (-float(np.sin(2.6)), float(np.cos(2.6))))
PISTON = (
    DrawnPath((A, B), ALONG, units=((0.0, 0.0), (2.0, 0.0)), share=(0.0, 0.2), stroke=ROD, width=Size(units=0.8)),
    DrawnPath((A, B), ALONG, units=((2.0, 0.0), (0.0, 0.0)), share=(0.2, 1.0), stroke=DRIVE, width=Size(units=0.35)),
)
_dashed = _template("dashed", DrawnPath((A, B), ON, stroke=FORCE, dashed=True), walls=True)
_mark = _template("mark", DrawnPath((B,), units=DIAMOND, closed=True, fill=PAPER))

SYMBOLS: dict[str, Symbol] = {
    "pin": _pin,
    "slider": _slider,
    "pin in slot": _pin_in_slot,
    "weld": _weld,
    "wheel": _wheel,
    "surface": _surface,
    "blade": _template("blade", DrawnPath((B,), units=((-1.1, 0.0), (1.1, 0.0)), width=Size(2.5, 0.3))),
    "rod": _template("rod", DrawnPath((A, B), ON, stroke=ROD, width=Size(2.0, 0.22)), pins=True),
    "actuator": _template("actuator", *PISTON, pins=True),
    "spring": _spring_damper,
    "turning spring": _turning_spring,
    "spiral": _template("spiral", _spiral()),
    "vane": _template(
        "vane",
        Circle((A,), Size(units=1.3), stroke=FORCE, width=Size(thin=1.2)),
        DrawnPath((B,), units=((-0.95, 0.0), (0.95, 0.0)), stroke=FORCE, width=Size(thin=2.1)),
    ),
    "bushing": _template(
        "bushing",
        Circle((A,), Size(units=0.85), (FORCE, PAPER, 0.7), FORCE),
        Circle((B,), Size(units=0.3), PAPER),
        DrawnPath((A, B), ON, stroke=FORCE),
    ),
    "turning": _template(
        "turning", DrawnPath((B,), units=_arc(1.75, -0.35, 2.6), **_DRIVE), DrawnPath((B,), units=head(*_END), **_HEAD)
    ),
    "pushing": _template(
        "pushing",
        DrawnPath((B, A), TURNED, units=((-1.1, 1.4), (0.9, 1.4)), **_DRIVE),
        DrawnPath((B, A), TURNED, units=head(1.2, 1.4, (1.0, 0.0)), **_HEAD),
    ),
    "dashed": _dashed,
    "mark": _mark,
    "nothing": _nothing,
    **gear_shapes.SYMBOLS,
}
