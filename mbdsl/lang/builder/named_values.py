"""Values that a Builder declares under names: parameters, inputs, variables and states."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from mbdsl.lang import python_values
from mbdsl.lang import syntax as s
from mbdsl.lang.builder.declaring import Declarations, displayed
from mbdsl.lang.builder.handles import Handle, Law, Number, Place
from mbdsl.lang.calls import CallLine
from mbdsl.lang.unparse import write


class NamedValues(Declarations):
    """The part of ``mbdsl.Builder`` for values."""

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
        left = s.Call(s.Reference((s.Step("der"),)), (goal,), at=(CallLine(), 0, 0))
        item = s.Relation(left, self._node(rate, f"der({write(goal.value)})"), at=left.at)  # type: ignore[arg-type]
        self._draft.rate(item, python_values.flag(replace, "replace"))
