"""Expressions of kernels: names, arithmetic, comparisons and conditions."""

from __future__ import annotations

import ast
from collections.abc import Callable, Sequence
from dataclasses import is_dataclass
from functools import partial
from types import ModuleType

from mbdsl.compilation.kernel_code import Code, translates
from mbdsl.compilation.kernel_types import (
    BOOL,
    FLOAT,
    INT,
    Array,
    Fixed,
    Group,
    Scalar,
    Untranslatable,
    Value,
    constant,
    describe,
    group,
    join,
    literal,
)

OPERATIONS = {ast.Add: "add", ast.Sub: "sub", ast.Mult: "mul"}
BITWISE = {ast.BitAnd: "and", ast.BitOr: "or", ast.BitXor: "xor", ast.LShift: "shl", ast.RShift: "ashr"}
COMPARISONS = {ast.Eq: "eq", ast.NotEq: "ne", ast.Lt: "lt", ast.LtE: "le", ast.Gt: "gt", ast.GtE: "ge"}


def condition(code: Code, node: ast.expr) -> Value:
    """The truth of an expression; known if it is a constant."""
    x = _bool_op(code, node, True) if isinstance(node, ast.BoolOp) else code.value(node)
    return constant(bool(x.type.value)) if isinstance(x.type, Fixed) else x


@translates(ast.Constant)
def _constant(code: Code, node: ast.Constant) -> Value:
    return constant(node.value)


@translates(ast.Name)
def _name(code: Code, node: ast.Name) -> Value:
    return code.read_name(node.id)


@translates(ast.Tuple)
def _tuple(code: Code, node: ast.Tuple) -> Value:
    return group([code.value(x) for x in node.elts])


@translates(ast.Attribute)
def _attribute(code: Code, node: ast.Attribute) -> Value:
    of = code.value(node.value)
    if isinstance(of.type, Fixed) and (isinstance(of.type.value, ModuleType) or is_dataclass(of.type.value)):
        return constant(getattr(of.type.value, node.attr))
    if isinstance(of.type, Group) and of.type.named is not None:
        return of.items[of.type.named._fields.index(node.attr)]
    if isinstance(of.type, Array) and node.attr == "size":
        size = of.leaves[1]
        return Value(INT, (code.new(f"mul i64 {size}, {of.leaves[2]}") if of.type.axes == 2 else size,))
    if isinstance(of.type, Array) and node.attr == "shape":
        return group([Value(INT, (x,)) for x in of.leaves[1:]])
    raise Untranslatable(f"`{ast.unparse(node)}`")


@translates(ast.UnaryOp)
def _unary_op(code: Code, node: ast.UnaryOp) -> Value:
    x = condition(code, node.operand) if isinstance(node.op, ast.Not) else code.value(node.operand)
    if isinstance(node.op, ast.Not):
        if x.known is not None:
            return constant(not x.known)
        return Value(BOOL, (code.new(f"xor i1 {code.truth(x)}, true"),))
    if x.known is not None and isinstance(node.op, ast.USub):
        return constant(-x.known)
    x = code.number(x, INT) if x.type == BOOL else x
    if isinstance(node.op, ast.USub) and x.type == FLOAT:
        return Value(FLOAT, (code.new(f"fneg double {x.leaves[0]}"),))
    if isinstance(node.op, ast.USub) and x.type == INT:
        return Value(INT, (code.new(f"sub i64 0, {x.leaves[0]}"),))
    if isinstance(node.op, ast.UAdd) and isinstance(x.type, Scalar):
        return x
    raise Untranslatable(f"`{ast.unparse(node)}`")


@translates(ast.BinOp)
def _bin_op(code: Code, node: ast.BinOp) -> Value:
    return operation(code, node.op, code.value(node.left), code.value(node.right))


