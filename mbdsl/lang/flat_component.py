"""A component under construction: its values, frames, ports and signals.

Everything is computed when it is first requested, and stored, so that the order of declarations does not matter.
"""

from __future__ import annotations

import re
from collections.abc import Callable
from functools import cache
from typing import TYPE_CHECKING

from mbdsl.elements.kind import ANY, REQUIRED, BodyKind, ForceKind, JointKind, Kind, Parameter, SensorKind
from mbdsl.errors import ModelError, Span
from mbdsl.expressions import symbolic
from mbdsl.expressions.primitive import potential
from mbdsl.expressions.symbolic import Expr
from mbdsl.lang import argument_checks, coupled_coordinates, modelica_names, orientations, units, values
from mbdsl.lang import syntax as s
from mbdsl.lang.connections import NotConnected, PortNode
from mbdsl.lang.evaluate import evaluate, place
from mbdsl.lang.mistakes import doubts, joint_laws, members
from mbdsl.lang.mistakes import names as other_names
from mbdsl.lang.modifiers import Contexts, Modifier, Modifiers, refuse_inner
from mbdsl.lang.paths import frames_over, path_of, spans
from mbdsl.lang.source import At, span_of
from mbdsl.lang.units import Dimension
from mbdsl.lang.unparse import write
from mbdsl.lang.values import Quantity, Value
from mbdsl.mechanism import poses_in_space, signals, wrenches
from mbdsl.mechanism.frozen_dict import FrozenDict
from mbdsl.mechanism.scene import Component, Frame, SpatialFrame
from mbdsl.mechanism.signal_names import accelerations
from mbdsl.messages import did_you_mean

if TYPE_CHECKING:
    from mbdsl.elements.rope_path import Path
    from mbdsl.lang.evaluate import Names
    from mbdsl.lang.flat_model import Assembly

#: results of a simulation, which are not variables of its equations
ACCELERATIONS = ("ax", "ay", "az", "alpha", "alphax", "alphay", "alphaz")


