"""States: a variable without a value whose derivative an equation gives, `Real x(start = 1)` with `der(x) = f`.

A state becomes a body with one coordinate (:mod:`mbdsl.elements.state`), whose velocity is its value, and the equation
a force on it.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING

from mbdsl.display_unit import DisplayUnit
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
from mbdsl.mechanism.scene import Component, Frame, InitialValue, SpatialFrame

if TYPE_CHECKING:
    from mbdsl.lang.scope import Scope


@dataclass(eq=False)
class State:
    """A state: its start, the size of its values, and its equation with the scope of its names."""

    name: str
    start: Quantity
    nominal: float | None
    fixed: bool
    doc: str
    at: At
    equation: s.Relation | None = None
    scope: Scope | None = None
    index: int = 0  #: of an array that an equation defines as a whole, its element from 1; else 0
    law: Quantity | None = None

    @property
    def frame(self) -> str:
        return f"{self.name}.c"


def derived(items: Iterable[s.Item]) -> set[str]:
    """Names of the variables whose derivative an equation gives, also within `for` and `if`."""
    found = set()
    for item in items:
        if isinstance(item, s.Relation):
            if (target := target_of(item)) is not None:
                found.add(target.steps[0].name)
        elif isinstance(item, s.For):
            found |= derived(item.items)
        elif isinstance(item, s.If):
            found |= derived(x for _, inner in item.branches for x in inner)
    return found


def target_of(item: s.Relation) -> s.Reference | None:
    """x of an equation `der(x) = f`, or of `f = der(x)`; None of other equations."""
    if item.right is None:
        return None
    return _derivative(item.left) or _derivative(item.right)


def _derivative(e: s.Expression) -> s.Reference | None:
    if isinstance(e, s.Call) and write(e.function) == "der" and len(e.arguments) == 1:
        inner = e.arguments[0].value
        return inner if isinstance(inner, s.Reference) else None
    return None


class States:
    """The states of a model under construction."""

    def __init__(self, spatial: bool) -> None:
        self._spatial = spatial
        self._states: dict[str, State] = {}  # by their frames

    def __bool__(self) -> bool:
        return bool(self._states)

    def make(self, name: str, start: Value, nominal: float | None, fixed: bool, doc: str, at: At) -> Value:
        """The value of a declared state, an expression; arrays have one state for each element."""
        if isinstance(start, tuple):
            stem = f"{name[:-1]}," if name.endswith("]") else f"{name}["
            return tuple(self.make(f"{stem}{i}]", x, nominal, fixed, doc, at) for i, x in enumerate(start, 1))
        state = State(name, start, nominal, fixed, doc, at)
        self._states[state.frame] = state
        return Quantity(self.value(state), start.dimension or units.NUMBER)

    def value(self, state: State) -> symbolic.Expr:
        """The expression for the value of a state."""
        if self._spatial:
            return spatial_coordinates.named(state.frame, "vx")
        return symbolic.coordinate(state.frame, "vx")

    def of(self, value: Value) -> State | None:
        """The state that a value is; None for other values."""
        leaf = getattr(value, "value", None)
        if isinstance(leaf, symbolic.Expr) and leaf.op == "coordinate" and leaf.value[1] == "vx":  # type: ignore[index]
            return self._states.get(leaf.value[0])  # type: ignore[index]
        return None

    def define(self, item: s.Relation, scope: Scope) -> None:
        """Enter an equation."""
        target = target_of(item)
        assert target is not None
        found = evaluate(target, scope.for_signals())
        whole = isinstance(found, tuple)
        for k, value in enumerate(found if isinstance(found, tuple) else (found,), 1):
            state = self.of(value)
            if state is None:
                raise _no_state(target, value)
            if state.equation is not None:
                first = span_of(state.equation.at)
                raise ModelError(
                    f"the derivative of `{state.name}` is given twice",
                    span_of(item.at),
                    notes=(("first given here", first),) if first else (),
                )
            state.equation, state.scope, state.index = item, scope, k if whole else 0

    def rate(self, state: State) -> Quantity:
        """The right-hand side of the equation of a state."""
        if state.law is None:
            if state.equation is None or state.scope is None:
                raise ModelError(
                    f"the derivative of `{state.name}` is not given",
                    span_of(state.at),
                    f"write `der({state.name}) = ...;` in the equation section, or give it a value",
                )
            assembly, item = state.scope.namespace.assembly, state.equation
            e = item.right if _derivative(item.left) else item.left
            assert e is not None
            with assembly.defining(state, f"der({state.name})", item.at):
                found = evaluate(e, state.scope.for_signals())
                with placed(e.at):
                    state.law = self._fitted(state, found, e)
        return state.law

    def _fitted(self, state: State, found: Value, e: s.Expression) -> Quantity:
        """The derivative of a state, checked."""
        what = f"der({state.name})"
        if state.index:
            if not isinstance(found, tuple) or len(found) < state.index:
                raise ModelError(f"{what}: found {values.describe(found)}, expected an array")
            found = found[state.index - 1]
        if isinstance(found, tuple):
            raise ModelError(f"{what}: found {values.describe(found)}, expected a single value")
        return values.numeric(argument_checks.fit(found, per_second(state.start.dimension), what, "", e), what)

    # -- the parts of a Scene ------------------------------------------------------------------------------------------

    def components(self, ground: Frame) -> dict[str, Component]:
        """Of each state its body and its equation."""
        found = {}
        for state in self._states.values():
            rate, span = self.rate(state), span_of(state.at)
            kind, equation = (of_variant(x, self._spatial).KIND for x in ("state", "state_rate"))
            found[state.name] = Component(state.name, kind, {"nominal": state.nominal}, span=span, doc=state.doc)
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

    def initial(self, given: Mapping[str, InitialValue]) -> Iterator[InitialValue]:
        """The starts of the states that have no other initial value."""
        for state in self._states.values():
            if state.name not in given:
                what = f"the start of `{state.name}`"
                number = argument_checks.number(state.start, what)
                dimension = state.start.dimension
                unit = DisplayUnit(unit_text(dimension)) if dimension not in (None, units.NUMBER) else DisplayUnit()  # type: ignore[arg-type]
                yield InitialValue(state.name, self.value(state), number, state.fixed, span_of(state.at), unit)


def per_second(dimension: Dimension | None) -> Dimension:
    """The dimension of a derivative."""
    return units.multiply(dimension or units.NUMBER, units.dimension("s"), -1)


def _no_state(target: s.Reference, value: Value) -> ModelError:
    name, hint = write(target), "declare it without a value: `Real x(start = 0);`"
    message = f"`der({name})`: `{name}` is not a variable whose derivative can be given"
    if isinstance(value, Quantity) and isinstance(value.value, symbolic.Expr):
        if symbolic.is_velocity_level(value.value):
            message = f"`der({name})`: accelerations follow from forces and cannot be given"
            hint = f"to use the derivative of a velocity in a law, filter it: `der(x) = ({name} - x)/T`"
        else:
            message = f"`der({name})`: `{name}` already has a value"
    return ModelError(message, span_of(target.at), hint)
