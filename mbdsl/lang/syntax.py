"""The syntax tree: what was written, before any name means anything.

Every node knows its place (``at``), which plays no part in comparisons. ``dump`` prints a tree.
"""

from __future__ import annotations

from dataclasses import dataclass, field, fields

from mbdsl.lang.source import At
from mbdsl.lang.units import Unit


@dataclass(frozen=True, slots=True, kw_only=True)
class Node:
    at: At = field(default=None, compare=False, repr=False)


# -- expressions ---------------------------------------------------------------------------------------------------


@dataclass(frozen=True, slots=True)
class Expression(Node):
    depth: int = field(default=1, compare=False, repr=False, kw_only=True)  #: operations inside each other


@dataclass(frozen=True, slots=True)
class Number(Expression):
    value: float | int
    unit: Unit | None = None


@dataclass(frozen=True, slots=True)
class String(Expression):
    value: str


@dataclass(frozen=True, slots=True)
class Boolean(Expression):
    value: bool


@dataclass(frozen=True, slots=True)
class Last(Expression):
    """``end`` as an index."""


@dataclass(frozen=True, slots=True)
class Everything(Expression):
    """``:`` as an index."""


@dataclass(frozen=True, slots=True)
class Step(Node):
    """One name of a reference with its indices."""

    name: str
    indices: tuple[Expression, ...] = ()


@dataclass(frozen=True, slots=True)
class Reference(Expression):
    """``arm.link[3].b``"""

    steps: tuple[Step, ...]


@dataclass(frozen=True, slots=True)
class Unary(Expression):
    operator: str
    operand: Expression


@dataclass(frozen=True, slots=True)
class Binary(Expression):
    operator: str
    left: Expression
    right: Expression


@dataclass(frozen=True, slots=True)
class Choice(Expression):
    """``if`` condition ``then`` value, ... ``else`` value"""

    branches: tuple[tuple[Expression, Expression], ...]
    otherwise: Expression


@dataclass(frozen=True, slots=True)
class Range(Expression):
    start: Expression
    step: Expression | None
    stop: Expression


@dataclass(frozen=True, slots=True)
class Array(Expression):
    """``{a, b} unit``; a matrix ``[a, b; c, d]`` is an array of arrays."""

    items: tuple[Expression, ...]
    unit: Unit | None = None


@dataclass(frozen=True, slots=True)
class Iterator(Node):
    name: str
    values: Expression


@dataclass(frozen=True, slots=True)
class Comprehension(Expression):
    """``{item for i in 1:N}``"""

    item: Expression
    iterators: tuple[Iterator, ...]
    unit: Unit | None = None


@dataclass(frozen=True, slots=True)
class Argument(Node):
    """One argument of a call or modifier: a value alone, or ``name(modifiers) = value``."""

    name: str = ""
    value: Expression | None = None
    modifiers: tuple[Argument, ...] = ()
    indices: tuple[Expression, ...] = ()
    each: bool = False
    final: bool = False


@dataclass(frozen=True, slots=True)
class Literal(Expression):
    """A value put into the tree by the library; text never makes one."""

    value: object


@dataclass(frozen=True, slots=True)
class Call(Expression):
    function: Reference
    arguments: tuple[Argument, ...]


# -- declarations --------------------------------------------------------------------------------------------------


@dataclass(frozen=True, slots=True)
class Item(Node):
    """Something in a model."""


@dataclass(frozen=True, slots=True)
class Declaration(Item):
    """``parameter Real k[3](min = 0) = {1, 2, 3} if c "doc"``"""

    prefixes: frozenset[str]
    type: str  #: dotted name, "" where it is left out
    name: str
    indices: tuple[Expression, ...] = ()
    arguments: tuple[Argument, ...] = ()
    value: Expression | None = None
    condition: Expression | None = None
    doc: str = ""
    type_at: At = field(default=None, compare=False, repr=False)


@dataclass(frozen=True, slots=True)
class Extends(Item):
    base: str
    arguments: tuple[Argument, ...] = ()


@dataclass(frozen=True, slots=True)
class Annotation(Item):
    arguments: tuple[Argument, ...]


@dataclass(frozen=True, slots=True)
class Connect(Item):
    first: Expression
    second: Expression


@dataclass(frozen=True, slots=True)
class Relation(Item):
    """Any other equation; only messages need it."""

    left: Expression
    right: Expression | None


@dataclass(frozen=True, slots=True)
class Initial(Item):
    mode: str  #: "fixed" or "guess"
    target: Expression
    value: Expression


@dataclass(frozen=True, slots=True)
class For(Item):
    iterators: tuple[Iterator, ...]
    items: tuple[Item, ...]


@dataclass(frozen=True, slots=True)
class If(Item):
    branches: tuple[tuple[Expression | None, tuple[Item, ...]], ...]


@dataclass(frozen=True, slots=True)
class Model(Node):
    name: str
    doc: str
    items: tuple[Item, ...]  #: declarations, extends clauses and annotations
    equations: tuple[Item, ...]
    initial: tuple[Item, ...]
    partial: bool = False


