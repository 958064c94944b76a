"""From a model in space to the solids of its picture: bodies by their dimensions, moments of inertia and frames."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from math import hypot, sqrt

import numpy as np

from mbdsl.elements.kind import BodyKind
from mbdsl.elements.vectors import turned_to
from mbdsl.kernels.arrays import Array
from mbdsl.mechanism.scene import Component, Scene
from mbdsl.numerics.rotation_arrays import of_matrix, quaternions
from mbdsl.system.tables import gravity
from mbdsl.viewing.motion import is_apart
from mbdsl.viewing.space.solid import BODY, Solid
from mbdsl.viewing.space.symbols import TO_X, bodies_shown, support, symbol
from mbdsl.viewing.tracks import GROUND, Place, SpaceMotion

OF_SIZE, OF_LENGTH = 0.03, 0.14  #: size of symbols relative to the mechanism, and its limit relative to median bars
LEAST = 0.012  #: least size of symbols relative to the mechanism without bars
BAR, MASS = 0.34, 0.8  #: radius of bars and of bodies without dimensions, in units
FLAT = 1.2  #: ratio of moments of inertia up to which a body counts as a thin disc
THIN = 0.08  #: thickness of a disc relative to its radius
LARGE, DISCS = 0.5, 1.5  #: largest radius of solids and discs by moments of inertia, relative to the mechanism
RIM = 24  #: number of points of an edge that is round
POINT = 0.02  #: extent of all frames relative to solids by moments of inertia up to which the frames are at one point
TRAVELS = 4.5  #: extent of the motion relative to the mechanism from which the camera follows a body at first
#: kinds of elements for which no point of the ground is special
UNATTACHED = {"RollingDisc", "KnifeEdge", "PointOnPlane", "Force", "Torque", "FreeMotion", "VelocityConstraint"}


@dataclass(frozen=True)
class Floor:
    """A plane through the position r [m], whose normal is the z axis of the quaternion p."""

    r: tuple[float, ...]
    p: tuple[float, ...]


@dataclass(frozen=True)
class SpaceDrawing:
    """All solids, those of them that have dimensions of their own, and sizes.

    ``bounds`` are the extremes (2, 3) [m] of the motion, ``size`` is the largest diagonal [m] of the mechanism at a
    time, ``unit`` the size of symbols [m]. The camera follows the body ``followed`` at first.
    """

    solids: list[Solid]
    sized: list[Solid]
    bounds: Array
    size: float
    unit: float
    floor: Floor | None
    followed: str = ""


def drawing(motion: SpaceMotion) -> SpaceDrawing:
    """The solids of a mechanism.

    Returns
    -------
    SpaceDrawing
        Solids and sizes.
    """
    scene = motion.scene
    ports = {frame for c in scene.components.values() for frame in c.ports.values()}
    wheels = dict(_wheels(motion))
    attached = dict.fromkeys(motion.spot_of(frame) for frame in sorted(ports))
    held = [place for place in attached if place.track == GROUND and _is_held(place, motion)]
    elements = [c for c in scene.components.values() if len(c.ports) == 2 and not isinstance(c.kind, BodyKind)]
    tracks = {track for c in elements for track in bodies_shown(c, motion)}  # of bodies that elements show
    given = {c.name: solid for c in scene.bodies() if (solid := _given(c, motion, wheels)) is not None}
    others = [c for c in scene.bodies() if c.name not in given and motion.spots[f"{c.name}.c"].track not in tracks]
    derived = {c.name: solid for c in others if (solid := _of_inertia(c, motion)) is not None}
    moving = [place for place in motion.spots.values() if place.track != GROUND]
    # frames of given solids that no element is attached to are no lengths of the mechanism
    free = {p for p in moving if motion.tracks[p.track] in given and p not in attached and any(p.r)}
    low, high = motion.extremes([*held, *(place for place in moving if place not in free)])
    frames = _size(low, high)
    low, high = _enclosed(low, high, [*free, *(p for solid in given.values() for p in corners(solid))], motion)
    if frames > POINT * min(map(_reach, derived.values()), default=0.0):  # otherwise solids are its only lengths
        within = _size(low, high)
        derived = {name: solid for name, solid in derived.items() if _is_small(solid, motion, within)}
    own = given | derived
    low, high = _enclosed(low, high, (p for solid in derived.values() for p in corners(solid)), motion)
    size = _size(low, high)
    bounds = np.stack([low.min(axis=0), high.max(axis=0)])
    if not np.isfinite(bounds).all():
        bounds, size = np.zeros((2, 3)), 0.0
    size = size if is_apart(size, motion.poses[..., :3]) else 0.0
    bars = {c.name: list(_bars(c, motion, ports, own.get(c.name))) for c in scene.bodies()}
    lengths = [max(_length(p, q) for p, q in pairs) for pairs in bars.values() if pairs]
    unit = min(OF_SIZE * size, OF_LENGTH * float(np.median(lengths)) if lengths else np.inf)
    if given and not lengths:
        unit = min(unit, max(LEAST * size, OF_LENGTH * float(np.median([_reach(solid) for solid in given.values()]))))
    unit = unit or 1.0
    solids = [s for c in scene.bodies() for s in _body(c, motion, own.get(c.name), bars[c.name], unit, tracks)]
    symbols = [s for c in elements for s in symbol(c, motion, unit)]
    turning = [s for s in symbols if s.role == BODY and len(s.at) == 1]
    round_ones = [corner for s in turning for corner in corners(s)]
    if round_ones and size > 0.0:
        low, high = motion.extremes(round_ones)
        bounds = np.stack([np.minimum(bounds[0], low.min(axis=0)), np.maximum(bounds[1], high.max(axis=0))])
    solids += symbols
    solids += [support(place, unit) for place in held]
    diagonal = float(np.linalg.norm(bounds[1] - bounds[0]))
    followed = _heaviest(scene) if size > 0.0 and diagonal > TRAVELS * size else ""
    return SpaceDrawing(
        solids, [*own.values(), *turning], bounds, size or 1.0, unit, _floor(motion, bounds, size), followed
    )


def _size(low: Array, high: Array) -> float:
    """The largest diagonal [m] of boxes (N, 3) over time."""
    with np.errstate(invalid="ignore"):
        diagonals = np.linalg.norm(high - low, axis=1)
    return float(diagonals.max(initial=0.0, where=np.isfinite(diagonals)))


def _heaviest(scene: Scene) -> str:
    return max(scene.bodies(), key=lambda c: float(c.kind.table(dict(c.values))[0])).name


def _wheels(motion: SpaceMotion) -> Iterator[tuple[str, Solid]]:
    """Bodies that roll, and their wheels."""
    for c in motion.scene.components.values():
        if c.kind.name == "RollingDisc" and (hub := motion.spot_of(c.ports["frame_b"])).track != GROUND:
            body = motion.tracks[hub.track]
            yield body, Solid("wheel", BODY, body, (hub.moved(p=TO_X),), (float(c.values["radius"]),) * 3)


def _enclosed(low: Array, high: Array, places: Iterable[Place], motion: SpaceMotion) -> tuple[Array, Array]:
    """Boxes (N, 3) over time, enlarged to contain places."""
    lower, higher = motion.extremes(places)
    return np.minimum(low, lower), np.maximum(high, higher)


def _given(c: Component, motion: SpaceMotion, wheels: Mapping[str, Solid]) -> Solid | None:
    """The solid of a body by its dimensions, or as a wheel."""
    v, centre = c.values, motion.spots[f"{c.name}.c"]
    if c.name in wheels:
        return wheels[c.name]
    if c.kind.name == "Box":
        return Solid("box", BODY, c.name, (centre,), (v["length"], v["width"], v["height"]))
    if c.kind.name == "Cylinder":
        radius = float(v["radius"])
        at = centre.moved(p=_axis_along(v["n"]))
        if v["bore"] > 0.0:
            return Solid("tube", BODY, c.name, (at,), (radius, radius, v["length"]), {"bore": v["bore"] / radius})
        return Solid("cylinder", BODY, c.name, (at,), (radius, radius, v["length"]))
    if c.kind.name == "Sphere":
        return Solid("ball", BODY, c.name, (centre,), (float(v["radius"]),) * 3)
    return None


def _apart(name: str, motion: SpaceMotion) -> float:
    """The largest distance [m] of frames of a body from its centre, 0 if it is rounding."""
    apart = max(hypot(*motion.spots[frame].r) for frame in motion.frames[name])
    return apart if is_apart(apart, motion.poses[..., :3]) else 0.0


def _is_small(solid: Solid, motion: SpaceMotion, within: float) -> bool:
    """Whether a solid by moments of inertia is not large compared with ``within``, the size [m] of the mechanism, and
    with distances of the body's frames from its centre."""
    most, apart = (DISCS if solid.draw == "cylinder" else LARGE) * within, _apart(solid.name, motion)
    if solid.draw == "ball" and apart:
        most = min(most, apart) / 2
    return _reach(solid) < most


