"""From calls with values of Python to declarations of the language."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from typing import Any, TypeAlias

from mbdsl.elements.kind import BodyKind, Kind
from mbdsl.errors import ModelError, UsageError
from mbdsl.expressions.spatial_coordinates import NAMES
from mbdsl.expressions.symbolic import COORDINATES
from mbdsl.lang import python_values
from mbdsl.lang import syntax as s
from mbdsl.lang.builder.draft import Draft
from mbdsl.lang.builder.handles import Handle, Law, Place
from mbdsl.lang.builder.kind_methods import KindMethods, known
from mbdsl.lang.calls import CallLine, GivenText
from mbdsl.lang.event_functions import ACTIONS
from mbdsl.lang.experiment import check_effects
from mbdsl.lang.load import deep
from mbdsl.lang.mistakes.events import no_action
from mbdsl.lang.parser import read_expression
from mbdsl.lang.unparse import indices, write, write_argument
from mbdsl.messages import count, did_you_mean

#: what a when-equation of a Builder does: texts as in a model, or new values of variables
Action: TypeAlias = str | Mapping[Place, Law]
_ASSIGNMENT = re.compile(r"([\w.]+(?:\[[^\]]*\])?)\s*=(?!=)\s*(.*)", re.DOTALL)


class Declarations(KindMethods):
    """The declarations of a Builder, and its handles."""

    name: str
    doc: str
    spatial = False  #: whether it makes models in space

    def __init__(self) -> None:
        self._draft = Draft(self.spatial)

    def __repr__(self) -> str:
        return f"<Builder of {self.name}: {count(len(self._draft.content.entries), 'declaration')}>"

    def _repr_html_(self) -> str:
        from mbdsl.plotting.figures import TextTable
        from mbdsl.plotting.html_tables import fragment

        declared = [entry.declaration for entry in self._draft.content.entries.values()]
        rows = [(d.name + indices(d.indices), _type(d), _arguments(d), d.doc) for d in declared]
        found = TextTable("", ("name", "kind", "frames and values", "description"), rows)
        return fragment(f"{self.name}: {self.doc}" if self.doc else self.name, (), [found])

    @property
    def coordinates(self) -> tuple[str, ...]:
        """Names of the coordinates of a frame, which are its signals."""
        return NAMES if self.spatial else COORDINATES

    def _declare(
        self,
        name: str,
        type_name: str,
        kind: Kind | None,
        doc: str,
        frames: Sequence[Place],
        values: Mapping[str, Any],
        replace: bool,
    ) -> Handle:
        """Declare a component, frame or table by its frames and values."""
        python_values.split_name(name, type_name)
        if kind is not None:
            values = {key: python_values.of_kind(kind, name, key, value) for key, value in values.items()}
            if kind.coupled:
                values, frames = self._by_name(kind, name, frames, values), ()
            if frames and not kind.ports:
                hint = f"give its parameters by name: `{type_name}({name!r}, {kind.parameters[0].name}=...)`"
                raise UsageError(f"{type_name} `{name}` takes no frames, found {frames[0]!r}", hint=hint)
        ports = kind.ports if kind is not None and len(kind.ports) == len(frames) else ["frame"] * len(frames)
        given = [s.Argument("", self._place(f, f"{name}.{port}")) for f, port in zip(frames, ports, strict=True)]
        with deep():
            given += [
                python_values.argument(key, value, name, self._handle_name)
                for key, value in values.items()
                if value is not None
            ]
        return self._enter(name, frozenset(), type_name, doc, replace, arguments=tuple(given))

    @staticmethod
    def _by_name(kind: Kind, name: str, given: Sequence[Any], values: Mapping[str, Any]) -> dict[str, Any]:
        """The values of a joint without frames, with the coordinates that are ``given`` by position."""
        if len(given) > len(kind.coupled):
            takes = count(len(kind.coupled), "coordinate")
            raise UsageError(f"{kind.name} `{name}` takes {takes}, found {len(given)}")
        found = dict(zip(kind.coupled, given, strict=False))
        if twice := [key for key in found if values.get(key) is not None]:
            raise UsageError(f"`{twice[0]}` of {kind.name} `{name}` is given twice")
        return found | {key: value for key, value in values.items() if value is not None}

    def _enter(
        self, name: str, prefixes: frozenset[str], type_name: str, doc: str, replace: bool, **parts: Any
    ) -> Handle:
        what = type_name or "parameter"
        plain, numbers = python_values.split_name(name, what)
        value = not (type_name in ("Frame", "Table") or type_name in known(self.spatial))
        if numbers and value:
            hint = "an array of parameters is given as a sequence of values"
            raise UsageError(f"{name!r}: only components, frames and tables have indices", hint=hint)
        text = python_values.text(doc, f"{name}.doc")
        if value and type_name:
            start = next((a.value for a in parts.get("arguments", ()) if a.name == "start"), None)
            numbers = (s.Everything(),) * _rank(parts.get("value") or start)
        d = s.Declaration(prefixes, type_name, plain, numbers, doc=text, **parts, at=(CallLine(), 0, 0))
        serial = self._draft.declare(d, python_values.flag(replace, "replace"))
        return Handle(self, name.replace(" ", ""), serial)

    def _is_component(self, name: str) -> bool:
        return self._draft.content.entries[name].declaration.type in known(self.spatial)

    def names_of(self, handle: Handle) -> Sequence[str]:
        """Names of the frames, ports and signals of a component, or of the signals of a frame.

        Parameters
        ----------
        handle : Handle
            The component or frame.

        Returns
        -------
        sequence of str
        """
        name = self._name(handle, "handle")
        if self._is_component(name):
            return self._draft.part(name).known_names()
        return self.coordinates if self._draft.content.entries[name].declaration.type == "Frame" else ()

    def _handle_name(self, given: object) -> str | None:
        """The name of a handle. Handles of another Builder and of removed components are refused."""
        if not isinstance(given, Handle):
            return None
        if given._owner is not self:
            raise UsageError(
                f"`{given}` belongs to another Builder, of {given._owner.name}, and not to this one, of {self.name}",
                hint=f"use a handle from this Builder, or give the name as a string: {str(given)!r}",
            )
        entry = self._draft.content.entries.get(given._root)
        if entry is None or entry.serial != given._serial:
            raise UsageError(
                f"`{given}`: `{given._root}` was removed from {self.name}",
                hint="use the handle of a component that was added later" if entry is not None else None,
            )
        return str(given)

    def _name(self, given: Place, what: str) -> str:
        name = self._handle_name(given)
        return python_values.text(given, what) if name is None else name

    def _place(self, frame: Place, what: str) -> s.Expression:
        if not isinstance(frame, Handle | str):
            raise UsageError(
                f"{what}: found {frame!r}, expected a frame or signal",
                hint="they are attributes of components: `rod.b`, `rod.phi`",
            )
        return read_expression(GivenText(what, self._name(frame, what)))

    def _node(self, value: Any, what: str) -> s.Expression:
        with deep():
            return python_values.expression(value, what, self._handle_name)

    def _actions(self, given: Sequence[Action], what: str) -> tuple[s.Item, ...]:
        """The statements of a branch of a when-equation."""
        found: list[s.Item] = []
        for action in given:
            if isinstance(action, Mapping):
                found += [self._assignment(target, value, what) for target, value in action.items()]
                continue
            text = python_values.text(action, what).strip().removesuffix(";")
            if (match := _ASSIGNMENT.fullmatch(text)) is not None:
                found.append(self._assignment(match[1], match[2], what))
                continue
            node = self._node(text, what)
            if not (isinstance(node, s.Call) and write(node.function) in ACTIONS):
                raise no_action(node)
            found.append(s.Relation(node, None, at=(CallLine(), 0, 0)))
        if not found:
            hint = """e.g. b.when("sample(0, 1 ms)", {"u": "-2*rod.phi"}, 'terminate("done")')"""
            raise UsageError(f"{what}: there is nothing to do", hint=hint)
        return tuple(found)

    def _assignment(self, target: Place, value: Any, what: str) -> s.Relation:
        left = self._place(target, what)
        return s.Relation(left, self._node(value, f"{what}: {write(left)}"), at=(CallLine(), 0, 0))

    def _root(self, given: Place, what: str) -> str:
        """The name of a component."""
        return self._name(given, what).replace(" ", "")

    def _start(self, mode: str, target: s.Expression, value: s.Expression, replace: bool) -> None:
        item = s.Initial(mode, target, value, at=(CallLine(), 0, 0))
        self._draft.initial(item, python_values.flag(replace, "replace"))

    def _shapes(self, name: str, parts: Sequence[str]) -> s.Argument:
        """The annotation with the shapes of a body."""
        entries = self._draft.content.entries
        of = {key: known(self.spatial).get(e.declaration.type) for key, e in entries.items()}
        bodies = [key for key, kind in of.items() if isinstance(kind, BodyKind)]
        if name not in bodies:
            raise ModelError(f"`{name}` is not a body", hint=did_you_mean(name, bodies, "bodies"))
        with deep():
            texts = [python_values.text(part, f"the shape of {name}") for part in parts]
            graphics = s.ArrayNode(tuple(read_expression(GivenText(f"shape of {name}", text)) for text in texts))
        return s.Argument("Shape", None, (s.Argument("graphics", graphics),))

    @staticmethod
    def _effects(without: str | Sequence[str]) -> s.ArrayNode:
        """Names of effects to leave out."""
        if not isinstance(without, str | Sequence):
            raise UsageError(f"without: found {without!r}, expected names of effects")
        effects = [python_values.text(x, "without") for x in ([without] if isinstance(without, str) else without)]
        return s.ArrayNode(tuple(map(s.String, check_effects(effects))))


def _rank(e: s.Expression | None) -> int:
    """Number of dimensions of a sequence."""
    return 1 + _rank(e.items[0] if e.items else None) if isinstance(e, s.ArrayNode) else 0


def displayed(name: str, unit: str) -> tuple[s.Argument, ...]:
    """The attribute ``displayUnit`` of a declaration."""
    text = python_values.text(unit, f"{name}.display_unit")
    return (s.Argument("displayUnit", s.String(text)),) if text else ()


def _type(d: s.Declaration) -> str:
    return " ".join([*sorted(d.prefixes), d.type] if d.type else sorted(d.prefixes))


def _arguments(d: s.Declaration) -> str:
    """The frames and values of a declaration, as in a text."""
    given = [write_argument(a) for a in d.arguments] + ([f"= {write(d.value)}"] if d.value is not None else [])
    return ", ".join(given)
