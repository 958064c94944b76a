"""Kernels to LLVM code: a translator for the part of Python in which kernels are written.

Kernels are functions of numbers and arrays without allocation: assignments, arithmetic, comparisons, ``if``, ``while``,
``for`` over ``range`` or a tuple, calls of kernels and of the functions in :mod:`mbdsl.compilation.kernel_types`,
views of arrays, tuples and named tuples. A kernel is translated once for each combination of argument types; functions
among the arguments are constants of that translation. Variables are memory on the stack, which LLVM turns into
registers. The types of variables follow from the assignments: if one is found to be wider than the code so far assumed,
the kernel is translated again.

Arithmetic is that of Python without its errors: a division by zero gives inf or nan, an index is not checked.
The code has the same results with every level of optimisation, because LLVM does not reorder floating-point operations.
"""

from __future__ import annotations

import ast
import builtins
import inspect
import sys
from collections.abc import Callable, Iterator, Mapping
from functools import cache
from pathlib import Path
from types import ModuleType

from mbdsl.compilation import marks
from mbdsl.compilation.kernel_types import (
    BOOL,
    FLOAT,
    INT,
    NOTHING,
    Array,
    Fixed,
    Group,
    Pointer,
    Scalar,
    Type,
    Untranslatable,
    Value,
    constant,
    describe,
    group,
    join,
    literal,
    of_argument,
)
from mbdsl.compilation.native_call import ARRAYS, Signature

#: functions of floats -> the intrinsic or the function of the C library
INTRINSICS = {"sin": "llvm.sin.f64", "cos": "llvm.cos.f64", "sqrt": "llvm.sqrt.f64", "exp": "llvm.exp.f64"}
INTRINSICS |= {"log": "llvm.log.f64", "log10": "llvm.log10.f64", "floor": "llvm.floor.f64", "ceil": "llvm.ceil.f64"}
LIBRARY = {name: name for name in "tan sinh cosh tanh hypot atan2 asin acos atan".split()}
LIBRARY |= {"arcsin": "asin", "arccos": "acos", "arctan": "atan", "arctan2": "atan2"}
OPERATIONS = {ast.Add: "add", ast.Sub: "sub", ast.Mult: "mul"}
BITWISE = {ast.BitAnd: "and", ast.BitOr: "or", ast.BitXor: "xor", ast.LShift: "shl", ast.RShift: "ashr"}
COMPARISONS = {ast.Eq: "eq", ast.NotEq: "ne", ast.Lt: "lt", ast.LtE: "le", ast.Gt: "gt", ast.GtE: "ge"}
#: distinct types of memory: no entry of an array of floats is an entry of an array of integers
MEMORY = """
!0 = !{!"mbdsl"}
!1 = !{!"floats", !0}
!2 = !{!"integers", !0}
!3 = !{!1, !1, i64 0}
!4 = !{!2, !2, i64 0}
"""
TAG = {"double": ", !tbaa !3", "i64": ", !tbaa !4"}


def translate(name: str, functions: Mapping[str, Callable], signatures: Mapping[str, Signature]) -> str:
    """LLVM code of a module with the entries ``name.function`` and ``name.function.packed``.

    Raises
    ------
    Untranslatable
        If a kernel contains something that is not translated.
    """
    module = Module()
    for key, function in functions.items():
        _add_entries(module, f"{name}.{key}", function, signatures[key])
    return module.text()


class Module:
    """The functions of a module, each a list of lines."""

    def __init__(self) -> None:
        self.lines: list[str] = []
        self.declared: dict[str, str] = {}  # symbol -> declaration
        self._made: dict[tuple, tuple[str, Type]] = {}
        self._tables: dict[tuple[str, ...], str] = {}
        self._pending: list[tuple] = []

    def text(self) -> str:
        tables = [
            f"{symbol} = internal constant [{len(x)} x {kind}] [{', '.join(f'{kind} {v}' for v in x)}]"
            for (kind, *x), symbol in self._tables.items()
        ]
        attributes = ["attributes #0 = { nounwind alwaysinline }", "attributes #1 = { nounwind noinline }"]
        return "\n".join([*tables, *self.declared.values(), *self.lines, *attributes, MEMORY])

    def declare(self, symbol: str, gives: str, takes: tuple[str, ...]) -> str:
        self.declared[symbol] = f"declare {gives} @{symbol}({', '.join(takes)})"
        return f"@{symbol}"

    def table(self, kind: str, entries: list[str]) -> str:
        key = (kind, *entries)
        return self._tables.setdefault(key, f"@table.{len(self._tables)}")

    def kernel(self, function: Callable, takes: tuple[Type, ...]) -> tuple[str, Type]:
        """Symbol and type of the result of a kernel for these arguments."""
        key = (function, takes)
        if key in self._pending:
            raise Untranslatable(f"`{function.__name__}` calls itself")
        if key not in self._made:
            self._pending.append(key)
            symbol = f'@"{function.__module__}.{function.__name__}.{len(self._made)}"'
            gives = Kernel.translated(self, function, symbol, takes)
            self._pending.pop()
            self._made[key] = symbol, gives
        return self._made[key]