def _of_inertia(c: Component, motion: SpaceMotion) -> Solid | None:
    """A ball or a thin disc with the moments of inertia of a body; if it has no frames apart from its centre, otherwise
    a cuboid."""
    if c.kind.name != "Body" or not c.values["m"] > 0.0:
        return None
    centre, bare = motion.spots[f"{c.name}.c"], not _apart(c.name, motion)
    m = c.values["m"]
    J = np.array(c.kind.table(dict(c.values))[1:], float).reshape(3, 3)
    moments, axes = np.linalg.eigh(J)
    if not np.any(J - np.diag(np.diag(J))):
        moments, axes = np.diag(J), np.eye(3)
    low, middle, high = np.sort(moments)
    if low <= 0.0:
        return None
    if high < (1.0 + 1e-9) * low:
        return Solid("ball", BODY, c.name, (centre,), (sqrt(2.5 * low / m),) * 3)
    if middle < FLAT * low and high > (low + middle) / FLAT:  # as of a thin disc: C = A + B
        radius = sqrt(2.0 * high / m)
        at = centre.moved(p=_axis_along(axes[:, int(np.argmax(moments))].tolist()))
        return Solid("cylinder", BODY, c.name, (at,), (radius, radius, THIN * radius))
    if not bare:
        return None
    square = 6.0 * (moments.sum() - 2.0 * moments) / m  # edges of a cuboid: J_x = m (b^2 + c^2)/12
    edges = np.sqrt(np.maximum(square, 1e-4 * square.max()))
    if np.linalg.det(axes) < 0.0:
        axes = axes * (1.0, 1.0, -1.0)
    return Solid("box", BODY, c.name, (centre.moved(p=quaternions(of_matrix(axes)).tolist()),), tuple(edges.tolist()))


