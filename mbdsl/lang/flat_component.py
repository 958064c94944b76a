"""A component under construction: its values, frames, ports and signals.

Everything is computed when it is first requested, and stored, so that the order of declarations does not matter.
"""

from __future__ import annotations

from functools import cache
from typing import TYPE_CHECKING, Any

from mbdsl.elements import of_variant
from mbdsl.elements.declaration import ANY, REQUIRED
from mbdsl.elements.kind import BodyKind, JointKind, Kind, SensorKind
from mbdsl.errors import ModelError, Span
from mbdsl.expressions import symbolic
from mbdsl.expressions.symbolic import Expr
from mbdsl.lang import argument_checks, coupled_coordinates, modelica_names, units, values
from mbdsl.lang import syntax as s
from mbdsl.lang.component_template import Template
from mbdsl.lang.component_values import values_of
from mbdsl.lang.connections import NotConnected, PortNode
from mbdsl.lang.evaluate import evaluate
from mbdsl.lang.mistakes import doubts, joint_laws
from mbdsl.lang.mistakes import names as other_names
from mbdsl.lang.modifiers import Contexts, Modifier
from mbdsl.lang.paths import path_of
from mbdsl.lang.source import At, placed, span_of
from mbdsl.lang.units import Dimension
from mbdsl.lang.values import Quantity, Value
from mbdsl.mechanism import signals, wrenches
from mbdsl.mechanism.frozen_dict import FrozenDict
from mbdsl.mechanism.poses import SpatialPose
from mbdsl.mechanism.scene import Frame
from mbdsl.mechanism.scene_parts import SpatialFrame
from mbdsl.mechanism.signal_names import accelerations

if TYPE_CHECKING:
    from mbdsl.elements.rope_path import Path
    from mbdsl.lang.evaluate import Names
    from mbdsl.lang.flat_model import Assembly

#: results of a simulation, which are not variables of its equations
ACCELERATIONS = ("ax", "ay", "az", "alpha", "alphax", "alphay", "alphaz")


