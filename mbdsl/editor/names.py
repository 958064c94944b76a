"""The names in a file, each with what it denotes: for hover, go to definition, references and rename."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from itertools import pairwise

from mbdsl.editor import entities as e
from mbdsl.editor.entities import Entity, OfKind, Symbol
from mbdsl.editor.vocabulary import class_of
from mbdsl.lang import lexer, modelica_names
from mbdsl.lang import syntax as s
from mbdsl.lang.functions import CONSTANTS
from mbdsl.lang.library import SourceUnit, key_of
from mbdsl.lang.scope import of_model
from mbdsl.lang.source import At

#: what a name denotes, if that has members or a type
Found = Entity | OfKind | tuple[s.Model, SourceUnit] | None


@dataclass(frozen=True)
class Occurrence:
    """A name in a text, from ``start`` to ``end``; ``found`` is what it denotes, if that has members or a type."""

    start: int
    end: int
    symbol: Symbol
    declares: bool = False
    found: Found = field(default=None, compare=False)


@dataclass(frozen=True)
class _Place:
    """Where an expression stands: its model and the names of it, loop variables, the component whose law it may be."""

    owner: s.Model
    members: Mapping[str, Entity]
    loops: Mapping[str, Symbol] = field(default_factory=dict)
    own: Entity | None = None

    def inside(self, own: Entity | None) -> _Place:
        return replace(self, own=own)


class NameIndex:
    """The names of a file.

    Parameters
    ----------
    unit : SourceUnit
        The file, with the files that it imports.

    Attributes
    ----------
    occurrences : list of Occurrence
        In the order of the text.
    """

    def __init__(self, unit: SourceUnit) -> None:
        self.unit = unit
        self._key = key_of(unit.file.name)
        self._found: dict[int, Occurrence] = {}
        self.occurrences: list[Occurrence] = []
        if not unit.file.models:
            return
        for name, start, end in self._aliases:
            self._add(start, end, Symbol(e.ALIAS, name, self._key), declares=True)
        for model in unit.file.models:
            self._model(model)
        self.occurrences = [self._found[at] for at in sorted(self._found)]

    def at(self, offset: int) -> Occurrence | None:
        """The name at an offset, or the one that ends there."""
        touching = [o for o in self.occurrences if o.start <= offset <= o.end]
        return touching[-1] if touching else None

    def of(self, symbol: Symbol) -> list[Occurrence]:
        """The names that denote a symbol."""
        return [o for o in self.occurrences if o.symbol == symbol]

    # -- models ------------------------------------------------------------------------------------------------

    @cached_property
    def _words(self) -> list[lexer.Token]:
        return [p for p in lexer.pieces(self.unit.text) if p.kind in (lexer.KEYWORD, lexer.NAME, lexer.STRING)]

    @cached_property
    def _aliases(self) -> list[tuple[str, int, int]]:
        aliases = [b for a, b in pairwise(self._words) if a.text == "as" and b.kind == lexer.NAME]
        return [(b.text, b.start, b.end) for b in aliases]

    @cached_property
    def _ends(self) -> dict[str, lexer.Token]:
        """Model -> its name after `end`."""
        ends = [b for a, b in pairwise(self._words) if (a.text, a.kind) == ("end", lexer.KEYWORD)]
        return {b.text: b for b in ends if b.kind == lexer.NAME}

    def _model(self, model: s.Model) -> None:
        symbol = Symbol(e.MODEL, model.name, self._key)
        self._name(model.at, symbol, True, (model, self.unit))
        if (end := self._ends.get(model.name)) is not None:
            self._add(end.start, end.end, symbol, found=(model, self.unit))
        self._visit((*model.items, *model.equations, *model.initial), _Place(model, e.members(model, self.unit)))

    def _visit(self, nodes: Iterable[s.Node | None], place: _Place) -> None:
        """Note the names in statements and expressions."""
        # Long sums are deep on their left side; a stack replaces the recursion.
        pending = [(x, place) for x in nodes if x is not None]
        while pending:
            x, place = pending.pop()
            inner: Iterable[s.Node] = ()
            if isinstance(x, s.Declaration):
                self._declaration(x, place)
            elif isinstance(x, s.Extends):
                self._type(x.base, x.at)
                base = self.unit.find(x.base)
                self._modifiers(x.arguments, e.members(*base) if base is not None else {}, place)
            elif isinstance(x, s.Argument):
                self._values((x,), place)
            elif isinstance(x, s.Call):
                self._function(x.function, place)
                self._values(x.arguments, place)
            elif isinstance(x, s.For | s.Comprehension):
                place = self._loops(x.iterators, place)
                inner = x.items if isinstance(x, s.For) else (x.item,)
            elif not (isinstance(x, s.Initial) and x.mode == "state"):
                if isinstance(x, s.Reference):
                    self.resolve(x, place)
                inner = s.children(x)
            pending += [(part, place) for part in inner]

    # -- declarations ------------------------------------------------------------------------------------------

    def _declaration(self, d: s.Declaration, place: _Place) -> None:
        found = e.entity(d, place.owner, self.unit)
        self._type(d.type, d.type_at)
        self._name(d.at, found.symbol, True, found)
        self._visit((*d.indices, d.condition, d.value), place)
        self._values(d.notes, place)
        self._arguments(found, d.arguments, place)

    def _type(self, name: str, at: At) -> None:
        """A type or base model, which may have the name of an import before it."""
        if at is None or not name:
            return
        alias, _, last = name.rpartition(".")
        found = self.unit.find(name)
        if found is None:
            self._add(at[1], at[2], Symbol(e.WORD, name))
            return
        if alias:
            self._add(at[1], at[1] + len(alias), Symbol(e.ALIAS, alias, self._key))
        symbol = Symbol(e.MODEL, found[0].name, key_of(found[1].file.name))
        self._add(at[2] - len(last), at[2], symbol, found=found)

    def _arguments(self, found: Entity, arguments: Iterable[s.Argument], place: _Place) -> None:
        """Modifiers and frames of a component, or attributes of a value."""
        inner = place.inside(found if found.form == e.COMPONENT else None)
        if found.form == e.SUB_MODEL and found.model is not None:
            self._modifiers(arguments, e.members(*found.model), place)
            return
        known = e.of_component(found) if found.form == e.COMPONENT else {}
        for a in arguments:
            if a.name == "frames":
                for frame in a.modifiers:
                    if (declared := known.get(frame.name)) is not None and declared.argument is not None:
                        self._name(frame.at, declared.symbol, True, declared)
                    self._visit((frame.value,), place)
                    self._values(frame.modifiers, place)
            if a.name:
                member = known.get(a.name)
                setting = Symbol(e.SETTING, a.name, owner=found.declaration.type)
                symbol = member.symbol if member is not None else setting
                self._name(a.at, symbol, found=member)
            self._visit((*a.indices, a.value), inner if a.name else place)
            if a.name != "frames":
                self._values(a.modifiers, place)

    def _modifiers(self, arguments: Iterable[s.Argument], known: Mapping[str, Entity], place: _Place) -> None:
        """Modifiers of a sub-model, which nest."""
        for a in arguments:
            member = known.get(a.name)
            if a.name and member is not None:
                self._name(a.at, member.symbol, found=member)
                self._arguments(member, a.modifiers, place)
            else:
                self._values(a.modifiers, place)
            self._visit((*a.indices, a.value), place)

    def _values(self, arguments: Iterable[s.Argument], place: _Place) -> None:
        """Arguments whose names are words of the language, as in annotations."""
        for a in arguments:
            if a.name:
                self._name(a.at, Symbol(e.SETTING, a.name))
            self._visit((a.value,), place)
            self._values(a.modifiers, place)

    # -- expressions -------------------------------------------------------------------------------------------

    def _loops(self, iterators: Iterable[s.Iterator], place: _Place) -> _Place:
        loops = dict(place.loops)
        for iterator in iterators:
            self._visit((iterator.values,), replace(place, loops=loops))
            assert iterator.at is not None
            loops[iterator.name] = Symbol(e.LOOP_VARIABLE, iterator.name, self._key, place=iterator.at[1])
            self._name(iterator.at, loops[iterator.name], True)
        return replace(place, loops=loops)

    def _function(self, reference: s.Reference, place: _Place) -> None:
        first = reference.steps[0]
        whole = modelica_names.function(".".join(step.name for step in reference.steps))
        if class_of(whole) == "function" and first.name not in place.members:
            self._name(reference.at, Symbol(e.WORD, whole))
        elif first.name in place.members:
            self.resolve(reference, place)
        else:
            self._name(first.at, Symbol(e.SETTING, first.name))

    def resolve(self, reference: s.Reference, place: _Place) -> Entity | OfKind | None:
        """Note all names of a reference; return what it denotes as far as that is known."""
        steps = reference.steps
        first = steps[0]
        if first.name == "Modelica":
            if first.at is not None and (last := steps[-1].at) is not None:
                self._add(first.at[1], last[2], Symbol(e.WORD, ".".join(x.name for x in steps)))
            return None
        found = self._first(first, len(steps) == 1, place)
        for step in steps[1:]:
            if found is None:
                return None
            before, found = found, e.inside(found).get(step.name) or e.by_other_name(found, step.name)
            if found is not None:
                self._name(step.at, found.symbol, found=found)
            elif step.name in e.coordinates(before):
                self._name(step.at, Symbol(e.COORDINATE, step.name))
            elif isinstance(before, Entity) and before.kind is not None and step.name in e.accelerations(before.kind):
                self._name(step.at, Symbol(e.OF_KIND, step.name, owner=before.kind.name))
        return found

    def _first(self, step: s.NamePart, alone: bool, place: _Place) -> Entity | OfKind | None:
        if step.name in place.loops:
            self._name(step.at, place.loops[step.name])
            return None
        found: Entity | OfKind | None = place.members.get(step.name)
        no_value = isinstance(found, Entity) and found.form in (e.COMPONENT, e.SUB_MODEL) and not step.indices
        if place.own is not None and not of_model(found, alone and no_value):
            found = e.of_component(place.own).get(step.name, found)
        if found is not None:
            self._name(step.at, found.symbol, found=found)
        elif step.name == "time" or step.name in CONSTANTS:
            self._name(step.at, Symbol(e.WORD, step.name))
        return found

    # -- notes -------------------------------------------------------------------------------------------------

    def _name(self, at: At, symbol: Symbol, declares: bool = False, found: Found = None) -> None:
        if at is not None:
            self._add(at[1], at[2], symbol, declares, found)

    def _add(self, start: int, end: int, symbol: Symbol, declares: bool = False, found: Found = None) -> None:
        self._found.setdefault(start, Occurrence(start, end, symbol, declares, found))
