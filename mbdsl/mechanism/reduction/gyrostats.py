"""Rotors that are symmetric about their axles, and the bodies that carry them, as gyrostats.

A body that only a hinge holds, whose mass is distributed symmetrically about the axis of the hinge, does not change the
distribution of mass when it turns: the body that carries it moves as if they were one rigid body with an additional
angular momentum along the axle (:mod:`mbdsl.bodies.gyrostat_kernels`). The hinge disappears, and the rotor's six
coordinates become one angle, on which nothing depends. Reactions of the hinge follow from the motion.

A rotor is left as it is where something depends on its angle: a law, a spring, a stop or a driver of the angle, or a
joint or force off its axle; and where the reactions of its hinge are needed, for friction or in a law.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from math import hypot
from typing import Any

from mbdsl.elements import of_variant
from mbdsl.elements.kind import BodyKind
from mbdsl.elements.row_derivatives import Freedom, freedom
from mbdsl.elements.vectors import least_minor
from mbdsl.expressions.symbolic import Expr, leaves, walk
from mbdsl.mechanism import graph as mechanism
from mbdsl.mechanism.edge import Edge
from mbdsl.mechanism.graph import GROUND, MechanismGraph
from mbdsl.mechanism.poses import SpatialPose, product, turned
from mbdsl.mechanism.reduction.note import Note
from mbdsl.mechanism.reduction.plane import RIGID
from mbdsl.mechanism.scene import Component, Frame, Scene
from mbdsl.mechanism.scene_parts import SpatialFrame

Vector = tuple[float, ...]
#: differences of moments of inertia, relative to the largest, and distances from the axle, relative to the largest
#: position of a frame, that count as rounding
SAME = 1e-12
#: least principal minor of the inertia of the body with rotors that turn freely, relative to its largest entry
REGULAR = 1e-12
#: kinds that may act on a rotor: they turn it, but do not depend on its angle; of the second ones, if both axes are the
#: axle
TURNING = ("Torque", "FreeMotion", "RotationalSpringDamper", "RotationalVelocityDriver")
HINGE = Freedom((), (2,))
ALIGNED = ("RotationalSpringDamper", "RotationalVelocityDriver")


@dataclass(frozen=True)
class Rotor:
    """A rotor on ``carrier``: at the angle zero, ``pose`` (12) is the pose of the rotor's axes in those of the carrier,
    and ``centre`` its centre of mass there. ``frame`` and ``base`` are the frames of the hinge on the rotor and on the
    carrier, whose z axes are the axle."""

    name: str
    carrier: str
    hinge: Component
    frame: SpatialFrame
    base: SpatialFrame
    pose: SpatialPose
    centre: Vector
    inertia: float  #: about the axle [kg.m2]

    @property
    def n(self) -> Vector:
        """The axle, in the carrier's axes."""
        return self.base.axes[6:]


@dataclass(frozen=True)
class Gyrostats:
    """The mechanism of ``graph``, which is in space, as the ``reduced`` one, whose hinges and rotors are gone."""

    graph: MechanismGraph
    reduced: MechanismGraph
    rotors: tuple[Rotor, ...]


def gyrostats(graph: MechanismGraph) -> tuple[Gyrostats | None, list[Note]]:
    """The mechanism with its symmetric rotors as parts of gyrostats, None if it has none; and the notes."""
    scene, notes, found = graph.scene, list[Note](), list[Rotor]()
    for e in graph.joints:
        if freedom(e.component.kind) != HINGE or GROUND in (e.body_i, e.body_j):
            continue
        for name, carrier in ((e.body_j, e.body_i), (e.body_i, e.body_j)):
            taken = {x for r in found for x in (r.name, r.carrier)}
            if name in taken or carrier in {r.name for r in found}:
                continue
            rotor = _rotor(graph, e, name, carrier)
            if rotor is None:
                continue
            kept = _dependence(graph, rotor)
            if kept is None:
                found.append(rotor)
                break
            by, why = kept
            notes.append(Note("kept", (name,), f"symmetric about its axle, but {why}", (by.name,), by.span))
    found = [r for own in _groups(found).values() if _regular(scene, own) for r in own]
    if not found:
        return None, notes
    for carrier, own in _groups(found).items():
        names = tuple(r.name for r in own)
        why = f"symmetric about axles on {carrier}: a gyrostat, whose steps need not resolve the spin"
        notes.append(Note("gyrostat", names, why, (), own[0].hinge.span))
    return Gyrostats(graph, mechanism.build(_scene(scene, found)), tuple(found)), notes


