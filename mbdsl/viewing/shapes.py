"""From a scene to the shapes of its picture: bodies by their frames, joints and forces by their symbols."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from mbdsl.elements.kind import BodyKind
from mbdsl.mechanism.scene import Component
from mbdsl.viewing import gear_shapes
from mbdsl.viewing.display import PAPER, Beam, Circle, DrawnPath, Shape, Size, colour_of
from mbdsl.viewing.given_shapes import given_shapes
from mbdsl.viewing.symbols import symbol
from mbdsl.viewing.tracks import GROUND, Motion, Spot

#: size of symbols relative to the extent of the motion, its limit relative to the median length of links, and the least
#: relative to the extent for mechanisms of up to ``FEW`` bodies
OF_EXTENT, OF_LENGTH, LEAST, FEW = 0.034, 0.3, 0.012, 50
GIVEN = ("backdrop", "outline")  #: shapes of the model
BODIES = ("wheel", "block", "plate", "ring")  #: shapes of elements that show a body
GOES_FAR = 0.1  #: length of a body relative to the extent of its motion
MANY = 600  #: number of components from which links are lines of one colour
#: shapes in the order in which they are drawn; all others come last
ORDER = (
    *("backdrop", "ring", "floor", "guide", "wall", "support", "spring", "damper", "spring-damper", "dashed", "plate"),
    *(
        "wheel",
        "belt",
        "rope",
        "link",
        "outline",
        "beam",
        "actuator",
        "rod",
        "block",
        "hub",
        "slot",
        "mass",
        "weld",
        "spiral",
        "vane",
    ),
)


@dataclass(frozen=True)
class Drawing:
    """All shapes in the order in which they are drawn, and their sizes.

    ``bounds`` is the rectangle (x0, y0, x1, y1) [m] of the motion, ``unit`` the size of symbols [m]. ``paths`` are
    frames whose path is drawn at first: those of single bodies that go far.
    """

    shapes: list[Shape]
    bounds: tuple[float, float, float, float]
    unit: float
    paths: tuple[str, ...] = ()


def drawing(motion: Motion) -> Drawing:
    """The shapes of a mechanism in the plane.

    Returns
    -------
    Drawing
        Shapes and sizes.
    """
    scene = motion.scene
    ports = {frame for c in scene.components.values() for frame in c.ports.values()}
    many = len(scene.components) > MANY
    bodies = [shape for c in scene.bodies() for shape in _body(c, motion, ports, many)]
    own = [shape for c in scene.components.values() if c.name in scene.shapes for shape in given_shapes(c, motion)]
    lengths = [length for shape in bodies if (length := _length(shape, motion)) is not None]
    unit = _unit(_bounds(motion, ports, own), lengths)  # provisional: for numbers of coils
    elements = [shape for c in scene.components.values() for shape in _element(c, motion, unit)]
    rolling = {shape.at[0].track for shape in elements if shape.draw in BODIES}
    replaced = {k for k, track in enumerate(motion.tracks) if track in scene.shapes}  # their shapes are given
    elements = [x for x in elements if x.draw not in BODIES or x.at[0].track not in replaced]
    bodies = [x for x in bodies if x.draw != "hub" or x.at[0].track not in rolling]
    bodies = [x for x in bodies if x.draw == "beam" or x.name not in scene.shapes]
    every = _once(bodies + own + elements)
    shapes = sorted(every, key=lambda shape: ORDER.index(shape.draw) if shape.draw in ORDER else len(ORDER))
    bounds = _bounds(motion, ports, elements + own)
    extent = float(np.hypot(bounds[2] - bounds[0], bounds[3] - bounds[1]))
    far = len(bodies) <= FEW and lengths and max(lengths) < GOES_FAR * extent
    paths = tuple(f"{c.name}.c" for c in scene.bodies()) if far and len(scene.bodies()) <= 2 else ()
    return Drawing(shapes, bounds, _unit(bounds, lengths), paths)


def _length(shape: Shape, motion: Motion) -> float | None:
    """The length [m] of a link or a beam."""
    if shape.draw == "link":
        (link,) = shape.items
        assert isinstance(link, DrawnPath)
        return float(np.hypot.reduce(np.subtract(link.metres, link.metres[0]), axis=1).max())
    return float(motion.scene.components[shape.name].values["length"]) if shape.draw == "beam" else None


def _unit(bounds: Sequence[float], lengths: Sequence[float]) -> float:
    """The size of symbols [m]."""
    extent = float(np.hypot(bounds[2] - bounds[0], bounds[3] - bounds[1]))
    unit = OF_EXTENT * extent
    if lengths and np.median(lengths) > 0.0:
        unit = min(unit, OF_LENGTH * float(np.median(lengths)))
        if len(lengths) <= FEW:
            unit = max(unit, LEAST * extent)
    return unit or 1.0


def _once(shapes: Sequence[Shape]) -> list[Shape]:
    """Shapes without further supports of the same pin, and without further gears of the same size at a place."""
    seen: set[tuple] = set()
    found = []
    for shape in shapes:
        place = _place(shape)
        if shape.draw not in ("support", "plate", "ring") or place not in seen:
            found.append(shape)
        seen.add(place)
    return found


def behind(back: Drawing, front: Drawing) -> Drawing:
    """``back`` without supports of pins that ``front`` has too, perhaps on the other side of the pin."""
    seen = {_place(shape) for shape in front.shapes if shape.draw == "support"}
    return replace(back, shapes=[x for x in back.shapes if x.draw != "support" or _place(x) not in seen])


def _place(shape: Shape) -> tuple:
    spots = ((at.track, round(at.x, 12), round(at.y, 12)) for at in shape.at if isinstance(at, Spot))
    return (shape.draw, shape.radius, *spots)


def _element(c: Component, motion: Motion, unit: float) -> Iterator[Shape]:
    if c.kind.name == "Coupling":
        yield from gear_shapes.wound(c, motion)
    if isinstance(c.kind, BodyKind) or len(c.ports) != 2:
        return
    a, b = (motion.spot_of(frame) for frame in c.ports.values())
    yield from symbol(c)(c, a, b, motion, unit)


def _body(c: Component, motion: Motion, ports: set[str], many: bool) -> Iterator[Shape]:
    """The shapes of a body."""
    own = colour_of(motion, c.name)
    pale = (own, PAPER, 0.72)
    for k, curve in enumerate(motion.curves):
        if curve.body == c.name:
            yield Shape("beam", c.name, (), (Beam(k, pale, own),))
            return
    centre = motion.spots[f"{c.name}.c"]
    if "phi" not in c.kind.coordinates:
        yield Shape("mass", c.name, (centre,), (Circle((centre,), Size(units=0.72), (own, PAPER, 0.25)),))
        return
    named = [name for name in motion.frames[c.name] if name != f"{c.name}.c" or name in ports]
    points = _distinct([(motion.spots[name].x, motion.spots[name].y) for name in named])
    if len(points) < 2:
        points = _distinct([*points, (0.0, 0.0)])
    if len(points) > 1:
        at, corners = (Spot(centre.track),), tuple(outline(points))
        look: dict[str, Any] = {
            "closed": len(corners) > 2,
            "fill": pale,
            "stroke": pale,
            "edge": own,
            "width": Size(units=0.85),
        }
        if many:
            look = {"stroke": "s0", "width": Size(1.6, 0.5)}
        yield Shape("link", c.name, at, (DrawnPath(at, metres=corners, **look),))
    else:
        line = DrawnPath((centre,), units=((0.0, 0.0), (0.95, 0.0)), stroke=own)
        yield Shape("hub", c.name, (centre,), (Circle((centre,), Size(units=0.95), pale, own), line))


def _distinct(points: Sequence[tuple[float, float]]) -> list[tuple[float, float]]:
    """Points without those that coincide with another up to rounding."""
    size = max((max(abs(x), abs(y)) for x, y in points), default=0.0)
    found: list[tuple[float, float]] = []
    for x, y in points:
        if all(np.hypot(x - u, y - w) > 1e-9 * size for u, w in found):
            found.append((x, y))
    return found


def outline(points: Sequence[tuple[float, float]]) -> list[tuple[float, float]]:
    """The convex hull of points, counter-clockwise; the two ends, if they lie on a line (monotone chain)."""
    order = sorted(points)
    size = max(order[-1][0] - order[0][0], max(y for _, y in order) - min(y for _, y in order))

    def half(sequence: list[tuple[float, float]]) -> list[tuple[float, float]]:
        chain: list[tuple[float, float]] = []
        for x, y in sequence:
            while len(chain) > 1:
                (ux, uy), (vx, vy) = chain[-2:]
                if (vx - ux) * (y - uy) - (vy - uy) * (x - ux) > 1e-9 * size**2:
                    break
                chain.pop()
            chain.append((x, y))
        return chain[:-1]

    return half(order) + half(order[::-1])


def _bounds(motion: Motion, ports: set[str], shapes: Sequence[Shape]) -> tuple[float, float, float, float]:
    """The rectangle of all points over time: frames, beams, wheels; frames of the ground only if they are ports."""
    spots = [spot for name, spot in motion.spots.items() if spot.track != GROUND or name in ports]
    given = [item for shape in shapes if shape.draw in GIVEN for item in shape.items if isinstance(item, DrawnPath)]
    places = [(at, path) for path in given for at in path.at if isinstance(at, Spot)]
    spots += [at.moved(x, y) for at, path in places for x, y in outline(path.metres)]
    lows, highs = ([part] for part in motion.extremes(spots))
    for shape in shapes:
        if shape.radius:
            low, high = motion.extremes([at for at in shape.at[:1] if isinstance(at, Spot)])
            lows.append(low - shape.radius)
            highs.append(high + shape.radius)
    for curve in motion.curves:
        finite = np.isfinite(curve.points)
        lows.append(curve.points.min(axis=(0, 1), initial=np.inf, where=finite)[None])
        highs.append(curve.points.max(axis=(0, 1), initial=-np.inf, where=finite)[None])
    low, high = np.concatenate(lows).min(axis=0, initial=np.inf), np.concatenate(highs).max(axis=0, initial=-np.inf)
    if not (np.isfinite(low).all() and np.isfinite(high).all()):
        return 0.0, 0.0, 0.0, 0.0
    return float(low[0]), float(low[1]), float(high[0]), float(high[1])
