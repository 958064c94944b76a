"""Values that a Builder declares under names, parameters, inputs, variables and states, and what changes them."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from mbdsl.lang import python_values
from mbdsl.lang import syntax as s
from mbdsl.lang.builder.declaring import Action, Declarations, displayed
from mbdsl.lang.builder.handles import Handle, Law, Number, Place
from mbdsl.lang.calls import CallLine
from mbdsl.lang.unparse import write

if TYPE_CHECKING:
    from typing_extensions import Unpack


class NamedValues(Declarations):
    """The part of ``mbdsl.Builder`` for values and events."""

    def parameter(
        self, name: str, value: Any, doc: str = "", type: str = "", *, display_unit: str = "", replace: bool = False
    ) -> Handle:
        """Declare a parameter, a named constant for use in texts.

        Parameters
        ----------
        name : str
        value : number, str or sequence
            Number in SI units, text, or array.
        doc : str, optional
            Description, one line.
        type : str, optional
            A quantity of the language, such as "Mass"; the unit of the value is checked against it.
        display_unit : str, optional
            Unit in which it is displayed, as ``displayUnit`` in a text: "mm".
        replace : bool, optional
            True: replaces the declaration of this name, if there is one.

        Returns
        -------
        Handle
        """
        type_name = python_values.text(type, "type")
        node = self._node(value, str(name))
        shown = displayed(name, display_unit)
        return self._enter(name, frozenset({"parameter"}), type_name, doc, replace, value=node, arguments=shown)

    def input(
        self,
        name: str,
        start: Number = 0.0,
        unit: str = "",
        doc: str = "",
        *,
        display_unit: str = "",
        replace: bool = False,
    ) -> Handle:
        """Declare an input, a value that the caller sets between the steps of a ``mbdsl.Simulation``.

        Parameters
        ----------
        name : str
        start : number or str, optional
            Value until the input is set.
        unit : str, optional
            Unit of the signal, such as "N.m".
        doc : str, optional
            Description, one line.
        display_unit : str, optional
            Unit in which it is displayed, as ``displayUnit`` in a text: "mm".
        replace : bool, optional
            True: replaces the declaration of this name, if there is one.

        Returns
        -------
        Handle
        """
        arguments = (*self._start_and_unit(name, start, unit), *displayed(name, display_unit))
        return self._enter(name, frozenset({"input"}), "Real", doc, replace, arguments=arguments)

    def _start_and_unit(self, name: str, start: Any, unit: str) -> list[s.Argument]:
        arguments = [s.Argument("start", self._node(start, f"{name}.start"))]
        given = python_values.text(unit, f"{name}.unit")
        return [*arguments, s.Argument("unit", s.String(unit))] if given else arguments

    def variable(
        self, name: str, value: Law, doc: str = "", *, display_unit: str = "", replace: bool = False
    ) -> Handle:
        """Declare a variable, a named expression of time and signals; it becomes a signal of the model.

        Parameters
        ----------
        name : str
        value : str, number or Expr
            The expression.
        doc : str, optional
            Description, one line.
        display_unit : str, optional
            Unit in which it is displayed, as ``displayUnit`` in a text: "mm".
        replace : bool, optional
            True: replaces the declaration of this name, if there is one.

        Returns
        -------
        Handle
        """
        node, shown = self._node(value, str(name)), displayed(name, display_unit)
        return self._enter(name, frozenset(), "Real", doc, replace, value=node, arguments=shown)

    def state(
        self,
        name: str,
        start: Number | Sequence[Number] = 0.0,
        rate: Law | None = None,
        unit: str = "",
        doc: str = "",
        *,
        nominal: Number | None = None,
        replace: bool = False,
    ) -> Handle:
        """Declare a variable that an equation of its derivative defines.

        Parameters
        ----------
        name : str
        start : number or str, optional
            Its value at the start, in SI units or with a unit: "2 A". An array has one state for each element.
        rate : str, number or Expr, optional
            Its derivative. Default: a later call of ``rate`` gives it, with names that are declared until then.
        unit : str, optional
            Its unit, such as "A".
        doc : str, optional
            Description, one line.
        nominal : number or str, optional
            The size of its values, by which errors are divided. Default: the largest value of a run.
        replace : bool, optional
            True: replaces the declaration of this name, if there is one, and its equation.

        Returns
        -------
        Handle
        """
        arguments = self._start_and_unit(name, start, unit)
        if nominal is not None:
            arguments.append(s.Argument("nominal", self._node(nominal, f"{name}.nominal")))
        handle = self._enter(name, frozenset(), "Real", doc, replace, arguments=tuple(arguments))
        if rate is not None:
            self.rate(handle, rate, replace=replace)
        return handle

    def rate(self, state: Place, rate: Law, *, replace: bool = False) -> None:
        """Set the derivative of a state, as ``der(x) = ...`` does in a text.

        Parameters
        ----------
        state : Handle or str
            The state, or an element of an array: "x[2]".
        rate : str, number or Expr
            The expression.
        replace : bool, optional
            True: replaces the derivative that was given before.

        Raises
        ------
        ModelError
            If a name is not known, or the derivative was given before.
        """
        goal = s.Argument("", self._place(state, "rate.state"))
        left = s.Call(s.Reference((s.NamePart("der"),)), (goal,), at=(CallLine(), 0, 0))
        item = s.Relation(left, self._node(rate, f"der({write(goal.value)})"), at=left.at)  # type: ignore[arg-type]
        self._draft.rate(item, python_values.flag(replace, "replace"))

    def discrete(
        self,
        name: str,
        start: Number | Sequence[Number] = 0.0,
        unit: str = "",
        doc: str = "",
        *,
        type: str = "Real",
        replace: bool = False,
    ) -> Handle:
        """Declare a variable that only when-equations change.

        Parameters
        ----------
        name : str
        start : number, bool or str, optional
            Its value at the start, in SI units or with a unit: "2 N". An array has one variable for each element.
        unit : str, optional
            Its unit, such as "N".
        doc : str, optional
            Description, one line.
        type : {"Real", "Integer", "Boolean"}, optional
            Its type, or a quantity of the language, such as "Force".
        replace : bool, optional
            True: replaces the declaration of this name, if there is one.

        Returns
        -------
        Handle
        """
        arguments = [s.Argument("start", self._node(start, f"{name}.start"))]
        if python_values.text(unit, f"{name}.unit"):
            arguments.append(s.Argument("unit", s.String(unit)))
        of = python_values.text(type, "type")
        return self._enter(name, frozenset({"discrete"}), of, doc, replace, arguments=tuple(arguments))

    def when(
        self,
        condition: Law | Sequence[Law],
        *actions: Action,
        elsewhen: Sequence[tuple[Law | Sequence[Law], Unpack[tuple[Action, ...]]]] = (),
    ) -> None:
        """Add what is done where a condition becomes true.

        Parameters
        ----------
        condition : str or Expr, or a sequence of them
            The condition, such as "rod.phi > 1" or "sample(0, 1 ms)"; of a sequence, one of them becomes true.
        *actions : str or mapping
            What is done: a text as in a model, "n = pre(n) + 1", "reinit(rod.w, 0 rad/s)", 'terminate("done")',
            'assert(rod.w < 9 rad/s, "too fast")'; or new values of variables, {u: "-2*rod.phi"}.
        elsewhen : sequence of (condition, *actions), optional
            Further branches, of which the first acts whose condition becomes true.

        Raises
        ------
        ModelError, UsageError
            If a name is not known, or an action is not written correctly.
        """
        branches = []
        others: list[Any] = [(condition, *actions), *elsewhen]
        for k, (given, *does) in enumerate(others):
            what = "when" if k == 0 else f"elsewhen[{k - 1}]"
            branches.append((self._node(given, f"{what}.condition"), self._actions(does, what)))
        self._draft.event(s.When(tuple(branches), at=(CallLine(), 0, 0)))

    def assertion(self, condition: Law, text: str, level: str = "error") -> None:
        """Add a condition that must hold during a run, as ``assert(condition, "text")`` does in a model.

        Parameters
        ----------
        condition : str or Expr
            The condition.
        text : str
            The reason, for the message.
        level : str
            "error": the run ends where the condition becomes false. "warning": it goes on, and warns at its end.

        Raises
        ------
        ModelError, UsageError
            If a name or the level is not known.
        """
        reason = s.String(python_values.text(text, "assertion.text"))
        given: tuple[s.Argument, ...] = (
            s.Argument("", self._node(condition, "assertion.condition")),
            s.Argument("", reason),
        )
        if level != "error":
            given += (s.Argument("", s.Reference((s.NamePart("AssertionLevel"), s.NamePart(level)))),)
        call = s.Call(s.Reference((s.NamePart("assert"),)), given, at=(CallLine(), 0, 0))
        self._draft.event(s.Relation(call, None, at=call.at))
