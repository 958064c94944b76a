"""Types and values of kernels: every value is a list of LLVM scalars, its leaves."""

from __future__ import annotations

import struct
from dataclasses import dataclass, field
from numbers import Integral, Real
from typing import Any, NamedTuple

from mbdsl.compilation.native_call import ARRAYS, Signature
from mbdsl.errors import UsageError


class Untranslatable(UsageError):
    """A kernel contains Python that :mod:`mbdsl.compilation.translation` does not translate; docs/kernels.md lists
    what it translates."""


class Scalar(NamedTuple):
    name: str  #: "int", "float" or "bool"
    leaf: str  #: its type in LLVM

    @property
    def leaves(self) -> tuple[str, ...]:
        return (self.leaf,)


INT, FLOAT, BOOL = Scalar("int", "i64"), Scalar("float", "double"), Scalar("bool", "i1")


class Array(NamedTuple):
    """A C-contiguous array: the address of its first entry, and its shape."""

    axes: int
    item: Scalar

    @property
    def leaves(self) -> tuple[str, ...]:
        return ("ptr", *["i64"] * self.axes)


class Group(NamedTuple):
    """A tuple; ``named`` is the class of a named tuple."""

    items: tuple[Type, ...]
    named: Any = None

    @property
    def leaves(self) -> tuple[str, ...]:
        return tuple(leaf for item in self.items for leaf in item.leaves)


class Pointer(NamedTuple):
    """The address of a compiled function."""

    signature: Signature

    @property
    def leaves(self) -> tuple[str, ...]:
        return ("ptr",)


class Fixed(NamedTuple):
    """A function, a module, a class or None, known when the kernel is translated; without leaves."""

    value: object

    @property
    def leaves(self) -> tuple[str, ...]:
        return ()


Type = Scalar | Array | Group | Pointer | Fixed
NOTHING = Fixed(None)


@dataclass(frozen=True)
class Value:
    type: Type
    leaves: tuple[str, ...] = ()  #: operands of LLVM instructions
    known: int | float | bool | None = field(default=None, compare=False)  #: of a scalar that is a constant

    @property
    def items(self) -> list[Value]:
        """The items of a tuple."""
        assert isinstance(self.type, Group)
        found, at = [], 0
        for kind in self.type.items:
            end = at + len(kind.leaves)
            found.append(constant(kind.value) if isinstance(kind, Fixed) else _with_known(kind, self.leaves[at:end]))
            at = end
        return found


def _with_known(kind: Type, leaves: tuple[str, ...]) -> Value:
    """A value; an integer that is a literal is known."""
    if kind == INT and not leaves[0].startswith("%"):
        return Value(kind, leaves, int(leaves[0]))
    return Value(kind, leaves)


def group(items: list[Value], named: type | None = None) -> Value:
    return Value(Group(tuple(x.type for x in items), named), tuple(leaf for x in items for leaf in x.leaves))


def constant(value: object) -> Value:
    """The value of a literal, or of a global name of a kernel's module."""
    if isinstance(value, bool):
        return Value(BOOL, ("true" if value else "false",), value)
    if isinstance(value, Integral):
        return Value(INT, (str(int(value)),), int(value))
    if isinstance(value, Real):
        return Value(FLOAT, (literal(float(value)),), float(value))
    if isinstance(value, tuple):
        return group([constant(x) for x in value], type(value) if type(value) is not tuple else None)
    return Value(Fixed(value))


def literal(value: float) -> str:
    """A number in LLVM's exact notation."""
    return f"0x{struct.unpack('<Q', struct.pack('<d', value))[0]:016X}"


def of_argument(kind: str | Signature) -> Type:
    """The type of an argument of a compiled function."""
    if isinstance(kind, Signature):
        return Pointer(kind)
    if kind in ARRAYS:
        axes, entry = ARRAYS[kind]
        return Array(axes, FLOAT if entry.kind == "f" else INT)
    return FLOAT if kind == "float" else INT


def join(one: Type, other: Type) -> Type:
    """The type of a variable that is assigned values of both types."""
    if one == other:
        return one
    if isinstance(one, Scalar) and isinstance(other, Scalar):
        return FLOAT if FLOAT in (one, other) else INT
    if isinstance(one, Group) and isinstance(other, Group) and len(one.items) == len(other.items):
        named = one.named if one.named is other.named else None
        return Group(tuple(join(a, b) for a, b in zip(one.items, other.items, strict=True)), named)
    raise Untranslatable(f"a variable is both {describe(one)} and {describe(other)}")


def describe(kind: Type) -> str:
    if isinstance(kind, Scalar):
        return f"{kind.name}"
    if isinstance(kind, Array):
        return f"an array with {kind.axes} axes of {kind.item.name}"
    if isinstance(kind, Group):
        return f"({', '.join(map(describe, kind.items))})"
    return "a compiled function" if isinstance(kind, Pointer) else repr(kind.value)
