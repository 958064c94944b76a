"""A mechanism in space that can only move in a plane, as a planar scene.

All bodies are held in parallel planes (:mod:`mbdsl.mechanism.reduction.plane`), and every joint and force has a
counterpart in the plane, which has the same components in the plane. Components out of the plane do no work; reactions
there follow from the motion, as those of other joints that are not solved for. The planar scene has the names of the
model. Coordinates of frames in laws become planar ones. Initial values are those of the assembly in space.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from functools import cache
from math import atan2, hypot, pi
from typing import Any

from mbdsl.elements import find
from mbdsl.elements.declaration import REQUIRED
from mbdsl.elements.kind import BodyKind, ForceKind, JointKind, Kind, PairKind
from mbdsl.elements.row_derivatives import axes_in, freedom
from mbdsl.errors import ModelError
from mbdsl.expressions.spatial_coordinates import named
from mbdsl.expressions.symbolic import Expr, call, const, coordinate, expr, rebuild, walk
from mbdsl.mechanism import graph as mechanism
from mbdsl.mechanism import signals
from mbdsl.mechanism.energies import gravity
from mbdsl.mechanism.graph import MechanismGraph
from mbdsl.mechanism.reduction.plane import SAME, InPlane, Plane, aligned, in_plane, is_point, plane_of
from mbdsl.mechanism.scene import Component, Frame, Scene


class NotPlanar(Exception):
    """Why a mechanism whose bodies are held in a plane is not solved there: the component, and the reason."""

    def __init__(self, component: Component, why: str) -> None:
        super().__init__(why)
        self.component, self.why = component, why


@dataclass(frozen=True)
class Angle:
    """``node``, an angle of the model that counts turns, is ``sign`` (phi_b - phi_a) of two frames in the plane; the
    node is None if the frames do not turn relative to each other, and frame a is None for the axes of the plane.

    Turns of bodies are chosen such that this holds; where it is ``needed`` and cannot hold, the motion is not planar.
    """

    node: Expr | None
    a: str | None
    b: str
    sign: float
    needed: bool


@dataclass(frozen=True)
class PlanarMotion:
    """The mechanism of ``graph``, which is in space, as the ``reduced`` one, which is planar."""

    graph: MechanismGraph
    plane: Plane
    reduced: MechanismGraph
    angles: tuple[Angle, ...]


def planar_motion(graph: MechanismGraph) -> PlanarMotion | None:
    """The planar motion of a mechanism in space; None if some body is not held in a plane.

    Raises
    ------
    NotPlanar
        If all bodies are held in a plane, but a component has no counterpart there.
    """
    plane = plane_of(graph)
    if plane is None:
        return None
    writer = _Writer(graph, plane)
    scene = writer.scene()
    try:
        return PlanarMotion(graph, plane, mechanism.build(scene), tuple(writer.angles.values()))
    except ModelError as problem:
        raise NotPlanar(next(iter(graph.bodies.values())), problem.message) from None


class _Writer:
    """Makes the planar scene of a mechanism."""

    def __init__(self, graph: MechanismGraph, plane: Plane) -> None:
        self.graph, self.plane, self.space = graph, plane, graph.scene
        self.at = plane.frames
        #: (body, x, y, phi) -> the first frame there, which stands for all of them in joints
        self.first: dict[tuple, str] = {}
        for name, frame in self.space.frames.items():
            p = self.at[name]
            self.first.setdefault((frame.body, p.x, p.y, p.phi), name)
        self.frames: dict[str, Frame] = {}
        self.known: dict[Expr | None, Expr] = {}  #: coordinates of joints -> their planar formulas
        self.angles: dict[Expr | str, Angle] = {}

    def scene(self) -> Scene:
        components = self.space.components.values()
        joined = [c for c in components if c.ports]
        for c in joined:
            self._measure(c)
        made = {}
        for c in components:
            found = self._body(c) if isinstance(c.kind, BodyKind) else self._joint_or_force(c)
            if found is not None:
                made[c.name] = found
        for name, p in self.at.items():
            frame = self.space.frames[name]
            self.frames[name] = Frame(name, frame.body, p.x, p.y, p.phi, frame.span)
        empty: dict[str, Any] = {"initial": (), "variables": {}, "parameters": {}, "shapes": {}, "warnings": ()}
        return replace(self.space, components=made, frames=self.frames, spatial=False, **empty)

    # -- bodies ------------------------------------------------------------------------------------------------
    def _body(self, c: Component) -> Component:
        assert isinstance(c.kind, BodyKind)
        if not c.kind.coordinates:
            g = gravity(self.space)
            e1, e2 = self.plane.axes[:3], self.plane.axes[3:6]
            x, y = (sum(a * b for a, b in zip(e, g, strict=True)) for e in (e1, e2))
            size = hypot(x, y)
            n = (x / size, y / size) if size else (0.0, -1.0)
            return self._with(c, "Ground", {"g": size, "n": n, "frames": ()})
        centre = self.at[f"{c.name}.c"]
        mass, *J = c.kind.table(c.values)
        if is_point(self.graph, c.name):
            return replace(self._with(c, "PointMass", {}), signals=())
        A = self.plane.bodies[c.name]
        k = A[2], A[5], A[8]
        about = sum(k[i] * J[3 * i + j] * k[j] for i in range(3) for j in range(3))
        values = {"m": mass, "I": about, "length": None, "com": (centre.x, centre.y), "frames": ()}
        return replace(self._with(c, "Body", values), signals=("phi", "w"))

    # -- joints and forces -------------------------------------------------------------------------------------
    def _joint_or_force(self, c: Component) -> Component | None:
        free, write = in_plane(c.kind), _writer(c.kind)
        if write is None:
            raise NotPlanar(c, f"{c.kind.name} has no counterpart in the plane")
        if c.friction is not None:
            raise NotPlanar(c, "its friction depends on all of its reactions")
        if free in ALIGNED and not aligned(self.plane, *c.ports.values()):
            raise NotPlanar(c, "its axes differ")
        if (free in LEVEL or write in (_same, _around)) and not self.plane.same_height(*c.ports.values()):
            raise NotPlanar(c, "its frames are in different planes")
        return write(self, c)

    def _pair(self, c: Component, kind: str | None = None, values: Mapping = {}, turned: bool = False) -> Component:
        """The counterpart of a joint or force, with frames exchanged if it is ``turned``, so that its angle is about k
        in both."""
        ports = {port: self._frame(frame) for port, frame in c.ports.items()}
        if turned:
            ports = dict(zip(ports, reversed(ports.values()), strict=True))
        return self._with(c, kind or c.kind.name, values, ports)

    def _with(self, c: Component, name: str, values: Mapping, ports: Mapping[str, str] = {}) -> Component:
        kind = find(name)
        assert kind is not None
        found = {p.name: None if p.default is REQUIRED else p.default for p in kind.parameters}
        own = {*found, *(kind.laws if isinstance(kind, ForceKind) else ())}
        found |= {key: self._law(c, x) if isinstance(x, Expr) else x for key, x in c.values.items() if key in own}
        found |= values
        found |= kind.derive({**found}) if isinstance(kind, JointKind) else {}
        given = [key for key in kind.law_parameters if found[key] is not None]
        value, leaf = found.__getitem__, lambda port, key: self._leaf(ports[port], key)
        formulas = signals.ComponentFormulas(kind, c.name, value, leaf)
        rows = kind.velocity_rows if isinstance(kind, JointKind) and c.velocity_constraints else ()
        return Component(
            c.name, kind, found, ports, signals.names(kind, given, False), c.span, c.doc,
            velocity_constraints=tuple(map(formulas.row, rows)),
            relations=tuple(map(formulas.row, kind.relations)) if isinstance(kind, JointKind) else (), units=c.units,
        )  # fmt: skip

    def _leaf(self, frame: str, key: str) -> Expr:
        """A coordinate of a frame in the plane."""
        if key in ("phi", "w") and is_point(self.graph, self.space.frames[frame].body):
            return const(self.at[frame].phi if key == "phi" else 0.0)
        return coordinate(frame, key)

    def _frame(self, name: str) -> str:
        p = self.at[name]
        return self.first[self.space.frames[name].body, p.x, p.y, p.phi]

    def _about(self, c: Component) -> float:
        """1 or -1, the component along k of the axis of frame_a about which its angle is, if it is parallel to k; else
        0."""
        a, b = (self.at[frame].k for frame in c.ports.values())
        free = freedom(c.kind)
        i = free.turns[0] if free and len(free.turns) == 1 else 2
        parallel = all(abs(x) <= SAME for n, x in enumerate(a) if n != i)
        measured = abs(b[1 if i == 0 else 0]) < 0.99  # the angle is that of an axis of frame_b
        return (1.0 if a[i] > 0.0 else -1.0) if parallel and measured else 0.0

    def _across(self, c: Component) -> bool:
        """Whether the x axis of frame_a is in the plane."""
        return abs(self.at[c.ports["frame_a"]].k[0]) <= SAME

    # -- laws --------------------------------------------------------------------------------------------------
    def _measure(self, c: Component) -> None:
        """The planar formulas of the coordinates of a joint or force."""
        ports = list(c.ports.values())
        measured = _writer(c.kind) is not None and len(ports) == 2
        node, sign = self.space.signal_of(c, "phi"), self._about(c) if measured else 0.0
        if node is not None and node.op == "angle" and sign:
            a, b = (self._frame(name) for name in ports)
            for key, found in (("phi", node), ("w", self.space.signal_of(c, "w"))):
                one, other = (b, a) if sign > 0.0 else (a, b)
                self.known[found] = self._leaf(one, key) - self._leaf(other, key)
            self._angle(Angle(node, a, b, sign, c.kind.counts_turns))
        if in_plane(c.kind) in WELDED:
            self.angles[c.name] = Angle(None, ports[0], ports[1], 1.0, True)
        planar = find(c.kind.name)
        if planar is not None and "s" in c.signals and {"s", "v"} <= planar.formulas.keys():
            formulas = signals.ComponentFormulas(
                planar, c.name, lambda name: None, lambda port, key: self._leaf(self._frame(c.ports[port]), key)
            )
            for key in ("s", "v"):
                self.known[self.space.signal_of(c, key)] = formulas.signal(key)

    def _angle(self, found: Angle) -> None:
        assert found.node is not None
        before = self.angles.get(found.node)
        self.angles[found.node] = replace(found, needed=found.needed or (before is not None and before.needed))

    def _law(self, c: Component, root: Expr) -> Expr:
        """An expression over frames in space as one over frames in the plane."""
        new: dict[Expr, Expr] = {}
        used = {root}
        for n in reversed(walk(root)):  # from the root on, without what is below a coordinate of a joint
            if n in used and n not in self.known:
                used.update(n.args)
        for n in walk(root):
            if n not in used:
                continue
            if n in self.known:
                new[n] = self.known[n]
                if n in self.angles:
                    self.angles[n] = replace(self.angles[n], needed=True)
            elif n.op == "coordinate":
                new[n] = self._coordinate(*n.value)
            elif n.op == "multiplier":
                raise NotPlanar(c, "its law reads reactions")
            elif n.op == "angle":
                new[n] = self._frame_angle(c, n)
            else:
                new[n] = rebuild(n, [new[a] for a in n.args]) if n.args else n
        return new[root]

    def _frame_angle(self, c: Component, node: Expr) -> Expr:
        """The signal phi of a frame, its angle about the z axis of the world."""
        frame = node.args[0].value[0] if node.args[0].op == "coordinate" else None
        if frame is None or node is not named(frame, "phi") or self.plane.normal != (0.0, 0.0, 1.0):
            raise NotPlanar(c, "its law reads an angle about another axis")
        if hypot(*self.at[frame].k[1:]) <= 0.1:
            raise NotPlanar(c, "its law reads the angle of an axis that is normal to the plane")
        self._angle(Angle(node, None, frame, 1.0, True))
        return self._leaf(frame, "phi")

    def _coordinate(self, frame: str, key: str) -> Expr:
        """A coordinate of a frame in space."""
        p, i = self.at[frame], "xyz".index(key[-1])
        e1, e2, k = (self.plane.axes[3 * j + i] for j in range(3))
        if key in ("x", "y", "z"):
            return e1 * self._leaf(frame, "x") + e2 * self._leaf(frame, "y") + k * p.height
        if key[0] == "v":
            return e1 * self._leaf(frame, "vx") + e2 * self._leaf(frame, "vy")
        if key[0] == "w":
            return k * self._leaf(frame, "w")
        j = "xyz".index(key[0])
        a, b, d = p.axes[3 * j : 3 * j + 3]
        c, s = (call(op, self._leaf(frame, "phi")) for op in ("cos", "sin"))
        return (e1 * a + e2 * b) * c + (e2 * a - e1 * b) * s + const(k * d)


def _hinge(w: _Writer, c: Component) -> Component:
    if not (sign := w._about(c)):
        raise NotPlanar(c, "its axis is not normal to the plane")
    return w._pair(c, "Revolute", turned=sign < 0.0)


def _cylinder(w: _Writer, c: Component) -> Component:
    """About k it is a hinge: others keep it from sliding. Across k it is a slider: others keep it from turning."""
    a, b = (w.at[frame].k for frame in c.ports.values())
    if w._about(c) and aligned(w.plane, *c.ports.values()):
        return w._pair(c, "Revolute")
    if max(abs(a[0]), abs(b[0])) > SAME or not w.plane.same_height(*c.ports.values()):
        raise NotPlanar(c, "its axis is neither normal to the plane nor in it")
    w.angles[c.name] = Angle(None, c.ports["frame_a"], c.ports["frame_b"], 1.0, True)
    return w._pair(c, "Prismatic", {"phi0": 0.0})


def _turning(w: _Writer, c: Component) -> Component:
    if not (sign := w._about(c)):
        raise NotPlanar(c, "it turns about an axis that is not normal to the plane")
    return w._pair(c, turned=sign < 0.0)


def _sliding(w: _Writer, c: Component) -> Component:
    if not w._across(c):
        raise NotPlanar(c, "its axis is not in the plane")
    return w._pair(c)


def _pin(w: _Writer, c: Component) -> Component:
    return w._pair(c, "Revolute")


def _free(w: _Writer, c: Component) -> Component:
    if not w._about(c):
        raise NotPlanar(c, "its plane is another one than that of the motion")
    return w._pair(c, "FreeMotion")


def _weld(w: _Writer, c: Component) -> Component:
    """The frames have parallel axes, which contain phi0."""
    return w._pair(c, values={"phi0": 0.0})


def _slider(w: _Writer, c: Component) -> Component:
    if not w._across(c):
        raise NotPlanar(c, "its axis is not in the plane")
    return w._pair(c, values={"phi0": 0.0})


def _same(w: _Writer, c: Component) -> Component:
    return w._pair(c)


def _around(w: _Writer, c: Component) -> Component:
    a = w.at[c.ports["frame_a"]]
    if max(abs(a.k[0]), abs(a.k[1])) > SAME:
        raise NotPlanar(c, "its axis is not normal to the plane")
    return w._pair(c)


def _on_plane(w: _Writer, c: Component) -> Component | None:
    """A plane normal to k: other joints hold the point on it. A plane along k: a line in the plane of the motion."""
    a = w.at[c.ports["frame_a"]]
    if max(abs(a.k[0]), abs(a.k[1])) <= SAME and w.plane.same_height(*c.ports.values()):
        return None
    if abs(a.k[2]) > SAME:
        raise NotPlanar(c, "its plane is inclined to that of the motion")
    line = f"{c.name}.line"
    across = a.phi + atan2(a.axes[7], a.axes[6]) + 0.5 * pi
    w.frames[line] = Frame(line, w.space.frames[c.ports["frame_a"]].body, a.x, a.y, across, c.span)
    return w._with(c, "PointOnLine", {}, {**c.ports, "frame_a": line})


def _nothing(w: _Writer, c: Component) -> None:
    """It constrains nothing, and the bodies are held by others."""


def _force(w: _Writer, c: Component) -> Component:
    axes: InPlane = w.at[c.ports["frame_a"]]
    parts = [w._law(c, expr(c.values[name])) for name in ("fx", "fy", "fz")]
    x, y = (sum((axes.axes[3 * j + i] * parts[j] for j in range(3)), const(0.0)) for i in range(2))
    return w._pair(c, values={"fx": x, "fy": y})


def _torque(w: _Writer, c: Component) -> Component | None:
    along = w.at[c.ports[c.values["axes"]]].k[2]
    if abs(abs(along) - 1.0) <= SAME:
        along = 1.0 if along > 0.0 else -1.0
    return w._pair(c, values={"tau": along * w._law(c, expr(c.values["tau"]))}) if abs(along) > SAME else None


def _without_frames(w: _Writer, c: Component) -> Component:
    return w._with(c, c.kind.name, {})


#: joints without rotations; with a common axis of their frames; with a common height of them: see ``IN_PLANE``
WELDED = ((0, 0), (1, 0))
ALIGNED = (*WELDED, (0, 1), (2, 1))
LEVEL = (*ALIGNED, (0, 3), (1, 3))
Write = Callable[[_Writer, Component], Component | None]
#: of joints by what they leave free
JOINTS: dict[tuple[int, int] | None, Write] = {
    (0, 0): _weld, (0, 1): _hinge, (0, 3): _pin, (1, 0): _slider, (1, 1): _cylinder, (1, 3): _sliding, (2, 1): _free,
    (2, 3): _on_plane,
}  # fmt: skip
FORCES: dict[str, Write] = {"Force": _force, "Torque": _torque}


@cache
def _writer(kind: Kind) -> Write | None:
    """The function that writes the counterpart of a joint or force; None if it is solved in space."""
    if not isinstance(kind, PairKind):
        return None
    if found := FORCES.get(kind.name) or JOINTS.get(in_plane(kind)):
        return found
    if kind.follows:
        return _turning if kind.follows == "rotation" else _sliding
    if not kind.ports:
        return _without_frames
    if isinstance(kind, JointKind) and not kind.rows and not kind.velocity_rows:
        return _nothing
    flat = not kind.velocity_rows if isinstance(kind, JointKind) else isinstance(kind, ForceKind) and kind.springs
    if not (flat and kind.g and find(kind.name)):
        return None
    return {frozenset[str](): _same, frozenset({"frame_a"}): _around}.get(frozenset(axes_in(kind)))
