"""Expressions of signals, such as ``hypot(A.fx, A.fy)``, in the place of names: read and checked as laws are."""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping
from contextlib import suppress
from functools import cached_property

from mbdsl.elements.declaration import ANY
from mbdsl.errors import MbdslError, ModelError, SyntaxProblem, UsageError
from mbdsl.expressions.symbolic import TIME, Expr, expr, input_signal, is_const, leaves
from mbdsl.lang import functions, units
from mbdsl.lang import syntax as s
from mbdsl.lang.evaluate import Budget, Names, evaluate
from mbdsl.lang.parser import parse_expression
from mbdsl.lang.quantities import unit_text
from mbdsl.lang.unparse import write
from mbdsl.lang.values import Quantity, Value, describe, numeric
from mbdsl.mechanism.scene import Scene
from mbdsl.mechanism.signal_names import SignalNames
from mbdsl.messages import did_you_mean

#: a signal or a parameter: its value and its unit
Operand = tuple[Expr | float, str]
#: operations whose value is an angle if all of their arguments are
_KEEPING = ("add", "sub", "neg", "abs", "min", "max", "hypot", "mod", "select")


class AskedSignals(SignalNames):
    """The signals of a scene and, wherever a name is given, expressions of them and of parameters."""

    @cached_property
    def _read(self) -> dict[str, tuple[Expr, str] | None]:
        return {}

    def entry(self, name: str) -> tuple[Expr, str] | None:
        """The expression and the unit of a signal, or of an expression of signals.

        Signals that have none themselves, such as accelerations, stand in it as inputs of their names.

        Returns
        -------
        (Expr, str) or None
            None if the name is that of a signal without an expression, or is neither a signal nor an expression.

        Raises
        ------
        UsageError
            If an expression is invalid; the message names the faulty part.
        """
        if super().__contains__(name):
            return super().entry(name)
        if name not in self._read:
            self._read[name] = read(name, self._operand, self.names, self.scene.name)
        return self._read[name]

    def asked(self, text: str) -> list[str]:
        """The signals that are not listed and match, or the text itself, if it is an expression of signals."""
        return super().asked(text) or ([] if self.entry(text) is None else [text])

    def __contains__(self, name: str) -> bool:
        try:
            return super().__contains__(name) or self.entry(name) is not None
        except MbdslError:
            return False

    def unit(self, name: str) -> str:
        """Return the SI unit of a signal or of an expression; "" if it is a pure number or its unit is unknown."""
        entry = None if super().__contains__(name) else self.entry(name)
        return super().unit(name) if entry is None else entry[1]

    def computed_in(self, root: Expr) -> list[str]:
        """The signals without an expression that an expression of signals contains."""
        return [str(x.value) for x in leaves(root) if x.op == "input" and self.is_computed(str(x.value))]

    def _operand(self, name: str) -> Operand | None:
        if (entry := self.listed_or_not(name)) is not None:
            return entry
        if self.is_computed(name):
            return input_signal(name), SignalNames.unit(self, name)
        return _parameter(self.scene, name)


def _parameter(scene: Scene, name: str) -> Operand | None:
    """A number among the parameters of the model or of its components."""
    if name in scene.parameters:
        value, unit = scene.parameters[name].value, scene.parameters[name].unit
    else:
        owner, _, key = name.rpartition(".")
        component = scene.components.get(owner)
        declared = None if component is None else component.kind.parameter(key)
        if component is None or declared is None:
            return None
        unit = component.units.get(key) or ("" if declared.unit == ANY else declared.unit)
        value = component.values.get(key)
    return (value, unit) if isinstance(value, (int, float, Expr)) and not isinstance(value, bool) else None