def _axis_along(n: Sequence[float]) -> tuple[float, ...]:
    """A quaternion that turns the z axis to the direction n."""
    return tuple(quaternions(of_matrix(np.array(turned_to("z", n)).reshape(3, 3).T)).tolist())


def _reach(solid: Solid) -> float:
    """Distance [m] from the centre within which a solid is."""
    x, y, z = solid.size
    return {"box": hypot(x, y, z) / 2, "cylinder": hypot(x, z / 2), "tube": hypot(x, z / 2)}.get(solid.draw, x)


def corners(solid: Solid) -> list[Place]:
    """The corners of the box around a solid."""
    x, y, z = solid.size
    half = (x / 2, y / 2) if solid.draw == "box" else (x, y)
    depth = {"box": z / 2, "cylinder": z / 2, "tube": z / 2, "wheel": 0.0}.get(solid.draw, z)
    signs = (-1.0, 1.0)
    return [solid.at[0].moved((i * half[0], j * half[1], k * depth)) for i in signs for j in signs for k in signs]


def edge(solid: Solid) -> tuple[Place, ...]:
    """Points whose convex hull the solid is; of a ball, and of a bar, which is thin, the ends of its axes."""
    at, radius, z = solid.at[0], solid.size[0], solid.size[2]
    if solid.draw == "box":
        return tuple(corners(solid))
    levels = (0.0,) if solid.draw == "wheel" else (-z / 2, z / 2)
    if solid.draw == "bar":
        return tuple(at.moved((0.0, 0.0, level)) for level in levels)
    if solid.draw == "ball":
        axes = np.concatenate([np.diag(solid.size), -np.diag(solid.size)])
        return tuple(at.moved(r) for r in axes.tolist())
    return tuple(place for level in levels for place in rounded(at, radius, level))