def returned(kind: Type) -> str:
    """The LLVM type of a result."""
    leaves = kind.leaves
    return "void" if not leaves else leaves[0] if len(leaves) == 1 else f"{{{', '.join(leaves)}}}"


class _Widened(Exception):
    """The type of a variable or of the result is wider than assumed so far."""


class Kernel:
    """The translation of one kernel for one combination of argument types."""

    @classmethod
    def translated(cls, module: Module, function: Callable, symbol: str, takes: tuple[Type, ...]) -> Type:
        types: dict[str, Type] = {}
        for _ in range(100):
            kernel = cls(module, function, takes, types)
            try:
                kernel._body()
            except _Widened:
                continue
            except Untranslatable as problem:
                if problem.args[1:]:
                    raise
                line = getattr(kernel.node, "lineno", 0)
                raise Untranslatable(f"{function.__module__}, line {line}: {problem}", True) from None
            gives = types.get(RESULT, NOTHING)
            if isinstance(gives, Fixed) and gives is not NOTHING and gives.value is not None:
                raise Untranslatable(f"`{function.__name__}` returns {describe(gives)}")
            arguments = [f"{leaf} %in.{k}.{i}" for k, kind in enumerate(takes) for i, leaf in enumerate(kind.leaves)]
            inlined = "#1" if hasattr(function, "__mbdsl_rare__") else "#0"
            module.lines += [
                f"define internal {returned(gives)} {symbol}({', '.join(arguments)}) {inlined} {{",
                "entry:",
                *kernel.variables,
                *kernel.lines,
                "}",
            ]
            return gives
        raise Untranslatable(f"the types of the variables of `{function.__name__}` are not found")

    def __init__(self, module: Module, function: Callable, takes: tuple[Type, ...], types: dict[str, Type]) -> None:
        self.module, self.function, self.types = module, function, types
        self.tree = syntax_tree(function)
        self.node: ast.AST = self.tree
        self.variables: list[str] = []  # allocations, at the start of the function
        self.lines: list[str] = []
        self.count = 0
        self.ended = False  # whether the present block has an end
        self.block = "entry"
        self.loops: list[tuple[str, str]] = []  # labels for continue and break
        self.memory: dict[str, list[str]] = {}
        names = [a.arg for a in self.tree.args.args]
        self.given = {
            name: Value(kind, tuple(f"%in.{k}.{i}" for i in range(len(kind.leaves))))
            for k, (name, kind) in enumerate(zip(names, takes, strict=True))
        }
        self.assigned = {n.id for n in ast.walk(self.tree) if isinstance(n, ast.Name) and isinstance(n.ctx, ast.Store)}

    # -- lines -----------------------------------------------------------------------------------------------

    def new(self, text: str) -> str:
        """An instruction with a result."""
        self.count += 1
        self.lines.append(f"  %v{self.count} = {text}")
        return f"%v{self.count}"

    def label(self) -> str:
        self.count += 1
        return f"b{self.count}"

    def start(self, label: str) -> None:
        self.lines.append(f"{label}:")
        self.block, self.ended = label, False

    def end(self, text: str) -> None:
        if not self.ended:
            self.lines.append(f"  {text}")
        self.ended = True

    def go(self, label: str) -> None:
        self.end(f"br label %{label}")

    def branch(self, test: Value, yes: str, no: str) -> None:
        self.end(f"br i1 {self.truth(test)}, label %{yes}, label %{no}")

    # -- variables -------------------------------------------------------------------------------------------

    def _body(self) -> None:
        for name, value in self.given.items():
            if name in self.assigned:
                self.assign_name(name, value)
        self.statements(self.tree.body)
        if not self.ended:
            if RESULT in self.types and self.types[RESULT] != NOTHING:
                raise Untranslatable("one end of the function returns a value, and another does not")
            self.end("ret void")

    def widen(self, name: str, kind: Type) -> Type:
        """The type of a variable, which is assigned a value of type ``kind``."""
        known = self.types.get(name)
        if known is None:
            self.types[name] = kind
            return kind
        joined = join(known, kind)
        if joined != known:
            self.types[name] = joined
            raise _Widened
        return known

    def assign_name(self, name: str, value: Value) -> None:
        kind = self.widen(name, value.type)
        if name not in self.memory:
            self.memory[name] = [f"%{name}.{i}" for i in range(len(kind.leaves))]
            for place, leaf in zip(self.memory[name], kind.leaves, strict=True):
                self.variables.append(f"  {place} = alloca {leaf}")
                self.variables.append(f"  store {leaf} {ZERO[leaf]}, ptr {place}")
        for place, leaf, x in zip(self.memory[name], kind.leaves, self.converted(value, kind).leaves, strict=True):
            self.lines.append(f"  store {leaf} {x}, ptr {place}")

    def read_name(self, name: str) -> Value:
        if name in self.assigned:
            if name not in self.types:
                raise Untranslatable(f"`{name}` is read before it is assigned")
            kind = self.types[name]
            if name not in self.memory:
                self.memory[name] = [f"%{name}.{i}" for i in range(len(kind.leaves))]
                for place, leaf in zip(self.memory[name], kind.leaves, strict=True):
                    self.variables.append(f"  {place} = alloca {leaf}")
                    self.variables.append(f"  store {leaf} {ZERO[leaf]}, ptr {place}")
            places = self.memory[name]
            return Value(
                kind, tuple(self.new(f"load {x}, ptr {p}") for p, x in zip(places, kind.leaves, strict=True))
            )
        if name in self.given:
            return self.given[name]
        scope = self.function.__globals__
        if name in scope:
            return constant(scope[name])
        if hasattr(builtins, name):
            return constant(getattr(builtins, name))
        raise Untranslatable(f"`{name}` is not defined")

    # -- conversions -----------------------------------------------------------------------------------------

    def converted(self, value: Value, kind: Type) -> Value:
        if value.type == kind:
            return value
        if isinstance(kind, Scalar) and isinstance(value.type, Scalar):
            return self.number(value, kind)
        if isinstance(kind, Group) and isinstance(value.type, Group):
            return group([self.converted(x, k) for x, k in zip(value.items, kind.items, strict=True)], kind.named)
        raise Untranslatable(f"{describe(value.type)} in place of {describe(kind)}")

    def number(self, value: Value, kind: Scalar) -> Value:
        """A number converted to another kind; to an integer by dropping the fraction."""
        if not isinstance(value.type, Scalar):
            raise Untranslatable(f"{describe(value.type)} in place of a number")
        if value.type == kind:
            return value
        if kind == BOOL:
            return Value(BOOL, (self.truth(value),))
        if value.known is not None and (kind == FLOAT or value.type == BOOL):
            return constant(float(value.known) if kind == FLOAT else int(value.known))
        step = {("bool", "int"): "zext i1", ("bool", "float"): "uitofp i1", ("int", "float"): "sitofp i64"}.get(
            (value.type.name, kind.name), "fptosi double"
        )
        return Value(kind, (self.new(f"{step} {value.leaves[0]} to {kind.leaf}"),))

    def truth(self, value: Value) -> str:
        if value.type == BOOL:
            return value.leaves[0]
        if value.type == INT:
            return self.new(f"icmp ne i64 {value.leaves[0]}, 0")
        if value.type == FLOAT:
            return self.new(f"fcmp une double {value.leaves[0]}, {literal(0.0)}")
        if value.type == NOTHING:
            return "false"
        raise Untranslatable(f"{describe(value.type)} as a condition")

    # -- statements ------------------------------------------------------------------------------------------

    def statements(self, body: list[ast.stmt]) -> None:
        for statement in body:
            if self.ended:
                return
            self.node = statement
            method = getattr(self, f"do_{type(statement).__name__}", None)
            if method is None:
                raise Untranslatable(f"`{ast.unparse(statement).splitlines()[0]}`")
            method(statement)

    def do_Pass(self, node: ast.Pass) -> None:
        pass

    def do_Expr(self, node: ast.Expr) -> None:
        if not isinstance(node.value, ast.Constant):
            self.value(node.value)

    def do_Assign(self, node: ast.Assign) -> None:
        value = self.value(node.value)
        for target in node.targets:
            self.assign(target, value)

    def do_AugAssign(self, node: ast.AugAssign) -> None:
        if isinstance(node.target, ast.Name):
            old = self.read_name(node.target.id)
            self.assign_name(node.target.id, self.operation(node.op, old, self.value(node.value)))
        elif isinstance(node.target, ast.Subscript):
            kind, place = self.place(node.target)
            value = self.value(node.value)
            old = Value(kind, (self.load(kind, place),))
            self.store(kind, place, self.operation(node.op, old, value))
        else:
            raise Untranslatable(f"`{ast.unparse(node)}`")

    def assign(self, target: ast.expr, value: Value) -> None:
        if isinstance(target, ast.Name):
            self.assign_name(target.id, value)
        elif isinstance(target, ast.Tuple):
            if not isinstance(value.type, Group) or len(value.type.items) != len(target.elts):
                raise Untranslatable(f"{describe(value.type)} is assigned to `{ast.unparse(target)}`")
            for part, item in zip(target.elts, value.items, strict=True):
                self.assign(part, item)
        elif isinstance(target, ast.Subscript):
            kind, place = self.place(target)
            self.store(kind, place, value)
        else:
            raise Untranslatable(f"`{ast.unparse(target)}` is assigned")

    def do_Return(self, node: ast.Return) -> None:
        value = self.value(node.value) if node.value is not None else constant(None)
        kind = self.widen(RESULT, value.type)
        leaves = self.converted(value, kind).leaves
        if not leaves:
            self.end("ret void")
        elif len(leaves) == 1:
            self.end(f"ret {kind.leaves[0]} {leaves[0]}")
        else:
            whole = "undef"
            for k, (leaf, x) in enumerate(zip(kind.leaves, leaves, strict=True)):
                whole = self.new(f"insertvalue {returned(kind)} {whole}, {leaf} {x}, {k}")
            self.end(f"ret {returned(kind)} {whole}")

    def do_If(self, node: ast.If) -> None:
        test = self.value(node.test)
        if test.known is not None or isinstance(test.type, Fixed):
            self.statements(node.body if test.known else node.orelse)
            return
        yes, no, after = self.label(), self.label(), self.label()
        self.branch(test, yes, no)
        self.start(yes)
        self.statements(node.body)
        ended = self.ended
        self.go(after)
        self.start(no)
        self.statements(node.orelse)
        ended &= self.ended
        self.go(after)
        if not ended:
            self.start(after)
        else:  # no statement follows
            self.start(after)
            self.end("unreachable")

    def do_While(self, node: ast.While) -> None:
        if node.orelse:
            raise Untranslatable("`while ... else`")
        again, body, after = self.label(), self.label(), self.label()
        self.go(again)
        self.start(again)
        test = self.value(node.test)
        self.branch(test, body, after)
        self.start(body)
        self.loops.append((again, after))
        self.statements(node.body)
        self.loops.pop()
        self.go(again)
        self.start(after)
        if test.known and not _breaks(node):
            self.end("unreachable")

    def do_Break(self, node: ast.Break) -> None:
        self.go(self.loops[-1][1])

    def do_Continue(self, node: ast.Continue) -> None:
        self.go(self.loops[-1][0])

    def do_For(self, node: ast.For) -> None:
        if node.orelse:
            raise Untranslatable("`for ... else`")
        match node.iter:
            case ast.Call(ast.Name("range"), arguments, []):
                self._range(node, [self.number(self.value(x), INT) for x in arguments])
            case _:
                self._unrolled(node, self.value(node.iter))

    def _range(self, node: ast.For, ends: list[Value]) -> None:
        first, last = (constant(0), *ends)[-2:] if len(ends) < 3 else ends[:2]
        step = ends[2] if len(ends) == 3 else constant(1)
        if not step.known:
            raise Untranslatable("the step of `range` has to be a literal")
        again, body, onward, after = (self.label() for _ in range(4))
        self.count += 1
        counter = f"%for.{self.count}"
        self.variables.append(f"  {counter} = alloca i64")
        self.lines.append(f"  store i64 {first.leaves[0]}, ptr {counter}")
        self.go(again)
        self.start(again)
        at = self.new(f"load i64, ptr {counter}")
        test = self.new(f"icmp {'slt' if step.known > 0 else 'sgt'} i64 {at}, {last.leaves[0]}")
        self.end(f"br i1 {test}, label %{body}, label %{after}")
        self.start(body)
        self.assign(node.target, Value(INT, (at,)))
        self.loops.append((onward, after))
        self.statements(node.body)
        self.loops.pop()
        self.go(onward)
        self.start(onward)
        following = self.new(f"add nsw i64 {at}, {step.leaves[0]}")
        self.lines.append(f"  store i64 {following}, ptr {counter}")
        self.go(again)
        self.start(after)

    def _unrolled(self, node: ast.For, over: Value) -> None:
        if not isinstance(over.type, Group):
            raise Untranslatable(f"a loop over {describe(over.type)}")
        after = self.label()
        for item in over.items:
            onward = self.label()
            self.assign(node.target, item)
            self.loops.append((onward, after))
            self.statements(node.body)
            self.loops.pop()
            self.go(onward)
            self.start(onward)
        self.go(after)
        self.start(after)

    # -- expressions -----------------------------------------------------------------------------------------

    def value(self, node: ast.expr) -> Value:
        method = getattr(self, f"on_{type(node).__name__}", None)
        if method is None:
            raise Untranslatable(f"`{ast.unparse(node)}`")
        return method(node)

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
        x = self.value(node.operand)
        if isinstance(node.op, ast.Not):
            if x.known is not None or x.type == NOTHING:
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
            return constant({"add": x.known + y.known, "sub": x.known - y.known, "mul": x.known * y.known}[OPERATIONS[type(op)]])
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
        if y.type == INT and y.known is not None and 0 < y.known <= 16:  # products, by repeated squares
            base, exponent, found = x, int(y.known), None
            while exponent:
                if exponent & 1:
                    found = base if found is None else self.operation(ast.Mult(), found, base)
                exponent >>= 1
                base = self.operation(ast.Mult(), base, base) if exponent else base
            assert found is not None
            return found
        a, b = self.number(x, FLOAT), self.number(y, FLOAT)
        if FLOAT not in (x.type, y.type):
            raise Untranslatable("`**` of integers; make one of them a float")
        pow = self.module.declare("llvm.pow.f64", "double", ("double", "double"))
        return Value(FLOAT, (self.new(f"call double {pow}(double {a.leaves[0]}, double {b.leaves[0]})"),))

    def on_Compare(self, node: ast.Compare) -> Value:
        left, tests = self.value(node.left), []
        for k, (op, right_node) in enumerate(zip(node.ops, node.comparators, strict=True)):
            right = self.value(right_node)  # kernels have no side effects in comparisons: all are evaluated
            tests.append(self.comparison(op, left, right))
            left = right
        found = tests[0]
        for test in tests[1:]:
            found = Value(BOOL, (self.new(f"and i1 {found.leaves[0]}, {test.leaves[0]}"),))
        return found

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

    def on_BoolOp(self, node: ast.BoolOp) -> Value:
        """``and``, ``or``: later operands are evaluated only if the earlier ones do not decide."""
        decides = isinstance(node.op, ast.Or)
        after, arrivals = self.label(), []
        for k, operand in enumerate(node.values):
            x = self.value(operand)
            if x.known is not None or x.type == NOTHING:
                if bool(x.known) == decides:
                    arrivals.append(("true" if decides else "false", self.block))
                    self.go(after)
                    break
                if k < len(node.values) - 1:
                    continue
            test = self.truth(x)
            arrivals.append((test, self.block))
            if k == len(node.values) - 1:
                self.go(after)
                break
            following = self.label()
            self.end(f"br i1 {test}, label %{after if decides else following}, label %{following if decides else after}")
            self.start(following)
        self.start(after)
        if len(arrivals) == 1:
            text = arrivals[0][0]
            return Value(BOOL, (text,), {"true": True, "false": False}.get(text))
        return Value(BOOL, (self.new("phi i1 " + ", ".join(f"[{x}, %{b}]" for x, b in arrivals)),))

    def on_IfExp(self, node: ast.IfExp) -> Value:
        test = self.value(node.test)
        if test.known is not None or isinstance(test.type, Fixed):
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

    # -- arrays ----------------------------------------------------------------------------------------------

    def load(self, kind: Scalar, place: str) -> str:
        return self.new(f"load {kind.leaf}, ptr {place}{TAG[kind.leaf]}")

    def store(self, kind: Scalar, place: str, value: Value) -> None:
        x = self.number(value, kind).leaves[0]
        self.lines.append(f"  store {kind.leaf} {x}, ptr {place}{TAG[kind.leaf]}")

    def place(self, node: ast.Subscript) -> tuple[Scalar, str]:
        """Type and address of an entry that is assigned."""
        of = self.value(node.value)
        if not isinstance(of.type, Array):
            raise Untranslatable(f"`{ast.unparse(node)}` is assigned")
        found = self.entry(of, node)
        if isinstance(found, Value):
            raise Untranslatable(f"`{ast.unparse(node)}` is assigned; assign its entries in a loop")
        return of.type.item, found

    def on_Subscript(self, node: ast.Subscript) -> Value:
        of = self.value(node.value)
        if isinstance(of.type, Group):
            return self.item(of, self.value(node.slice))
        if not isinstance(of.type, Array):
            raise Untranslatable(f"`{ast.unparse(node)}`")
        found = self.entry(of, node)
        return found if isinstance(found, Value) else Value(of.type.item, (self.load(of.type.item, found),))

    def entry(self, of: Value, node: ast.Subscript) -> str | Value:
        """The address of an entry of an array, or a view."""
        assert isinstance(of.type, Array)
        indices = node.slice.elts if isinstance(node.slice, ast.Tuple) else [node.slice]
        base, *shape = of.leaves
        item = of.type.item
        if len(indices) > of.type.axes or any(isinstance(x, ast.Slice) for x in indices[:-1]):
            raise Untranslatable(f"`{ast.unparse(node)}`")
        offset = ""
        for axis, index in enumerate(indices):
            below = "".join(shape[axis + 1 :])  # number of entries per step of this axis: one or two axes
            if isinstance(index, ast.Slice):
                first, length = self._bounds(index, shape[axis])
                offset = self._sum(offset, self._times(first, below))
                place = self.new(f"getelementptr inbounds {item.leaf}, ptr {base}, i64 {offset}")
                return Value(Array(of.type.axes - axis, item), (place, length, *shape[axis + 1 :]))
            at = self.index(self.value(index), shape[axis])
            offset = self._sum(offset, self._times(at, below))
        place = self.new(f"getelementptr inbounds {item.leaf}, ptr {base}, i64 {offset}")
        if len(indices) < of.type.axes:
            return Value(Array(of.type.axes - len(indices), item), (place, *shape[len(indices) :]))
        return place

    def _sum(self, a: str, b: str) -> str:
        return b if a in ("", "0") else a if b == "0" else self.new(f"add nsw i64 {a}, {b}")

    def _times(self, a: str, b: str) -> str:
        return a if not b or a == "0" else self.new(f"mul nsw i64 {a}, {b}")

    def index(self, x: Value, length: str) -> str:
        """An index; a literal may count from the end."""
        if x.type not in (INT, BOOL):
            raise Untranslatable(f"{describe(x.type)} as an index")
        at = self.number(x, INT).leaves[0]
        if x.known is not None:
            return at if x.known >= 0 else self.new(f"add nsw i64 {length}, {at}")
        return at

    def _bounds(self, node: ast.Slice, length: str) -> tuple[str, str]:
        """First index and length of a slice."""
        if node.step is not None:
            raise Untranslatable(f"`{ast.unparse(node)}`: a slice with a step")
        first = "0" if node.lower is None else self.index(self.value(node.lower), length)
        last = length
        smaller = self.module.declare("llvm.smin.i64", "i64", ("i64", "i64"))
        larger = self.module.declare("llvm.smax.i64", "i64", ("i64", "i64"))
        if node.upper is not None:
            last = self.index(self.value(node.upper), length)
            last = self.new(f"call i64 {smaller}(i64 {last}, i64 {length})")
        size = self.new(f"sub nsw i64 {last}, {first}")
        return first, self.new(f"call i64 {larger}(i64 {size}, i64 0)")

    def item(self, of: Value, index: Value) -> Value:
        """An item of a tuple; if the index is not a literal, all items have the same type."""
        items = of.items
        if index.known is not None:
            return items[int(index.known)]
        at = self.index(index, "")
        kind = items[0].type
        for x in items[1:]:
            kind = join(kind, x.type)
        items = [self.converted(x, kind) for x in items]
        leaves = []
        for k, leaf in enumerate(kind.leaves):
            entries = [x.leaves[k] for x in items]
            if not any(x.startswith("%") for x in entries):
                table = self.module.table(leaf, entries)
                place = self.new(f"getelementptr inbounds {leaf}, ptr {table}, i64 {at}")
                leaves.append(self.new(f"load {leaf}, ptr {place}"))
                continue
            found = entries[0]
            for number, x in enumerate(entries[1:], 1):
                here = self.new(f"icmp eq i64 {at}, {number}")
                found = self.new(f"select i1 {here}, {leaf} {x}, {leaf} {found}")
            leaves.append(found)
        return Value(kind, tuple(leaves))

    # -- calls -----------------------------------------------------------------------------------------------

    def on_Call(self, node: ast.Call) -> Value:
        function = self.value(node.func)
        arguments = [self.value(x) for x in node.args]
        named = {x.arg: self.value(x.value) for x in node.keywords}
        if isinstance(function.type, Pointer):
            return self.pointer_call(function, arguments)
        if not isinstance(function.type, Fixed):
            raise Untranslatable(f"`{ast.unparse(node)}`")
        called = function.type.value
        if isinstance(called, type) and hasattr(called, "_fields"):
            return group([*arguments, *(named[f] for f in called._fields[len(arguments) :])], called)
        called = getattr(called, "py_func", called)
        if getattr(called, "__mbdsl_kernel__", False):
            return self.kernel_call(called, arguments, named)
        if named or not callable(called):
            raise Untranslatable(f"`{ast.unparse(node)}`")
        return self.builtin_call(called, arguments, node)

    def kernel_call(self, called: Callable, arguments: list[Value], named: dict) -> Value:
        bound = inspect.signature(called).bind(*arguments, **named)
        bound.apply_defaults()
        given = [x if isinstance(x, Value) else constant(x) for x in bound.arguments.values()]
        symbol, gives = self.module.kernel(called, tuple(x.type for x in given))
        passed = ", ".join(f"{leaf} {x}" for v in given for leaf, x in zip(v.type.leaves, v.leaves, strict=True))
        if not gives.leaves:
            self.lines.append(f"  call void {symbol}({passed})")
            return Value(gives)
        result = self.new(f"call {returned(gives)} {symbol}({passed})")
        if len(gives.leaves) == 1:
            return Value(gives, (result,))
        return Value(
            gives,
            tuple(self.new(f"extractvalue {returned(gives)} {result}, {k}") for k in range(len(gives.leaves))),
        )

    def pointer_call(self, function: Value, arguments: list[Value]) -> Value:
        """The call of a compiled function by its address."""
        assert isinstance(function.type, Pointer)
        signature = function.type.signature
        words: list[tuple[str, str]] = []
        for kind, x in zip(signature.takes, arguments, strict=True):
            wanted = of_argument(kind)
            x = self.converted(x, wanted)
            words += _spread(x, self.new) if isinstance(wanted, Array) else zip(wanted.leaves, x.leaves, strict=True)
        passed = ", ".join(f"{leaf} {x}" for leaf, x in words)
        if signature.gives == "int":
            return Value(INT, (self.new(f"call i64 {function.leaves[0]}({passed})"),))
        self.lines.append(f"  call void {function.leaves[0]}({passed})")
        return constant(None)

    def builtin_call(self, called: Callable, arguments: list[Value], node: ast.Call) -> Value:
        if called is marks.square:
            of, at = arguments
            place = self.new(f"getelementptr inbounds double, ptr {of.leaves[0]}, i64 {at.leaves[0]}")
            return Value(Array(2, FLOAT), (place, "6", "6"))
        if called is len and isinstance(arguments[0].type, Array):
            return Value(INT, (arguments[0].leaves[1],))
        if called is len and isinstance(arguments[0].type, Group):
            return constant(len(arguments[0].items))
        if not arguments or not all(isinstance(x.type, Scalar) for x in arguments):
            raise Untranslatable(f"`{ast.unparse(node)}`")
        if called in (max, min) and len(arguments) > 1:
            return self.extreme(ast.Gt() if called is max else ast.Lt(), arguments)
        if called is abs:
            (x,) = arguments
            if x.type == FLOAT:
                fabs = self.module.declare("llvm.fabs.f64", "double", ("double",))
                return Value(FLOAT, (self.new(f"call double {fabs}(double {x.leaves[0]})"),))
            x = self.number(x, INT)
            absolute = self.module.declare("llvm.abs.i64", "i64", ("i64", "i1"))
            return Value(INT, (self.new(f"call i64 {absolute}(i64 {x.leaves[0]}, i1 false)"),))
        if called in (int, float, bool):
            return self.number(arguments[0], {int: INT, float: FLOAT, bool: BOOL}[called])
        name = getattr(called, "__name__", "")
        of_math = getattr(called, "__module__", "") == "math" or type(called).__name__ == "ufunc"
        if of_math and (name in INTRINSICS or name in LIBRARY):
            words = [self.number(x, FLOAT).leaves[0] for x in arguments]
            symbol = INTRINSICS.get(name) or LIBRARY[name]
            symbol = self.module.declare(symbol, "double", ("double",) * len(words))
            result = self.new(f"call double {symbol}({', '.join(f'double {x}' for x in words)})")
            if name in ("floor", "ceil") and type(called).__name__ != "ufunc":  # those of the module math give integers
                return self.number(Value(FLOAT, (result,)), INT)
            return Value(FLOAT, (result,))
        raise Untranslatable(f"`{ast.unparse(node)}`: this function is not available in kernels")

    def extreme(self, op: ast.cmpop, arguments: list[Value]) -> Value:
        """max or min, with Python's choice where values are equal or not numbers."""
        found = arguments[0]
        for x in arguments[1:]:
            kind = join(found.type, x.type)
            kind = INT if kind == BOOL else kind
            found, x = self.converted(found, kind), self.converted(x, kind)
            test = self.comparison(op, x, found).leaves[0]
            leaf = kind.leaves[0]
            found = Value(kind, (self.new(f"select i1 {test}, {leaf} {x.leaves[0]}, {leaf} {found.leaves[0]}"),))
        return found


