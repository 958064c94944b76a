"""Symbols of joints and forces: what is drawn between the two frames of an element, by its kind.

A kind names one of ``SYMBOLS`` as its ``drawing``; without it a joint is drawn as a mark and a force as a dashed line.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator

import numpy as np

from mbdsl.elements.kind import ForceKind
from mbdsl.mechanism.scene import Component
from mbdsl.viewing import gear_shapes
from mbdsl.viewing.motion import GROUND, Motion, Spot
from mbdsl.viewing.rope_shapes import rope
from mbdsl.viewing.shape import Shape

Symbol = Callable[[Component, Spot, Spot, Motion], Iterator[Shape]]


def symbol(component: Component) -> Symbol:
    """The symbol of a component that has two frames.

    Parameters
    ----------
    component : Component
        A joint or a force.

    Returns
    -------
    callable
        (component, spot of frame_a, spot of frame_b, motion) -> its shapes.
    """
    kind = component.kind
    return SYMBOLS.get(kind.drawing, _dashed if isinstance(kind, ForceKind) else _mark)


def _pin(c: Component, a: Spot, b: Spot, motion: Motion) -> Iterator[Shape]:
    if GROUND in (a.track, b.track):
        base, moving = (a, b) if a.track == GROUND else (b, a)
        yield Shape("support", c.name, (base,), {"side": _side(base, moving, motion)})
    yield Shape("pin", c.name, (a,))


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


def _slider(c: Component, a: Spot, b: Spot, motion: Motion) -> Iterator[Shape]:
    yield _rail(c, a, b, motion, "guide")
    yield Shape("block", c.name, (b, a))


def _pin_in_slot(c: Component, a: Spot, b: Spot, motion: Motion) -> Iterator[Shape]:
    if a.track == GROUND:
        yield from _slider(c, a, b, motion)
    else:
        yield _rail(c, a, b, motion, "slot")
    yield Shape("pin", c.name, (b,))


def _rail(c: Component, a: Spot, b: Spot, motion: Motion, draw: str, margin: float = 0.0) -> Shape:
    """The part of the x axis of ``a`` that ``b`` travels on; ``side`` of the rail: -1 below the axis, else above it."""
    pa, pb = motion.pose(a), motion.pose(b)
    s = np.cos(pa[:, 2]) * (pb[:, 0] - pa[:, 0]) + np.sin(pa[:, 2]) * (pb[:, 1] - pa[:, 1])
    low, high = (float(np.nanmin(s)), float(np.nanmax(s))) if np.isfinite(s).any() else (0.0, 0.0)
    ground = next((x for x in motion.scene.components.values() if "g" in x.values and not x.kind.coordinates), None)
    nx, ny = ground.values["n"] if ground is not None else (0.0, -1.0)
    sideways = -np.sin(pa[0, 2]) * nx + np.cos(pa[0, 2]) * ny  # gravity along the normal of the rail
    data = {"from": low - margin, "to": high + margin, "side": -1 if sideways <= 1e-9 else 1}
    return Shape(draw, c.name, (a,), data | {"fixed": a.track == GROUND})


def _wheel(c: Component, a: Spot, b: Spot, motion: Motion) -> Iterator[Shape]:
    radius = float(c.values["radius"])
    line = _rail(c, a, b, motion, "floor", radius)
    yield Shape("floor", c.name, line.at, line.data | {"side": -1})
    yield Shape("wheel", c.name, (b,), {"radius": radius})


def _between(draw: str, pins: bool = False) -> Symbol:
    def shapes(c: Component, a: Spot, b: Spot, motion: Motion) -> Iterator[Shape]:
        for spot, other in ((a, b), (b, a)):
            if spot.track == GROUND and other.track != GROUND:
                if pins:
                    yield Shape("support", c.name, (spot,), {"side": _side(spot, other, motion)})
                else:
                    yield Shape("wall", c.name, (spot, other))
        pa, pb = motion.pose(a), motion.pose(b)
        length = np.hypot(pb[:, 0] - pa[:, 0], pb[:, 1] - pa[:, 1])
        length = length[np.isfinite(length)] if np.isfinite(length).any() else np.zeros(1)
        data = {"low": float(length.min()), "high": float(length.max()), "mean": float(length.mean())}
        yield Shape(draw, c.name, (a, b), data)
        if pins:
            yield Shape("pin", c.name, (a,))
            yield Shape("pin", c.name, (b,))

    return shapes


def _spring_damper(c: Component, a: Spot, b: Spot, motion: Motion) -> Iterator[Shape]:
    """A spring, a damper or both, by the constants that are not zero."""
    k, damping = (c.values.get(name) for name in ("k", "c"))
    draw = "spring" if not damping else "damper" if not k else "spring-damper"
    yield from _between(draw)(c, a, b, motion)


def _at_b(draw: str) -> Symbol:
    def shapes(c: Component, a: Spot, b: Spot, motion: Motion) -> Iterator[Shape]:
        yield Shape(draw, c.name, (b, a))

    return shapes


def _weld(c: Component, a: Spot, b: Spot, motion: Motion) -> Iterator[Shape]:
    base, other = (a, b) if a.track == GROUND else (b, a)
    if base.track == GROUND and other.track != GROUND:
        yield Shape("wall", c.name, (base, Spot(other.track)))
    yield Shape("weld", c.name, (b,))


def _nothing(c: Component, a: Spot, b: Spot, motion: Motion) -> Iterator[Shape]:
    yield from ()


_dashed = _between("dashed")
_mark = _at_b("mark")

SYMBOLS: dict[str, Symbol] = {
    "pin": _pin,
    "slider": _slider,
    "pin in slot": _pin_in_slot,
    "weld": _weld,
    "wheel": _wheel,
    "blade": _at_b("blade"),
    "rod": _between("rod", pins=True),
    "actuator": _between("actuator", pins=True),
    "spring": _spring_damper,
    "spiral": _at_b("spiral"),
    "bushing": _at_b("bushing"),
    "turning": _at_b("turning"),
    "pushing": _at_b("pushing"),
    "dashed": _dashed,
    "mark": _mark,
    "nothing": _nothing,
    "rope": rope,
    **gear_shapes.SYMBOLS,
}
