"""Initial values: from ``initial equation`` sections and from ``start`` modifiers."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator
from functools import lru_cache

from mbdsl.errors import ModelError, Span
from mbdsl.expressions import symbolic
from mbdsl.lang import argument_checks, values
from mbdsl.lang import syntax as s
from mbdsl.lang.evaluate import evaluate
from mbdsl.lang.flat_component import FlatComponent
from mbdsl.lang.mistakes import doubts
from mbdsl.lang.quantities import unit_text
from mbdsl.lang.scope import Scope
from mbdsl.lang.source import At, placed, span_of
from mbdsl.lang.states import DeclaredState, States, derivative, per_second
from mbdsl.lang.units import NUMBER, Dimension, Unit
from mbdsl.lang.unparse import write
from mbdsl.lang.values import Quantity, Value
from mbdsl.mechanism.given_attitudes import given_attitudes
from mbdsl.mechanism.scene import InitialValue
from mbdsl.messages import DisplayUnit

STATES = {"steady": True, "static": True, "given": False}  #: values of ``initial(state = ...)``


def is_steady(item: s.Initial) -> bool:
    """Whether ``initial(state = ...)`` means the equilibrium.

    Raises
    ------
    ModelError
        If it is not a state.
    """
    name, value = write(item.target), write(item.value)
    if name != "state":
        raise ModelError(f"initial has no `{name}`", span_of(item.target.at), "write `initial(state = steady);`")
    if value not in STATES:
        hint = "`steady` is the equilibrium; `given` are the initial values"
        raise ModelError(f"found the state `{value}`, expected steady or given", span_of(item.value.at), hint)
    return STATES[value]


def check_steady(item: s.Initial, given: Iterable[InitialValue], states: Collection[symbolic.Expr] = ()) -> None:
    """Check that a model that starts at its equilibrium has no initial values that contradict it; those of ``states``
    are where the search for the equilibrium begins.

    Raises
    ------
    ModelError
        If a position is fixed, or a velocity is not zero.
    """
    for x in given:
        if x.target in states:
            continue
        if symbolic.is_velocity_level(x.target):
            wrong = x.value != 0.0
            message, hint = f"`{x.name}` is {x.value:g}, and the model is at rest where it starts", "omit this velocity"
        else:
            wrong, message = x.fixed, f"`{x.name}` is fixed, and the model starts at its equilibrium"
            hint = f"write `guess {x.name} = ...`: the equilibrium that is reached from there"
        if wrong:
            notes = ((f"`initial({write(item.target)} = {write(item.value)})` is here", span_of(item.at)),)
            raise ModelError(message, x.span, hint, notes=notes if notes[0][1] else ())


class InitialValues:
    """The initial values of a model."""

    def __init__(
        self,
        parts: Iterable[FlatComponent],
        equations: list[tuple[s.Initial, Scope]],
        warn: doubts.Warn,
        states: States,
    ) -> None:
        self.parts = parts
        self.states = states
        self.warn = warn
        self.equations = equations

    def values(self) -> Iterator[InitialValue]:
        """One value for each name: fixed values override guesses, later guesses override earlier ones."""
        found: dict[str, tuple[InitialValue, At]] = {}
        for initial, at in [*self._starts(), *self._given()]:
            before = found.get(initial.name)
            if before is not None and before[0].fixed:
                if not initial.fixed:
                    continue
                first = span_of(before[1])
                raise ModelError(
                    f"the initial value of `{initial.name}` is fixed twice",
                    initial.span,
                    notes=(("first fixed here", first),) if first else (),
                )
            found[initial.name] = (initial, at)
        given_attitudes(initial for initial, _ in found.values())  # it checks them
        return (initial for initial, _ in found.values())

    def _starts(self) -> Iterator[tuple[InitialValue, At]]:
        """Modifiers like ``phi(start = 10 deg, fixed = true)``."""
        for part in self.parts:
            modifiers = part.template.modifiers
            if not modifiers:
                continue
            for signal in part.kind.signals:
                modifier = modifiers.get(signal.name)
                if modifier is None or not modifier.inner or modifier.value is not None:
                    continue
                name = f"{part.name}.{signal.name}"
                start, fixed = modifier.inner.get("start"), modifier.inner.get("fixed")
                keep = False
                if fixed is not None and fixed.value is not None:
                    decided = fixed.pick(fixed.evaluate(), 0, part.contexts)
                    if isinstance(decided, tuple) or not isinstance(decided.value, bool):
                        raise ModelError(
                            f"`fixed` is true or false, found {values.describe(decided)}", fixed.value_span()
                        )
                    keep = decided.value
                given = start if start is not None and start.value is not None else None
                if given is None and not keep:
                    continue
                source = given or modifier  # as in Modelica, the start is zero unless it is given
                with placed(source.value.at if source.value is not None else source.at):
                    value = Quantity(0.0) if given is None else given.pick(given.evaluate(), 0, part.contexts)
                    target = part.signal(signal.name)
                    yield self._initial_value(name, target, value, keep, source.at, source.value), source.at

    def _given(self) -> Iterator[tuple[InitialValue, At]]:
        """The initial equations."""
        known: dict[int, Value] = {}  # numbers in loops, by their places in the tree
        for item, scope in self.equations:
            if rates := self._rates_of(item, scope):
                self._give_rates(rates, evaluate(item.value, scope), item)
                continue
            name, target = self._target(item.target, scope.for_signals())
            value = known.get(id(item.value)) or evaluate(item.value, scope)
            if isinstance(item.value, s.Number):
                known[id(item.value)] = value
            targets, given = [target], [value]
            if isinstance(target, tuple):
                targets = list(target)
                given = list(value) if isinstance(value, tuple) else [value] * len(targets)
                if len(given) != len(targets):
                    raise ModelError(
                        f"found an array of {len(given)} for {len(targets)} initial values", span_of(item.value.at)
                    )
            for k, (t, v) in enumerate(zip(targets, given, strict=True)):
                label = f"{name}[{k + 1}]" if isinstance(target, tuple) else name
                with placed(item.at):
                    assert isinstance(t, Quantity)
                    if (state := self.states.of(t)) is not None:
                        label = state.name
                    yield self._initial_value(label, t, v, item.mode == "fixed", item.at, item.value), item.at

    def _rates_of(self, item: s.Initial, scope: Scope) -> list[DeclaredState]:
        """The states of an initial equation ``der(x) = ...``; [] of others."""
        if not self.states or (inner := derivative(item.target)) is None:
            return []
        found = scope.for_signals().value(inner)
        states = [self.states.of(x) for x in (found if isinstance(found, tuple) else (found,))]
        return [x for x in states if x is not None]

    def _give_rates(self, states: list[DeclaredState], value: Value, item: s.Initial) -> None:
        given = value if isinstance(value, tuple) else (value,) * len(states)
        if len(given) != len(states):
            raise ModelError(f"found an array of {len(given)} for {len(states)} states", span_of(item.value.at))
        for state, x in zip(states, given, strict=True):
            what = f"the initial value of `der({state.name})`"
            with placed(item.value.at):
                x = values.numeric(
                    argument_checks.fit(x, per_second(state.start.dimension), what, "", item.value), what
                )
                number = argument_checks.number(x, what)
            if state.rate_at_start is not None:
                first = span_of(state.rate_at_start[1])
                notes = (("first given here", first),) if first else ()
                raise ModelError(f"{what} is given twice", span_of(item.at), notes=notes)
            state.rate_at_start = number, item.at

    def _target(self, target: s.Expression, scope: Scope) -> tuple[str, Value]:
        """Name and value of the left side of an initial equation: a signal, or der(signal)."""
        if isinstance(target, s.Reference):
            with placed(target.at):
                entity = scope.resolve(target)
                return getattr(entity, "name", None) or write(target), scope.value_of(entity, target)
        inner = target.arguments[0].value if isinstance(target, s.Call) and len(target.arguments) == 1 else None
        if isinstance(inner, s.Reference) and isinstance(target, s.Call) and write(target.function) == "der":
            name, found = self._target(inner, scope)
            refuse_acceleration(name, found, target.at)
            return f"der({name})", evaluate(target, scope)
        raise ModelError(
            f"found `{write(target)}` on the left of an initial equation, expected a signal",
            span_of(target.at),
            "e.g. `crank.phi = 30 deg;` or `guess rod.w = 1 rad/s;`",
        )

    def _initial_value(
        self, name: str, target: Quantity, value: Value, fixed: bool, at: At, e: s.Expression | None = None
    ) -> InitialValue:
        if isinstance(value, tuple):
            raise ModelError(f"found {values.describe(value)} for `{name}`, expected a single value")
        check_target(name, target.value, span_of(at))
        what = f"the initial value of `{name}`"
        if target.dimension == NUMBER:
            doubts.angle(self.warn, value, e, what)
        number = argument_checks.number(argument_checks.fit(value, target.dimension, what, "", e), what)
        return InitialValue(name, target.expression, number, fixed, span_of(at), _display(value.unit, target.dimension))


@lru_cache
def _display(unit: Unit | None, dimension: Dimension | None) -> DisplayUnit:
    """The unit that a value was written with, else the SI unit of the target, whose dimension is given."""
    if unit is not None and unit.dimension == dimension:
        return DisplayUnit(unit.text, unit.factor)
    if dimension is None or dimension == NUMBER:  # radians and pure numbers are not distinguished
        return DisplayUnit()
    return DisplayUnit(unit_text(dimension))


def refuse_acceleration(name: str, found: Value, at: At) -> None:
    """An error if a value, whose derivative an initial equation gives, is a velocity."""
    if (
        isinstance(found, Quantity)
        and isinstance(found.value, symbolic.Expr)
        and symbolic.is_velocity_level(found.value)
    ):
        raise ModelError(
            f"the initial value of `der({name})`, an acceleration, follows from the forces",
            span_of(at),
            "give the positions in which the forces balance, or begin at the equilibrium: `initial(state = steady);`",
        )


def check_target(name: str, target: object, span: Span | None) -> None:
    """Check that a signal varies, and is a function of positions and velocities only.

    Raises
    ------
    ModelError
        If not; ``name`` is that of the signal.
    """
    leaves = symbolic.leaves(target) if isinstance(target, symbolic.Expr) else []
    if not leaves:
        raise ModelError(f"`{name}` cannot be given an initial value: it does not vary", span)
    for leaf in leaves:
        if leaf.op in ("multiplier", "input"):
            what = "a reaction" if leaf.op == "multiplier" else "an input or a discrete variable"
            raise ModelError(
                f"`{name}` depends on {what}; only positions and velocities have initial values",
                span,
                "a discrete variable or an input begins at its `start`, as in `discrete Real x(start = 3);`"
                if leaf.op == "input"
                else "reactions follow from the motion",
            )
    if any(leaf.op == "time" for leaf in leaves):
        raise ModelError(f"`{name}` depends on time; only positions and velocities have initial values", span)
