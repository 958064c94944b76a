"""When-equations and discrete variables: from the syntax tree to :mod:`mbdsl.mechanism.events`."""

from __future__ import annotations

from collections.abc import Collection, Iterable
from fractions import Fraction
from typing import TYPE_CHECKING

from mbdsl.errors import ModelError, Span
from mbdsl.expressions import symbolic
from mbdsl.expressions.symbolic import Expr, input_signal
from mbdsl.lang import argument_checks, units, values
from mbdsl.lang import syntax as s
from mbdsl.lang.assertions import parts
from mbdsl.lang.evaluate import evaluate, loop
from mbdsl.lang.event_functions import FUNCTIONS
from mbdsl.lang.mistakes import events as mistakes
from mbdsl.lang.source import At, placed, span_of
from mbdsl.lang.states import States
from mbdsl.lang.unparse import write
from mbdsl.lang.values import Quantity, Value
from mbdsl.mechanism.contacts import NUMBERS
from mbdsl.mechanism.events import INITIAL, TERMINAL, Action, Branch, Clock, Discrete, Events, WhenEquation
from mbdsl.mechanism.scene_parts import Component

if TYPE_CHECKING:
    from mbdsl.lang.scope import Scope

#: largest denominator of a time that counts as exact, and the rounding error of a number
SIMPLE, EPS = 1_000_000, 2.0**-52
SAMPLE = "write `sample(start, period)`, such as `sample(0 s, 0.1 s)`"


def assigned(items: Iterable[s.Item]) -> set[str]:
    """Names of the variables that when-equations set."""
    found = set()
    for item in items:
        if isinstance(item, s.When):
            found |= {x for _, inner in item.branches for x in _targets(inner)}
        elif isinstance(item, s.For):
            found |= assigned(item.items)
        elif isinstance(item, s.If):
            found |= assigned(x for _, inner in item.branches for x in inner)
    return found


def _targets(items: Iterable[s.Item]) -> set[str]:
    found = set()
    for item in items:
        if isinstance(item, s.Relation) and item.right is not None and isinstance(item.left, s.Reference):
            found.add(item.left.steps[0].name)
        elif isinstance(item, s.When):  # a mistake of its own
            found |= assigned([item])
        elif isinstance(item, s.For):
            found |= _targets(item.items)
        elif isinstance(item, s.If):
            found |= _targets(x for _, inner in item.branches for x in inner)
    return found