def operation(code: Code, op: ast.operator, x: Value, y: Value) -> Value:
    if not (isinstance(x.type, Scalar) and isinstance(y.type, Scalar)):
        raise Untranslatable(f"arithmetic with {describe(x.type)} and {describe(y.type)}")
    kind: Scalar = FLOAT if FLOAT in (x.type, y.type) or isinstance(op, ast.Div) else INT
    if isinstance(op, ast.Pow):
        return power(code, x, y)
    if kind == INT and x.known is not None and y.known is not None and type(op) in OPERATIONS:
        return constant(
            {"add": x.known + y.known, "sub": x.known - y.known, "mul": x.known * y.known}[OPERATIONS[type(op)]]
        )
    a, b = code.number(x, kind).leaves[0], code.number(y, kind).leaves[0]
    if type(op) in OPERATIONS:
        prefix = "f" if kind == FLOAT else ""
        return Value(kind, (code.new(f"{prefix}{OPERATIONS[type(op)]} {kind.leaf} {a}, {b}"),))
    if isinstance(op, ast.Div):
        return Value(FLOAT, (code.new(f"fdiv double {a}, {b}"),))
    if isinstance(op, (ast.FloorDiv, ast.Mod)):
        return floor_division(code, isinstance(op, ast.Mod), kind, a, b, y.known)
    if type(op) in BITWISE and kind == INT:
        return Value(INT, (code.new(f"{BITWISE[type(op)]} i64 {a}, {b}"),))
    raise Untranslatable(f"the operator `{type(op).__name__}` between {describe(x.type)} and {describe(y.type)}")


def floor_division(code: Code, rest: bool, kind: Scalar, a: str, b: str, divisor: float | None) -> Value:
    """a // b or a % b, rounded towards minus infinity."""
    if kind == FLOAT:
        if not rest:
            raise Untranslatable("`//` of floats; use floor(a/b)")
        r = code.new(f"frem double {a}, {b}")
        negative = [code.new(f"fcmp olt double {x}, {literal(0.0)}") for x in (b, r)]
        other = code.new(f"xor i1 {negative[0]}, {negative[1]}")
        zero = code.new(f"fcmp oeq double {r}, {literal(0.0)}")
        copysign = code.module.declare("llvm.copysign.f64", "double", ("double", "double"))
        signed = code.new(f"call double {copysign}(double {literal(0.0)}, double {b})")
        shifted = code.new(f"fadd double {r}, {b}")
        moved = code.new(f"select i1 {other}, double {shifted}, double {r}")
        return Value(FLOAT, (code.new(f"select i1 {zero}, double {signed}, double {moved}"),))
    if not divisor:  # the division by zero gives zero
        none = code.new(f"icmp eq i64 {b}, 0")
        b = code.new(f"select i1 {none}, i64 1, i64 {b}")
        a = code.new(f"select i1 {none}, i64 0, i64 {a}")
    if divisor in (None, -1):  # -2**63/-1, whose result is too large, would end the process
        minus, opposite = code.new(f"icmp eq i64 {b}, -1"), code.new(f"sub i64 0, {a}")
        a = code.new(f"select i1 {minus}, i64 {opposite}, i64 {a}")
        b = code.new(f"select i1 {minus}, i64 1, i64 {b}")
    r = code.new(f"srem i64 {a}, {b}")
    signs = code.new(f"xor i64 {r}, {b}")
    other = code.new(f"icmp slt i64 {signs}, 0")
    inexact = code.new(f"icmp ne i64 {r}, 0")
    down = code.new(f"and i1 {other}, {inexact}")
    if rest:
        shifted = code.new(f"add i64 {r}, {b}")
        return Value(INT, (code.new(f"select i1 {down}, i64 {shifted}, i64 {r}"),))
    q = code.new(f"sdiv i64 {a}, {b}")
    below = code.new(f"sub i64 {q}, 1")
    return Value(INT, (code.new(f"select i1 {down}, i64 {below}, i64 {q}"),))


def power(code: Code, x: Value, y: Value) -> Value:
    if y.type == INT and y.known == 2:
        return operation(code, ast.Mult(), x, x)
    a, b = code.number(x, FLOAT), code.number(y, FLOAT)
    if FLOAT not in (x.type, y.type):
        raise Untranslatable("`**` of integers; make one of them a float")
    pow = code.module.declare("llvm.pow.f64", "double", ("double", "double"))
    return Value(FLOAT, (code.new(f"call double {pow}(double {a.leaves[0]}, double {b.leaves[0]})"),))