def rounded(at: Place, radius: float, level: float = 0.0, turns: int = 1) -> tuple[Place, ...]:
    """Points of a circle about the z axis of a place, or of a spiral that begins near the axis."""
    part = np.arange(turns * RIM + (turns > 1)) / RIM
    size = radius * (0.2 + 0.8 * part / turns if turns > 1 else np.ones_like(part))
    points = np.stack([size * np.cos(2 * np.pi * part), size * np.sin(2 * np.pi * part), level + 0.0 * part], axis=1)
    return tuple(at.moved(point) for point in points.tolist())


def _bars(c: Component, motion: SpaceMotion, ports: set[str], own: Solid | None) -> Iterator[tuple[Place, Place]]:
    """The ends of bars between the frames of a body: between two frames, otherwise from the frames to the nearest point
    of the bar of a Rod, or to the centre."""
    if "rx" not in c.kind.coordinates:
        return
    centre = motion.spots[f"{c.name}.c"]
    inside = 1e-9 * (c.values.get("length") or 1.0) if own is None else 1.01 * _reach(own)
    held: dict[tuple[float, ...], Place] = {}
    for name in motion.frames[c.name]:
        place = motion.spots[name]
        if _length(centre, place) > inside:
            held.setdefault(tuple(round(x, 12) for x in place.r), place)
    ends = [motion.spots[f"{c.name}.{k}"] for k in "ab" if f"{c.name}.{k}" in motion.spots]
    if len(ends) == 2 and own is None and _length(*ends) > 0.0:
        a, along = np.array(ends[0].r), np.array(ends[1].r) - np.array(ends[0].r)
        yield ends[0], ends[1]
        for place in held.values():
            part = min(1.0, max(0.0, float((np.array(place.r) - a) @ along / (along @ along))))
            foot = Place(centre.track, tuple((a + part * along).tolist()))
            if _length(foot, place) > 1e-9 * _length(*ends):
                yield foot, place
        return
    if len(held) == 2 and own is None and f"{c.name}.c" not in ports:
        first, second = held.values()
        yield first, second
        return
    for place in held.values():
        yield centre, place


def _length(p: Place, q: Place) -> float:
    return hypot(*(x - y for x, y in zip(p.r, q.r, strict=True)))


def _body(
    c: Component,
    motion: SpaceMotion,
    own: Solid | None,
    bars: Sequence[tuple[Place, Place]],
    unit: float,
    shown: set[int],
) -> Iterator[Solid]:
    if own is not None:
        yield own
    radius = BAR * unit
    for p, q in bars:
        along = np.array(q.r) - np.array(p.r)
        middle = tuple(((np.array(p.r) + np.array(q.r)) / 2).tolist())
        at = Place(p.track, middle, _axis_along(along.tolist()))
        yield Solid("bar", BODY, c.name, (at,), (radius, radius, _length(p, q)))
    if own is None and not bars and motion.spots[f"{c.name}.c"].track not in shown:
        yield Solid("ball", BODY, c.name, (motion.spots[f"{c.name}.c"],), (MASS * unit,) * 3)


def _floor(motion: SpaceMotion, bounds: Array, size: float) -> Floor | None:
    """The plane that discs roll on, or the horizontal plane below the mechanism; None without gravity."""
    for c in motion.scene.components.values():
        if c.kind.name == "RollingDisc" and (plane := motion.spot_of(c.ports["frame_a"])).track == GROUND:
            return Floor(plane.r, plane.p)
    g = np.array(gravity(motion.scene), float)
    if not g.any():
        return None
    up = -g / np.linalg.norm(g)
    corners = np.array([[bounds[i, 0], bounds[j, 1], bounds[k, 2]] for i in (0, 1) for j in (0, 1) for k in (0, 1)])
    middle = bounds.mean(axis=0)
    below = middle + (float((corners @ up).min()) - float(middle @ up) - 0.02 * size) * up
    return Floor(tuple(below.tolist()), _axis_along(up.tolist()))


def _is_held(place: Place, motion: SpaceMotion) -> bool:
    """Whether an element is attached to a frame of the ground, unlike planes and free motions."""
    kinds = {
        c.kind.name
        for c in motion.scene.components.values()
        if len(c.ports) == 2 and not isinstance(c.kind, BodyKind)
        if any(motion.spot_of(frame) == place for frame in c.ports.values())
    }
    return bool(kinds - UNATTACHED)