@dataclass(frozen=True, slots=True)
class Import(Node):
    path: str
    alias: str = ""


@dataclass(frozen=True, slots=True)
class File(Node):
    name: str
    imports: tuple[Import, ...]
    models: tuple[Model, ...]


# -- text ----------------------------------------------------------------------------------------------------------


def write(e: Expression | None) -> str:
    """An expression as text of the language."""
    match e:
        case None:
            return ""
        case Number(value, unit):
            return f"{value!r} {unit.text}" if unit else repr(value)
        case String(value):
            return '"' + value.replace("\\", "\\\\").replace('"', '\\"').replace("\n", "\\n") + '"'
        case Boolean(value):
            return "true" if value else "false"
        case Last():
            return "end"
        case Everything():
            return ":"
        case Reference(steps):
            return ".".join(s.name + _indices(s.indices) for s in steps)
        case Unary(operator, operand):
            return f"{operator}{' ' if operator.isalpha() else ''}{_inner(operand)}"
        case Binary():
            # Long sums lean to the left; they are written without recursion, and without parentheses where equal.
            parts: list[str] = []
            while True:
                parts += (_inner(e.right), e.operator)  # type: ignore[union-attr]
                left = e.left  # type: ignore[union-attr]
                if not (isinstance(left, Binary) and _PRECEDENCE[left.operator] == _PRECEDENCE[e.operator] != 6):  # type: ignore[union-attr]
                    return " ".join([_inner(left), *reversed(parts)])
                e = left
        case Choice(branches, otherwise):
            parts = " elseif ".join(f"{write(c)} then {write(v)}" for c, v in branches)
            return f"if {parts} else {write(otherwise)}"
        case Range(start, step, stop):
            return ":".join(_inner(x) for x in (start, step, stop) if x is not None)
        case Array(items, unit):
            return "{" + ", ".join(map(write, items)) + "}" + (f" {unit.text}" if unit else "")
        case Comprehension(item, iterators, unit):
            return "{" + f"{write(item)} for {_iterators(iterators)}" + "}" + (f" {unit.text}" if unit else "")
        case Literal(value):
            return str(value)
        case Call(function, arguments):
            return f"{write(function)}({', '.join(map(write_argument, arguments))})"
    raise TypeError(f"no expression: {e!r}")


_PRECEDENCE = {
    "or": 1,
    "and": 2,
    "==": 3,
    "<>": 3,
    "<": 3,
    "<=": 3,
    ">": 3,
    ">=": 3,
    "+": 4,
    "-": 4,
    "*": 5,
    "/": 5,
    "^": 6,
}


def _inner(e: Expression) -> str:
    return f"({write(e)})" if isinstance(e, Binary | Unary | Choice | Range) else write(e)


def _indices(indices: tuple[Expression, ...]) -> str:
    return f"[{', '.join(map(write, indices))}]" if indices else ""


def _iterators(iterators: tuple[Iterator, ...]) -> str:
    return ", ".join(f"{i.name} in {write(i.values)}" for i in iterators)


def write_argument(a: Argument) -> str:
    if not a.name:
        return write(a.value)
    words = ("each " if a.each else "") + ("final " if a.final else "") + a.name + _indices(a.indices)
    inner = f"({', '.join(map(write_argument, a.modifiers))})" if a.modifiers else ""
    return words + inner + (f" = {write(a.value)}" if a.value is not None else "")


def dump(node: Node, level: int = 0) -> str:
    """The tree, one item a line, indented by its depth."""
    pad = "  " * level
    match node:
        case File(name, imports, models):
            lines = [f"File {name}"]
            lines += [f'  Import "{i.path}"' + (f" as {i.alias}" if i.alias else "") for i in imports]
            return "\n".join(lines + [dump(m, level + 1) for m in models])
        case Model():
            lines = [f"{pad}Model {node.name}" + (" (partial)" if node.partial else "")]
            for title, items in (("", node.items), ("equation", node.equations), ("initial", node.initial)):
                if items and title:
                    lines.append(f"{pad}  {title}")
                lines += [dump(i, level + (2 if title else 1)) for i in items]
            return "\n".join(lines)
        case For(iterators, items):
            return "\n".join([f"{pad}For {_iterators(iterators)}", *(dump(i, level + 1) for i in items)])
        case If(branches):
            lines = []
            for condition, items in branches:
                lines.append(f"{pad}If {write(condition)}" if condition is not None else f"{pad}Else")
                lines += [dump(i, level + 1) for i in items]
            return "\n".join(lines)
    shown = []
    for f in fields(node):
        value = getattr(node, f.name)
        if f.name in ("at", "type_at", "doc") or value in ((), "", None, frozenset()):
            continue
        if isinstance(value, Expression):
            value = write(value)
        elif isinstance(value, frozenset):
            value = " ".join(sorted(value))
        elif isinstance(value, tuple):
            value = ", ".join(write_argument(v) if isinstance(v, Argument) else write(v) for v in value)
        shown.append(f"{f.name}={value}")
    return f"{pad}{type(node).__name__} {' '.join(shown)}"
