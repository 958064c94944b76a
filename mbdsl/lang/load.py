"""Reads a model: from text to Scene."""

from __future__ import annotations

import os
import re
import sys
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from contextvars import ContextVar
from dataclasses import dataclass, field
from typing import Any

from mbdsl.errors import ModelError, UsageError
from mbdsl.lang import syntax as s
from mbdsl.lang.data_files import Columns
from mbdsl.lang.entities import Namespace
from mbdsl.lang.experiment import check_effects, read_experiment
from mbdsl.lang.flat_model import Assembly
from mbdsl.lang.instantiate import Instance
from mbdsl.lang.library import Allowed, Library, SourceUnit, read
from mbdsl.lang.mistakes.space import first_of_all
from mbdsl.lang.overrides import merged, read_overrides
from mbdsl.lang.source import span_of
from mbdsl.mechanism.scene import Scene
from mbdsl.messages import did_you_mean, few
from mbdsl.storage.garbage_collection import uncollected

_chosen: ContextVar[str | None] = ContextVar("name of the model to read", default=None)


@contextmanager
def model_chosen(name: str | None) -> Iterator[None]:
    """While the block runs, files that are read without the name of a model are read with this one."""
    before = _chosen.set(name)
    try:
        yield
    finally:
        _chosen.reset(before)


def chosen_now() -> str | None:
    """The name for files that are read without one."""
    return _chosen.get()


def load(
    path: str | os.PathLike[str],
    overrides: Mapping[str, str | float] = {},
    model: str | None = None,
    without: Iterable[str] = (),
    allow_imports: Allowed | None = None,
) -> Scene:
    """Read a model from a file.

    Parameters
    ----------
    path : path
        The ``.mbd`` file.
    overrides : mapping, optional
        Values that replace those of the model's parameters, as numbers in SI units or as texts with units:
        ``{"k": "120 N/mm", "crank.m": 4.0}``.
    model : str, optional
        Name of the model to read. Default: the model with the name of the file, else the last one in the file that is
        not partial.
    without : iterable of str, optional
        Effects to leave out: "friction", "damping", "flexibility", "gravity".
    allow_imports : bool or path, optional
        Whether the file may import files from outside its own folder: True allows all folders, a path allows that
        folder. Default: False, unless the command line has ``--allow-imports``. Only for models that you trust.

    Returns
    -------
    Scene
        The checked model.

    Raises
    ------
    UsageError
        If ``path`` is the text of a model.
    MbdslError
        If the file cannot be read or the model is invalid.
    """
    file = os.fspath(path)
    if _is_model(file):
        hint = "`mbdsl.parse(text)` reads a model from a text: `mbdsl.simulate(mbdsl.parse(text))`"
        raise UsageError("found the text of a model, expected the path of a .mbd file", hint=hint)
    return parse_text(read(file), file, overrides, model, without, allow_imports)


def parse_text(
    text: str,
    file: str = "<text>",
    overrides: Mapping[str, str | float] = {},
    model: str | None = None,
    without: Iterable[str] = (),
    allow_imports: Allowed | None = None,
) -> Scene:
    """Read a model from a text.

    Parameters
    ----------
    text : str
        The content of a ``.mbd`` file.
    file : str, optional
        Name of the text in messages; imports are relative to its folder.
    overrides, model, without, allow_imports : optional
        As for ``mbdsl.load``.

    Returns
    -------
    Scene
        The checked model.

    Raises
    ------
    UsageError
        If ``text`` is a path.
    MbdslError
        If the model is invalid.
    """
    if not isinstance(text, str) or (text.endswith(".mbd") and "\n" not in text):
        hint = "`mbdsl.load(path)` reads a model from a file"
        raise UsageError(f"found {text!r}, expected the text of a model", hint=hint)
    return read_scene(Library(allow_imports), text, file, overrides, model, without)


def read_scene(
    library: Library,
    text: str,
    file: str,
    overrides: Mapping[str, Any] = {},
    model: str | None = None,
    without: Iterable[str] = (),
) -> Scene:
    """As :func:`parse_text`, with the imports of a library."""
    with deep():
        return _read(library, text, file, merged({}, overrides), model, check_effects(without))