class FlatComponent:
    """A component of the flat model under construction."""

    __slots__ = (
        "_formulas",
        "_frames",
        "_laws",
        "_path",
        "_signal_names",
        "_values",
        "assembly",
        "at",
        "contexts",
        "doc",
        "drawn",
        "joint",
        "kind",
        "lacks",
        "name",
        "nodes",
        "template",
    )

    def __init__(
        self, assembly: Assembly, name: str, template: Template, contexts: Contexts = (), at: At = None, doc: str = ""
    ) -> None:
        self.assembly = assembly
        self.name = name
        self.kind = template.kind
        self.template = template
        self.contexts = contexts
        self.at = at
        self.doc = doc
        self.joint: FlatComponent | None = None  #: whose own frames it uses
        self.nodes = {port: PortNode(f"{name}.{port}", at) for port in template.kind.ports}
        self._values: dict | None = None
        self._frames: dict[str, Frame] | None = None
        self._laws: dict[str, Expr] = {}
        self._formulas: signals.ComponentFormulas | None = None
        self._signal_names: tuple[str, ...] | None = None
        self._path: Path | None = None
        self.drawn: list[tuple[tuple[s.Argument, ...], Names]] = []  #: annotations with shapes
        self.lacks: set[str] = set()  #: effects in ``assembly.without`` that it would have otherwise

    # -- values ------------------------------------------------------------------------------------------------

    def modifier(self, name: str) -> Modifier | None:
        """The modifier of a parameter, if it gives a value."""
        modifier = self.template.modifiers.get(name)
        return modifier if modifier is not None and modifier.value is not None else None

    @property
    def values(self) -> dict:
        """All parameters except laws, in SI, with defaults and derived values."""
        if self._values is None:
            if not self.template.modifiers and self.template.shared is None:
                self.template.shared = self.assembly.plain.get(self.kind)
            if self.template.shared is None:
                with self.assembly.defining(self, f"`{self.name}`", self.at):
                    self._values = values_of(self)
                if not self.template.modifiers and self.template.shared is not None:
                    self.assembly.plain[self.kind] = self.template.shared
            else:
                self._values, _, self.lacks = self.template.shared
        return self._values

    def law(self, name: str) -> Expr | None:
        """The expression of a law parameter, or its default."""
        if name in self._laws:
            return self._laws[name]
        parameter = self.kind.parameter(name)
        assert parameter is not None
        modifier = self.modifier(name)
        if modifier is None:
            default = parameter.default
            return None if default is None or default is REQUIRED else symbolic.const(default)
        assert modifier.value is not None
        with self.assembly.defining((self, name), f"`{self.name}.{name}`", modifier.value.at):
            value = evaluate(modifier.value, modifier.scope.for_law(self, name))
            with placed(modifier.value.at):
                picked = modifier.pick(value, 0, self.contexts)
                if isinstance(picked, tuple) and (hint := other_names.components(self.kind, modifier.value)):
                    what = f"`{name}` of `{self.name}`: found {values.describe(picked)}, expected a single value"
                    raise ModelError(what, hint=hint)
                law = argument_checks.law(parameter, picked, self.name, modifier.value)
                if "damping" in self.assembly.without and "damping" in self.kind.effects:
                    if symbolic.is_velocity_level(law):
                        self.lacks.add("damping")
                    law = symbolic.substitute(law, _at_rest)
                self._laws[name] = law
                if parameter.unit == "rad":
                    doubts.angle(self.assembly.warn, picked, modifier.value, f"`{name}` of `{self.name}`")
                if isinstance(self.kind, JointKind):
                    joint_laws.check_law(name, law, self.kind, self.name)
                    if name in self.kind.coupled:
                        coupled_coordinates.check_law(name, law, self.kind, self.name)
                    if arguments := dict(self.kind.functions).get(name):
                        formulas = {argument: self.formulas.signal(argument) for argument in arguments}
                        joint_laws.check_coupling(name, law, formulas, self.kind, self.name)
        return self._laws[name]

    # -- frames ------------------------------------------------------------------------------------------------

    def poses(self, found: dict) -> dict[str, tuple[float, ...]]:
        """Frames of a body by their own names, in the body's axes."""
        if not isinstance(self.kind, BodyKind):
            return {}
        com = self.kind.com(found)
        centre = (*com, *SpatialFrame.axes) if self.assembly.spatial else (com[0], com[1], 0.0)
        poses = {"c": centre, **self.kind.frames(found)}
        for name, pose in found.get("frames", ()):
            taken = name in poses or self.kind.parameter(name) or any(x.name == name for x in self.kind.signals)
            if taken or name in accelerations(self.kind):
                modifier = self.template.modifiers["frames"].inner[name]
                what = "a frame" if name in poses else "a parameter or signal"
                raise ModelError(f"`{self.name}` already has {what} `{name}`", span_of(modifier.at))
            poses[name] = pose
        return poses

    @property
    def frames(self) -> dict[str, Frame]:
        """Frames of a body by their own names."""
        if self._frames is None:
            found = self.values
            shared = self.template.shared
            poses = shared[1] if shared is not None and shared[0] is found else self.poses(found)
            span = span_of(self.at)
            self._frames = {
                name: frame_at(f"{self.name}.{name}", self.name, pose[:12], span, sum(pose[12:]))
                for name, pose in poses.items()
            }
        return self._frames

    def follow(self, joint: FlatComponent) -> None:
        """Take the axis of a joint that it is attached to, unless it has its own."""
        kind, follows = joint.kind, self.kind.follows
        if not isinstance(kind, JointKind) or not kind.placing.free_axes:
            return
        if follows not in kind.placing.free_axes and kind.rows == 5 and isinstance(self.kind, JointKind):
            raise self._immovable(joint)  # it leaves one motion free, and another one is prescribed
        if follows not in kind.placing.free_axes or self.modifier("n"):
            return
        axis = kind.placing.free_axes[follows]
        if axis is None:
            self.joint = joint
        else:
            self._values = FrozenDict({**self.values, "n": joint.values[axis]})

    def _immovable(self, joint: FlatComponent) -> ModelError:
        """The error of a driver of a motion that the joint does not have."""
        turns = self.kind.follows == "rotation"
        one, other = ("Rotational", "Translational") if turns else ("Translational", "Rotational")
        return ModelError(
            f"{self.kind.name} `{self.name}` drives {joint.kind.name} `{joint.name}`, "
            f"which does not {'turn' if turns else 'slide'}",
            span_of(self.at),
            f"use a {self.kind.name.replace(one, other)}, or a joint that {'turns' if turns else 'slides'}",
        )

    def own_frame(self, port: str) -> Frame:
        """The frame that its kernels use for a port: that of the port, or one with other axes."""
        if self.joint is not None:
            return self.joint.own_frame(port)
        base = self.port_frame(port)
        axes = self.kind.axes(self.values).get(port) if self.kind.spatial else None
        if axes is None or axes == SpatialFrame.axes:
            return base
        pose = base.pose @ SpatialPose.of_axes(axes)
        return frame_at(f"{self.name}.{port}", base.body, pose, span_of(self.at), base.phi)

    def port_frame(self, port: str) -> Frame:
        """The frame of a port, after all connections are made."""
        frame = self.nodes[port].frame
        if frame is None and port in self.kind.optional_ports:
            return self.assembly.world(self)
        if frame is None:
            other = next((n for p, n in self.nodes.items() if p != port and n.frame is not None), None)
            where = f" (its other port is on `{other.frame.name}`)" if other is not None and other.frame else ""
            written = f"`{self.kind.name} {self.name}({{}})`,".format
            named = f"two frames, {written('a, b')}" if len(self.nodes) > 1 else f"a frame, {written('a')}"
            raise NotConnected(
                f"`{port}` of {self.kind.name} `{self.name}` is not connected{where}",
                span_of(self.at),
                f"name {named} or `connect({self.name}.{port}, ...);`",
            )
        return frame

    # -- signals -----------------------------------------------------------------------------------------------

    def signal_names(self) -> tuple[str, ...]:
        if self._signal_names is None:
            laws = filter(self.has_law, self.kind.law_parameters)
            kind = self.own_kind
            touching = kind.contacts
            rubs = bool(self.values.get("mu_s")) if touching else self.has_friction()
            sticks = self.formulas.sticks or (rubs and bool(touching or getattr(kind, "unilateral", False)))
            self._signal_names = signals.names(kind, laws, rubs, sticks)
        return self._signal_names

    def has_friction(self) -> bool:
        """Whether it is a joint with friction."""
        return isinstance(self.kind, JointKind) and self.kind.friction != "" and self.values["mu_s"] > 0.0

    def has_law(self, name: str) -> bool:
        """Whether a law parameter is given or has a default."""
        parameter = self.kind.parameter(name)
        return parameter is not None and (self.modifier(name) is not None or parameter.default not in (None, REQUIRED))

    @property
    def own_kind(self) -> Kind:
        """Its kind, or the one that its values make of it."""
        variant = "" if self.kind.specialised is None else self.kind.specialised(self.values)
        return of_variant(variant, self.kind.spatial).KIND if variant else self.kind

    @property
    def formulas(self) -> signals.ComponentFormulas:
        """The formulas of its kind."""
        if self._formulas is None:
            self._formulas = signals.ComponentFormulas(self.own_kind, self.name, self._given, self._coordinate)
        return self._formulas

    def _formulas_at(self, port: str) -> signals.ComponentFormulas:
        """The same; at frame_b of a component along a path, those of its last span."""
        if not self.kind.computed or port == "frame_a":
            return self.formulas
        given = {**self.values, **self.path.of_span(len(self.path.spans) - 1)}
        return signals.ComponentFormulas(self.kind, self.name, given.get, self._coordinate)

    def _given(self, name: str) -> object:
        if name in self.kind.computed:
            return self.path.signals[name]
        return self.law(name) if name in self.kind.law_parameters else self.values[name]

    @property
    def path(self) -> Path:
        """The path of a component that may run over further frames."""
        if self._path is None:
            self._path = path_of(self, self.modifier("over"))
        return self._path

    def _coordinate(self, port: str, key: str) -> Expr:
        frame = self.frames["c"] if port == "c" else self.own_frame(port)
        return self.assembly.coordinate(frame, key).expression

    def signal(self, name: str) -> Quantity:
        """A signal by its own name, as an expression over frames."""
        if (key := _of_centre(self.kind, name)) is not None:
            return self.assembly.coordinate(self.frames["c"], key)
        own = self.units().get(name) if self.kind.coupled else None
        return Quantity(self.formulas.signal(name), units.dimension(own) if own else _dimension(self.own_kind, name))

    def units(self) -> dict[str, str]:
        """Units of signals of a joint that couples coordinates, by their dimensions."""
        given: dict[str, tuple[Dimension | None, s.Expression | None]] = {}
        for p in self.kind.parameters:
            modifier = self.modifier(p.name)
            if modifier is None or modifier.value is None:
                given[p.name] = None, None
                continue
            value = modifier.pick(evaluate(modifier.value, modifier.scope.for_law(self, p.name)), 0, self.contexts)
            given[p.name] = getattr(value, "dimension", None), modifier.value
        return coupled_coordinates.checked_units(self.kind, self.name, given)

    def on_port(self, port: str, key: str) -> Quantity:
        """A component of what a joint or force exerts on the body at a port, in the axes of the frame there."""
        frame = self.port_frame(port)
        force, torque = wrenches.on_port(self._formulas_at(port), port)
        found = wrenches.in_axes(force, torque, lambda name: self.assembly.coordinate(frame, name).expression)
        return Quantity(found[key], units.dimension(wrenches.units(self.assembly.spatial)[key]))

    def own(self, name: str) -> Value | PortNode | Frame | None:
        """The parameter, port or frame called ``name`` in the component; None for signals and unknown names."""
        if name in self.nodes:
            return self.nodes[name]
        parameter = self.kind.parameter(name)
        if parameter is not None and not parameter.law and parameter.unit:
            return self._quantity(self.values[name], parameter.unit)
        if isinstance(self.kind, BodyKind):
            return self.frames.get(name)
        return None

    def by_other_name(self, name: str) -> PortNode | Frame | None:
        """The port or frame that has ``name`` in Modelica or by the habit of other kinds: `rod.frame_a`, `pin.a`."""
        if not isinstance(self.kind, BodyKind):
            return self.nodes.get(modelica_names.PORTS.get(name, ""))
        centred = not any(self.frames["c"].pose[: 3 if self.kind.spatial else 2])
        found = modelica_names.frame_of_body(name, tuple(self.frames), self.kind.is_frame, centred)
        return self.frames.get(found) if found is not None else None

    def _quantity(self, value: Any, unit: str) -> Any:
        """The value of a parameter with its unit; None if it has none."""
        if isinstance(value, tuple):
            return tuple(self._quantity(v, unit) for v in value)
        dimension = None if unit == ANY else units.dimension(unit)
        return None if value is None else Quantity(value, dimension)

    @property
    def is_point(self) -> bool:
        """Whether its bare name denotes a frame."""
        return isinstance(self.kind, BodyKind) and self.kind.is_frame

    def output_only(self, name: str) -> bool:
        """Whether ``name`` is a result that laws cannot use."""
        if isinstance(self.kind, SensorKind):
            return any(x.name == name for x in self.kind.measured)
        return isinstance(self.kind, BodyKind) and bool(self.kind.coordinates) and name in accelerations(self.kind)

    def forget(self) -> None:
        """Discard values and signals, because the effects to leave out have changed."""
        self._values, self._formulas, self._laws, self.template.shared, self.lacks = None, None, {}, None, set()
        self._signal_names, self._path = None, None

    def known_names(self) -> list[str]:
        """The names for the hint "did you mean"."""
        frames = self.frames if isinstance(self.kind, BodyKind) else ()
        parameters = (p.name for p in self.kind.parameters if p.name != "frames")
        return [*frames, *self.signal_names(), *self.nodes, *parameters]


def frame_at(name: str, body: str, pose: tuple[float, ...], span: Span | None, turn: float = 0.0) -> Frame:
    """The frame at a pose on a body: (x, y, phi), or in space origin and axes, with its angle about z as given."""
    if len(pose) == 3:
        return Frame(name, body, *pose, span=span)
    return SpatialFrame(name, body, pose[0], pose[1], turn, span, z=pose[2], axes=tuple(pose[3:]))


def _at_rest(leaf: Expr) -> Expr | None:
    """Zero for velocities."""
    return symbolic.const(0.0) if symbolic.is_velocity(leaf) else None


@cache
def _of_centre(kind: Kind, signal: str) -> str | None:
    """The key, if the signal of a body is a coordinate of its frame "c", as most are."""
    formula = kind.formulas.get(signal, "") if isinstance(kind, BodyKind) and not kind.law_parameters else ""
    port, _, key = formula.partition(".")
    return key if port == "c" and key in symbolic.COORDINATES else None


@cache
def _dimension(kind: Kind, signal: str) -> Dimension | None:
    unit = kind.unit_of(signal)
    return units.dimension(unit) if unit else None


def is_body(part: FlatComponent) -> bool:
    return isinstance(part.kind, BodyKind)
