"""Statements of kernels: assignments, branches, loops."""

from __future__ import annotations

import ast
from collections.abc import Iterator

from mbdsl.compilation.kernel_arrays import assigned_entry, load, store
from mbdsl.compilation.kernel_code import RESULT, Code, returned, translates
from mbdsl.compilation.kernel_expressions import condition, operation
from mbdsl.compilation.kernel_types import INT, Group, Untranslatable, Value, constant, describe


def translate_body(code: Code, body: list[ast.stmt]) -> None:
    for statement in body:
        if code.ended:
            return
        code.node = statement
        code.translated(statement)


@translates(ast.Pass)
def _pass(code: Code, node: ast.Pass) -> None:
    pass


@translates(ast.Expr)
def _expr(code: Code, node: ast.Expr) -> None:
    if not isinstance(node.value, ast.Constant):
        code.value(node.value)


@translates(ast.Assign)
def _assign(code: Code, node: ast.Assign) -> None:
    value = code.value(node.value)
    for target in node.targets:
        assign(code, target, value)


@translates(ast.AugAssign)
def _aug_assign(code: Code, node: ast.AugAssign) -> None:
    if isinstance(node.target, ast.Name):
        old = code.read_name(node.target.id)
        code.assign_name(node.target.id, operation(code, node.op, old, code.value(node.value)))
    elif isinstance(node.target, ast.Subscript):
        kind, place = assigned_entry(code, node.target)
        old = Value(kind, (load(code, kind, place),))
        store(code, kind, place, operation(code, node.op, old, code.value(node.value)))
    else:
        raise Untranslatable(f"`{ast.unparse(node)}`")


def assign(code: Code, target: ast.expr, value: Value) -> None:
    if isinstance(target, ast.Name):
        code.assign_name(target.id, value)
    elif isinstance(target, ast.Tuple):
        if not isinstance(value.type, Group) or len(value.type.items) != len(target.elts):
            raise Untranslatable(f"{describe(value.type)} is assigned to `{ast.unparse(target)}`")
        for part, item in zip(target.elts, value.items, strict=True):
            assign(code, part, item)
    elif isinstance(target, ast.Subscript):
        kind, place = assigned_entry(code, target)
        store(code, kind, place, value)
    else:
        raise Untranslatable(f"`{ast.unparse(target)}` is assigned")


@translates(ast.Return)
def _return(code: Code, node: ast.Return) -> None:
    value = code.value(node.value) if node.value is not None else constant(None)
    kind = code.widen(RESULT, value.type)
    leaves = code.converted(value, kind).leaves
    if not leaves:
        code.end("ret void")
    elif len(leaves) == 1:
        code.end(f"ret {kind.leaves[0]} {leaves[0]}")
    else:
        whole = "undef"
        for k, (leaf, x) in enumerate(zip(kind.leaves, leaves, strict=True)):
            whole = code.new(f"insertvalue {returned(kind)} {whole}, {leaf} {x}, {k}")
        code.end(f"ret {returned(kind)} {whole}")


@translates(ast.If)
def _if(code: Code, node: ast.If) -> None:
    test = condition(code, node.test)
    if test.known is not None:
        translate_body(code, node.body if test.known else node.orelse)
        return
    yes, no, after = code.label(), code.label(), code.label()
    code.branch(test, yes, no)
    code.start(yes)
    translate_body(code, node.body)
    ended = code.ended
    code.go(after)
    code.start(no)
    translate_body(code, node.orelse)
    ended &= code.ended
    code.go(after)
    if not ended:
        code.start(after)
    else:  # no statement follows
        code.start(after)
        code.end("unreachable")


@translates(ast.While)
def _while(code: Code, node: ast.While) -> None:
    if node.orelse:
        raise Untranslatable("`while ... else`")
    again, body, after = code.label(), code.label(), code.label()
    code.go(again)
    code.start(again)
    test = condition(code, node.test)
    code.branch(test, body, after)
    code.start(body)
    code.loops.append((again, after))
    translate_body(code, node.body)
    code.loops.pop()
    code.go(again)
    code.start(after)
    if test.known and not _breaks(node):
        code.end("unreachable")


@translates(ast.Break)
def _break(code: Code, node: ast.Break) -> None:
    code.go(code.loops[-1][1])


@translates(ast.Continue)
def _continue(code: Code, node: ast.Continue) -> None:
    code.go(code.loops[-1][0])


@translates(ast.For)
def _for(code: Code, node: ast.For) -> None:
    if node.orelse:
        raise Untranslatable("`for ... else`")
    match node.iter:
        case ast.Call(ast.Name("range"), arguments, []):
            _over_range(code, node, [code.number(code.value(x), INT) for x in arguments])
        case _:
            _unrolled(code, node, code.value(node.iter))


def _over_range(code: Code, node: ast.For, ends: list[Value]) -> None:
    first, last = (constant(0), *ends)[-2:] if len(ends) < 3 else ends[:2]
    step = ends[2] if len(ends) == 3 else constant(1)
    if not step.known:
        raise Untranslatable("the step of `range` has to be a literal")
    again, body, onward, after = (code.label() for _ in range(4))
    code.count += 1
    counter = f"%for.{code.count}"
    code.variables.append(f"  {counter} = alloca i64")
    code.lines.append(f"  store i64 {first.leaves[0]}, ptr {counter}")
    code.go(again)
    code.start(again)
    at = code.new(f"load i64, ptr {counter}")
    test = code.new(f"icmp {'slt' if step.known > 0 else 'sgt'} i64 {at}, {last.leaves[0]}")
    code.end(f"br i1 {test}, label %{body}, label %{after}")
    code.start(body)
    assign(code, node.target, Value(INT, (at,)))
    code.loops.append((onward, after))
    translate_body(code, node.body)
    code.loops.pop()
    code.go(onward)
    code.start(onward)
    following = code.new(f"add nsw i64 {at}, {step.leaves[0]}")
    code.lines.append(f"  store i64 {following}, ptr {counter}")
    code.end(f"br label %{again}, !llvm.loop {code.module.loop()}")
    code.start(after)


def _unrolled(code: Code, node: ast.For, over: Value) -> None:
    if not isinstance(over.type, Group):
        raise Untranslatable(f"a loop over {describe(over.type)}")
    after = code.label()
    for item in over.items:
        onward = code.label()
        assign(code, node.target, item)
        code.loops.append((onward, after))
        translate_body(code, node.body)
        code.loops.pop()
        code.go(onward)
        code.start(onward)
    code.go(after)
    code.start(after)


def _breaks(loop: ast.While) -> bool:
    """Whether a loop contains a ``break`` of its own."""

    def own(body: list[ast.stmt]) -> Iterator[ast.stmt]:
        for x in body:
            yield x
            if isinstance(x, ast.If):
                yield from own([*x.body, *x.orelse])

    return any(isinstance(x, ast.Break) for x in own(loop.body))
