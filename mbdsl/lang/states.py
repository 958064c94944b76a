"""States: a variable without a value whose derivative an equation gives, `Real x(start = 1)` with `der(x) = f`.

A state becomes a body with one coordinate (:mod:`mbdsl.elements.state`), whose velocity is its value, and the equation
a force on it.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING

from mbdsl.elements import of_variant
from mbdsl.errors import ModelError
from mbdsl.expressions import spatial_coordinates, symbolic
from mbdsl.lang import argument_checks, units, values
from mbdsl.lang import syntax as s
from mbdsl.lang.evaluate import evaluate
from mbdsl.lang.quantities import unit_text
from mbdsl.lang.source import At, placed, span_of
from mbdsl.lang.units import Dimension
from mbdsl.lang.unparse import write
from mbdsl.lang.values import Quantity, Value
from mbdsl.mechanism.scene import Component, Description, Frame, InitialValue
from mbdsl.mechanism.scene_parts import SpatialFrame
from mbdsl.messages import DisplayUnit

if TYPE_CHECKING:
    from mbdsl.lang.entities import Slot
    from mbdsl.lang.scope import Scope


@dataclass(eq=False)
class DeclaredState:
    """A state: its start, the size of its values, and its equation with the scope of its names."""

    name: str
    start: Quantity
    nominal: float | None
    fixed: bool | None  #: None if nothing is written
    doc: str
    at: At
    unit: str = ""
    equation: s.Relation | None = None
    scope: Scope | None = None
    index: int = 0  #: of an array that an equation defines as a whole, its element from 1; else 0
    law: Quantity | None = None
    rate_at_start: tuple[float, At] | None = None  #: of `der(x) = ...` among the initial equations

    @property
    def frame(self) -> str:
        return f"{self.name}.c"


def derived(items: Iterable[s.Item]) -> dict[str, s.Relation]:
    """Names of the variables whose derivative an equation gives, also within `for` and `if`, and these equations."""
    found = dict[str, s.Relation]()
    for item in items:
        if isinstance(item, s.Relation):
            if (target := target_of(item)) is not None and len(target.steps) == 1:
                found[target.steps[0].name] = item
        elif isinstance(item, s.For):
            found |= derived(item.items)
        elif isinstance(item, s.If):
            found |= derived(x for _, inner in item.branches for x in inner)
    return found


def target_of(item: s.Relation) -> s.Reference | None:
    """x of an equation `der(x) = f`, or of `f = der(x)`; None of other equations."""
    if item.right is None:
        return None
    return derivative(item.left) or derivative(item.right)


def derivative(e: s.Expression) -> s.Reference | None:
    """x of the expression `der(x)` of a name; None of others."""
    if isinstance(e, s.Call) and write(e.function) == "der" and len(e.arguments) == 1:
        inner = e.arguments[0].value
        return inner if isinstance(inner, s.Reference) else None
    return None


class States:
    """The states of a model under construction."""

    def __init__(self, spatial: bool) -> None:
        self._spatial = spatial
        self._states: dict[str, DeclaredState] = {}  # by their frames

    def __bool__(self) -> bool:
        return bool(self._states)

    def __iter__(self) -> Iterator[DeclaredState]:
        return iter(self._states.values())

    def make(self, name: str, start: Value, nominal: Value | None, fixed: bool | None, slot: Slot) -> Value:
        """The value of a declared state, an expression; arrays have one state for each element."""
        if isinstance(start, tuple):
            stem = f"{name[:-1]}," if name.endswith("]") else f"{name}["
            sizes = nominal if isinstance(nominal, tuple) else (nominal,) * len(start)
            if len(sizes) != len(start):
                raise ModelError(f"`nominal` of `{name}`: found {len(sizes)} values, expected {len(start)}")
            each = enumerate(zip(start, sizes, strict=True), 1)
            return tuple(self.make(f"{stem}{i}]", x, size, fixed, slot) for i, (x, size) in each)
        what, size = f"`nominal` of `{name}`", None
        if nominal is not None:
            size = argument_checks.number(values.numeric(nominal, what), what)
            if not size > 0.0:
                raise ModelError(f"{what} is {size:g}, it must be positive")
        state = DeclaredState(name, start, size, fixed, slot.doc, slot.at, slot.unit)
        self._states[state.frame] = state
        return Quantity(self.value(state), start.dimension or units.NUMBER)

    def value(self, state: DeclaredState) -> symbolic.Expr:
        """The expression for the value of a state."""
        if self._spatial:
            return spatial_coordinates.named(state.frame, "vx")
        return symbolic.coordinate(state.frame, "vx")

    def of(self, value: Value | symbolic.Expr) -> DeclaredState | None:
        """The state that a value is; None for other values."""
        leaf = value if isinstance(value, symbolic.Expr) else getattr(value, "value", None)
        if isinstance(leaf, symbolic.Expr) and leaf.op == "coordinate" and leaf.value[1] == "vx":  # type: ignore[index]
            return self._states.get(leaf.value[0])  # type: ignore[index]
        return None

    def define(self, item: s.Relation, scope: Scope) -> None:
        """Enter an equation."""
        target = target_of(item)
        assert target is not None
        found = _declared(target, scope)
        whole = isinstance(found, tuple)
        for k, value in enumerate(found if isinstance(found, tuple) else (found,), 1):
            state = self.of(value)
            if state is None:
                raise _no_state(target)
            if state.equation is not None:
                first = span_of(state.equation.at)
                raise ModelError(
                    f"the derivative of `{state.name}` is given twice",
                    span_of(item.at),
                    notes=(("first given here", first),) if first else (),
                )
            state.equation, state.scope, state.index = item, scope, k if whole else 0

    def rate(self, state: DeclaredState) -> Quantity:
        """The right-hand side of the equation of a state."""
        if state.law is None:
            if state.equation is None or state.scope is None:
                raise ModelError(
                    f"the derivative of `{state.name}` is not given",
                    span_of(state.at),
                    f"write `der({state.name}) = ...;` in the equation section, or give it a value",
                )
            assembly, item = state.scope.namespace.assembly, state.equation
            e = item.right if derivative(item.left) else item.left
            assert e is not None
            with assembly.defining(state, f"der({state.name})", item.at):
                found = evaluate(e, state.scope.for_signals())
                with placed(e.at):
                    state.law = self._fitted(state, found, e)
        return state.law

    def _fitted(self, state: DeclaredState, found: Value, e: s.Expression) -> Quantity:
        """The derivative of a state, checked."""
        what = f"der({state.name})"
        if state.index:
            if not isinstance(found, tuple) or len(found) < state.index:
                raise ModelError(f"{what}: found {values.describe(found)}, expected an array")
            found = found[state.index - 1]
        if isinstance(found, tuple):
            raise ModelError(f"{what}: found {values.describe(found)}, expected a single value")
        expected = per_second(state.start.dimension)
        if state.start.dimension in (None, units.NUMBER) and getattr(found, "dimension", None) == units.NUMBER:
            hint = f"divide by a time, as in `({write(e)})/(1 s)`"
            raise ModelError(f"{what}: found a pure number, expected a number per time [1/s]", hint=hint)
        return values.numeric(argument_checks.fit(found, expected, what, "", e), what)

    # -- the parts of a Scene ------------------------------------------------------------------------------------------

    def components(self, ground: Frame) -> dict[str, Component]:
        """Of each state its body and its equation."""
        found = {}
        for state in self._states.values():
            rate, span = self.rate(state), span_of(state.at)
            kind, equation = (of_variant(x, self._spatial).KIND for x in ("state", "state_rate"))
            given = {"nominal": state.nominal, "rate": state.rate_at_start and state.rate_at_start[0]}
            found[state.name] = Component(state.name, kind, given, span=span, doc=state.doc)
            found[f"der({state.name})"] = Component(
                f"der({state.name})",
                equation,
                {"rate": symbolic.expr(rate.value)},  # type: ignore[arg-type]
                {"frame_a": ground.name, "frame_b": state.frame},
                span=span_of(state.equation.at) if state.equation is not None else span,
            )
        return found

    def frames(self) -> dict[str, Frame]:
        """Of each state its frame."""
        made = SpatialFrame if self._spatial else Frame
        return {x.frame: made(x.frame, x.name, span=span_of(x.at)) for x in self._states.values()}

    def variables(self) -> Iterator[tuple[str, symbolic.Expr, Description]]:
        """Of each state its derivative, as a variable."""
        for state in self:
            rate = symbolic.expr(self.rate(state).value)  # type: ignore[arg-type]
            unit = unit_text(per_second(state.start.dimension))
            unit = "1/s" if unit == "rad/s" and state.unit != "rad" else unit
            yield f"der({state.name})", rate, Description(unit, f"rate of {state.name}")

    def initial(self, given: Mapping[str, InitialValue]) -> Iterator[InitialValue]:
        """The starts of the states that have no other initial value.

        Raises
        ------
        ModelError
            If a state has two initial values.
        """
        for state in self:
            found = [("its value is given here", x.span)] if (x := given.get(state.name)) and x.fixed else []
            if state.rate_at_start is not None:
                found.append(("its derivative is given here", span_of(state.rate_at_start[1])))
            if state.fixed:
                found.append(("its start is fixed here", span_of(state.at)))
            if len(found) > 1:
                notes = tuple((text, span) for text, span in found[1:] if span is not None)
                raise ModelError(f"state `{state.name}` has two initial values", found[0][1], notes=notes)
            if state.name not in given:
                number = argument_checks.number(state.start, f"the start of `{state.name}`")
                dimension = state.start.dimension
                unit = DisplayUnit(unit_text(dimension)) if dimension not in (None, units.NUMBER) else DisplayUnit()  # type: ignore[arg-type]
                kept = state.fixed is not False
                yield InitialValue(state.name, self.value(state), number, kept, span_of(state.at), unit)


def per_second(dimension: Dimension | None) -> Dimension:
    """The dimension of a derivative."""
    return units.multiply(dimension or units.NUMBER, units.dimension("s"), -1)


def refuse_no_state(slot: Slot, d: s.Declaration) -> None:
    """Raise an error if a variable whose derivative an equation gives is not declared as a state."""
    hint = f"a state is declared without a value, `{d.type or 'Real'} {d.name}(start = ...);`"
    word = next((x for x in ("parameter", "constant", "input") if x in d.prefixes), None)
    if word is not None:
        article = "an" if word == "input" else "a"
        raise ModelError(
            f"`{slot.name}` is {article} {word}, an equation cannot give its derivative", span_of(d.at), hint
        )
    if d.type in ("Integer", "Boolean", "String"):
        raise ModelError(
            f"`{slot.name}` is of type {d.type}, a state is a real number", span_of(d.type_at or d.at), hint
        )


def _declared(target: s.Reference, scope: Scope) -> Value:
    """The value of the variable whose derivative an equation gives."""
    from mbdsl.lang.scope import SignalEntity  # which uses this module

    scope = scope.for_signals()
    with placed(target.at):
        entity = scope.resolve(target)
        if isinstance(entity, SignalEntity):
            raise _no_state(target, "motions follow from forces and joints: no equation gives their derivatives")
        return scope.value_of(entity, target)


def _no_state(target: s.Reference, why: str = "") -> ModelError:
    name, hint = write(target), "declare it without a value: `Real x(start = 0);`"
    if why:
        hint = f"to use the derivative of a velocity in a law, filter it: `der(x) = ({name} - x)/T`"
    return ModelError(f"`der({name})`: {why or f'`{name}` already has a value'}", span_of(target.at), hint)
