"""Kernels to LLVM code: a translator for the part of Python in which kernels are written.

Kernels are functions of numbers and arrays without allocation: assignments, arithmetic, comparisons, ``if``, ``while``,
``for`` over ``range`` or a tuple, calls of kernels and of the functions in :mod:`mbdsl.compilation.kernel_calls`,
views of arrays, tuples and named tuples. A kernel is translated once for each combination of argument types; functions
among the arguments are constants of that translation. Variables are memory on the stack, which LLVM turns into
registers. The types of variables follow from their assignments; if an assignment requires a wider type than the code
before it assumes, the kernel is translated again.

Arithmetic is that of Python without its errors: a division by zero gives inf or nan (of integers: 0), and indices are
not checked.
The code has the same results with every level of optimisation, because LLVM does not reorder floating-point operations.
"""

from __future__ import annotations

import ast
from collections.abc import Callable, Iterator, Mapping

from mbdsl.compilation.entry_points import block_entry, result
from mbdsl.compilation.kernel_calls import Calls
from mbdsl.compilation.kernel_code import RESULT, Widened, returned
from mbdsl.compilation.kernel_types import (
    INT,
    NOTHING,
    Array,
    Fixed,
    Group,
    Type,
    Untranslatable,
    Value,
    constant,
    describe,
    of_argument,
)
from mbdsl.compilation.llvm_module import Module
from mbdsl.compilation.native_call import Signature


def translate(name: str, functions: Mapping[str, Callable], signatures: Mapping[str, Signature]) -> str:
    """LLVM code of a module with the entries ``name.function`` and ``name.function.packed``.

    Raises
    ------
    Untranslatable
        If a kernel contains something that is not translated.
    """
    module = Module(Kernel.translated)
    for key, function in functions.items():
        _add_entries(module, f"{name}.{key}", function, signatures[key])
    return module.text()


class Kernel(Calls):
    """The translation of one kernel for one combination of argument types."""

    @classmethod
    def translated(cls, module: Module, function: Callable, symbol: str, takes: tuple[Type, ...], apart: bool) -> Type:
        types: dict[str, Type] = {}
        for _ in range(100):
            kernel = cls(module, function, takes, types)
            try:
                kernel._body()
            except Widened:
                continue
            except Untranslatable as problem:
                if problem.args[1:]:
                    raise
                line = getattr(kernel.node, "lineno", 0)
                raise Untranslatable(f"{function.__module__}, line {line}: {problem}", True) from None
            gives = types.get(RESULT, NOTHING)
            if isinstance(gives, Fixed) and gives is not NOTHING and gives.value is not None:
                raise Untranslatable(f"`{function.__name__}` returns {describe(gives)}")
            arguments = [
                f"{leaf}{' noalias' if apart and i == 0 and isinstance(kind, Array) else ''} %in.{k}.{i}"
                for k, kind in enumerate(takes)
                for i, leaf in enumerate(kind.leaves)
            ]
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

    def _body(self) -> None:
        for name, value in self.given.items():
            if name in self.assigned:
                self.assign_name(name, value)
        self.statements(self.tree.body)
        if not self.ended:
            if RESULT in self.types and self.types[RESULT] != NOTHING:
                raise Untranslatable("one end of the function returns a value, and another does not")
            self.end("ret void")

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
            old = Value(kind, (self.load(kind, place),))
            self.store(kind, place, self.operation(node.op, old, self.value(node.value)))
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
        test = self.condition(node.test)
        if test.known is not None:
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
        test = self.condition(node.test)
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
        self.end(f"br label %{again}, !llvm.loop {self.module.loop()}")
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


def _breaks(loop: ast.While) -> bool:
    """Whether a loop contains a ``break`` of its own."""

    def own(body: list[ast.stmt]) -> Iterator[ast.stmt]:
        for x in body:
            yield x
            if isinstance(x, ast.If):
                yield from own([*x.body, *x.orelse])

    return any(isinstance(x, ast.Break) for x in own(loop.body))


def _add_entries(module: Module, name: str, function: Callable, signature: Signature) -> None:
    """The functions ``name`` and ``name.packed``: see :mod:`mbdsl.compilation.entry_points`."""
    kinds = tuple(of_argument(kind) for kind in signature.takes)
    symbol, gives = module.kernel(function, kinds, apart=True)
    if gives != (INT if signature.gives == "int" else NOTHING):
        raise Untranslatable(f"`{function.__name__}` returns {describe(gives)}")
    takes = ", ".join(leaf for kind in kinds for leaf in kind.leaves)
    module.lines.append(f'@"{name}" = alias {result(signature)} ({takes}), ptr {symbol}')
    module.lines += block_entry(f"{name}.packed", symbol, signature)
