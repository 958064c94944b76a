"""Reads a model: from text to Scene."""

from __future__ import annotations

import os
import sys
from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager

from mbdsl.errors import ModelError, UsageError
from mbdsl.lang import syntax as s
from mbdsl.lang.entities import Namespace
from mbdsl.lang.experiment import check_effects, read_experiment
from mbdsl.lang.flat_model import Assembly
from mbdsl.lang.instantiate import Instance
from mbdsl.lang.library import Allowed, Library, Unit, read
from mbdsl.lang.overrides import read_overrides
from mbdsl.lang.source import span_of
from mbdsl.mechanism.scene import Scene
from mbdsl.messages import did_you_mean


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
        Name of the model to read. Default: the model with the name of the file, else the last one in the file.
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
    MbdslError
        If the file cannot be read or the model is invalid.
    """
    file = os.fspath(path)
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
    MbdslError
        If the model is invalid.
    """
    return read_scene(Library(allow_imports), text, file, overrides, model, without)


def read_scene(
    library: Library,
    text: str,
    file: str,
    overrides: Mapping[str, str | float] = {},
    model: str | None = None,
    without: Iterable[str] = (),
) -> Scene:
    """As :func:`parse_text`, with the imports of a library."""
    with deep():
        unit = library.add(text, file)
        return _flatten(_main(unit, model), unit, library, overrides, check_effects(without))


def _main(unit: Unit, name: str | None) -> s.Model:
    models = unit.file.models
    if name is not None:
        found = unit.own(name)
        if found is None:
            raise UsageError(
                f"{unit.file.name} has no model `{name}`", hint=did_you_mean(name, [m.name for m in models], "it has")
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


def _flatten(
    model: s.Model, unit: Unit, library: Library, overrides: Mapping[str, str | float], without: tuple[str, ...]
) -> Scene:
    assembly = Assembly()
    assembly.without = without
    root = Namespace(assembly)
    instance = Instance(assembly, root, model, unit, {})
    instance.modifiers = read_overrides(overrides, instance)
    instance.build()
    experiment = read_experiment(instance.content.annotations, instance.scope)
    return assembly.scene(root, model.name, model.doc, experiment, library.files)


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
