"""Entries and views of arrays, and items of tuples."""

from __future__ import annotations

import ast

from mbdsl.compilation.kernel_code import Code, translates
from mbdsl.compilation.kernel_types import (
    BOOL,
    INT,
    Array,
    Group,
    Scalar,
    Untranslatable,
    Value,
    constant,
    describe,
    join,
)

#: marks of the types of memory that :data:`mbdsl.compilation.llvm_module.METADATA` defines
TAG = {"double": ", !tbaa !3", "i64": ", !tbaa !4"}


def load(code: Code, kind: Scalar, place: str) -> str:
    return code.new(f"load {kind.leaf}, ptr {place}{TAG[kind.leaf]}")


def store(code: Code, kind: Scalar, place: str, value: Value) -> None:
    x = code.number(value, kind).leaves[0]
    code.lines.append(f"  store {kind.leaf} {x}, ptr {place}{TAG[kind.leaf]}")


def assigned_entry(code: Code, node: ast.Subscript) -> tuple[Scalar, str]:
    """Type and address of an entry that is assigned."""
    of = code.value(node.value)
    if not isinstance(of.type, Array):
        raise Untranslatable(f"`{ast.unparse(node)}` is assigned")
    found = entry_of(code, of, node)
    if isinstance(found, Value):
        raise Untranslatable(f"`{ast.unparse(node)}` is assigned; assign its entries in a loop")
    return of.type.item, found


@translates(ast.Subscript)
def _subscript(code: Code, node: ast.Subscript) -> Value:
    of = code.value(node.value)
    if isinstance(of.type, Group):
        return item_of(code, of, code.value(node.slice))
    if not isinstance(of.type, Array):
        raise Untranslatable(f"`{ast.unparse(node)}`")
    found = entry_of(code, of, node)
    return found if isinstance(found, Value) else Value(of.type.item, (load(code, of.type.item, found),))


def entry_of(code: Code, of: Value, node: ast.Subscript) -> str | Value:
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
            first, length = _bounds(code, index, shape[axis])
            offset = _sum(code, offset, _times(code, first, below))
            place = code.new(f"getelementptr inbounds {item.leaf}, ptr {base}, i64 {offset}")
            return Value(Array(of.type.axes - axis, item), (place, length, *shape[axis + 1 :]))
        at = index_of(code, code.value(index), shape[axis])
        offset = _sum(code, offset, _times(code, at, below))
    place = code.new(f"getelementptr inbounds {item.leaf}, ptr {base}, i64 {offset}")
    if len(indices) < of.type.axes:
        return Value(Array(of.type.axes - len(indices), item), (place, *shape[len(indices) :]))
    return place


def _sum(code: Code, a: str, b: str) -> str:
    return b if a in ("", "0") else a if b == "0" else code.new(f"add nsw i64 {a}, {b}")


def _times(code: Code, a: str, b: str) -> str:
    return a if not b or a == "0" else code.new(f"mul nsw i64 {a}, {b}")


def index_of(code: Code, x: Value, length: str) -> str:
    """An index. A negative one counts from the end, as in Python; in kernels of mbdsl, which have no other negative
    indices, only if it is a literal: the check takes time."""
    if x.type not in (INT, BOOL):
        raise Untranslatable(f"{describe(x.type)} as an index")
    at = code.number(x, INT).leaves[0]
    if x.known is not None:
        return at if x.known >= 0 else code.new(f"add nsw i64 {length}, {at}")
    if not code.of_user:
        return at
    negative, from_end = code.new(f"icmp slt i64 {at}, 0"), code.new(f"add nsw i64 {length}, {at}")
    return code.new(f"select i1 {negative}, i64 {from_end}, i64 {at}")


def _bounds(code: Code, node: ast.Slice, length: str) -> tuple[str, str]:
    """First index and length of a slice."""
    if node.step is not None:
        raise Untranslatable(f"`{ast.unparse(node)}`: a slice with a step")
    last = length
    smaller = code.module.declare("llvm.smin.i64", "i64", ("i64", "i64"))
    larger = code.module.declare("llvm.smax.i64", "i64", ("i64", "i64"))
    lower = code.value(node.lower) if node.lower is not None else constant(0)
    first = index_of(code, lower, length)
    if lower.known < 0 if lower.known is not None else code.of_user:
        first = code.new(f"call i64 {larger}(i64 {first}, i64 0)")
    if node.upper is not None:
        last = index_of(code, code.value(node.upper), length)
        last = code.new(f"call i64 {smaller}(i64 {last}, i64 {length})")
    size = code.new(f"sub nsw i64 {last}, {first}")
    return first, code.new(f"call i64 {larger}(i64 {size}, i64 0)")


def item_of(code: Code, of: Value, index: Value) -> Value:
    """An item of a tuple; if the index is not a literal, all items have the same type."""
    items = of.items
    if index.known is not None:
        return items[int(index.known)]
    at = index_of(code, index, str(len(items)))
    kind = items[0].type
    for x in items[1:]:
        kind = join(kind, x.type)
    items = [code.converted(x, kind) for x in items]
    leaves = []
    for k, leaf in enumerate(kind.leaves):
        entries = [x.leaves[k] for x in items]
        if not any(x.startswith("%") for x in entries):
            table = code.module.table(leaf, entries)
            place = code.new(f"getelementptr inbounds {leaf}, ptr {table}, i64 {at}")
            leaves.append(code.new(f"load {leaf}, ptr {place}"))
            continue
        found = entries[0]
        for number, x in enumerate(entries[1:], 1):
            here = code.new(f"icmp eq i64 {at}, {number}")
            found = code.new(f"select i1 {here}, {leaf} {x}, {leaf} {found}")
        leaves.append(found)
    return Value(kind, tuple(leaves))
