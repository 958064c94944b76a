"""The content of a model, with that of the models that it extends."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field

from mbdsl.elements import find
from mbdsl.errors import ModelError
from mbdsl.lang import modelica_names
from mbdsl.lang import syntax as s
from mbdsl.lang.library import SourceUnit
from mbdsl.lang.modifiers import Modifiers, bind, merge
from mbdsl.lang.scope import Scope
from mbdsl.lang.source import span_of
from mbdsl.messages import did_you_mean


@dataclass(frozen=True)
class Member:
    """An item of a model or of one that it extends, with the file it came from and the modifiers of `extends`."""

    item: s.Item
    unit: SourceUnit
    modifiers: Modifiers


@dataclass
class ModelContent:
    """All items of a model and its bases; names are looked up in ``scope``, that of the extending model."""

    scope: Scope
    members: list[Member] = field(default_factory=list)
    annotations: list[s.Annotation] = field(default_factory=list)
    equations: list[s.Item] = field(default_factory=list)
    initial: list[s.Item] = field(default_factory=list)

    def add(self, model: s.Model, unit: SourceUnit, modifiers: Modifiers, below: tuple[s.Model, ...] = ()) -> None:
        """Add ``model`` from the file ``unit``; ``below`` are the models that extend it."""
        if any(m is model for m in below):
            raise ModelError(f"`{model.name}` extends itself: {circle(below, model)}", span_of(model.at))
        for item in model.items:
            self.scope.budget.spend(20)  # nested bases may be many
            if isinstance(item, s.Extends):
                self._extend(item, model, unit, modifiers, below)
            elif isinstance(item, s.Annotation):
                self.annotations.append(item)
            else:
                self.members.append(Member(item, unit, modifiers))
        self.equations += model.equations
        self.initial += model.initial

    def _extend(
        self, item: s.Extends, model: s.Model, unit: SourceUnit, modifiers: Modifiers, below: tuple[s.Model, ...]
    ) -> None:
        found = unit.find(item.base)
        if found is None:
            if item.base.startswith(modelica_names.ICONS):
                return
            if find(modelica_names.kind(item.base)) is not None:
                raise ModelError(f"`{item.base}` is a built-in kind, only models can be extended", span_of(item.at))
            hint = did_you_mean(item.base, unit.names(), "models here")
            raise ModelError(f"there is no model `{item.base}` to extend", span_of(item.at), hint)
        positional, own = bind(item.arguments, self.scope, len(self.scope.namespace.contexts))
        if positional:
            raise ModelError("`extends` takes modifiers `name = value`", span_of(positional[0].at))
        first = len(self.members)
        self.add(*found, merge(modifiers, own), (*below, model))
        known = [name for member in self.members[first:] for name in declared_names(member.item)] if own else []
        for name, modifier in own.items():
            if name not in known:
                hint = did_you_mean(name, known, f"`{item.base}` has")
                raise ModelError(f"`{item.base}` has no `{name}`", span_of(modifier.at), hint)


def circle(chain: tuple[s.Model, ...], model: s.Model) -> str:
    """The cycle at the end of a chain of models, as text."""
    start = next(i for i, m in enumerate(chain) if m is model)
    return " -> ".join(f"`{m.name}`" for m in [*chain[start:], model])


def declarations(item: s.Item) -> Iterator[s.Declaration]:
    """All declarations of an item: itself, or those in a loop or `if`."""
    if isinstance(item, s.Declaration):
        yield item
    elif isinstance(item, s.For):
        for inner in item.items:
            yield from declarations(inner)
    elif isinstance(item, s.If):
        for _, items in item.branches:
            for inner in items:
                yield from declarations(inner)


def declared_names(item: s.Item) -> list[str]:
    """Names that a declaration, loop or `if` declares."""
    return [d.name for d in declarations(item)]


def reachable(model: s.Model, unit: SourceUnit) -> list[s.Model]:
    """A model and all models that it consists of: its bases, the models of its components, and theirs."""
    found, waiting = [], [(model, unit)]
    while waiting:
        m, home = waiting.pop()
        if any(m is x for x in found):
            continue
        found.append(m)
        names = [item.base for item in m.items if isinstance(item, s.Extends)]
        names += [d.type for item in m.items for d in declarations(item)]
        waiting += [x for name in names if (x := home.find(name)) is not None]
    return found
