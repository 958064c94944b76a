"""The entities that names of a model denote: parameters, arrays of components, frames, tables, sub-models."""

from __future__ import annotations

from collections.abc import Callable
from itertools import pairwise
from typing import TYPE_CHECKING, Any, Union

from mbdsl.errors import ModelError, Span
from mbdsl.expressions import symbolic
from mbdsl.lang import argument_checks, units, values
from mbdsl.lang.connections import PortNode
from mbdsl.lang.modifiers import Contexts, Modifier, Modifiers
from mbdsl.lang.source import At, placed, span_of
from mbdsl.lang.values import Quantity, Value
from mbdsl.mechanism.scene import Frame, Input
from mbdsl.mechanism.scene_parts import Table

if TYPE_CHECKING:
    from mbdsl.lang.flat_component import FlatComponent
    from mbdsl.lang.flat_model import Assembly
    from mbdsl.lang.scope import SignalEntity

SMOOTHNESS = ("linear", "cubic", "monotone")
EXTRAPOLATION = ("hold", "linear", "periodic", "error")
TABLE_ARGUMENTS = ("table", "file", "x", "y", "smoothness", "extrapolation")

#: two columns of numbers, and their dimensions
Columns2 = tuple[tuple[float, ...], tuple[float, ...], units.Dimension | None, units.Dimension | None]


class Namespace:
    """The names of one model or sub-model. ``name`` is "" for the main model."""

    def __init__(
        self, assembly: Assembly, name: str = "", parent: Namespace | None = None, contexts: Contexts = ()
    ) -> None:
        self.assembly = assembly
        self.name = name
        self.parent = parent
        self.contexts = contexts
        self.members: dict[str, Entity] = {}
        self.places: dict[str, At] = {}  # where names were declared
        self.pending: dict[str, Callable[[], None]] = {}  # declared, but not made yet

    def full(self, name: str) -> str:
        return f"{self.name}.{name}" if self.name else name

    def find(self, name: str) -> Entity | None:
        found = self.members.get(name)
        if found is None and name in self.pending:
            make = self.pending.pop(name)
            make()
            found = self.members.get(name)
        return found

    def names(self) -> list[str]:
        return list(dict.fromkeys([*self.members, *self.pending]))

    def declare(self, name: str, at: At) -> None:
        """Register a name, which must be new."""
        if name == "time":
            raise ModelError("`time` is the name of the simulated time, it cannot be declared", span_of(at))
        if name in self.places:
            first = span_of(self.places[name])
            notes = (("first declared here", first),) if first else ()
            raise ModelError(f"`{self.full(name)}` is declared twice", span_of(at), notes=notes)
        self.places[name] = at


class Many:
    """Several entities named together: ``link.a``, ``link[2:4]``."""

    __slots__ = ("items",)

    def __init__(self, items: list) -> None:
        self.items = items


class Disabled:
    """A component whose condition is false."""

    __slots__ = ("at", "name")

    def __init__(self, name: str, at: At) -> None:
        self.name = name
        self.at = at


class ComponentArray:
    """Components with indices. In a loop they are added one by one."""

    __slots__ = ("at", "items", "name", "sizes")

    def __init__(self, name: str, rank: int, at: At) -> None:
        self.name = name
        self.at = at
        self.items: dict[tuple[int, ...], Entity] = {}
        self.sizes = (0,) * rank

    def add(self, index: tuple[int, ...], entity: Entity) -> None:
        self.items[index] = entity
        self.sizes = tuple(map(max, self.sizes, index))

    def shape(self) -> tuple[int, ...]:
        return self.sizes

    def in_order(self) -> list[Entity]:
        return [self.items[key] for key in sorted(self.items)]

    def select(self, positions: list[list[int] | int], owner: str, at: At) -> Entity:
        if len(positions) == 1 and isinstance(positions[0], int) and (only := self.items.get((positions[0],))):
            return only
        keys: list[tuple[int, ...]] = [()]
        single = True
        for position in positions:
            if isinstance(position, int):
                keys = [(*key, position) for key in keys]
            else:
                single = False
                keys = [(*key, i) for key in keys for i in position]
        found = []
        for key in keys:
            if key not in self.items:
                shown = ", ".join(map(str, key))
                raise ModelError(f"`{owner}[{shown}]` is not declared", span_of(at))
            found.append(self.items[key])
        return found[0] if single else Many(found)


class Slot:
    """A parameter, constant or variable: a name with a value, which is evaluated when it is first requested."""

    def __init__(
        self, assembly: Assembly, name: str, make: Callable[[], Value], at: At, doc: str = "", unit: str = ""
    ) -> None:
        self.assembly = assembly
        self.name = name
        self.at = at
        self.doc = doc
        self.unit = unit
        self.constant = True
        self.derived = False  #: whether an equation gives its derivative
        self.discrete = False  #: whether a when-equation sets it
        self.inputs: tuple[Input, ...] = ()  # the inputs with this name
        self.display: tuple[Modifier, str] | None = None  # the attribute and the unit in which it is displayed
        self._make = make
        self._value: Value | None = None

    def value(self) -> Value:
        if self._value is None:
            with self.assembly.defining(self, f"`{self.name}`", self.at):
                self._value = self._make()
        return self._value


class FrameMember:
    """A frame with a name of its own: fixed to a body, or an alias of a frame or port."""

    def __init__(
        self,
        assembly: Assembly,
        name: str,
        make: Callable[[], Frame | PortNode],
        at: At,
        base: Callable[[], Frame | PortNode | FlatComponent] | None = None,
    ) -> None:
        self.assembly = assembly
        self.name = name
        self.at = at
        self.base = base  #: what it is fixed to
        self._make = make
        self._target: Frame | PortNode | None = None

    def target(self) -> Frame | PortNode:
        if self._target is None:
            with self.assembly.defining(self, f"`{self.name}`", self.at):
                self._target = self._make()
        return self._target