RESULT = "return"  #: the key of the result among the types of variables, which no variable can have
ZERO = {"i64": "0", "double": literal(0.0), "i1": "false", "ptr": "null"}


def _breaks(loop: ast.While) -> bool:
    """Whether a loop contains a ``break`` of its own."""

    def own(body: list[ast.stmt]) -> Iterator[ast.stmt]:
        for x in body:
            yield x
            if isinstance(x, ast.If):
                yield from own([*x.body, *x.orelse])

    return any(isinstance(x, ast.Break) for x in own(loop.body))


# -- entries -------------------------------------------------------------------------------------------------


def _spread(array: Value, new: Callable[[str], str]) -> list[tuple[str, str]]:
    """The words by which an array is passed to a compiled function: those of numba's arrays, which are two pointers for
    memory that numba manages, number of entries, size of an entry, address, shape and strides."""
    base, *shape = array.leaves
    count = new(f"mul i64 {shape[0]}, {shape[1]}") if len(shape) == 2 else shape[0]
    strides = [new(f"mul i64 {shape[1]}, 8"), "8"] if len(shape) == 2 else ["8"]
    words = [("ptr", "null"), ("ptr", "null"), ("i64", count), ("i64", "8"), ("ptr", base)]
    return words + [("i64", x) for x in (*shape, *strides)]


