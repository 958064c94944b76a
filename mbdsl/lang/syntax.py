"""The syntax tree of a text, before names are resolved.

Every node has its place (``at``), which comparisons ignore. :mod:`mbdsl.lang.unparse` prints trees.
"""

from __future__ import annotations

import collections.abc
from dataclasses import dataclass, field, fields
from typing import TYPE_CHECKING, Any

from mbdsl.lang.source import At
from mbdsl.lang.units import Unit

if TYPE_CHECKING:
    from typing_extensions import dataclass_transform

    @dataclass_transform(eq_default=False, frozen_default=True, field_specifiers=(field,))
    def node(kind: type) -> type: ...

else:
    # Nodes are frozen for the type checker only: generating the methods of frozen classes would take longer than the
    # rest of the import of this file, and longer than reading a model.
    node = dataclass(slots=True, eq=False, repr=False)


@node
class Node:
    """Any piece of syntax."""

    # Comparison and repr are written once, here: generating thirty would take a third of the start-up time.
    at: At = field(default=None, compare=False, repr=False, kw_only=True)

    def _content(self) -> tuple:
        return tuple(getattr(self, f.name) for f in fields(self) if f.compare)

    def __eq__(self, other: object) -> bool:
        return type(self) is type(other) and self._content() == other._content()

    def __hash__(self) -> int:
        return hash((type(self), self._content()))

    def __repr__(self) -> str:
        shown = ", ".join(f"{f.name}={getattr(self, f.name)!r}" for f in fields(self) if f.repr)
        return f"{type(self).__name__}({shown})"


def children(node: object) -> collections.abc.Iterator[Node]:
    """The nodes of which a node, or a tuple of nodes and tuples, consists."""
    for part in node._content() if isinstance(node, Node) else node if isinstance(node, tuple) else ():
        if isinstance(part, Node):
            yield part
        else:
            yield from children(part)


def inside(node: object) -> collections.abc.Iterator[Node]:
    """All nodes of a piece of syntax, each before those in it."""
    if isinstance(node, Node):
        yield node
    for part in children(node):
        yield from inside(part)


# -- expressions ---------------------------------------------------------------------------------------------------


@node
class Expression(Node):
    """A piece of syntax that has a value."""

    depth: int = field(default=1, compare=False, repr=False, kw_only=True)  #: operations inside each other


@node
class Number(Expression):
    """``3 kg``"""

    value: float | int
    unit: Unit | None = None


@node
class String(Expression):
    """A text, ``"..."``."""

    value: str


@node
class Boolean(Expression):
    """``true`` or ``false``"""

    value: bool


@node
class Last(Expression):
    """``end`` as an index."""


@node
class Everything(Expression):
    """``:`` as an index."""


@node
class NamePart(Node):
    """One name of a reference with its indices."""

    name: str
    indices: tuple[Expression, ...] = ()


@node
class Reference(Expression):
    """``arm.link[3].b``"""

    steps: tuple[NamePart, ...]


@node
class Unary(Expression):
    """``-x``, ``not x``"""

    operator: str
    operand: Expression


@node
class Binary(Expression):
    """``x + y``"""

    operator: str
    left: Expression
    right: Expression


@node
class Choice(Expression):
    """``if`` condition ``then`` value, ... ``else`` value"""

    branches: tuple[tuple[Expression, Expression], ...]
    otherwise: Expression


@node
class Range(Expression):
    """``start:step:stop``"""

    start: Expression
    step: Expression | None
    stop: Expression


@node
class ArrayNode(Expression):
    """``{a, b} unit``; a matrix ``[a, b; c, d]`` is an array of arrays."""

    items: tuple[Expression, ...]
    unit: Unit | None = None


@node
class Iterator(Node):
    """``i in 1:N``"""

    name: str
    values: Expression


@node
class Comprehension(Expression):
    """``{item for i in 1:N}``"""

    item: Expression
    iterators: tuple[Iterator, ...]
    unit: Unit | None = None


@node
class Argument(Node):
    """One argument of a call or modifier: a value alone, or ``name(modifiers) = value``."""

    name: str = ""
    value: Expression | None = None
    modifiers: tuple[Argument, ...] = ()
    indices: tuple[Expression, ...] = ()
    each: bool = False
    final: bool = False


@node
class Literal(Expression):
    """A value that the Builder inserts into the tree; text never creates one."""

    value: Any


@node
class Call(Expression):
    """``f(x)``, or modifiers after a name"""

    function: Reference
    arguments: tuple[Argument, ...]


# -- declarations --------------------------------------------------------------------------------------------------


@node
class Item(Node):
    """An item of a model."""


@node
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
    notes: tuple[Argument, ...] = ()  #: arguments of its annotation
    type_at: At = field(default=None, compare=False, repr=False)


@node
class Extends(Item):
    """``extends Base(m = 1 kg);``"""

    base: str
    arguments: tuple[Argument, ...] = ()


@node
class Annotation(Item):
    """``annotation(...);``"""

    arguments: tuple[Argument, ...]


@node
class Connect(Item):
    """``connect(a, b);``"""

    first: Expression
    second: Expression
    notes: tuple[Argument, ...] = ()  #: arguments of its annotation


@node
class Relation(Item):
    """Any other equation; it occurs only in error messages."""

    left: Expression
    right: Expression | None


@node
class Initial(Item):
    """``guess rod.phi = 10 deg;``, or ``initial(state = steady);`` with the target ``state``"""

    mode: str  #: "fixed", "guess" or "state"
    target: Expression
    value: Expression


@node
class For(Item):
    """``for i in 1:N loop ... end for;``"""

    iterators: tuple[Iterator, ...]
    items: tuple[Item, ...]


@node
class If(Item):
    """``if condition then ... else ... end if;``, the condition of ``else`` is None"""

    branches: tuple[tuple[Expression | None, tuple[Item, ...]], ...]


@node
class When(Item):
    """``when condition then ... elsewhen condition then ... end when;``"""

    branches: tuple[tuple[Expression, tuple[Item, ...]], ...]


@node
class Model(Node):
    """``model Name ... end Name;``"""

    name: str
    doc: str
    items: tuple[Item, ...]  #: declarations, extends clauses and annotations
    equations: tuple[Item, ...]
    initial: tuple[Item, ...]
    partial: bool = False
    spatial: bool = False


@node
class Function(Node):
    """``function f ... end f;``, whose ``assigned`` names have one expression each, in their order"""

    name: str
    doc: str
    inputs: tuple[Declaration, ...]
    outputs: tuple[Declaration, ...]
    declared: tuple[Declaration, ...]  #: inputs, outputs and intermediate values
    assigned: tuple[tuple[str, Expression], ...]


@node
class Import(Node):
    """``import "parts.mbd" as parts;``"""

    path: str
    alias: str = ""


@node
class Passed(Node):
    """A statement without an effect, as ``within Library``."""

    text: str


@node
class File(Node):
    """A whole text: imports and models."""

    name: str
    imports: tuple[Import, ...]
    models: tuple[Model, ...]
    passed: tuple[Passed, ...] = field(default=(), compare=False)
    functions: tuple[Function, ...] = ()