class TableMember:
    """A function defined by points."""

    def __init__(self, assembly: Assembly, name: str, modifiers: Modifiers, at: At) -> None:
        self.assembly = assembly
        self.name = name
        self.at = at
        self.modifiers = modifiers
        self._made: tuple[Table, units.Dimension | None, units.Dimension | None] | None = None

    def made(self) -> tuple[Table, units.Dimension | None, units.Dimension | None]:
        """The table, and the dimensions of its two columns."""
        if self._made is None:
            with self.assembly.defining(self, f"`{self.name}`", self.at):
                self._made = self._make()
        return self._made

    def _make(self) -> tuple[Table, units.Dimension | None, units.Dimension | None]:
        given, file = self.modifiers.get("table"), self.modifiers.get("file")
        if file is not None and file.value is not None:
            if given is not None and given.value is not None:
                raise ModelError(
                    f"Table `{self.name}` has both `table` and `file`", given.value_span(), "leave one out"
                )
            span, what = file.value_span(), f"`file` of `{self.name}`"
            u, y, u_dimension, y_dimension = self._of_file(span)
        elif given is not None and given.value is not None:
            span, what = given.value_span(), f"`table` of `{self.name}`"
            u, y, u_dimension, y_dimension = self._of_points(given, what)
        else:
            raise ModelError(
                f"Table `{self.name}` needs `table`",
                span_of(self.at),
                'write `table = [0 s, 0 N; 1 s, 2 N]`, or `file = "road.csv", x = "s", y = "z"`',
            )
        smoothness = self._choice("smoothness", SMOOTHNESS)
        extrapolation = self._choice("extrapolation", EXTRAPOLATION)
        if extrapolation == "periodic" and y[0] != y[-1]:
            raise ModelError(f"{what} is periodic, but begins with {y[0]:g} and ends with {y[-1]:g}", span)
        return Table(self.name, u, y, smoothness, extrapolation), u_dimension, y_dimension

    def _of_file(self, span: Span | None) -> Columns2:
        """The columns of a file, and their dimensions."""
        file, x, y = (self._text(name) for name in ("file", "x", "y"))
        library = self.assembly.library
        if library is None or file is None:
            raise ModelError(
                f"Table `{self.name}`: a file belongs to a model in a file",
                span,
                "in Python give the points: `table=list(zip(s, z))`",
            )
        naming = self.at[0].file if self.at is not None else ""
        first, second = library.columns(file, naming, x, y, span)
        return first.numbers, second.numbers, first.dimension, second.dimension

    def _text(self, name: str) -> str | None:
        """The value of an argument that is a text; None if it is not given."""
        from mbdsl.elements.declaration import Parameter

        modifier = self.modifiers.get(name)
        if modifier is None or modifier.value is None:
            return None
        with placed(modifier.value.at):
            return argument_checks.argument(Parameter(name, ""), modifier.evaluate(), self.name)

    def _of_points(self, given: Modifier, what: str) -> Columns2:
        """The columns of ``table``, and their dimensions."""
        for name in ("x", "y"):
            if name in self.modifiers:
                raise ModelError(f"`{name}` names a column of `file`", span_of(self.modifiers[name].at))
        span = given.value_span()
        rows = given.evaluate()
        found = values.shape(rows)
        if len(found) != 2 or found[1] != 2:
            raise ModelError(
                f"{what}: found {argument_checks.shape_words(found)}, expected rows of two values `[u, y; ...]`", span
            )
        if found[0] < 2:
            raise ModelError(f"{what} has {found[0]} row, it needs at least 2", span)
        with placed(given.value_at):
            (u, u_dimension), (y, y_dimension) = (self._column(rows, k) for k in (0, 1))
        for k, (before, after) in enumerate(pairwise(u)):
            if not before < after:
                raise ModelError(
                    f"{what}: the first column must grow, but row {k + 2} has {after:g} after {before:g}", span
                )
        return u, y, u_dimension, y_dimension

    def _column(self, rows: Any, k: int) -> tuple[tuple[float, ...], units.Dimension | None]:
        what = f"column {k + 1} of `{self.name}`"
        dimension = None
        numbers = []
        for row in rows:
            q = values.numeric(row[k], what)
            dimension = values.common(Quantity(0, dimension), q, what)
            numbers.append(argument_checks.number(q, what))
        return tuple(numbers), dimension

    def _choice(self, name: str, choices: tuple[str, ...]) -> str:
        from mbdsl.elements.declaration import Parameter

        modifier = self.modifiers.get(name)
        if modifier is None or modifier.value is None:
            return choices[0]
        with placed(modifier.value.at):
            return argument_checks.argument(Parameter(name, "", choices=choices), modifier.evaluate(), self.name)

    def at_argument(self, argument: Value, varying: bool) -> Quantity:
        table, u_dimension, y_dimension = self.made()
        q = values.numeric(argument, f"`{self.name}`")
        if u_dimension is not None:
            argument_checks.fit(q, u_dimension, f"the argument of `{self.name}`")
        if not varying:
            raise ModelError(f"the table `{self.name}` is used in laws only; this value must be known before the start")
        node = symbolic.Expr("table", (q.expression,), (table, 0))
        return Quantity(node, y_dimension)


Entity = Union[
    Quantity,
    tuple,
    Slot,
    "SignalEntity",
    Frame,
    PortNode,
    FrameMember,
    TableMember,
    "FlatComponent",
    ComponentArray,
    Many,
    Disabled,
    Namespace,
]