class EventsOfModel:
    """The discrete variables, clocks and when-equations of a model under construction."""

    def __init__(self, states: States) -> None:
        self._states = states
        self._variables: dict[str, Discrete] = {}
        self._clocks: dict[str, Clock] = {}
        self._whens: list[tuple[s.When, Scope]] = []
        self._assertions: list[tuple[s.Relation, Scope]] = []

    def __bool__(self) -> bool:
        return bool(self._whens or self._assertions)

    # -- values --------------------------------------------------------------------------------------------------------

    def make(self, name: str, type_name: str, start: Value, unit: str, doc: str, at: At) -> Value:
        """The value of a discrete variable, an expression; arrays have one for each element."""
        if isinstance(start, tuple):
            stem = f"{name[:-1]}," if name.endswith("]") else f"{name}["
            return tuple(self.make(f"{stem}{i}]", type_name, x, unit, doc, at) for i, x in enumerate(start, 1))
        number = float(bool(start.value)) if start.boolean else argument_checks.number(start, f"the start of `{name}`")
        self._add(Discrete(name, number, type_name or "Real", unit, doc, span_of(at)))
        return self._leaf(name, type_name == "Boolean", start.dimension)

    def _add(self, variable: Discrete) -> None:
        self._variables[variable.name] = variable

    def _leaf(self, name: str, truth: bool, dimension: units.Dimension | None) -> Quantity:
        leaf = input_signal(name)
        if truth:
            return values.boolean(symbolic.call("ne", leaf, 0.0))
        return Quantity(leaf, dimension or units.NUMBER)

    def variable(self, value: Value) -> str | None:
        """The name of the discrete variable that a value is; None of other values."""
        x = getattr(value, "value", None)
        if isinstance(x, Expr) and x.op == "ne" and x.args[0].op == "input":
            x = x.args[0]
        name = str(x.value) if isinstance(x, Expr) and x.op == "input" else ""
        return name if self._variables.get(name, Discrete("")).type else None

    # -- functions -----------------------------------------------------------------------------------------------------

    def call(self, e: s.Call, scope: Scope) -> Value | None:
        """The value of a function of events; None of other functions."""
        name = write(e.function)
        if name not in FUNCTIONS:
            return None
        given = [a.value for a in e.arguments if a.value is not None]
        wanted = {"pre": 1, "edge": 1, "change": 1, "sample": 2}.get(name, 0)
        if len(given) != wanted:
            hint = SAMPLE if name == "sample" else f"write `{name}(x)` for a variable x" if wanted else None
            raise ModelError(f"{name}() takes {wanted} argument{'s' * (wanted != 1)}, found {len(given)}", hint=hint)
        if name in ("initial", "terminal"):
            return self._truth(INITIAL if name == "initial" else TERMINAL)
        if name == "sample":
            return self._sample(given, scope)
        return self._of_variable(name, evaluate(given[0], scope.for_signals()), given[0], scope)

    def _of_variable(self, name: str, value: Value, e: s.Expression, scope: Scope) -> Value:
        """pre(x), edge(x) or change(x); of an array, that of each element."""
        if isinstance(value, tuple):
            return tuple(self._of_variable(name, x, e, scope) for x in value)
        past = self._past(value, scope)
        if past is None:
            raise mistakes.no_discrete(name, e, value)
        if name == "pre":
            return past
        differs = symbolic.call("ne", symbolic.expr(value.value), symbolic.expr(past.value))  # type: ignore[arg-type]
        if name == "change":
            return values.boolean(differs)
        if not value.boolean:
            hint = f"`change({write(e)})` is true where a number changes"
            raise ModelError(f"edge() takes a Boolean, found {values.describe(value)}", span_of(e.at), hint)
        return values.boolean(symbolic.call("and", symbolic.expr(value.value), differs))  # type: ignore[arg-type]

    def _past(self, value: Quantity, scope: Scope) -> Quantity | None:
        """The value before an event of what only events change: discrete variables, and numbers of contacts, such as
        that of their impacts."""
        read = symbolic.leaves(value.value) if isinstance(value.value, Expr) else []
        parts = scope.namespace.assembly.parts
        for name in (str(x.value) for x in read):
            contact, _, number = name.rpartition(".")
            counted = number in NUMBERS and (contact in parts or contact.rpartition(".")[0] in parts)
            if not (self._variables.get(name, Discrete("")).type or counted):
                return None
            self._add(Discrete(f"pre({name})", self._variables.get(name, Discrete("")).start))
        past = {x: input_signal(f"pre({x.value})") for x in read}
        if not read:
            return None
        before = symbolic.substitute(symbolic.expr(value.value), past.get)  # type: ignore[arg-type]
        return values.boolean(before) if value.boolean else Quantity(before, value.dimension)

    def _truth(self, name: str) -> Quantity:
        self._add(Discrete(name))
        return self._leaf(name, True, None)

    def _sample(self, given: list[s.Expression], scope: Scope) -> Quantity:
        start, period = (_seconds(e, scope) for e in given)
        if period <= 0:
            message = f"the period of sample() is {float(period):g} s, it must be positive"
            raise ModelError(message, span_of(given[1].at), SAMPLE)
        name = f"sample({float(start):.17g}, {float(period):.17g})"
        self._clocks.setdefault(name, Clock(name, start, period, span_of(given[1].at)))
        return self._truth(name)

    # -- when-equations ------------------------------------------------------------------------------------------------

    def enter(self, item: s.When, scope: Scope) -> None:
        self._whens.append((item, scope))

    def watch(self, item: s.Relation, scope: Scope) -> None:
        """Enter an assertion whose condition varies: it is checked at the start, and where it becomes false."""
        self._assertions.append((item, scope))

    def _assertion(self, item: s.Relation, scope: Scope) -> WhenEquation:
        action = self._call(item, scope.for_signals())
        at_start = symbolic.expr(self._truth(INITIAL).value)  # type: ignore[arg-type]
        assert action.value is not None
        holds = action.value if action.what == "assert" else action.value.args[0]
        return WhenEquation((Branch((symbolic.call("not", holds), at_start), (action,), action.span),))

    def finished(self, at_rest: Collection[str]) -> Events:
        """The events of the model, checked; ``at_rest`` are the frames that do not move."""
        whens = tuple(self._when(item, scope) for item, scope in self._whens)
        whens += tuple(self._assertion(item, scope) for item, scope in self._assertions)
        self._single(whens)
        for action in (a for when in whens for branch in when.branches for a in branch.actions):
            read = symbolic.leaves(*(() if action.signal is None else (action.signal,)))
            if read and all(x.op == "coordinate" and x.value[0] in at_rest for x in read):
                hint = "`reinit` changes a velocity of a body or a joint, or a state"
                raise ModelError(f"reinit of `{action.target}`: it does not move", action.span, hint)
        found = Events(dict(self._variables), tuple(self._clocks.values()), whens)
        if circle := found.circle():
            first = {a.target: a.span for b in reversed(found.branches) for a in reversed(b.actions) if a.what == "set"}
            notes = tuple((f"{x} is set here", span) for x in circle[1:-1] if (span := first[x]) is not None)
            raise ModelError(
                f"cyclic definition: {' -> '.join(circle)}",
                first[circle[0]],
                f"break the circle by the value before the event, `pre({circle[-1]})`",
                notes=notes[:5],
            )
        return found

    def refuse_instants(self, components: Iterable[Component]) -> None:
        """Refuse laws that read `sample()`, `initial()` or `terminal()`: these are true in events only."""
        mistakes.refuse_instants({INITIAL, TERMINAL, *self._clocks} & self._variables.keys(), components)

    def _when(self, item: s.When, scope: Scope) -> WhenEquation:
        scope = scope.for_signals()
        branches = []
        for condition, items in item.branches:
            found = evaluate(condition, scope)
            each = found if isinstance(found, tuple) else (found,)
            for q in each:
                if isinstance(q, tuple) or not q.boolean:
                    raise ModelError(
                        f"`when` takes a condition (true or false), found {values.describe(q)}",
                        span_of(condition.at),
                        f"compare it with a threshold: `when {write(condition)} > ... then`",
                    )
            self._refuse_equality(condition, scope)
            conditions = tuple(symbolic.expr(q.value) for q in each)  # type: ignore[union-attr,arg-type]
            if any(n.value == symbolic.QUIET for n in symbolic.walk(*conditions)):
                message = "`when` needs the event that noEvent() leaves out"
                raise ModelError(message, span_of(condition.at), "write the condition without it")
            branches.append(Branch(conditions, tuple(self._actions(items, scope)), span_of(condition.at)))
        return WhenEquation(tuple(branches))

    def _refuse_equality(self, condition: s.Expression, scope: Scope) -> None:
        """Refuse `a == b` of values that move: they are never equal for a time, and it would never act."""
        for e in s.inside(condition):
            if isinstance(e, s.Binary) and e.operator == "==":
                sides = [evaluate(x, scope) for x in (e.left, e.right)]
                read = symbolic.leaves(*(symbolic.expr(q.value) for q in sides if isinstance(q, Quantity)))  # type: ignore[arg-type]
                if any(x.op != "input" or self._states.of(x) is not None for x in read):
                    raise mistakes.never_equal(e)

    def _actions(self, items: Iterable[s.Item], scope: Scope) -> Iterable[Action]:
        for item in items:
            if isinstance(item, s.For):
                for inner in loop(item.iterators, scope):
                    yield from self._actions(item.items, inner)
            elif isinstance(item, s.If):
                yield from self._chosen(item, scope)
            elif isinstance(item, s.Relation):
                yield from self._assignment(item, scope) if item.right is not None else [self._call(item, scope)]
            else:
                raise ModelError(f"found `{_first_word(item)}` in a `when`", span_of(item.at), mistakes.HOLDS)

    def _chosen(self, item: s.If, scope: Scope) -> Iterable[Action]:
        """The actions of the branch of an `if` of parameters."""
        for condition, items in item.branches:
            value = None if condition is None else evaluate(condition, scope)
            if value is not None and (isinstance(value, tuple) or not isinstance(value.value, bool)):
                raise ModelError(
                    "an `if` within a `when` depends on parameters only",
                    span_of(item.at),
                    "choose the value: `x = if condition then a else b;`",
                )
            if value is None or value.value:
                yield from self._actions(items, scope)
                return

    def _assignment(self, item: s.Relation, scope: Scope) -> Iterable[Action]:
        assert item.right is not None
        target, value = evaluate(item.left, scope), evaluate(item.right, scope)
        targets = target if isinstance(target, tuple) else (target,)
        given = value if isinstance(value, tuple) else (value,) * len(targets)
        if len(given) != len(targets):
            raise ModelError(f"found an array of {len(given)} for {len(targets)} variables", span_of(item.right.at))
        for t, v in zip(targets, given, strict=True):
            name = self.variable(t)
            if name is None:
                raise self._not_discrete(item.left, t)
            value = self._fitted(t, v, name, item.right)
            if self._variables[name].type == "Integer" and not self.whole(value):
                raise ModelError(
                    f"`{name}` is a whole number, found `{write(item.right)}`",
                    span_of(item.right.at),
                    "round it: `floor(...)` or `ceil(...)`",
                )
            yield Action("set", name, value, span=span_of(item.left.at))

    def whole(self, x: Expr) -> bool:
        """Whether an expression has whole values, by its form."""
        if x.op == "const":
            return float(x.value) == round(float(x.value))
        if x.op == "input":
            name = str(x.value).removeprefix("pre(").removesuffix(")")
            return self._variables.get(name, Discrete("")).type in ("Integer", "Boolean")
        if x.op in ("floor", "ceil", "sign", "lt", "le", "eq", "ne", "and", "or", "not"):
            return True
        if x.op == "select":
            return all(map(self.whole, x.args[1:]))
        return x.op in ("add", "sub", "mul", "neg", "abs", "min", "max", "mod") and all(map(self.whole, x.args))

    def _not_discrete(self, e: s.Expression, target: Value) -> ModelError:
        x, text = getattr(target, "value", None), write(e)
        hint = f"declare it without a value: `discrete Real {text}(start = ...);`"
        if isinstance(e, s.Call):
            hint = f"set a variable and use it in the equation, as in `{text} = (if on then 1 else 0)/(1 s);`"
        if self._states.of(target) is not None or (isinstance(x, Expr) and symbolic.is_velocity_level(x)):
            hint = f"a state or a velocity jumps by `reinit({text}, ...)`"
        elif isinstance(x, Expr) and x.op == "input":
            hint = "inputs are given by `--input` or by a Simulation: set another variable"
        return ModelError(f"`{text}` is no discrete variable: a `when` cannot set it", span_of(e.at), hint)

    def _fitted(self, target: Value, value: Value, name: str, e: s.Expression) -> Expr:
        """A value for a variable, of its type and dimension."""
        what = f"`{name}`"
        assert isinstance(target, Quantity)
        with placed(e.at):
            if isinstance(value, tuple) or value.boolean != target.boolean:
                wanted = "true or false" if target.boolean else "a number"
                hint = "write `true` or `false`, or a comparison" if target.boolean else None
                raise ModelError(f"{what}: found {values.describe(value)}, expected {wanted}", hint=hint)
            if target.boolean:
                return symbolic.expr(value.value)  # type: ignore[arg-type]
            return symbolic.expr(argument_checks.fit(value, target.dimension, what, "", e).value)  # type: ignore[union-attr,arg-type]

    def _call(self, item: s.Relation, scope: Scope) -> Action:
        """reinit(x, value), terminate("text") or assert(condition, "text")."""
        call = item.left
        name = write(call.function) if isinstance(call, s.Call) else ""
        given = [a.value for a in call.arguments if a.value is not None] if isinstance(call, s.Call) else []
        span = span_of(item.at)
        if name == "terminate" and len(given) == 1 and isinstance(given[0], s.String):
            return Action("terminate", "", None, None, _text(given[0]), span)
        if name == "assert":
            condition, text, warns = parts(item)
            found = evaluate(condition, scope)
            if isinstance(found, tuple) or not found.boolean:
                raise ModelError(
                    f"assert() takes a condition (true or false), found {values.describe(found)}",
                    span_of(condition.at),
                )
            value = symbolic.expr(found.value)  # type: ignore[arg-type]
            return (
                self._warning(condition, value, text, span)
                if warns
                else Action("assert", write(condition), value, None, text, span)
            )
        if name == "reinit" and len(given) == 2:
            target, value = evaluate(given[0], scope), evaluate(given[1], scope)
            return self._reinit(given, target, value, span)
        raise mistakes.no_action(call, span)

    def _warning(self, condition: s.Expression, value: Expr, text: str, span: Span | None) -> Action:
        """An assertion that is a warning only counts how often it is false."""
        name = f"assert({len(self._variables)})"
        before = f"pre({name})"
        self._add(Discrete(name))
        self._add(Discrete(before))
        count = input_signal(before)
        found = symbolic.call("select", value, count, count + 1.0)
        return Action("set", name, found, None, f"`{write(condition)}` is false: {text}", span)

    def _reinit(self, given: list[s.Expression], target: Value, value: Value, span) -> Action:
        name = write(given[0])
        if isinstance(target, tuple) or not isinstance(target.value, Expr):
            raise ModelError(f"reinit() takes a state or a velocity, found `{name}`", span_of(given[0].at))
        if self.variable(target) is not None:
            hint = f"a discrete variable is set: `{name} = ...;`"
            raise ModelError(f"reinit() takes a state or a velocity, found `{name}`", span_of(given[0].at), hint)
        if self._states.of(target) is None and not symbolic.is_velocity_level(target.value):
            hint = "give the velocity another value: `reinit(joint.v, ...)`"
            raise ModelError(f"reinit of `{name}`: positions do not jump", span_of(given[0].at), hint)
        number = self._fitted(target, value, name, given[1])
        return Action("reinit", name, number, target.value, span=span)

    def _single(self, whens: tuple[WhenEquation, ...]) -> None:
        """Check that no variable is set by two when-equations."""
        by: dict[str, tuple[int, Action]] = {}
        for k, when in enumerate(whens):
            for action in (a for branch in when.branches for a in branch.actions if a.what == "set"):
                number, first = by.setdefault(action.target, (k, action))
                if number != k:
                    notes = (("the first one is here", first.span),) if first.span else ()
                    raise ModelError(
                        f"`{action.target}` is set by two when-equations",
                        action.span,
                        "write one `when ... elsewhen ...`",
                        notes=notes,
                    )
            for branch in when.branches:
                seen: dict[object, Action] = {}
                for action in (a for a in branch.actions if a.what in ("set", "reinit")):
                    key = action.target if action.signal is None else action.signal
                    if (first := seen.setdefault(key, action)) is not action:
                        notes = (("the first time is here", first.span),) if first.span else ()
                        raise ModelError(f"`{action.target}` is set twice in one event", action.span, notes=notes)


def _text(e: s.Expression) -> str:
    return e.value if isinstance(e, s.String) else write(e)


def _seconds(e: s.Expression, scope: Scope) -> Fraction:
    """A time that is known before the start, as an exact fraction: a simple one such as 1/3, or its decimals."""
    with placed(e.at):
        value = argument_checks.fit(evaluate(e, scope), units.dimension("s"), "sample()", "s", e)
        number = argument_checks.number(value, "sample()")  # type: ignore[arg-type]
    simple = Fraction(number).limit_denominator(SIMPLE)
    rounded = abs(float(simple) - number) <= 4.0 * EPS * abs(number)
    return simple if rounded else Fraction(repr(float(f"{number:.15g}")))


def _first_word(item: s.Item) -> str:
    return {s.When: "when", s.Connect: "connect"}.get(type(item), "annotation")