def _groups(rotors: Iterable[Rotor]) -> dict[str, list[Rotor]]:
    """Carrier -> its rotors."""
    found: dict[str, list[Rotor]] = {}
    for r in rotors:
        found.setdefault(r.carrier, []).append(r)
    return found


def _rotor(graph: MechanismGraph, e: Edge, name: str, carrier: str) -> Rotor | None:
    """The rotor, if a body that nothing but a hinge holds is symmetric about its axis."""
    scene, ends = graph.scene, (name, carrier)
    holding = [j for j in graph.kinematic_joints if name in (j.body_i, j.body_j)]
    if len(holding) > 1 or any(len(graph.bodies[body].coordinates) != RIGID for body in ends):
        return None
    at = {scene.frames[f].body: scene.frames[f] for f in e.component.ports.values()}
    frame, base = at[name], at[carrier]
    assert isinstance(frame, SpatialFrame) and isinstance(base, SpatialFrame)
    m, J, com = _masses(graph.bodies[name])
    n, largest = frame.axes[6:], max(map(abs, J))
    C = sum(n[i] * J[3 * i + j] * n[j] for i in range(3) for j in range(3))
    A = 0.5 * (J[0] + J[4] + J[8] - C)
    if not (m > 0.0 and SAME * largest < C and _masses(graph.bodies[carrier])[0] > 0.0):
        return None
    symmetric = [(C - A) * n[i] * n[j] + (A if i == j else 0.0) for i in range(3) for j in range(3)]
    if any(abs(x - y) > SAME * largest for x, y in zip(J, symmetric, strict=True)) or not _on_axle(com, frame, scene):
        return None
    pose = base.pose.carrying(frame.pose)
    return Rotor(name, carrier, e.component, frame, base, pose, (pose @ (*com, *frame.axes)).origin, C)


def _masses(c: Component) -> tuple[float, Vector, Vector]:
    """Mass, inertia about the centre of mass (9), and the centre of mass from the reference point."""
    assert isinstance(c.kind, BodyKind)
    m, *J = c.kind.table(c.values)
    return m, tuple(J), c.kind.com(c.values)


def _on_axle(place: Sequence[float], frame: SpatialFrame, scene: Scene) -> bool:
    """Whether a place on a rotor is on its axle, which is the z axis of its frame ``frame``."""
    away = [x - y for x, y in zip(place, frame.pose, strict=False)]
    largest = max(abs(x) for f in scene.frames.values() if f.body == frame.body for x in f.pose[:3])
    return hypot(*product(frame.axes[6:], away)) <= SAME * largest


def _along(frame: Frame, k: int, n: Sequence[float]) -> bool:
    """Whether axis ``k`` of a frame is parallel to the unit vector n."""
    assert isinstance(frame, SpatialFrame)
    return hypot(*product(frame.axes[3 * k : 3 * k + 3], n)) <= SAME


def _dependence(graph: MechanismGraph, rotor: Rotor) -> tuple[Component, str] | None:
    """The component that prevents the reduction, and the reason; None if there is none."""
    scene, hinge = graph.scene, rotor.hinge
    if hinge.friction is not None:
        return hinge, "the friction of its hinge depends on reactions there"
    aligned = {hinge.name}
    for c in scene.components.values():
        frames = [scene.frames[f] for f in c.ports.values()]
        if c is hinge or all(f.body != rotor.name for f in frames):
            continue
        axles = {rotor.name: rotor.frame.axes[6:], rotor.carrier: rotor.n}
        if {f.body for f in frames} == set(axles) and all(_along(f, 2, axles[f.body]) for f in frames):
            aligned.add(c.name)
        axes = frames[-1] if c.values.get("axes") == "frame_b" else frames[0]
        if (why := _of_action(rotor, c, axes, c.name in aligned)) is not None:
            return c, why
    known = {scene.signal_of(scene.components[name], "w") for name in aligned}
    for c in scene.components.values():
        if (why := _of_reading(scene, rotor, c, known, c.name in aligned)) is not None:
            return c, why
    return None


def _of_action(rotor: Rotor, c: Component, axes: Frame, aligned: bool) -> str | None:
    """Why a joint or force on a rotor, with axes of the frame ``axes``, prevents the reduction."""
    if c.kind.name not in TURNING:
        return f"{c.kind.name} may depend on its angle"
    if c.kind.name in ALIGNED and not aligned:
        return "this acts about another axis"
    if c.kind.name == "Torque" and axes.body == rotor.name and not _along(axes, 2, rotor.frame.axes[6:]):
        return "this acts about an axis that turns with it"
    return "this spring depends on its angle" if c.values.get("k") else None


