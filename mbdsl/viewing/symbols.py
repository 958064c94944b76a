"""Symbols of joints and forces: what is drawn between the two frames of an element, by its kind.

A kind names one of ``SYMBOLS`` as its ``drawing``; without it a joint is drawn as a mark and a force as a dashed line.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any

import numpy as np

from mbdsl.elements import modules
from mbdsl.elements.kind import ForceKind, Kind
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
    THIN,
    TURNED,
    Circle,
    Item,
    Path,
    Points,
    Shape,
    Size,
    colour_of,
    head,
    square,
)
from mbdsl.viewing.rope_shapes import rope
from mbdsl.viewing.tracks import GROUND, Motion, Spot

#: (component, its frames, motion, provisional size of symbols [m]) -> its shapes
Symbol = Callable[[Component, Spot, Spot, Motion, float], Iterator[Shape]]

COIL, FEWEST, MOST = 1.1, 3, 24  #: length of a coil in units, numbers of coils
DIAMOND = ((0.7, 0.0), (0.0, 0.7), (-0.7, 0.0), (0.0, -0.7))


def drawing_of(kind: Kind) -> str | None:
    """The name of the symbol of a kind."""
    return getattr(modules().get(kind.name), "DRAWING", None) or KNOWN.get(kind.name)


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
    return SYMBOLS.get(drawing_of(kind) or "", _dashed if isinstance(kind, ForceKind) else _mark)


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
    triangle = Path(at, units=((0.0, 0.0), (-0.8, y), (0.8, y)), closed=True, fill=SHADE)
    line = Path(at, units=((-1.25, y), (1.25, y)), hatch=side)
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
    line = Path((at, other), ALONG, units=((0.0, -1.3), (0.0, 1.3)), hatch=1)
    return Shape("wall", c.name, (at, other), (line,))


def _slider(c: Component, a: Spot, b: Spot, motion: Motion, unit: float) -> Iterator[Shape]:
    low, high, side = _travel(a, b, motion)
    ends, units = ((low, 0.0), (high, 0.0)), ((-2.0, 0.8 * side), (2.0, 0.8 * side))
    if a.track == GROUND:
        rail = Path((a,), metres=ends, units=units, hatch=side)
    else:
        rail = Path((a,), metres=ends, units=units, stroke=PALE, width=Size(units=0.3))
    yield Shape("guide", c.name, (a,), (rail,))
    own = colour_of(motion, b)
    block = Path((b, a), TURNED, units=square(1.15, 0.78), closed=True, fill=(own, PAPER, 0.6), stroke=(own, INK, 0.4))
    yield Shape("block", c.name, (b, a), (block,))


def _pin_in_slot(c: Component, a: Spot, b: Spot, motion: Motion, unit: float) -> Iterator[Shape]:
    if a.track == GROUND:
        yield from _slider(c, a, b, motion, unit)
    else:
        low, high, _ = _travel(a, b, motion)
        slot = Path((a,), metres=((low, 0.0), (high, 0.0)), stroke=PAPER, edge=PALE, width=Size(units=0.95))
        yield Shape("slot", c.name, (a,), (slot,))
    yield pin(c, b)


def _travel(a: Spot, b: Spot, motion: Motion) -> tuple[float, float, int]:
    """The part [m] of the x axis of ``a`` that ``b`` travels on; -1: gravity is towards its right side, else 1."""
    low, high = motion.travel(a, b)
    ground = next((x for x in motion.scene.components.values() if "g" in x.values and not x.kind.coordinates), None)
    nx, ny = ground.values["n"] if ground is not None else (0.0, -1.0)
    phi = motion.pose(a)[0, 2]
    return low, high, -1 if -np.sin(phi) * nx + np.cos(phi) * ny <= 1e-9 else 1


def _wheel(c: Component, a: Spot, b: Spot, motion: Motion, unit: float) -> Iterator[Shape]:
    radius = float(c.values["radius"])
    low, high, _ = _travel(a, b, motion)
    ends = ((low - radius, 0.0), (high + radius, 0.0))
    floor = Path((a,), metres=ends, hatch=-1) if a.track == GROUND else Path((a,), metres=ends, width=Size(thin=2.0))
    yield Shape("floor", c.name, (a,), (floor,))
    yield gear_shapes.wheel(c, b, radius, motion)


def _between(draw: str, *items: Callable[[Component, Spot, Spot, Motion, float], Item], pins: bool = False) -> Symbol:
    """Items from frame to frame, with supports and pins or with walls at the ends on the ground."""

    def shapes(c: Component, a: Spot, b: Spot, motion: Motion, unit: float) -> Iterator[Shape]:
        for spot, other in ((a, b), (b, a)):
            if spot.track == GROUND and other.track != GROUND:
                yield _support(c, spot, other, motion) if pins else wall(c, spot, other)
        yield Shape(draw, c.name, (a, b), tuple(item(c, a, b, motion, unit) for item in items))
        if pins:
            yield pin(c, a)
            yield pin(c, b)

    return shapes


def _line(colour: str, width: Size, dashed: bool = False) -> Callable[..., Item]:
    return lambda c, a, b, motion, unit: Path((a, b), ON, stroke=colour, width=width, dashed=dashed)


def _part(points: Points, share: tuple[float, ...], **look) -> Callable[..., Item]:
    return lambda c, a, b, motion, unit: Path((a, b), ALONG, units=points, share=share, **look)


def _coils(y: float, height: float, lead: float, start: float = 0.0) -> Callable[..., Item]:
    """A zigzag at ``y`` between leads; the number of its coils follows from the mean length."""

    def item(c: Component, a: Spot, b: Spot, motion: Motion, unit: float) -> Item:
        count = 2 * min(MOST, max(FEWEST, round(float(motion.apart(a, b).mean()) / unit / COIL)))
        inner = start + lead
        ends = [(start, y), (inner, y)]
        points, share = list(ends), [0.0, 0.0]
        for k in range(count):
            part = (k + 0.5) / count
            points.append((inner * (1.0 - 2.0 * part), y + (height if k % 2 else -height)))
            share.append(part)
        points += [(-x, y) for x, _ in ends[::-1]]
        return Path((a, b), ALONG, units=tuple(points), share=(*share, 1.0, 1.0), stroke=FORCE, width=Size(thin=1.3))

    return item


def _dashpot(y: float, height: float, start: float = 0.0) -> tuple[Callable[..., Item], ...]:
    """A cylinder from the left and a piston from the right, at the part of its stroke."""

    def rod(points: Points, share: tuple[float, ...], thick: float = 1.3, state: float = 0.0) -> Callable[..., Item]:
        def item(c: Component, a: Spot, b: Spot, motion: Motion, unit: float) -> Item:
            length = motion.apart(a, b)
            states = tuple(state if part == 0.25 else 0.0 for part in share) if state else ()
            look: dict[str, Any] = {"stroke": FORCE, "width": Size(thin=thick)}
            low, high = float(length.min()), float(length.max())
            return Path((a, b), ALONG, units=points, share=share, state=states, low=low, high=high, **look)

        return item

    left, right, piston = -0.75, 2.25, -0.15
    corners = ((right, y - height), (left, y - height), (left, y + height), (right, y + height))
    return (
        rod(((start, y), (left, y)), (0.0, 0.25)),
        rod(corners, (0.25,) * 4),
        rod(((piston, y - 0.75 * height), (piston, y + 0.75 * height)), (0.25, 0.25), 2.1, 1.8),
        rod(((piston, y), (-start, y)), (0.25, 1.0), 1.3, 1.8),
    )


def _spring_damper(c: Component, a: Spot, b: Spot, motion: Motion, unit: float) -> Iterator[Shape]:
    """A spring, a damper or both, by the constants that are not zero."""
    k, damping = (c.values.get(name) for name in ("k", "c"))
    yield from (SPRING if not damping else DAMPER if not k else BOTH)(c, a, b, motion, unit)


_ENDS = tuple(
    _part(points, share, stroke=FORCE, width=Size(thin=1.3))
    for points, share in (
        (((0.0, 0.0), (0.7, 0.0)), (0.0, 0.0)),
        (((0.7, -0.7), (0.7, 0.7)), (0.0, 0.0)),
        (((0.0, 0.0), (-0.7, 0.0)), (1.0, 1.0)),
        (((-0.7, -0.7), (-0.7, 0.7)), (1.0, 1.0)),
    )
)
ZIGZAG, DASHPOT = (_coils(0.0, 0.55, 0.8),), _dashpot(0.0, 0.45)
PISTON = (
    _part(((0.0, 0.0), (2.0, 0.0)), (0.0, 0.2), stroke=ROD, width=Size(units=0.8)),
    _part(((2.0, 0.0), (0.0, 0.0)), (0.2, 1.0), stroke=DRIVE, width=Size(units=0.35)),
)
SPRING, DAMPER = _between("spring", *ZIGZAG), _between("damper", *DASHPOT)
BESIDE = (*_ENDS, _coils(0.7, 0.42, 0.8, 0.7), *_dashpot(-0.7, 0.36, 0.7))
BOTH = _between("spring-damper", *BESIDE)


def _at_b(draw: str, *items: Callable[[Component, Spot, Spot, Motion], Item]) -> Symbol:
    """Items at frame_b."""

    def shapes(c: Component, a: Spot, b: Spot, motion: Motion, unit: float) -> Iterator[Shape]:
        yield Shape(draw, c.name, (b, a), tuple(item(c, a, b, motion) for item in items))

    return shapes


def _on_b(points: Points, axes: str | None = None, **look) -> Callable[..., Item]:
    """A path in the axes of frame_b, or with the angle of frame_a."""
    look = {"closed": True, **look}
    if axes is None:
        return lambda c, a, b, motion: Path((b,), units=points, **look)
    return lambda c, a, b, motion: Path((b, a), axes, units=points, **look)


def _weld(c: Component, a: Spot, b: Spot, motion: Motion, unit: float) -> Iterator[Shape]:
    base, other = (a, b) if a.track == GROUND else (b, a)
    if base.track == GROUND and other.track != GROUND:
        yield wall(c, base, Spot(other.track))
    mark = Path((b,), units=square(0.32), closed=True, fill=INK, stroke=None)
    yield Shape("weld", c.name, (b,), (mark,))


def _spiral(c: Component, a: Spot, b: Spot, motion: Motion, unit: float) -> Iterator[Shape]:
    """From the angle of frame_a to that of frame_b, by two turns and the angle between them."""
    part = np.arange(61) / 60
    radius = 1.55 - 1.15 * part
    points = np.stack([radius * np.cos(4 * np.pi * part), radius * np.sin(4 * np.pi * part)], axis=1)
    look: dict[str, Any] = {"stroke": FORCE, "width": Size(thin=1.2)}
    coil = Path((b, a), TURNED, units=gear_shapes.rounded(points, 4), state=tuple(part.round(4).tolist()), **look)
    yield Shape("spiral", c.name, (b, a), (coil,))


def _arc(radius: float, first: float, last: float) -> Points:
    angle = np.linspace(first, last, 40)
    return gear_shapes.rounded(np.stack([radius * np.cos(angle), radius * np.sin(angle)], axis=1), 4)


def _nothing(c: Component, a: Spot, b: Spot, motion: Motion, unit: float) -> Iterator[Shape]:
    yield from ()


_THICK: dict[str, Any] = {"closed": False, "stroke": DRIVE, "width": Size(thin=1.8)}
_END = (1.75 * float(np.cos(2.6)), 1.75 * float(np.sin(2.6)), (-float(np.sin(2.6)), float(np.cos(2.6))))
_HEAD: dict[str, Any] = {"fill": DRIVE, "stroke": None}
_dashed = _between("dashed", _line(FORCE, THIN, dashed=True))
_mark = _at_b("mark", _on_b(DIAMOND, fill=PAPER))

SYMBOLS: dict[str, Symbol] = {
    "pin": _pin,
    "slider": _slider,
    "pin in slot": _pin_in_slot,
    "weld": _weld,
    "wheel": _wheel,
    "blade": _at_b("blade", _on_b(((-1.1, 0.0), (1.1, 0.0)), closed=False, width=Size(2.5, 0.3))),
    "rod": _between("rod", _line(ROD, Size(2.0, 0.22)), pins=True),
    "actuator": _between("actuator", *PISTON, pins=True),
    "spring": _spring_damper,
    "spiral": _spiral,
    "bushing": _at_b(
        "bushing",
        lambda c, a, b, motion: Circle((a,), Size(units=0.85), (FORCE, PAPER, 0.7), FORCE),
        lambda c, a, b, motion: Circle((b,), Size(units=0.3), PAPER),
        lambda c, a, b, motion: Path((a, b), ON, stroke=FORCE),
    ),
    "turning": _at_b("turning", _on_b(_arc(1.75, -0.35, 2.6), **_THICK), _on_b(head(*_END), **_HEAD)),
    "pushing": _at_b(
        "pushing",
        _on_b(((-1.1, 1.4), (0.9, 1.4)), TURNED, **_THICK),
        _on_b(head(1.2, 1.4, (1.0, 0.0)), TURNED, **_HEAD),
    ),
    "dashed": _dashed,
    "mark": _mark,
    "nothing": _nothing,
    "rope": rope,
    **gear_shapes.SYMBOLS,
}
