"""A model under construction from Python: its declarations, in an order that can be changed."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from typing import Any

from mbdsl.errors import MbdslError, ModelError, UsageError
from mbdsl.lang import syntax as s
from mbdsl.lang.draft_content import Content, Entry, experiment, find_dependents, full_name, without
from mbdsl.lang.experiment import check_effects
from mbdsl.lang.load import deep, flatten, instantiate
from mbdsl.lang.overrides import merged
from mbdsl.lang.trial import UNIT, Trial
from mbdsl.lang.unparse import write
from mbdsl.mechanism.scene import Scene
from mbdsl.messages import count, did_you_mean, few


@dataclass(frozen=True)
class ModelOrigin:
    """The syntax tree that a Scene was made of, and what was asked for."""

    model: s.Model
    overrides: Mapping[str, Any]
    without: tuple[str, ...]

    def scene(self, parameters: Mapping[str, Any], without: Sequence[str] = ()) -> Scene:
        """The Scene with other parameters."""
        overrides, effects = merged(self.overrides, parameters), (*self.without, *check_effects(without))
        with deep():
            scene = flatten(instantiate(self.model, UNIT, overrides, effects))
        return scene.made_from(ModelOrigin(self.model, overrides, effects))


class Draft:
    """A model under construction. Every change is checked first; one that is refused leaves it as it was."""

    def __init__(self, spatial: bool = False) -> None:
        self.content = Content(spatial=spatial)
        self._serial = 0
        self._trial: Trial | None = None

    def __getstate__(self) -> dict:
        return {**self.__dict__, "_trial": None}

    @property
    def trial(self) -> Trial:
        """The content, evaluated."""
        if self._trial is None:
            self._trial = _trial(self.content)
        return self._trial

    @contextmanager
    def _adding(self) -> Iterator[Trial]:
        """The trial, for an addition to it; after an error it is discarded, as it may hold a part of the addition."""
        trial, self._trial = self.trial, None
        yield trial
        self._trial = trial

    def _exchange(self, content: Content) -> None:
        """Replace the content, if the new one is valid."""
        self._trial, self.content = _trial(content), content

    # -- changes -----------------------------------------------------------------------------------------------

    def declare(self, d: s.Declaration, instead: bool) -> int:
        """Add a declaration, or put it ``instead`` of the one with its name; return its number."""
        name, entries = full_name(d), self.content.entries
        before = entries.get(name)
        if before is None:
            with self._adding() as trial:
                trial.declare(d)
            self._serial += 1
            entries[name] = Entry(d, self._serial)
        elif not instead:
            hint = "give it another name, or `replace=True` to replace the first one"
            raise ModelError(f"`{name}` is declared twice", hint=hint)
        else:
            new = Entry(replace(d, notes=before.declaration.notes), before.serial)
            try:
                self._exchange(replace(self.content, entries={**entries, name: new}))
            except MbdslError as problem:
                problem.notes = (*problem.notes, (f"`{name}` is not replaced", None))
                raise
        return self.content.entries[name].serial

    def connect(self, item: s.Connect) -> None:
        """Add a connection."""
        with self._adding() as trial:
            trial.connect(item)
        self.content.connections.append(item)

    def initial(self, item: s.Initial, instead: bool) -> None:
        """Add an initial value, or put it ``instead`` of those of its target."""
        left = _without_target(self.content.initial, item.target) if instead else self.content.initial
        if len(left) < len(self.content.initial):
            self._exchange(replace(self.content, initial=[*left, item]))
        else:
            with self._adding() as trial:
                trial.initial(item)
            self.content.initial.append(item)

    def forget_initial(self, target: s.Expression) -> None:
        """Remove the initial values of ``target``."""
        left = _without_target(self.content.initial, target)
        if len(left) == len(self.content.initial):
            raise UsageError(f"no initial value was given for `{write(target)}`")
        self._exchange(replace(self.content, initial=left))

    def draw(self, name: str, shape: s.Argument, instead: bool) -> None:
        """Give a body a shape, in addition to those that it has or ``instead`` of them."""
        entry = self.content.entries[name]
        d = replace(entry.declaration, notes=(shape,) if instead else (*entry.declaration.notes, shape))
        self.trial.draw(d)
        self.content.entries[name] = Entry(d, entry.serial)

    def set_experiment(self, given: Mapping[str, s.Argument]) -> None:
        """Set defaults of simulations."""
        settings = {**self.content.settings, **given}
        self.trial.experiment(experiment(settings))
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


def _without_target(items: Sequence[s.Initial], target: s.Expression) -> list[s.Initial]:
    return [item for item in items if item.target != target]


def _trial(content: Content) -> Trial:
    return Trial(content.model("", ""))