class Template:
    """The data that the elements of one declaration share: kind, modifiers, and the values if they are equal."""

    __slots__ = ("kind", "modifiers", "shared")

    def __init__(self, kind: Kind, modifiers: Modifiers) -> None:
        self.kind = kind
        self.modifiers = modifiers
        self.shared: tuple[dict, dict, set[str]] | None = None

    def unknown(
        self,
        owner: str,
        attached: Callable[[], other_names.Attached] | None = None,
        passed: list[s.Passed] | None = None,
    ) -> None:
        """Raise an error for modifiers that the kind does not have.

        ``attached()`` is how it is declared, for advice about it.

        Modifiers of Modelica that have no effect on the motion are added to ``passed``, if it is given.
        """
        if not self.modifiers:
            return
        kind = self.kind
        measured = {signal.name for signal in kind.signals}
        known = [*(p.name for p in kind.parameters), *kind.ports]
        for name, modifier in self.modifiers.items():
            start = bool(modifier.inner) and modifier.value is None
            if (kind.parameter(name) and not (start and name in measured)) or name in kind.ports:
                if name == "frames" and kind.spatial:
                    for frame, inner in modifier.inner.items():
                        orientations.check(inner, f"frame `{frame}` of `{owner}`")
                elif name != "frames":
                    takes = f"{kind.name} takes: {', '.join(known)}"
                    refuse_inner(modifier, f"`{name}` of {kind.name} `{owner}`", takes)
                else:
                    for frame, inner in modifier.inner.items():
                        refuse_inner(inner, f"frame `{frame}` of `{owner}`", f"write `{frame} = {{x, y}}`")
                continue
            if start and name in measured:
                for attribute, inner in modifier.inner.items():
                    if attribute not in ("start", "fixed", *modelica_names.NO_EFFECT):
                        hint = did_you_mean(attribute, ("start", "fixed"), "attributes of a signal")
                        raise ModelError(f"a signal has no attribute `{attribute}`", span_of(inner.at), hint)
                    refuse_inner(inner, f"`{attribute}` of `{owner}.{name}`", f"write `{attribute} = ...`")
                    if passed is not None and attribute in modelica_names.NO_EFFECT[1:]:
                        passed.append(s.Passed(attribute, at=inner.at))
                continue
            if name in measured:
                message = f"`{name}` of `{owner}` is a signal; only its start can be given"
                raise ModelError(message, span_of(modifier.at), f"write `{name}(start = ..., fixed = true)`")
            if passed is not None and modelica_names.has_no_effect(name, modifier.value):
                passed.append(s.Passed(name, at=modifier.at))
                continue
            hint = self._axis(name, modifier, owner, attached)
            if hint == "":
                continue
            given = {key: m.value for key, m in self.modifiers.items() if m.value is not None}
            hint = hint or members.start(kind, owner, name, *modifier.start(), given)
            hint = hint or other_names.parameter(kind, known, name, given)
            hint = hint or did_you_mean(name, known, f"{kind.name} takes")
            raise ModelError(f"{kind.name} `{owner}` has no parameter `{name}`", span_of(modifier.at), hint)

    def _axis(
        self, name: str, modifier: Modifier, owner: str, attached: Callable[[], other_names.Attached] | None
    ) -> str | None:
        """The remedy if the modifier is the axis of a joint; "" if the joint has this axis."""
        if name not in ("n", "r") or modifier.value is None:
            return None
        given = modifier.evaluate()
        if not isinstance(given, tuple) or any(isinstance(x, tuple) or not x.number or x.varying for x in given):
            return None
        n = [float(x.value) for x in given]  # type: ignore[union-attr,arg-type]
        joint = other_names.Attached() if attached is None else attached()
        return other_names.axis(self.kind.name, owner, n, joint)


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
        self._formulas: signals.Formulas | None = None
        self._signal_names: tuple[str, ...] | None = None
        self._path: Path | None = None
        self.drawn: list[tuple[tuple[s.Argument, ...], Names]] = []  #: annotations with shapes
        self.lacks: set[str] = set()  #: effects in ``assembly.without`` that it would have otherwise

    # -- values ------------------------------------------------------------------------------------------------

    def _modifier(self, name: str) -> Modifier | None:
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
                    self._values = self._make_values()
                if not self.template.modifiers and self.template.shared is not None:
                    self.assembly.plain[self.kind] = self.template.shared
            else:
                self._values, _, self.lacks = self.template.shared
        return self._values

    def _check_quoted(self, parameter: Parameter, modifier: Modifier) -> None:
        """Refuse ``axes = world``, where a text was meant."""
        found = write(modifier.value) if isinstance(modifier.value, s.Reference) else ""
        if found in parameter.choices and isinstance(parameter.default, str):
            message = f"`{parameter.name}` of `{self.name}` is a text"
            raise ModelError(message, modifier.value_span(), f'write it in quotes: `{parameter.name} = "{found}"`')

    def _make_values(self) -> dict:
        same = True
        found: dict = {}
        for parameter in self.kind.parameters:
            if parameter.law:
                if parameter.default is REQUIRED and self._modifier(parameter.name) is None:
                    raise self._missing(parameter)
                found[parameter.name] = None
                continue
            if parameter.name == "frames":
                found["frames"], equal = self._user_frames()
                same = same and equal
                continue
            modifier = self._modifier(parameter.name)
            if modifier is None:
                if parameter.default is REQUIRED:
                    raise self._missing(parameter)
                found[parameter.name] = parameter.default
                continue
            if parameter.name == "over":
                found["over"] = tuple(x.name for x in frames_over(modifier))
                continue
            self._check_quoted(parameter, modifier)
            value = modifier.evaluate()
            try:
                picked = modifier.pick(value, self._rank(parameter, modifier, values.shape(value)), self.contexts)
                found[parameter.name] = argument_checks.argument(parameter, picked, self.name, modifier.value)
            except ModelError as problem:
                raise place(problem, modifier.value.at) from None  # type: ignore[union-attr]
            if parameter.unit == "rad":
                doubts.angle(self.assembly.warn, picked, modifier.value, f"`{parameter.name}` of `{self.name}`")
            if parameter.name == "pitch":
                doubts.pitch_per_angle(self.assembly.warn, self.name, picked, modifier.value)
            same = same and picked is value
        doubts.damping_alone(self.assembly.warn, self.kind, self.name, self.template.modifiers)
        laws = {p.name: modifier for p in self.kind.parameters if p.law and (modifier := self._modifier(p.name))}
        problem_text = self.kind.check({**found, **laws} if laws else found)
        if problem_text:
            raise ModelError(f"{self.kind.name} `{self.name}`: {problem_text}", span_of(self._place_of(problem_text)))
        if (doubt := self.kind.doubt(found)) is not None:
            message = f"no body has the moments of inertia I of {self.kind.name} `{self.name}`: {doubt}"
            hint = "check their order and the axes: a moment is at most the sum of the two others"
            self.assembly.warn(message, self._place_of(message), hint)
        try:
            found.update(self.kind.derive(found))
        except ArithmeticError:
            raise ModelError(f"{self.kind.name} `{self.name}`: its values are too large", span_of(self.at)) from None
        for effect in self.assembly.without:
            if effect in self.kind.effects and (changed := self.kind.effects[effect](found)):
                found.update(changed)
                self.lacks.add(effect)
        found = FrozenDict(found)  # components share it
        if same:
            self.template.shared = (found, self._poses(found), self.lacks)
        return found

    def _rank(self, parameter: Parameter, modifier: Modifier, shape: tuple[int, ...]) -> int:
        """Number of dimensions of the value of one component; of an array, values without `each` are one by one."""
        accepted, inside = (parameter.shape, *parameter.or_shapes), self.contexts[modifier.level :]
        if len(accepted) == 1 or (shape not in accepted and modifier.each):
            return len(parameter.shape)
        if not inside or modifier.each or shape[1:] not in accepted or shape[:1] != (inside[-1][1],):
            return len(shape)
        if shape in accepted and modifier.value is not None:
            doubts.one_by_one(self.assembly.warn, parameter.name, self.name, len(shape) - 1, modifier.value)
        return len(shape) - 1

    def _place_of(self, problem: str) -> At:
        """The value of the only parameter that a problem names, if it is a kind in space; else the component."""
        words = set(re.findall(r"[A-Za-z]\w*", problem)) if self.kind.spatial else ()
        named = [modifier for p in self.kind.parameters if p.name in words and (modifier := self._modifier(p.name))]
        return named[0].value.at if len(named) == 1 and named[0].value is not None else self.at

    def _missing(self, parameter: Parameter) -> ModelError:
        unit = "" if parameter.unit in ("", "1") else f" [{parameter.unit}]"
        examples = {"kg": "1 kg", "m": "1 m", "rad": "2*time", "N.m": "1 N.m", "": "crank.w + 2*rod.w"}
        if isinstance(self.kind, JointKind) and self.kind.functions:
            examples[""] = "x^2 + y^2 - (1 m)^2"
        if parameter.name in self.kind.coupled:
            examples |= {"": "pin.phi", "rad": "pin.phi"}
        return ModelError(
            f"{self.kind.name} `{self.name}` needs `{parameter.name}`: {parameter.doc}{unit}",
            span_of(self.at),
            f"write `{parameter.name} = {examples.get(parameter.unit, '...')}`",
        )

    def _user_frames(self) -> tuple[tuple, bool]:
        given = self.template.modifiers.get("frames")
        if given is None:
            return (), True
        if given.value is not None or not given.inner:
            raise ModelError(
                f"`frames` of `{self.name}` is a list of named frames",
                span_of(given.at),
                "write `frames(tip = {x, y})`",
            )
        found, same = [], True
        orientations.refuse_loose(given.inner, self.name, self.assembly.spatial)
        for name, modifier in given.inner.items():
            what = f"frame `{name}` of `{self.name}`"
            if modifier.value is None and modifier.inner and self.assembly.spatial:
                pose, turn = orientations.pose(what, modifier.inner, self.contexts, modifier.at, self.assembly.warn)
                found.append((name, (*pose, turn)))
                same = same and not self.contexts
                continue
            if modifier.value is None:
                raise ModelError(f"{what} has no position", span_of(modifier.at), f"write `{name} = {{x, y}}`")
            value = modifier.evaluate()
            try:
                picked = modifier.pick(value, 1, self.contexts)
                read = argument_checks.spatial_pose if self.assembly.spatial else argument_checks.pose
                found.append((name, read(picked, what)))
                if isinstance(picked, tuple) and len(picked) == 3:
                    doubts.angle(self.assembly.warn, picked[2], modifier.value, f"phi of {what}")
            except ModelError as problem:
                raise place(problem, modifier.value.at) from None
            same = same and picked is value
        return tuple(found), same

    def law(self, name: str) -> Expr | None:
        """The expression of a law parameter, or its default."""
        if name in self._laws:
            return self._laws[name]
        parameter = self.kind.parameter(name)
        assert parameter is not None
        modifier = self._modifier(name)
        if modifier is None:
            default = parameter.default
            return None if default is None or default is REQUIRED else symbolic.const(default)  # type: ignore[arg-type]
        assert modifier.value is not None
        with self.assembly.defining((self, name), f"`{self.name}.{name}`", modifier.value.at):
            value = evaluate(modifier.value, modifier.scope.for_law(self, name))
            try:
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
                    if arguments := dict(self.kind.couplings).get(name):
                        formulas = {argument: self.formulas.signal(argument) for argument in arguments}
                        joint_laws.check_coupling(name, law, formulas, self.kind, self.name)
            except ModelError as problem:
                raise place(problem, modifier.value.at) from None
        return self._laws[name]

    # -- frames ------------------------------------------------------------------------------------------------

    def _poses(self, found: dict) -> dict[str, tuple[float, ...]]:
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
            poses = shared[1] if shared is not None and shared[0] is found else self._poses(found)
            span = span_of(self.at)
            self._frames = {
                name: frame_at(f"{self.name}.{name}", self.name, pose[:12], span, sum(pose[12:]))
                for name, pose in poses.items()
            }
        return self._frames

    def follow(self, joint: FlatComponent) -> None:
        """Take the axis of a joint that it is attached to, unless it has its own."""
        kind, follows = joint.kind, self.kind.follows
        if not isinstance(kind, JointKind) or not kind.free_axes:
            return
        if follows not in kind.free_axes and kind.rows == 5 and isinstance(self.kind, JointKind):
            raise self._immovable(joint)  # it leaves one motion free, and another one is prescribed
        if follows not in kind.free_axes or self._modifier("n"):
            return
        axis = kind.free_axes[follows]
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
        pose = poses_in_space.composed(base.pose, (0.0, 0.0, 0.0, *axes))
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
            laws = filter(self._has_law, self.kind.law_parameters)
            self._signal_names = signals.names(self.kind, laws, self._has_friction())
        return self._signal_names

    def _has_friction(self) -> bool:
        return isinstance(self.kind, JointKind) and self.kind.friction != "" and self.values["mu_s"] > 0.0

    def _has_law(self, name: str) -> bool:
        parameter = self.kind.parameter(name)
        return parameter is not None and (self._modifier(name) is not None or parameter.default not in (None, REQUIRED))

    @property
    def formulas(self) -> signals.Formulas:
        """The formulas of its kind."""
        if self._formulas is None:
            self._formulas = signals.Formulas(self.kind, self.name, self._given, self._coordinate)
        return self._formulas

    def _formulas_at(self, port: str) -> signals.Formulas:
        """The same; at frame_b of a component along a path, those of its last span."""
        if not self.kind.computed or port == "frame_a":
            return self.formulas
        given = {**self.values, **self.path.of_span(len(self.path.spans) - 1)}
        return signals.Formulas(self.kind, self.name, given.get, self._coordinate)

    def _given(self, name: str) -> object:
        if name in self.kind.computed:
            return self.path.signals[name]
        return self.law(name) if name in self.kind.law_parameters else self.values[name]

    @property
    def path(self) -> Path:
        """The path of a component that may run over further frames."""
        if self._path is None:
            self._path = path_of(self, self._modifier("over"))
        return self._path

    def _coordinate(self, port: str, key: str) -> Expr:
        frame = self.frames["c"] if port == "c" else self.own_frame(port)
        return self.assembly.coordinate(frame, key).value  # type: ignore[return-value]

    def signal(self, name: str) -> Quantity:
        """A signal by its own name, as an expression over frames."""
        if (key := _of_centre(self.kind, name)) is not None:
            return self.assembly.coordinate(self.frames["c"], key)
        own = self._units().get(name) if self.kind.coupled else None
        return Quantity(self.formulas.signal(name), units.dimension(own) if own else _dimension(self.kind, name))

    def _units(self) -> dict[str, str]:
        """Units of signals of a joint that couples coordinates, by their dimensions."""
        given: dict[str, tuple[Dimension | None, s.Expression | None]] = {}
        for p in self.kind.parameters:
            modifier = self._modifier(p.name)
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
        found = wrenches.in_axes(force, torque, lambda name: self.assembly.coordinate(frame, name).value)  # type: ignore[arg-type,return-value]
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

    def _quantity(self, value: object, unit: str) -> Value | None:
        if isinstance(value, tuple):
            return tuple(self._quantity(v, unit) for v in value)  # type: ignore[misc]
        dimension = None if unit == ANY else units.dimension(unit)
        return None if value is None else Quantity(value, dimension)  # type: ignore[arg-type]

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

    # -- the result --------------------------------------------------------------------------------------------

    def components(self) -> list[Component]:
        """The component, and those of the further spans of its path."""
        if self.kind.computed:
            return spans(self, self._modifier("over"))
        return [self.component()]

    def component(self) -> Component:
        kind = self.kind
        laws = {name: self.law(name) for name in kind.law_parameters}
        if isinstance(kind, ForceKind) and kind.springs is None:
            laws |= {name: self.formulas.signal(name) for name in kind.laws if laws.get(name) is None}
        ports = {port: self.own_frame(port).name for port in self.nodes}
        return Component(
            self.name,
            kind,
            {**self.values, **laws} if laws else self.values,
            ports,
            self.signal_names(),
            span_of(self.at),
            self.doc,
            self._energy(),
            self._velocity_constraints(),
            self.formulas.signal("friction") if self._has_friction() else None,
            self.formulas.friction_rows() if self._has_friction() else (),
            {port: frame for port, own in ports.items() if (frame := self.port_frame(port).name) != own},
            tuple(map(self.formulas.row, kind.relations)) if isinstance(kind, JointKind) else (),
            self._units() if kind.coupled else {},
        )

    def _energy(self) -> Expr | None:
        """The potential energy, if the kind has one; of a law, if it depends on the kind's coordinate and rate only."""
        kind = self.kind
        if not getattr(kind, "energy", ""):
            return None
        given = [name for name in kind.law_parameters if self._has_law(name)]
        if not given:
            return self.formulas.energy()
        law, coordinate = self.formulas.law(given[0]), next((x for x in ("s", "phi") if x in kind.formulas), None)
        if law is None or coordinate is None or len(given) > 1:
            return None
        rate = self.formulas.signal("v" if coordinate == "s" else "w")
        start = self.values.get(f"{coordinate}0", 0.0)
        return potential(law, self.formulas.signal(coordinate), rate, float(start))

    def _velocity_constraints(self) -> tuple[Expr, ...]:
        if not isinstance(self.kind, JointKind) or not self.kind.velocity_rows:
            return ()
        found = tuple(self.formulas.row(row) for row in self.kind.velocity_rows)
        for name in self.kind.law_parameters:
            modifier = self._modifier(name)
            for row in found:
                try:
                    joint_laws.check_row(name, row, self.kind, self.name)
                except ModelError as problem:
                    raise place(problem, modifier.value.at if modifier and modifier.value else self.at) from None
        return found


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
