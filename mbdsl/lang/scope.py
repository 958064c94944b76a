"""Resolution of names: from ``arm.link[3].b.x`` to a parameter, a frame or a signal."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

from mbdsl.elements.kind import BodyKind, JointKind, PairKind
from mbdsl.errors import ModelError
from mbdsl.expressions import spatial_coordinates
from mbdsl.expressions.symbolic import TIME, Expr, expr
from mbdsl.lang import functions, modelica_names, units, values
from mbdsl.lang import syntax as s
from mbdsl.lang.connections import NotConnected, PortNode
from mbdsl.lang.entities import ComponentArray, Disabled, FrameMember, Many, Namespace, Slot, TableMember
from mbdsl.lang.evaluate import Names
from mbdsl.lang.flat_component import ACCELERATIONS, FlatComponent, is_body
from mbdsl.lang.indices import element, positions
from mbdsl.lang.mistakes import doubts, members
from mbdsl.lang.mistakes import names as other_names
from mbdsl.lang.mistakes import references as mistakes
from mbdsl.lang.source import placed, span_of
from mbdsl.lang.unparse import write
from mbdsl.lang.values import Quantity, Value
from mbdsl.mechanism import sections, wrenches
from mbdsl.mechanism.scene import Frame
from mbdsl.mechanism.signal_names import SIZES
from mbdsl.messages import did_you_mean

if TYPE_CHECKING:
    from mbdsl.lang.entities import Entity


class SignalEntity:
    """A name of a quantity that varies."""

    __slots__ = ("_make", "name")

    def __init__(self, name: str, make: Callable[[], Quantity]) -> None:
        self.name = name
        self._make = make

    def value(self) -> Quantity:
        return self._make()


class Varies(ModelError):
    """A value that varies where one is needed that is known before the start."""


class Scope(Names):
    """A place in a model: a namespace, loop variables, and the component whose law is evaluated."""

    __slots__ = ("budget", "law", "locals", "namespace", "owner", "size", "varying")

    def __init__(
        self,
        namespace: Namespace,
        local: dict[str, Value] | None = None,
        varying: bool = False,
        size: int | None = None,
    ) -> None:
        self.namespace = namespace
        self.locals = local or {}
        self.varying = varying
        self.size = size  # of the dimension that is being indexed: the value of `end`
        self.owner: FlatComponent | None = None
        self.law = ""
        self.budget = namespace.assembly.budget

    def with_locals(self, names: dict[str, Value]) -> Scope:
        return self._copy({**self.locals, **names}, self.varying, self.size)

    def for_signals(self) -> Scope:
        return self if self.varying else self._copy(self.locals, True, self.size)

    def for_law(self, owner: FlatComponent, law: str) -> Scope:
        scope = self._copy(self.locals, True, self.size)
        scope.owner, scope.law = owner, law
        return scope

    def with_size(self, size: int) -> Scope:
        """The scope of an index, in which `end` is ``size``."""
        return self._copy(self.locals, self.varying, size)

    def _copy(self, local: dict[str, Value], varying: bool, size: int | None) -> Scope:
        scope = Scope(self.namespace, local, varying, size)
        scope.owner, scope.law = self.owner, self.law
        return scope

    # -- values ------------------------------------------------------------------------------------------------

    def value(self, reference: s.Reference) -> Value:
        steps = reference.steps
        if len(steps) == 1 and not steps[0].indices and steps[0].name in self.locals:
            return self.locals[steps[0].name]
        value = self.value_of(self.resolve(reference), reference)
        if self.owner is not None and len(steps) == 1:
            self._doubt_hidden(self.owner, steps[0].name, value, reference)
        return value

    def _doubt_hidden(self, owner: FlatComponent, name: str, value: Value, reference: s.Reference) -> None:
        """Warn if a value of the model has the name of a signal of the component, which its law may have meant."""
        if name == self.law or not isinstance(self.namespace.find(name), Slot) or isinstance(value, tuple):
            return
        unit = owner.kind.unit_of(name) if name in owner.signal_names() else None
        driver = isinstance(owner.kind, JointKind) and owner.kind.driver == self.law  # its law cannot use signals
        if unit is not None and not driver and value.dimension in (None, units.dimension(unit)):
            doubts.hidden_signal(self.namespace.assembly.warn, name, owner.name, reference.at)

    def rate(self, leaf: Expr) -> Expr | None:
        states = self.namespace.assembly.states
        state = states.of(leaf)
        return None if state is None else expr(states.rate(state).value)  # type: ignore[arg-type]

    def value_of(self, entity: Entity, reference: s.Reference) -> Value:
        if isinstance(entity, SignalEntity):
            if not self.varying:
                raise self._not_constant(entity.name)
            return entity.value()
        if isinstance(entity, Quantity | tuple):
            return entity
        if isinstance(entity, Slot):
            value = entity.value()
            if not self.varying and _varies(value):
                raise self._not_constant(write(reference))
            return value
        if isinstance(entity, Many):
            return tuple(self.value_of(item, reference) for item in entity.items)
        if isinstance(entity, Disabled):
            raise mistakes.disabled(entity, write(reference))
        name = write(reference)
        if isinstance(entity, Frame | PortNode | FrameMember):
            raise ModelError(f"`{name}` is a frame, expected a value", None, f"its signals are {name}.x, .y, .phi, ...")
        if isinstance(entity, TableMember):
            raise ModelError(f"`{name}` is a table, expected a value", None, f"call it: `{name}(time)`")
        if isinstance(entity, FlatComponent):
            known = [n for n in entity.known_names() if "." not in n]
            raise ModelError(
                f"`{name}` is a {entity.kind.name}, expected a value", None, f"it has {', '.join(known[:12])}"
            )
        raise ModelError(f"`{name}` is a component, expected a value")

    def _not_constant(self, name: str) -> Varies:
        return Varies(f"`{name}` varies in time, but this value must be known before the start")

    def last(self) -> Value:
        return super().last() if self.size is None else values.literal(self.size)

    def declared(self, name: str) -> str | None:
        if name in self.locals:
            return ""
        slot = self.namespace.find(name)
        return slot.unit if isinstance(slot, Slot) else None

    def apply(self, reference: s.Reference, argument: Value) -> Value | None:
        name = reference.steps[0].name
        if len(reference.steps) == 1 and name not in self.locals and self.namespace.find(name) is None:
            return None
        entity = self.resolve(reference)
        if not isinstance(entity, TableMember):
            if isinstance(entity, Disabled):
                raise mistakes.disabled(entity, write(reference))
            return None
        return entity.at_argument(argument, self.varying)

    def doubt_angle(self, value: Value, e: s.Expression, what: str) -> None:
        doubts.angle(self.namespace.assembly.warn, value, e, what)

    def function_names(self) -> list[str]:
        library = self.namespace.assembly.library
        own = next(iter(library.units.values())).function_names() if library is not None else []
        return [*own, *(name for name, member in self.namespace.members.items() if isinstance(member, TableMember))]

    def call(self, e: s.Call) -> Value | None:
        assembly = self.namespace.assembly
        if (event := assembly.events.call(e, self)) is not None:
            return event
        library = assembly.library
        if library is None or e.function.at is None:
            return None
        found = library.unit_of(e.function.at[0].file).function(write(e.function))
        if found is None:
            return None
        from mbdsl.lang.function_calls import call

        return call(found, e, self)

    def of_function(self, names: dict[str, Value]) -> Scope:
        """Inside of a function, which knows its own names only."""
        return Scope(Namespace(self.namespace.assembly), dict(names), self.varying)

    # -- names -------------------------------------------------------------------------------------------------

    def resolve(self, reference: s.Reference) -> Entity:
        """The entity that ``reference`` denotes."""
        steps = reference.steps
        first = steps[0]
        if first.name == "Modelica" and (constant := modelica_names.CONSTANTS.get(write(reference))) is not None:
            return Quantity(constant[0], units.dimension(constant[1]))
        entity = self._first(first, reference)
        if first.indices:
            entity = self._index(entity, first, first.name)
        so_far, last = first.name, len(steps) - 1
        for k in range(1, len(steps)):
            step = steps[k]
            entity = self._step(entity, step, so_far)
            if step.indices or k < last:
                so_far = f"{so_far}.{step.name}"
            if step.indices:
                entity = self._index(entity, step, so_far)
        return entity

    def _first(self, step: s.NamePart, reference: s.Reference) -> Entity:
        name = step.name
        if name in self.locals:
            return self.locals[name]
        found = self.namespace.find(name)
        if self.owner is not None and not of_model(found, len(reference.steps) == 1 and _no_value(found, step)):
            own = self._own(self.owner, name)
            if own is not None:
                return own
        if found is not None:
            return found
        if name == "time":
            if not self.varying:
                raise self._not_constant("time")
            return Quantity(TIME, units.dimension("s"))
        if name in functions.CONSTANTS:
            return Quantity(functions.CONSTANTS[name], units.NUMBER)
        if name == "Modelica":
            whole = write(reference)
            raise ModelError(f"unknown name `{whole}`", span_of(reference.at), other_names.constant(whole))
        raise mistakes.unknown(self, name, step.at)

    def _own(self, owner: FlatComponent, name: str) -> Entity | None:
        if name != self.law and name in owner.signal_names():
            return SignalEntity(f"{owner.name}.{name}", lambda: owner.signal(name))
        if name == self.law and any(x.name == name for x in owner.kind.signals):
            # `torque = ...` cannot use itself, and the law `phi` of a driver differs from the measured `phi`.
            return None
        return owner.own(name)

    def _step(self, entity: Entity, step: s.NamePart, owner: str) -> Entity:
        name = step.name
        if isinstance(entity, FlatComponent):
            return self._of_part(entity, step, owner)
        if isinstance(entity, Many):
            return Many([self._step(item, step, owner) for item in entity.items])
        if isinstance(entity, ComponentArray):
            return Many([self._step(item, step, owner) for item in entity.in_order()])
        if isinstance(entity, Disabled):
            return entity
        if isinstance(entity, Namespace):
            found = entity.find(name)
            if found is None:
                hint = did_you_mean(name, entity.names(), f"`{owner}` has")
                raise ModelError(f"`{owner}` has no `{name}`", span_of(step.at), hint)
            return found
        if isinstance(entity, FrameMember):
            if name in ("frame_b", "frame"):  # of a FixedTranslation, and of Fixed in PlanarMechanics
                return entity
            if name == "frame_a" and entity.base is not None:
                return entity.base()
            entity = entity.target()
        if isinstance(entity, Frame | PortNode):
            coordinates = self.namespace.assembly.coordinates
            if name in coordinates:
                return SignalEntity(f"{owner}.{name}", lambda: _coordinate(self.namespace, entity, name))
            if name in ACCELERATIONS:
                raise mistakes.output_only(f"{owner}.{name}", step.at)
            if name in SIZES and f"{name}x" in coordinates:
                raise mistakes.size(f"{owner}.{name}", coordinates, name, step.at)
            assembly, (component, _, port) = self.namespace.assembly, entity.name.rpartition(".")
            kind = part.kind if (part := assembly.parts.get(component)) is not None else None
            if part is not None and isinstance(kind, PairKind) and name in wrenches.units(assembly.spatial):
                return SignalEntity(f"{owner}.{name}", lambda: part.on_port(port, name))
            if part is not None and isinstance(kind, PairKind):
                coordinates = (*coordinates, *wrenches.units(assembly.spatial))
                if name in SIZES and not step.indices:
                    raise mistakes.size(f"{owner}.{name}", coordinates, name, step.at)
            if isinstance(kind, BodyKind) and kind.name in sections.KINDS and name in sections.keys(assembly.spatial):
                raise mistakes.output_only(f"{owner}.{name}", step.at)
            hint = self._in_space(name)
            hint = hint or members.hint(kind, owner, port, "", step, assembly.spatial)
            hint = hint or did_you_mean(name, coordinates, "a frame has")
            raise ModelError(f"the frame `{owner}` has no `{name}`", span_of(step.at), hint)
        kind = "a table" if isinstance(entity, TableMember) else "a value"
        raise ModelError(f"`{owner}` is {kind}, it has no `{name}`", span_of(step.at))

    def _of_part(self, part: FlatComponent, step: s.NamePart, owner: str) -> Entity:
        name = step.name
        if name in part.signal_names():
            return SignalEntity(f"{part.name}.{name}", lambda: part.signal(name))
        found = part.own(name)
        if found is not None:
            return found
        if part.output_only(name):
            raise mistakes.output_only(f"{owner}.{name}", step.at)
        if name in SIZES and f"{name}x" in part.signal_names():
            raise mistakes.size(f"{owner}.{name}", part.signal_names(), name, step.at)
        if part.is_point and name in self.namespace.assembly.coordinates:
            frame = part.frames["c"]
            return SignalEntity(f"{owner}.{name}", lambda: _coordinate(self.namespace, frame, name))
        other = part.by_other_name(name)
        if other is not None:
            return other
        known = part.known_names()
        hint = self._in_space(name) if is_body(part) else None
        frame_a = getattr(part.by_other_name("frame_a"), "name", "").rpartition(".")[2] if is_body(part) else ""
        hint = hint or members.hint(part.kind, owner, "", frame_a, step, self.namespace.assembly.spatial)
        hint = hint or did_you_mean(name, known, "it has")
        raise ModelError(f"{part.kind.name} `{owner}` has no `{name}`", span_of(step.at), hint)

    def _in_space(self, name: str) -> str | None:
        """The remedy for a coordinate that only frames in space have."""
        if self.namespace.assembly.spatial or name not in spatial_coordinates.NAMES:
            return None
        return f"in space it has `{name}`: write `spatial model` at the beginning of the model"

    def _index(self, entity: Entity, step: s.NamePart, owner: str) -> Entity:
        if isinstance(entity, ComponentArray):
            return entity.select(positions(self, step, entity.sizes, owner, "component"), owner, step.at)
        if isinstance(entity, Slot):
            entity = self.value_of(entity, s.Reference((step,), at=step.at))
        if isinstance(entity, Disabled):
            return entity
        if isinstance(entity, tuple):
            return element(self, entity, step, owner)
        raise ModelError(f"`{owner}` is not an array, it has no elements", span_of(step.at))

    # -- frames ------------------------------------------------------------------------------------------------

    def frame(self, e: s.Expression, centred: bool = False) -> Frame | PortNode | FlatComponent | Many | Disabled:
        """The frame that an argument denotes; a joint denotes its two frames, and if ``centred`` a body its centre of
        mass."""
        if not isinstance(e, s.Reference):
            raise ModelError(f"found `{write(e)}`, expected a frame", span_of(e.at), "e.g. `rod.b`, or `ground`")
        with placed(e.at):
            return as_frame(self.resolve(e), e, centred)


def of_model(found: object, no_value: bool) -> bool:
    """Whether a name in a law of a component is the one ``found`` in the model, and not a name of the component.

    As in Modelica, a modifier sees the names around it; the component's own names have lower priority. A component has
    no value, so that `s` in the law of a spring `s` can only mean its length.
    """
    return found is not None and not no_value


def as_frame(
    entity: Entity, e: s.Expression, centred: bool = False
) -> Frame | PortNode | FlatComponent | Many | Disabled:
    """The frame that ``entity``, written as ``e``, denotes; see :meth:`Scope.frame`."""
    if isinstance(entity, Frame | PortNode | Disabled):
        return entity
    if isinstance(entity, FrameMember):
        return entity.target()
    if isinstance(entity, Many):
        return Many([as_frame(item, e, centred) for item in entity.items])
    if isinstance(entity, ComponentArray):
        return Many([as_frame(item, e, centred) for item in entity.in_order()])
    if isinstance(entity, FlatComponent):
        if not is_body(entity):
            return entity
        if entity.is_point or centred:
            return entity.frames["c"]
        name = write(e)
        frames = ", ".join(f"{name}.{f}" for f in entity.frames)
        raise ModelError(f"`{name}` is a {entity.kind.name}, expected one of its frames", None, f"its frames: {frames}")
    name = write(e)
    if isinstance(entity, Namespace):
        connectors = [n for n, m in entity.members.items() if isinstance(m, PortNode | FrameMember)]
        listed = f"its connectors: {', '.join(f'{name}.{c}' for c in connectors)}" if connectors else None
        raise ModelError(f"`{name}` is a sub-model, expected a frame", None, listed)
    raise ModelError(f"`{name}` is {'a table' if isinstance(entity, TableMember) else 'a value'}, expected a frame")


def _coordinate(namespace: Namespace, entity: Frame | PortNode, key: str) -> Quantity:
    frame = entity if isinstance(entity, Frame) else entity.frame
    if frame is None:
        raise NotConnected(f"`{entity.name}` is not connected, it has no `{key}`")
    return namespace.assembly.coordinate(frame, key)


def _varies(value: Value) -> bool:
    return any(_varies(v) for v in value) if isinstance(value, tuple) else value.varying


def _no_value(found: Entity | None, step: s.NamePart) -> bool:
    return isinstance(found, FlatComponent | Namespace | ComponentArray) and not step.indices