def read(
    text: str, operand: Callable[[str], Operand | None], names: Collection[str], where: str
) -> tuple[Expr, str] | None:
    """An expression of signals.

    Parameters
    ----------
    text : str
        The expression.
    operand : callable
        The value and the SI unit of a name; None if there is none.
    names : collection of str
        Names, for messages.
    where : str
        What they belong to.

    Returns
    -------
    (Expr, str) or None
        The expression and its SI unit, "" for a pure number; None if the text is a name or a pattern.

    Raises
    ------
    UsageError
        If a part of the expression is not a signal, or the dimensions of its parts do not fit.
    """
    try:
        tree = parse_expression(text, "<signal>")
        if isinstance(tree, s.Reference | s.Number | s.String):
            return None
    except SyntaxProblem as problem:
        if not set(text) & set("()+/^<> "):  # a pattern such as `crank.*`
            return None
        raise UsageError(f"`{text}` is not an expression of signals: {problem.message}", hint=problem.hint) from None
    scope = _Scope(operand, names, where)
    try:
        value = evaluate(tree, scope)
        if not isinstance(value, Quantity) or isinstance(value.value, str):
            raise ModelError(f"expected a number, found {describe(value)}", hint="name the components one by one")
    except ModelError as problem:
        raise UsageError(f"`{text}`: {problem.message}", hint=problem.hint) from None
    if value.dimension is None:
        # a number before a signal may have any unit in a law; before a constant it has none, as in `2*L`
        with suppress(ModelError):
            value.dimension = numeric(evaluate(tree, _Scope(operand, names, where, constant=True)), text).dimension
    root = expr(value.value)
    if not leaves(root):
        raise UsageError(f"`{text}` contains no signal", hint=did_you_mean(text, names, "signals"))
    return root, _unit(root, value, scope.units)


def _unit(root: Expr, value: Quantity, known: Mapping[Expr, str]) -> str:
    """The unit of an expression: that of an operand of its dimension (N.m, rad/s), else the usual one."""
    if value.boolean or value.dimension is None:
        return ""
    if value.dimension == units.NUMBER:
        return "rad" if _is_angle(root, known) else ""
    same = (unit for unit in known.values() if unit and units.dimension(unit) == value.dimension)
    return next(same, unit_text(value.dimension))


def _is_angle(node: Expr, known: Mapping[Expr, str]) -> bool:
    """Whether an expression is a sum, or a multiple, of angles."""
    if node in known:
        return known[node] == "rad"
    if node.op == "div":
        return is_const(node.args[1]) and _is_angle(node.args[0], known)
    args = [x for x in node.args[node.op == "select" :] if not is_const(x)]
    if node.op == "mul":
        return len(args) == 1 and _is_angle(args[0], known)
    return node.op in _KEEPING and all(_is_angle(x, known) for x in args)


class _Scope(Names):
    """Signals and parameters by their full names, without warnings: a number in a result is written by its reader."""

    def __init__(
        self, operand: Callable[[str], Operand | None], names: Collection[str], where: str, constant: bool = False
    ) -> None:
        self.budget = Budget()
        self.constant = constant  # whether all signals are 1, to find the dimension of an expression
        self.units: dict[Expr, str] = {}
        self._operand, self._names, self._where = operand, names, where

    def value(self, reference: s.Reference) -> Value:
        name = write(reference).replace(" ", "")
        if name == "time":
            return Quantity(1.0 if self.constant else TIME, units.dimension("s"))
        found = self._operand(name)
        if found is None:
            if name in functions.CONSTANTS:
                return Quantity(functions.CONSTANTS[name], units.NUMBER)
            hint = did_you_mean(name, self._names, "signals")
            raise ModelError(f"there is no signal `{name}` in {self._where}", hint=hint)
        value, unit = found
        if isinstance(value, Expr):
            self.units[value] = unit
        parsed = units.parse(unit) if unit else None  # a unit that is not known fits every other one
        return Quantity(1.0 if self.constant else value, None if parsed is None else parsed.dimension)

    def with_locals(self, names: dict[str, Value]) -> _Scope:
        raise ModelError("an expression of signals has no loops")