def _add_entries(module: Module, name: str, function: Callable, signature: Signature) -> None:
    """The functions ``name``, and ``name.packed`` with the arguments in one block of words: arrays as address, shape."""
    kinds = tuple(of_argument(kind) for kind in signature.takes)
    symbol, gives = module.kernel(function, kinds)
    wanted = "i64" if signature.gives == "int" else "void"
    if gives != (INT if signature.gives == "int" else NOTHING):
        raise Untranslatable(f"`{function.__name__}` returns {describe(gives)}")
    takes, passed, loads, packed = [], [], [], []
    at = 0
    for k, kind in enumerate(kinds):
        if isinstance(kind, Array):
            words = ["ptr", "ptr", "i64", "i64", "ptr", *["i64"] * (2 * kind.axes)]
            takes += [f"{leaf} %in.{k}.{i}" for i, leaf in enumerate(words)]
            passed += [f"ptr %in.{k}.4", *(f"i64 %in.{k}.{5 + i}" for i in range(kind.axes))]
        else:
            takes.append(f"{kind.leaves[0]} %in.{k}.0")
            passed.append(f"{kind.leaves[0]} %in.{k}.0")
        for leaf in kind.leaves:
            loads.append(f"  %p{at} = getelementptr i64, ptr %block, i64 {at}")
            loads.append(f"  %w{at} = load {leaf}, ptr %p{at}")
            packed.append(f"{leaf} %w{at}")
            at += 1
    result, give = ("%r = ", "  ret i64 %r") if wanted == "i64" else ("", "  ret void")
    module.lines += [
        f'define {wanted} @"{name}"({", ".join(takes)}) nounwind {{',
        f"  {result}call {wanted} {symbol}({', '.join(passed)})",
        give,
        "}",
        f'define i64 @"{name}.packed"(ptr %block) nounwind {{',
        *loads,
        f"  {result}call {wanted} {symbol}({', '.join(packed)})",
        "  ret i64 %r" if wanted == "i64" else "  ret i64 0",
        "}",
    ]


# -- sources -------------------------------------------------------------------------------------------------


def syntax_tree(function: Callable) -> ast.FunctionDef:
    return _functions_of(sys.modules[function.__module__])[function.__name__]


@cache
def _functions_of(module: ModuleType) -> dict[str, ast.FunctionDef]:
    """The functions of a module by name."""
    text = vars(module).get(marks.TEXT) or Path(str(module.__file__)).read_text(encoding="utf-8")
    return {node.name: node for node in ast.parse(text).body if isinstance(node, ast.FunctionDef)}
