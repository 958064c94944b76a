"""Expressions of kernels: names, arithmetic, comparisons and conditions."""

from __future__ import annotations

import ast
from collections.abc import Callable, Sequence
from functools import partial
from types import ModuleType

from mbdsl.compilation.kernel_code import Code
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


class Expressions(Code):
    def value(self, node: ast.expr) -> Value:
        method = getattr(self, f"on_{type(node).__name__}", None)
        if method is None:
            raise Untranslatable(f"`{ast.unparse(node)}`")
        return method(node)

    def condition(self, node: ast.expr) -> Value:
        """The truth of an expression; known if it is a constant."""
        x = self.on_BoolOp(node, True) if isinstance(node, ast.BoolOp) else self.value(node)
        return constant(bool(x.type.value)) if isinstance(x.type, Fixed) else x

    def on_Constant(self, node: ast.Constant) -> Value:
        return constant(node.value)

    def on_Name(self, node: ast.Name) -> Value:
        return self.read_name(node.id)

    def on_Tuple(self, node: ast.Tuple) -> Value:
        return group([self.value(x) for x in node.elts])

    def on_Attribute(self, node: ast.Attribute) -> Value:
        of = self.value(node.value)
        if isinstance(of.type, Fixed) and isinstance(of.type.value, ModuleType):
            return constant(getattr(of.type.value, node.attr))
        if isinstance(of.type, Group) and of.type.named is not None:
            return of.items[of.type.named._fields.index(node.attr)]  # type: ignore[attr-defined]
        if isinstance(of.type, Array) and node.attr == "size":
            size = of.leaves[1]
            return Value(INT, (self.new(f"mul i64 {size}, {of.leaves[2]}") if of.type.axes == 2 else size,))
        if isinstance(of.type, Array) and node.attr == "shape":
            return group([Value(INT, (x,)) for x in of.leaves[1:]])
        raise Untranslatable(f"`{ast.unparse(node)}`")

    def on_UnaryOp(self, node: ast.UnaryOp) -> Value:
        x = self.condition(node.operand) if isinstance(node.op, ast.Not) else self.value(node.operand)
        if isinstance(node.op, ast.Not):
            if x.known is not None:
                return constant(not x.known)
            return Value(BOOL, (self.new(f"xor i1 {self.truth(x)}, true"),))
        if x.known is not None and isinstance(node.op, ast.USub):
            return constant(-x.known)
        x = self.number(x, INT) if x.type == BOOL else x
        if isinstance(node.op, ast.USub) and x.type == FLOAT:
            return Value(FLOAT, (self.new(f"fneg double {x.leaves[0]}"),))
        if isinstance(node.op, ast.USub) and x.type == INT:
            return Value(INT, (self.new(f"sub i64 0, {x.leaves[0]}"),))
        if isinstance(node.op, ast.UAdd) and isinstance(x.type, Scalar):
            return x
        raise Untranslatable(f"`{ast.unparse(node)}`")

    def on_BinOp(self, node: ast.BinOp) -> Value:
        return self.operation(node.op, self.value(node.left), self.value(node.right))

    def operation(self, op: ast.operator, x: Value, y: Value) -> Value:
        if not (isinstance(x.type, Scalar) and isinstance(y.type, Scalar)):
            raise Untranslatable(f"arithmetic with {describe(x.type)} and {describe(y.type)}")
        kind: Scalar = FLOAT if FLOAT in (x.type, y.type) or isinstance(op, ast.Div) else INT
        if isinstance(op, ast.Pow):
            return self.power(x, y)
        if kind == INT and x.known is not None and y.known is not None and type(op) in OPERATIONS:
            return constant(
                {"add": x.known + y.known, "sub": x.known - y.known, "mul": x.known * y.known}[OPERATIONS[type(op)]]
            )
        x, y = self.number(x, kind), self.number(y, kind)
        a, b = x.leaves[0], y.leaves[0]
        if type(op) in OPERATIONS:
            prefix = "f" if kind == FLOAT else ""
            return Value(kind, (self.new(f"{prefix}{OPERATIONS[type(op)]} {kind.leaf} {a}, {b}"),))
        if isinstance(op, ast.Div):
            return Value(FLOAT, (self.new(f"fdiv double {a}, {b}"),))
        if isinstance(op, (ast.FloorDiv, ast.Mod)):
            return self.floor_division(isinstance(op, ast.Mod), kind, a, b, y.known)
        if type(op) in BITWISE and kind == INT:
            return Value(INT, (self.new(f"{BITWISE[type(op)]} i64 {a}, {b}"),))
        raise Untranslatable(f"the operator `{type(op).__name__}` between {describe(x.type)} and {describe(y.type)}")

    def floor_division(self, rest: bool, kind: Scalar, a: str, b: str, divisor: float | None) -> Value:
        """a // b or a % b, rounded towards minus infinity."""
        if kind == FLOAT:
            if not rest:
                raise Untranslatable("`//` of floats; use floor(a/b)")
            r = self.new(f"frem double {a}, {b}")
            negative = [self.new(f"fcmp olt double {x}, {literal(0.0)}") for x in (b, r)]
            other = self.new(f"xor i1 {negative[0]}, {negative[1]}")
            zero = self.new(f"fcmp oeq double {r}, {literal(0.0)}")
            copysign = self.module.declare("llvm.copysign.f64", "double", ("double", "double"))
            signed = self.new(f"call double {copysign}(double {literal(0.0)}, double {b})")
            shifted = self.new(f"fadd double {r}, {b}")
            moved = self.new(f"select i1 {other}, double {shifted}, double {r}")
            return Value(FLOAT, (self.new(f"select i1 {zero}, double {signed}, double {moved}"),))
        if not divisor:  # the division by zero gives zero
            none = self.new(f"icmp eq i64 {b}, 0")
            b = self.new(f"select i1 {none}, i64 1, i64 {b}")
            a = self.new(f"select i1 {none}, i64 0, i64 {a}")
        if divisor in (None, -1):  # -2**63/-1, whose result is too large, would end the process
            minus, opposite = self.new(f"icmp eq i64 {b}, -1"), self.new(f"sub i64 0, {a}")
            a = self.new(f"select i1 {minus}, i64 {opposite}, i64 {a}")
            b = self.new(f"select i1 {minus}, i64 1, i64 {b}")
        r = self.new(f"srem i64 {a}, {b}")
        signs = self.new(f"xor i64 {r}, {b}")
        other = self.new(f"icmp slt i64 {signs}, 0")
        inexact = self.new(f"icmp ne i64 {r}, 0")
        down = self.new(f"and i1 {other}, {inexact}")
        if rest:
            shifted = self.new(f"add i64 {r}, {b}")
            return Value(INT, (self.new(f"select i1 {down}, i64 {shifted}, i64 {r}"),))
        q = self.new(f"sdiv i64 {a}, {b}")
        below = self.new(f"sub i64 {q}, 1")
        return Value(INT, (self.new(f"select i1 {down}, i64 {below}, i64 {q}"),))

    def power(self, x: Value, y: Value) -> Value:
        if y.type == INT and y.known == 2:
            return self.operation(ast.Mult(), x, x)
        a, b = self.number(x, FLOAT), self.number(y, FLOAT)
        if FLOAT not in (x.type, y.type):
            raise Untranslatable("`**` of integers; make one of them a float")
        pow = self.module.declare("llvm.pow.f64", "double", ("double", "double"))
        return Value(FLOAT, (self.new(f"call double {pow}(double {a.leaves[0]}, double {b.leaves[0]})"),))

    def on_Compare(self, node: ast.Compare) -> Value:
        left = self.value(node.left)

        def test(op: ast.cmpop, right_node: ast.expr) -> Value:
            nonlocal left
            right = self.value(right_node)
            found, left = self.comparison(op, left, right), right
            return found

        tests = [partial(test, op, x) for op, x in zip(node.ops, node.comparators, strict=True)]
        return tests[0]() if len(tests) == 1 else self.decided(False, tests)

    def comparison(self, op: ast.cmpop, x: Value, y: Value) -> Value:
        if isinstance(op, (ast.Is, ast.IsNot)):
            if not (isinstance(x.type, Fixed) or isinstance(y.type, Fixed)):
                raise Untranslatable("`is` compares numbers")
            return constant((x.type == y.type) == isinstance(op, ast.Is))
        if not (isinstance(x.type, Scalar) and isinstance(y.type, Scalar)) or type(op) not in COMPARISONS:
            raise Untranslatable(f"a comparison of {describe(x.type)} and {describe(y.type)}")
        name = COMPARISONS[type(op)]
        if FLOAT in (x.type, y.type):
            x, y = self.number(x, FLOAT), self.number(y, FLOAT)
            name = "une" if name == "ne" else f"o{name}"
            return Value(BOOL, (self.new(f"fcmp {name} double {x.leaves[0]}, {y.leaves[0]}"),))
        x, y = self.number(x, INT), self.number(y, INT)
        name = name if name in ("eq", "ne") else f"s{name}"
        return Value(BOOL, (self.new(f"icmp {name} i64 {x.leaves[0]}, {y.leaves[0]}"),))

    def on_BoolOp(self, node: ast.BoolOp, as_condition: bool = False) -> Value:
        """``and``, ``or``. Their result is a truth; in Python it is an operand: all operands have to be truths, too."""

        def truth(operand: ast.expr) -> Value:
            x = self.condition(operand) if as_condition else self.value(operand)
            if not as_condition and x.type != BOOL:
                raise Untranslatable(f"`{ast.unparse(node)}` gives {describe(x.type)}; use `... if ... else ...`")
            return x

        return self.decided(isinstance(node.op, ast.Or), [partial(truth, x) for x in node.values])

    def decided(self, decides: bool, operands: Sequence[Callable[[], Value]]) -> Value:
        """Whether an operand has the truth that ``decides``; later operands are not evaluated then."""
        after, arrivals = self.label(), []
        for k, operand in enumerate(operands):
            x = operand()
            if x.known is not None:
                if bool(x.known) == decides:
                    arrivals.append(("true" if decides else "false", self.block))
                    self.go(after)
                    break
                if k < len(operands) - 1:
                    continue
            test = self.truth(x)
            arrivals.append((test, self.block))
            if k == len(operands) - 1:
                self.go(after)
                break
            following = self.label()
            self.end(
                f"br i1 {test}, label %{after if decides else following}, label %{following if decides else after}"
            )
            self.start(following)
        self.start(after)
        if len(arrivals) == 1:
            text = arrivals[0][0]
            return Value(BOOL, (text,), {"true": True, "false": False}.get(text))
        return Value(BOOL, (self.new("phi i1 " + ", ".join(f"[{x}, %{b}]" for x, b in arrivals)),))

    def on_IfExp(self, node: ast.IfExp) -> Value:
        test = self.condition(node.test)
        if test.known is not None:
            return self.value(node.body if test.known else node.orelse)
        yes, no, after = self.label(), self.label(), self.label()
        self.branch(test, yes, no)
        self.start(yes)
        one = self.value(node.body)
        end_yes, mark = self.block, len(self.lines)
        self.start(no)
        other = self.value(node.orelse)
        kind = join(one.type, other.type)
        other = self.converted(other, kind)
        end_no = self.block
        self.go(after)
        # the conversion of the first value belongs to the end of its block
        later, self.lines = self.lines[mark:], self.lines[:mark]
        one = self.converted(one, kind)
        self.lines += [f"  br label %{after}", *later]
        self.start(after)
        pairs = zip(kind.leaves, one.leaves, other.leaves, strict=True)
        return Value(kind, tuple(self.new(f"phi {leaf} [{a}, %{end_yes}], [{b}, %{end_no}]") for leaf, a, b in pairs))
