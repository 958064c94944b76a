"""Entries and views of arrays, and items of tuples."""

from __future__ import annotations

import ast

from mbdsl.compilation.kernel_expressions import Expressions
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


class Arrays(Expressions):
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
        """An index. A negative one counts from the end, as in Python; in kernels of mbdsl, which have no other negative
        indices, only if it is a literal: the check takes time."""
        if x.type not in (INT, BOOL):
            raise Untranslatable(f"{describe(x.type)} as an index")
        at = self.number(x, INT).leaves[0]
        if x.known is not None:
            return at if x.known >= 0 else self.new(f"add nsw i64 {length}, {at}")
        if not self.of_user:
            return at
        negative, from_end = self.new(f"icmp slt i64 {at}, 0"), self.new(f"add nsw i64 {length}, {at}")
        return self.new(f"select i1 {negative}, i64 {from_end}, i64 {at}")

    def _bounds(self, node: ast.Slice, length: str) -> tuple[str, str]:
        """First index and length of a slice."""
        if node.step is not None:
            raise Untranslatable(f"`{ast.unparse(node)}`: a slice with a step")
        last = length
        smaller = self.module.declare("llvm.smin.i64", "i64", ("i64", "i64"))
        larger = self.module.declare("llvm.smax.i64", "i64", ("i64", "i64"))
        lower = self.value(node.lower) if node.lower is not None else constant(0)
        first = self.index(lower, length)
        if lower.known < 0 if lower.known is not None else self.of_user:
            first = self.new(f"call i64 {larger}(i64 {first}, i64 0)")
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
        at = self.index(index, str(len(items)))
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
