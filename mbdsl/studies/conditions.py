"""Conditions on signals, such as ``mass.x > 0.5 m and pin.w < 0``: the times at which they hold in a run."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np

from mbdsl.errors import SyntaxProblem, UsageError
from mbdsl.kernels.arrays import Array
from mbdsl.lang import syntax as s
from mbdsl.lang.asked_signals import AskedSignals
from mbdsl.lang.parser import parse_expression
from mbdsl.lang.unparse import write

EXAMPLE = "a condition compares signals: mass.x > 0.5 m and pin.w < 0"
#: the number of a comparison, or an operation on such trees
Tree: TypeAlias = "int | tuple[str, Tree] | tuple[str, Tree, Tree]"


@dataclass(frozen=True)
class StudyCondition:
    """A condition."""

    text: str  #: as written
    tree: Tree  #: numbers of comparisons, connected by "and", "or" and "not"
    differences: tuple[str, ...]  #: for each comparison an expression that is positive where it holds
    closed: tuple[bool, ...]  #: for each comparison whether it also holds where the expression is zero

    def spans(self, t: Array, xs: Sequence[Array]) -> Array:
        """Return the times between which the condition holds.

        Parameters
        ----------
        t : (N,) [s]
            Times of the outputs.
        xs : sequence of (N,)
            Values of the differences.

        Returns
        -------
        (k, 2) array [s]
            Begin and end of each span, by linear interpolation of the differences between outputs.
        """
        changes: dict[float, list[int]] = {}  # comparisons that change at a time
        now = []
        for number, (x, closed) in enumerate(zip(xs, self.closed, strict=True)):
            holds = x >= 0.0 if closed else x > 0.0
            now.append(bool(holds[0]))
            for k in np.flatnonzero(holds[1:] != holds[:-1]):
                part = x[k] / (x[k] - x[k + 1])
                changes.setdefault(float(t[k] + part * (t[k + 1] - t[k])), []).append(number)
        times = [float(t[0])] if _holds(self.tree, now) else []
        for time in sorted(changes):
            for number in changes[time]:
                now[number] = not now[number]
            if _holds(self.tree, now) != len(times) % 2:
                times.append(time)
        if len(times) % 2:
            times.append(float(t[-1]))
        return np.array(times).reshape(-1, 2)


def _holds(tree: Tree, now: Sequence[bool]) -> bool:
    """Whether the condition holds, from its comparisons."""
    if isinstance(tree, int):
        return now[tree]
    first, *other = (_holds(part, now) for part in tree[1:])
    return not first if not other else first and other[0] if tree[0] == "and" else first or other[0]


def read(text: str, names: AskedSignals) -> StudyCondition:
    """A condition from its text.

    Raises
    ------
    UsageError
        If it is not a condition, or a side is not an expression of signals.
    """
    differences: list[str] = []
    closed: list[bool] = []

    def tree(e: s.Expression) -> Tree:
        if isinstance(e, s.Unary) and e.operator == "not":
            return "not", tree(e.operand)
        if isinstance(e, s.Binary) and e.operator in ("and", "or"):
            return e.operator, tree(e.left), tree(e.right)
        if not (isinstance(e, s.Binary) and e.operator in ("<", "<=", ">", ">=")):
            raise UsageError(f"`{text}`: found `{write(e)}`, expected a comparison by <, <=, > or >=", hint=EXAMPLE)
        left, right = (f"({write(side)})" for side in (e.left, e.right))
        difference = f"{left} - {right}" if e.operator[0] == ">" else f"{right} - {left}"
        if names.select([difference]) != [difference]:
            raise UsageError(f"`{text}` is not a condition", hint=EXAMPLE)
        differences.append(difference)
        closed.append(e.operator.endswith("="))
        return len(differences) - 1

    try:
        found = tree(parse_expression(text, "<condition>"))
    except SyntaxProblem as problem:
        if "=" in text.replace("<=", "").replace(">=", ""):
            reason, hint = "signals are compared by <, <=, > or >=", EXAMPLE
        else:
            reason, hint = problem.message, problem.hint or EXAMPLE
        raise UsageError(f"`{text}` is not a condition: {reason}", hint=hint) from None
    return StudyCondition(text, found, tuple(differences), tuple(closed))
