"""Formulas of elements, such as ``k*(s - s0) + c*v``: text to expression.

The syntax is that of Python with ``^`` for powers and indices that start at 1: as in the mbdsl language, except that a
leading minus belongs to the first factor of a product. Formulas occur in elements only, not in models.
"""

from __future__ import annotations

import ast
import operator
from collections.abc import Callable
from functools import cache
from typing import Protocol

from mbdsl.expressions.derivatives import der
from mbdsl.expressions.symbolic import OPERATIONS, Expr, at_start, call, const, expr

_OPERATORS: dict[type[ast.operator], Callable[[Expr, Expr], Expr]] = {
    ast.Add: operator.add,
    ast.Sub: operator.sub,
    ast.Mult: operator.mul,
    ast.Div: operator.truediv,
    ast.Pow: operator.pow,
}


class FormulaNames(Protocol):
    """The meaning of the names in a formula."""

    def value(self, name: str) -> Expr | float:
        """``k``: a parameter, a law or a signal."""

    def element(self, name: str, index: int) -> Expr | float:
        """``lam[1]``, ``k[2]``: an element of an array; ``index`` starts at 1."""

    def coordinate(self, port: str, key: str) -> Expr:
        """``frame_a.x``: a coordinate of a frame."""


def evaluate(formula: str, names: FormulaNames) -> Expr:
    """The expression that ``formula`` describes.

    Parameters
    ----------
    formula : str
        Numbers, names, ``+ - * / ^``, ``der(...)``, ``start(...)`` (the value at the start), and the operations
        of :mod:`mbdsl.expressions.symbolic`.
    names : Names
        Values of the names in it.

    Raises
    ------
    ValueError
        If it contains anything else.
    """
    return _read(formula)(names)


@cache
def _read(formula: str) -> Callable[[FormulaNames], Expr]:
    return _compiled(ast.parse(formula.replace("^", "**"), mode="eval").body)


def _compiled(node: ast.expr) -> Callable[[FormulaNames], Expr]:
    """The function that evaluates a syntax tree."""
    match node:
        case ast.Constant(value=int() | float() as number):
            constant = const(number)
            return lambda names: constant
        case ast.Name(id=name):
            return lambda names: expr(names.value(name))
        case ast.Attribute(value=ast.Name(id=port), attr=key):
            return lambda names: names.coordinate(port, key)
        case ast.Subscript(value=ast.Name(id=name), slice=ast.Constant(value=int() as index)):
            return lambda names: expr(names.element(name, index))
        case ast.UnaryOp(op=ast.USub(), operand=operand):
            value = _compiled(operand)
            return lambda names: -value(names)
        case ast.BinOp(left=left, op=op, right=right) if type(op) in _OPERATORS:
            apply, a, b = _OPERATORS[type(op)], _compiled(left), _compiled(right)
            return lambda names: apply(a(names), b(names))
        case ast.Call(func=ast.Name(id="der"), args=[argument], keywords=[]):
            value = _compiled(argument)
            return lambda names: der(value(names))
        case ast.Call(func=ast.Name(id="start"), args=[argument], keywords=[]):
            value = _compiled(argument)
            return lambda names: at_start(value(names))
        case ast.Call(func=ast.Name(id=name), args=arguments, keywords=[]) if name in OPERATIONS:
            values = [_compiled(argument) for argument in arguments]
            return lambda names: call(name, *(value(names) for value in values))
    raise ValueError(f"`{ast.unparse(node)}` cannot be part of a formula")