@dataclass(frozen=True)
class TextOrigin:
    """The texts that a scene was read from, the main one first, and what was asked for."""

    files: Mapping[str, str]
    model: str
    overrides: Mapping[str, Any]
    without: tuple[str, ...]
    data: Mapping[str, Columns] = field(default_factory=dict)  #: columns of files of numbers

    def scene(self, parameters: Mapping[str, Any], without: Sequence[str] = ()) -> Scene:
        """The scene with other parameters, read from the same texts; the disk is not read."""
        main, effects = next(iter(self.files)), (*self.without, *check_effects(without))
        with deep():
            library = Library(texts=self.files, data=self.data)
            return _read(library, self.files[main], main, merged(self.overrides, parameters), self.model, effects)


@uncollected
def _read(
    library: Library,
    text: str,
    file: str,
    overrides: Mapping[str, Any],
    model: str | None,
    without: tuple[str, ...],
) -> Scene:
    unit = library.add(text, file)
    found = _main(unit, chosen_now() if model is None else model)
    try:
        scene = flatten(instantiate(found, unit, overrides, without, library))
    except ModelError:
        if not found.spatial and (first := first_of_all(found, unit)) is not None:
            raise first from None
        raise
    return scene.made_from(TextOrigin(scene.files, found.name, overrides, without, library.used))


def _is_model(path: object) -> bool:
    """Whether a path is the text of a model."""
    if not isinstance(path, str) or path.endswith(".mbd"):
        return False
    return "\n" in path or (
        re.match(r"\s*(spatial\s+)?(partial\s+)?model\s+\w", path) is not None and not os.path.exists(path)
    )


def _main(unit: SourceUnit, name: str | None) -> s.Model:
    models = unit.file.models
    if name is not None:
        found = unit.own(name)
        complete = [m.name for m in models if not m.partial]
        if found is None:
            close = did_you_mean(name, complete)
            listed = f"its models are {few(complete, 12)}" if complete else "it has no model that is not partial"
            raise UsageError(f"{unit.file.name} has no model `{name}`", hint=f"{close} {listed}" if close else listed)
        if found.partial:
            raise UsageError(
                f"model `{name}` of {unit.file.name} is partial",
                span_of(found.at),
                f"choose a model that extends it: {few(complete, 12)}" if complete else None,
            )
        return found
    if not models:
        raise ModelError(
            f"{unit.file.name} holds no model", span_of(unit.file.at), "a model is written `model Name ... end Name;`"
        )
    stem = os.path.splitext(os.path.basename(unit.file.name))[0]
    named = [m for m in models if _plain(m.name) == _plain(stem)]
    complete = [m for m in models if not m.partial]
    if not (named or complete):
        raise ModelError(f"all models of {unit.file.name} are partial", span_of(models[-1].at))
    return (named or complete)[-1]


def _plain(name: str) -> str:
    return name.replace("_", "").replace("-", "").lower()


def instantiate(
    model: s.Model,
    unit: SourceUnit,
    overrides: Mapping[str, Any] = {},
    without: tuple[str, ...] = (),
    library: Library | None = None,
) -> Instance:
    """The main model with all that it declares, before it is connected; a library has the files of its tables."""
    assembly = Assembly(model.spatial)
    assembly.without, assembly.library = without, library
    assembly.passed += [item for file in (unit, *unit.imports, *unit.aliases.values()) for item in file.file.passed]
    instance = Instance(assembly, Namespace(assembly), model, unit, {})
    instance.modifiers = read_overrides(overrides, instance)
    instance.build()
    return instance


def flatten(instance: Instance) -> Scene:
    """The Scene of the main model."""
    model, experiment = instance.model, read_experiment(instance.content.annotations, instance.scope)
    return instance.assembly.scene(instance.namespace, model.name, model.doc, experiment)


@contextmanager
def deep() -> Iterator[None]:
    """Raise the recursion limit for deeply nested models; a RecursionError becomes a ModelError."""
    before = sys.getrecursionlimit()
    # Since 3.11 calls of Python functions do not use the C stack, whose size is the actual limit.
    sys.setrecursionlimit(max(before, 10_000 if sys.version_info >= (3, 11) else 4_000))
    try:
        yield
    except RecursionError:
        raise ModelError("the definitions of this model refer to each other too deeply") from None
    finally:
        sys.setrecursionlimit(before)