def _of_reading(scene: Scene, rotor: Rotor, c: Component, known: set[Expr | None], aligned: bool) -> str | None:
    """Why the expressions and frames of a component prevent the reduction; ``known`` are speeds about the axle, and
    the constraints of ``aligned`` joints contain no others."""
    rows = () if aligned else (*c.velocity_constraints, *c.friction_rows)
    read = _read([x for x in (*c.values.values(), *rows, c.friction) if isinstance(x, Expr)], known)
    if any(n.op == "multiplier" and n.value[0] == rotor.hinge.name for n in read):
        return "a law reads the reactions of its hinge"
    leaves_of_frames: list[tuple[str, str]] = [n.value for n in read if n.op == "coordinate"]
    used = [(scene.frames[name], key) for name, key in leaves_of_frames]
    used += [(scene.frames[name], "") for name in c.ports.values()]
    for frame, key in used:
        if frame.body != rotor.name:
            continue
        if not _on_axle(frame.pose[:3], rotor.frame, scene):
            return "this refers to a frame off its axle"
        if len(key) == 2 and key[0] in "xyz" and not _along(frame, "xyz".index(key[0]), rotor.frame.axes[6:]):
            return "a law depends on its angle"
    return None


def _read(roots: Sequence[Expr], known: set[Expr | None]) -> list[Expr]:
    """The leaves of expressions, without those below nodes that are ``known``."""
    order = walk(*roots) if roots else []
    used = set(roots)
    for n in reversed(order):
        if n in used and n not in known:
            used.update(n.args)
    return [n for n in leaves(*roots) if n in used] if roots else []


def _regular(scene: Scene, rotors: Sequence[Rotor]) -> bool:
    """Whether the inertia of a carrier with rotors that turn freely is regular."""
    _m, _com, J = _together(scene, rotors)
    free = list(J)
    for r in rotors:
        for i in range(3):
            for j in range(3):
                free[3 * i + j] -= r.inertia * r.n[i] * r.n[j]
    return least_minor([free[k : k + 3] for k in (0, 3, 6)], max(map(abs, free))) > REGULAR


def _together(scene: Scene, rotors: Sequence[Rotor]) -> tuple[float, Vector, Vector]:
    """Mass, centre of mass from the carrier's reference point, and inertia about it (9), of a carrier with rotors."""
    m, J, com = _masses(scene.components[rotors[0].carrier])
    parts = [(m, J, com)]
    for r in rotors:
        m, J, _ = _masses(scene.components[r.name])
        axes = r.pose[3:]
        columns = [turned(axes, J[k : k + 3]) for k in (0, 3, 6)]  # P J, as J is symmetric
        turned_J = [turned(axes, [column[i] for column in columns]) for i in range(3)]
        parts.append((m, tuple(x for row in turned_J for x in row), r.centre))
    mass = sum(m for m, _, _ in parts)
    centre = tuple(sum(m * c[i] for m, _, c in parts) / mass for i in range(3))
    total = [0.0] * 9
    for m, J, c in parts:
        d = [x - y for x, y in zip(c, centre, strict=True)]
        square = sum(x * x for x in d)
        for i in range(3):
            for j in range(3):
                total[3 * i + j] += J[3 * i + j] + m * ((square if i == j else 0.0) - d[i] * d[j])
    return mass, centre, tuple(total)


def _scene(scene: Scene, rotors: Sequence[Rotor]) -> Scene:
    """The scene without the rotors and their hinges; frames on a rotor's axle become frames of its carrier."""
    gone = {x for r in rotors for x in (r.name, r.hinge.name)}
    components = {name: c for name, c in scene.components.items() if name not in gone}
    frames = {name: f for name, f in scene.frames.items() if f.body not in gone}
    kind = of_variant("gyrostat", True).KIND
    for carrier, own in _groups(rotors).items():
        m, com, J = _together(scene, own)
        values: Mapping[str, Any] = {"m": m, "com": com, "J": J, "rotors": tuple((r.n, r.inertia) for r in own)}
        components[carrier] = replace(components[carrier], kind=kind, values=values, signals=())
        for k, r in enumerate(own):
            for name, f in scene.frames.items():
                if f.body == r.name and _on_axle(f.pose[:3], r.frame, scene):
                    x, y, z, *axes = r.pose @ f.pose
                    frames[name] = SpatialFrame(name, carrier, x, y, f.phi, f.span, None, z, tuple(axes), k + 1)
    empty: dict[str, Any] = {"initial": (), "variables": {}, "parameters": {}, "shapes": {}, "warnings": ()}
    return replace(scene, components=components, frames=frames, **empty)
