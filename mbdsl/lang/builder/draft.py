"""A model under construction from Python: its declarations, in an order that can be changed."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

from mbdsl.errors import MbdslError, ModelError, UsageError
from mbdsl.lang import syntax as s
from mbdsl.lang.builder.content import DraftContent, DraftEntry, full_name, is_element
from mbdsl.lang.builder.references import check_names, find_dependents, without
from mbdsl.lang.calls import called
from mbdsl.lang.experiment import check_effects
from mbdsl.lang.flat_component import FlatComponent
from mbdsl.lang.inheritance import Member
from mbdsl.lang.initial_values import is_steady
from mbdsl.lang.instantiate import Instance
from mbdsl.lang.library import SourceUnit
from mbdsl.lang.load import deep, flatten, instantiate
from mbdsl.lang.overrides import merged
from mbdsl.lang.unparse import write
from mbdsl.mechanism.scene import Scene
from mbdsl.messages import count, did_you_mean, few

UNIT = SourceUnit(s.File("<library>", (), ()), "")  #: a Builder has no file


@dataclass(frozen=True)
class ModelOrigin:
    """The syntax tree that a Scene was made of, and what was asked for."""

    model: s.Model
    overrides: Mapping[str, Any]
    without: tuple[str, ...]

    def scene(self, parameters: Mapping[str, Any], without: Sequence[str] = ()) -> Scene:
        """The Scene with other parameters."""
        overrides, effects = merged(self.overrides, parameters), (*self.without, *check_effects(without))
        with deep(), called():
            scene = flatten(instantiate(self.model, UNIT, overrides, effects))
        return scene.made_from(ModelOrigin(self.model, overrides, effects))


class Draft:
    """A model under construction: what was declared, checked for its names and kinds.

    A change with a wrong name is refused, and leaves the draft as it was. Values are evaluated with the whole model.
    """

    def __init__(self, spatial: bool = False) -> None:
        self.content = DraftContent(spatial=spatial)
        self._serial = 0
        self._instance: Instance | None = None

    def __getstate__(self) -> dict:
        return {**self.__dict__, "_instance": None}

    @property
    def instance(self) -> Instance:
        """The declarations as a model that is not connected."""
        if self._instance is None:
            self._instance = _instance(self.content)
        return self._instance

    def part(self, name: str) -> FlatComponent:
        """The component with a full name."""
        return self.instance.assembly.parts[name]

    def _exchange(self, content: DraftContent) -> None:
        """Replace the content, if the names of the new one are known."""
        instance = _instance(content)
        declared = (e.declaration for e in content.entries.values())
        for item in (*declared, *content.connections, *content.rates, *content.events, *content.initial):
            check_names(item, instance)
        self._instance, self.content = instance, content

    # -- changes -----------------------------------------------------------------------------------------------

    def declare(self, d: s.Declaration, instead: bool) -> int:
        """Add a declaration, or put it ``instead`` of the one with its name; return its number."""
        name, entries = full_name(d), self.content.entries
        before = entries.get(name)
        if before is None:
            instance, self._instance = self.instance, None  # after an error it may hold a part of the declaration
            with deep(), called():
                _add(d, instance)
                check_names(d, instance)
            self._serial += 1
            entries[name], self._instance = DraftEntry(d, self._serial), instance
        elif not instead:
            hint = "give it another name, or `replace=True` to replace the first one"
            raise ModelError(f"`{name}` is declared twice", hint=hint)
        else:
            new = DraftEntry(replace(d, notes=before.declaration.notes), before.serial)
            try:
                self._exchange(replace(self.content, entries={**entries, name: new}))
            except MbdslError as problem:
                problem.notes = (*problem.notes, (f"`{name}` is not replaced", None))
                raise
        return self.content.entries[name].serial

    def connect(self, item: s.Connect) -> None:
        """Add a connection."""
        check_names(item, self.instance)
        self.content.connections.append(item)

    def rate(self, item: s.Relation, instead: bool) -> None:
        """Add the equation of a state, or put it ``instead`` of the one that it has."""
        check_names(item, self.instance)
        before = [x for x in self.content.rates if x.left == item.left]
        if before and not instead:
            raise ModelError(f"`{write(item.left)}` is given twice", hint="to replace it: `rate(..., replace=True)`")
        self.content.rates = [*(x for x in self.content.rates if x not in before), item]
        self._instance = None

    def event(self, item: s.When | s.Relation) -> None:
        """Add a when-equation or an assertion."""
        check_names(item, self.instance)
        self.content.events.append(item)
        self._instance = None

    def initial(self, item: s.Initial, instead: bool) -> None:
        """Add an initial value, or put it ``instead`` of those of its target."""
        if item.mode == "state":
            is_steady(item)
        check_names(item, self.instance)
        left = _without_target(self.content.initial, item.target)
        before = [x for x in self.content.initial if x.target == item.target]
        if not instead and any(x.mode == item.mode == "fixed" for x in before):
            hint = "to give another value instead: `initial(..., replace=True)`"
            raise ModelError(f"the initial value of `{write(item.target)}` is fixed twice", hint=hint)
        self.content.initial = [*(left if instead else self.content.initial), item]

    def forget_initial(self, target: s.Expression) -> None:
        """Remove the initial values of ``target``."""
        left = _without_target(self.content.initial, target)
        if len(left) == len(self.content.initial):
            raise UsageError(f"no initial value was given for `{write(target)}`")
        self.content.initial = left

    def draw(self, name: str, shape: s.Argument, instead: bool) -> None:
        """Give a body a shape, in addition to those that it has or ``instead`` of them."""
        entry = self.content.entries[name]
        d = replace(entry.declaration, notes=(shape,) if instead else (*entry.declaration.notes, shape))
        check_names(d, self.instance)
        self.content.entries[name] = DraftEntry(d, entry.serial)

    def set_experiment(self, given: Mapping[str, s.Argument]) -> None:
        """Set defaults of simulations."""
        settings = {**self.content.settings, **given}
        check_names(tuple(given.values()), self.instance)
        self.content.settings = settings

    def remove(self, name: str, dependents: bool) -> tuple[str, ...]:
        """Remove a declaration, or all elements of an array, and the ``dependents``; return their names."""
        entries = self.content.entries
        chosen = [key for key, e in entries.items() if name in (key, e.declaration.name)]
        if not chosen:
            raise UsageError(f"there is no `{name}` to remove", hint=did_you_mean(name, entries, "there are"))
        found = find_dependents(self.content, chosen)
        if found and not dependents:
            raise UsageError(
                f"`{name}` cannot be removed: {few(found)} {'refers' if len(found) == 1 else 'refer'} to it",
                hint="remove what refers to it first, or with it: `remove(..., dependents=True)`",
            )
        gone = {*chosen, *found}
        self._exchange(without(self.content, gone))
        return tuple(key for key in entries if key in gone)

    def scene(self, name: str, doc: str, parameters: Mapping[str, Any], without: Sequence[str]) -> Scene:
        """The Scene of the whole model."""
        return ModelOrigin(self.content.model(name, doc), {}, ()).scene(parameters, without)

    def __repr__(self) -> str:
        return f"<Draft of {count(len(self.content.entries), 'declaration')}>"


def _add(d: s.Declaration, instance: Instance) -> None:
    """Add a declaration; indices denote one element of an array."""
    namespace, element = instance.namespace, is_element(d)
    if element:
        namespace.places.setdefault(d.name, d.at)
    else:
        namespace.declare(d.name, d.at)
    instance.declare(Member(d, UNIT, {}), d, instance.scope, element)


def _without_target(items: Sequence[s.Initial], target: s.Expression) -> list[s.Initial]:
    return [item for item in items if item.target != target]


def _instance(content: DraftContent) -> Instance:
    with deep(), called():
        return instantiate(content.model("", ""), UNIT)
