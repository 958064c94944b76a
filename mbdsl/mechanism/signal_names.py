"""Names, units and expressions of all signals of a scene, before and after a simulation."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping
from functools import cached_property
from typing import Any

from mbdsl.elements.kind import BodyKind, JointKind, PairKind, SensorKind
from mbdsl.errors import UsageError
from mbdsl.expressions import spatial_coordinates
from mbdsl.expressions.symbolic import Expr, call, const, coordinate
from mbdsl.mechanism import sections, wrenches
from mbdsl.mechanism.contacts import is_contact
from mbdsl.mechanism.energies import energies
from mbdsl.mechanism.scene import ENERGIES, STATE, Component, Description, Scene, is_rate
from mbdsl.messages import did_you_mean, few
from mbdsl.results.selection import matching

UNITS = {"x": "m", "y": "m", "phi": "rad", "vx": "m/s", "vy": "m/s", "w": "rad/s"}
ACCELERATIONS = {"ax": "m/s2", "ay": "m/s2", "alpha": "rad/s2"}
ACCELERATIONS_IN_SPACE = {f"a{i}": "m/s2" for i in "xyz"} | {f"alpha{i}": "rad/s2" for i in ("x", "y", "z", "")}
#: coordinates of frames in space among the signals: without the components of axes
SPATIAL_UNITS = {k: unit for k, unit in spatial_coordinates.UNITS.items() if k not in spatial_coordinates.AXES}
QUATERNION = spatial_coordinates.QUATERNION
#: sizes of vectors whose components are signals with an axis behind the letter: of forces, torques and velocities
SIZES = ("f", "t", "v")

#: beginnings of the names of residuals of constraints and of their rates, which patterns match only if they name them
RESIDUALS = ("Phi[", "dPhi[", "Gam[")

#: an expression and its unit, or what makes them: a function, its two arguments, and the unit
Entry = tuple[Expr, str] | tuple[Callable, Any, str, str]


class Expressions(Mapping[str, tuple[Expr, str]]):
    """Signal name -> (expression, unit); an expression is made when it is first requested."""

    def __init__(self, entries: dict[str, Entry]) -> None:
        self.entries = entries

    def __getitem__(self, name: str) -> tuple[Expr, str]:
        entry = self.entries[name]
        if len(entry) == 4:
            make, owner, key, unit = entry
            entry = self.entries[name] = (make(owner, key), unit)
        return entry

    def __iter__(self) -> Iterator[str]:
        return iter(self.entries)

    def __len__(self) -> int:
        return len(self.entries)

    def __contains__(self, name: object) -> bool:
        return name in self.entries


class SignalNames:
    """The signals of a scene.

    Parameters
    ----------
    scene : Scene
        The model.

    Attributes
    ----------
    flexible : list of str
        Names of the bodies that deform.
    """

    def __init__(self, scene: Scene) -> None:
        self.scene = scene
        self.flexible = [c.name for c in scene.components.values() if c.deforms]

    @cached_property
    def expressions(self) -> Expressions:
        """Signal name -> (expression, unit), of signals that are functions of q, v, lam and t."""
        scene = self.scene
        found: dict[str, Entry] = {}
        for c in scene.components.values():
            units_of, of_component = c.kind.unit_of, scene.signal_of
            for key in c.signals:
                if not (scene.spatial and key in QUATERNION):
                    found[f"{c.name}.{key}"] = (of_component, c, key, c.units.get(key) or units_of(key) or "")
        units, of_frame = (SPATIAL_UNITS, spatial_coordinates.named) if scene.spatial else (UNITS, coordinate)
        for name, frame in self._frames.items():
            for key, unit in units.items():
                if key not in QUATERNION:
                    found.setdefault(f"{name}.{key}", (of_frame, frame, key, unit))
        for c in self._sensors:
            loads = wrenches.units(scene.spatial)
            found |= {f"{c.name}.{key}": (self._load, c, key, unit) for key, unit in loads.items()}
        self._add_sizes(found)
        for name, expression in scene.variables.items():
            found.setdefault(name, (expression, scene.descriptions.get(name, Description()).unit))
        if not self.flexible:
            for name, energy in zip(ENERGIES, energies(scene), strict=True):
                found[name] = (energy, "J")
        return Expressions(found)

    @cached_property
    def on_ports(self) -> Expressions:
        """As ``expressions``, of what elements exert on their frames, in the axes of these: ``pin.frame_a.fx``.

        They are not among the ``names``, as a mechanism has too many of them.
        """
        found: dict[str, Entry] = {}
        for c in self.scene.components.values():
            if isinstance(c.kind, PairKind) and not is_rate(c):
                for port in c.ports:
                    at = self._element_at(c, port)
                    for key, unit in wrenches.units(self.scene.spatial).items():
                        found[f"{c.name}.{port}.{key}"] = (self._on_port, at, f"{port}.{key}", unit)
        self._add_sizes(found)
        return Expressions(found)

    @cached_property
    def sections(self) -> dict[str, str]:
        """Signal name -> unit, of the forces in sections of rods and beams: ``rod.b.N``; not among the ``names``."""
        return sections.units(self.scene)

    @property
    def _sensors(self) -> list[Component]:
        return [c for c in self.scene.components.values() if isinstance(c.kind, SensorKind)]

    def _element_at(self, c: Component, port: str) -> Component:
        """The component that exerts what is named after a port: at frame_b of a rope over discs, its last span."""
        along_path = c.kind.computed and port == "frame_b" and "stretch" in c.signals
        return self.scene.components[c.values["last"]] if along_path else c

    def _on_port(self, c: Component, name: str) -> Expr:
        port, _, key = name.partition(".")
        return self.scene.in_axes(*self.scene.on_port(c, port), c.attached.get(port, c.ports[port]))[key]

    def _load(self, sensor: Component, key: str) -> Expr:
        """A component of what all joints and forces at the frame of a sensor exert on its body."""
        scene, frame = self.scene, sensor.ports["frame"]
        own = {own for c in scene.components.values() for port, own in c.ports.items() if c.attached.get(port) == frame}
        loads = scene.loads({frame, *own})
        n, m = (3, 3) if scene.spatial else (2, 1)
        force = [sum((load.force[i] for load in loads), const(0.0)) for i in range(n)]
        torque = [sum((load.torque[i] for load in loads), const(0.0)) for i in range(m)]
        return scene.in_axes(force, torque, frame)[key]

    def _add_sizes(self, found: dict[str, Entry]) -> None:
        for name in [name for name in found if name.endswith(tuple(f".{size}x" for size in SIZES))]:
            vector, unit = name[:-1], found[name][-1]
            if f"{vector}y" in found:
                found.setdefault(vector, (self._size, vector, "xyz", unit))

    def _size(self, vector: str, axes: str) -> Expr:
        """The size of a vector, from its components: ``A.f`` from A.fx, A.fy and, if there is one, A.fz."""
        x, *others = (e[0] for i in axes if (e := self.listed_or_not(f"{vector}{i}")) is not None)
        for component in others:
            x = call("hypot", x, component)
        return x

    @cached_property
    def formulas(self) -> Expressions:
        """As ``expressions``, and quaternions as in laws, with a sign that jumps where the scalar part is zero."""
        quaternions = (name for name in self.computed if self.scene.spatial and name.rpartition(".")[2] in QUATERNION)
        return Expressions(self.expressions.entries | {name: (self.scene.signal(name), "1") for name in quaternions})

    @property
    def _frames(self) -> dict[str, str]:
        """Names and other names of frames -> their names.

        The frames with the axes of a joint or force in space are left out: they are named like its ports, which denote
        in models the frames that it is attached to."""
        components = self.scene.components

        def named(name: str) -> bool:
            owner = components.get(name.rpartition(".")[0])
            return owner is None or (isinstance(owner.kind, BodyKind) and owner.kind.variant != STATE)

        return {name: name for name in self.scene.frames if named(name)} | dict(self.scene.aliases)

    @cached_property
    def computed(self) -> dict[str, str]:
        """Signal name -> unit, of signals without an expression.

        These are accelerations, residuals of constraints, elastic coordinates, energies of bodies that deform, and
        quaternions, whose sign does not jump as that of the expression does.
        """
        found = {}
        for c in self.scene.components.values():
            if isinstance(c.kind, BodyKind) and c.kind.coordinates and c.kind.variant != STATE:
                found |= {f"{c.name}.{key}": unit for key, unit in accelerations(c.kind).items()}
                found[f"{c.name}.a"] = ACCELERATIONS["ax"]
                if c.kind.spatial and len(c.kind.coordinates) > 3:
                    found |= {f"{c.name}.p{k}": "1" for k in range(4)}
                if c.deforms:
                    found.update(dict.fromkeys(_elastic(c), ""))
            elif isinstance(c.kind, JointKind) and not is_contact(c):  # the gap of a contact is no residual
                for k in range(c.kind.rows):
                    found[f"{c.name}.Phi[{k + 1}]"] = ""
                    found[f"{c.name}.dPhi[{k + 1}]"] = ""
                for k in range(len(c.velocity_constraints)):
                    found[f"{c.name}.Gam[{k + 1}]"] = ""
            elif isinstance(c.kind, SensorKind):
                felt = {f"{c.name}.{x.name}": x.unit for x in c.kind.measured if x.unit == ACCELERATIONS["ax"]}
                found |= felt | {f"{c.name}.a": ACCELERATIONS["ax"]}
        if self.scene.spatial:
            found |= {f"{name}.{key}": "1" for name in self._frames for key in QUATERNION}
        return found | (dict.fromkeys(ENERGIES, "J") if self.flexible else {})

    @property
    def names(self) -> list[str]:
        """Names of all signals, "time" first."""
        return ["time", *self.expressions, *self.computed]

    @property
    def defaults(self) -> list[str]:
        """Names of the coordinates and velocities of all bodies, of the states, and of the discrete variables."""
        return [*self.motion, *self.scene.events.typed]

    @property
    def motion(self) -> list[str]:
        """Names of the coordinates and velocities of all bodies, and of the states."""
        bodies, states = self.scene.bodies(), [c.name for c in self.scene.states()]
        if self.scene.spatial:
            both = ("position", "velocity")
            return [f"{b.name}.{key}" for keys in both for b in bodies for key in _spatial(b, keys)] + states
        keys = {"x": "vx", "y": "vy", "phi": "w"}
        found = [f"{b.name}.{key}" for b in bodies for key in b.kind.coordinates]
        return found + [f"{b.name}.{keys[key]}" for b in bodies for key in b.kind.coordinates] + states

    @property
    def elastic(self) -> list[str]:
        """Names of the coordinates of bodies that deform and of their rates."""
        return [name for body in self.flexible for name in _elastic(self.scene.components[body])]

    def __contains__(self, name: str) -> bool:
        return name == "time" or name in self.expressions or self.is_computed(name) or name in self.on_ports

    def is_computed(self, name: str) -> bool:
        """Whether a signal has no expression."""
        return name in self.computed or name in self.sections

    def listed_or_not(self, name: str) -> tuple[Expr, str] | None:
        """The expression and the unit of a signal, whether it is among the ``names`` or not; None if it has none."""
        return self.expressions.get(name) or self.on_ports.get(name)

    def unit(self, name: str) -> str:
        """Return the SI unit of a signal; "" if the signal is a pure number or its unit is unknown."""
        if name == "time":
            return "s"
        entry = self.expressions.entries.get(name)
        if entry is None and name not in self.computed:
            entry = self.on_ports.entries.get(name)
        unit = entry[-1] if entry is not None else self.computed.get(name) or self.sections.get(name, "")
        return "" if unit == "1" else unit

    def select(self, patterns: str | Iterable[str]) -> list[str]:
        """Select signals by names and glob patterns, without duplicates.

        Raises
        ------
        UsageError
            If a pattern matches no name, or is not a text.
        """
        names, chosen = self.names, {}
        known = dict.fromkeys(names)
        if not isinstance(patterns, Iterable):
            raise UsageError(f"found {patterns!r}, expected names of signals", hint='e.g. ["crank.phi", "O.f*"]')
        for pattern in [patterns] if isinstance(patterns, str) else patterns:
            if not isinstance(pattern, str):
                raise UsageError(f"found {pattern!r} among the names of signals, expected a text")
            found = [pattern] if pattern in known else self._matching(pattern, names)
            if not found:
                raise self.unknown(pattern)
            chosen.update(dict.fromkeys(found))
        return list(chosen)

    def _matching(self, pattern: str, names: list[str]) -> list[str]:
        """The signals that a pattern matches: without residuals, unless it is `*` or names them, and with those of a
        port or a section if it begins with this frame, as ``rod.a.*`` does."""
        found = matching(pattern, names)
        if pattern != "*" and not any(word[:-1] in pattern for word in RESIDUALS):
            found = [x for x in found if not x.rpartition(".")[2].startswith(RESIDUALS)] or found
        if not found:
            return self.asked(pattern)
        frame = pattern.rpartition(".")[0]
        own = (
            [x for x in self.unlisted if x.rpartition(".")[0] == frame] if frame and not set(frame) & set("*?") else []
        )
        return [*found, *(matching(pattern, own) if own else ())]

    @property
    def unlisted(self) -> list[str]:
        """Signals that are not among the ``names``: those of ports, and of sections of rods and beams."""
        return [*self.on_ports, *self.sections]

    def asked(self, text: str) -> list[str]:
        """The signals that a pattern without a match among the ``names`` stands for."""
        return matching(text, self.unlisted)

    def entry(self, name: str) -> tuple[Expr, str] | None:
        """The expression and the unit of a signal; None if it has none."""
        return self.listed_or_not(name)

    def unknown(self, name: str) -> UsageError:
        """The error of a name or pattern without a match, with similar names."""
        listed = "`*` matches all; `mbdsl signals MODEL` and `Trajectory.signals` list them"
        near = [x for x in self.on_ports if x.startswith(f"{name.split('.')[0]}.")] if name.count(".") > 1 else []
        hint = self._of_sections(name) or did_you_mean(name, [*self.names, *near]) or listed
        return UsageError(f"there is no signal `{name}` in {self.scene.name}", hint=hint)

    def _of_sections(self, name: str) -> str | None:
        """The hint for a force in a section of a rod or beam without a section, or of a section without this force."""
        owner, _, key = name.rpartition(".")
        c = self.scene.components.get(owner)
        if c is not None and sections.has_sections(c) and key in sections.keys(self.scene.spatial):
            own = [x for x in self.sections if x.startswith(f"{owner}.") and x.endswith(f".{key}")]
            section = f"{owner}.a.{key}" if f"{owner}.a.{key}" in own else own[0] if own else ""
            here = f"name a section, `{section}`, or " if section else ""
            return f"`{name}` varies along {owner}: {here}use `mbdsl plot MODEL --along {name}`"
        own = [x for x in self.sections if x.rpartition(".")[0] == owner]
        return f"forces in this section: {few(own)}" if own and key[:1].isupper() else None


def accelerations(kind: BodyKind) -> dict[str, str]:
    """The accelerations of a body and their units, in world axes; alpha is about the z axis."""
    if not kind.spatial:
        return {key: unit for key, unit in ACCELERATIONS.items() if key != "alpha" or "phi" in kind.coordinates}
    rotates = len(kind.coordinates) > 3
    return {key: unit for key, unit in ACCELERATIONS_IN_SPACE.items() if rotates or not key.startswith("alpha")}


def _spatial(body: Component, level: str) -> list[str]:
    """The signals of a body in space that are its position or its velocity."""
    rotates = len(body.kind.coordinates) > 3
    if level == "position":
        return ["x", "y", "z", *(["p0", "p1", "p2", "p3"] if rotates else [])]
    return ["vx", "vy", "vz", *(["wx", "wy", "wz"] if rotates else [])]


def _elastic(body: Component) -> list[str]:
    return [f"{body.name}.{q}[{k + 1}]" for q in ("q", "dq") for k in range(len(body.coordinates))]