@translates(ast.Compare)
def _compare(code: Code, node: ast.Compare) -> Value:
    left = code.value(node.left)

    def test(op: ast.cmpop, right_node: ast.expr) -> Value:
        nonlocal left
        right = code.value(right_node)
        found, left = comparison(code, op, left, right), right
        return found

    tests = [partial(test, op, x) for op, x in zip(node.ops, node.comparators, strict=True)]
    return tests[0]() if len(tests) == 1 else decided(code, False, tests)


def comparison(code: Code, op: ast.cmpop, x: Value, y: Value) -> Value:
    if isinstance(op, (ast.Is, ast.IsNot)):
        if not (isinstance(x.type, Fixed) or isinstance(y.type, Fixed)):
            raise Untranslatable("`is` compares numbers")
        return constant((x.type == y.type) == isinstance(op, ast.Is))
    if not (isinstance(x.type, Scalar) and isinstance(y.type, Scalar)) or type(op) not in COMPARISONS:
        raise Untranslatable(f"a comparison of {describe(x.type)} and {describe(y.type)}")
    name = COMPARISONS[type(op)]
    if FLOAT in (x.type, y.type):
        x, y = code.number(x, FLOAT), code.number(y, FLOAT)
        name = "une" if name == "ne" else f"o{name}"
        return Value(BOOL, (code.new(f"fcmp {name} double {x.leaves[0]}, {y.leaves[0]}"),))
    x, y = code.number(x, INT), code.number(y, INT)
    name = name if name in ("eq", "ne") else f"s{name}"
    return Value(BOOL, (code.new(f"icmp {name} i64 {x.leaves[0]}, {y.leaves[0]}"),))


@translates(ast.BoolOp)
def _bool_op(code: Code, node: ast.BoolOp, as_condition: bool = False) -> Value:
    """``and``, ``or``. Their result is a truth; in Python it is an operand: all operands have to be truths, too."""

    def truth(operand: ast.expr) -> Value:
        x = condition(code, operand) if as_condition else code.value(operand)
        if not as_condition and x.type != BOOL:
            raise Untranslatable(f"`{ast.unparse(node)}` gives {describe(x.type)}; use `... if ... else ...`")
        return x

    return decided(code, isinstance(node.op, ast.Or), [partial(truth, x) for x in node.values])


def decided(code: Code, decides: bool, operands: Sequence[Callable[[], Value]]) -> Value:
    """Whether an operand has the truth that ``decides``; later operands are not evaluated then."""
    after, arrivals = code.label(), []
    for k, operand in enumerate(operands):
        x = operand()
        if x.known is not None:
            if bool(x.known) == decides:
                arrivals.append(("true" if decides else "false", code.block))
                code.go(after)
                break
            if k < len(operands) - 1:
                continue
        test = code.truth(x)
        arrivals.append((test, code.block))
        if k == len(operands) - 1:
            code.go(after)
            break
        following = code.label()
        code.end(f"br i1 {test}, label %{after if decides else following}, label %{following if decides else after}")
        code.start(following)
    code.start(after)
    if len(arrivals) == 1:
        text = arrivals[0][0]
        return Value(BOOL, (text,), {"true": True, "false": False}.get(text))
    return Value(BOOL, (code.new("phi i1 " + ", ".join(f"[{x}, %{b}]" for x, b in arrivals)),))


@translates(ast.IfExp)
def _if_exp(code: Code, node: ast.IfExp) -> Value:
    test = condition(code, node.test)
    if test.known is not None:
        return code.value(node.body if test.known else node.orelse)
    yes, no, after = code.label(), code.label(), code.label()
    code.branch(test, yes, no)
    code.start(yes)
    one = code.value(node.body)
    end_yes, mark = code.block, len(code.lines)
    code.start(no)
    other = code.value(node.orelse)
    kind = join(one.type, other.type)
    other = code.converted(other, kind)
    end_no = code.block
    code.go(after)
    # the conversion of the first value belongs to the end of its block
    later, code.lines = code.lines[mark:], code.lines[:mark]
    one = code.converted(one, kind)
    code.lines += [f"  br label %{after}", *later]
    code.start(after)
    pairs = zip(kind.leaves, one.leaves, other.leaves, strict=True)
    return Value(kind, tuple(code.new(f"phi {leaf} [{a}, %{end_yes}], [{b}, %{end_no}]") for leaf, a, b in pairs))
