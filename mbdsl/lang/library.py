"""The files of a model: imports, and the models that names denote in each file."""

from __future__ import annotations

import os
import re
import stat
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from contextvars import ContextVar
from dataclasses import dataclass, field
from pathlib import Path

from mbdsl.errors import ModelError, Span, UsageError
from mbdsl.lang import data_files, limits
from mbdsl.lang import syntax as s
from mbdsl.lang.data_files import Column, Columns
from mbdsl.lang.parser import parse
from mbdsl.lang.source import span_of
from mbdsl.messages import did_you_mean

#: where imports may lead: False: inside the folder of the model; True: anywhere; a path: inside this folder
Allowed = bool | str | os.PathLike[str]

_allowed: ContextVar[Allowed] = ContextVar("allowed imports", default=False)
#: how a file of the language begins, after comments
_MODEL = re.compile(r'(?:\s|//[^\n]*|/\*.*?\*/)*(?:import\s*"|(?:spatial|partial|model|function)\b|\Z)', re.DOTALL)


@contextmanager
def imports_allowed(where: Allowed) -> Iterator[None]:
    """While the block runs, models that are read without a setting of their own may import from ``where``."""
    before = _allowed.set(where)
    try:
        yield
    finally:
        _allowed.reset(before)


def allowed_now() -> Allowed:
    """The setting for models that are read without one of their own."""
    return _allowed.get()


@dataclass
class SourceUnit:
    """One file with the files that it imports."""

    file: s.File
    text: str
    imports: list[SourceUnit] = field(default_factory=list)
    aliases: dict[str, SourceUnit] = field(default_factory=dict)

    def own(self, name: str) -> s.Model | None:
        return next((m for m in self.file.models if m.name == name), None)

    def find(self, name: str) -> tuple[s.Model, SourceUnit] | None:
        """The model that ``name`` (or ``alias.Name``) denotes in this file."""
        alias, dot, rest = name.partition(".")
        if dot:
            unit = self.aliases.get(alias)
            model = unit.own(rest) if unit is not None else None
            return (model, unit) if model is not None and unit is not None else None
        for unit in [self, *self.imports]:
            model = unit.own(name)
            if model is not None:
                return model, unit
        return None

    def function(self, name: str) -> s.Function | None:
        """The function that ``name`` (or ``alias.name``) denotes in this file."""
        alias, dot, rest = name.partition(".")
        if dot:
            unit = self.aliases.get(alias)
            return None if unit is None else next((f for f in unit.file.functions if f.name == rest), None)
        return next((f for unit in [self, *self.imports] for f in unit.file.functions if f.name == name), None)

    def function_names(self) -> list[str]:
        """The names of all functions that this file can use."""
        found = [f.name for unit in [self, *self.imports] for f in unit.file.functions]
        return found + [f"{alias}.{f.name}" for alias, unit in self.aliases.items() for f in unit.file.functions]

    def names(self) -> list[str]:
        """The names of all models that this file can use."""
        found = [m.name for unit in [self, *self.imports] for m in unit.file.models]
        return found + [f"{alias}.{m.name}" for alias, unit in self.aliases.items() for m in unit.file.models]


class Library:
    """The files of one model, each read once.

    A model is data, perhaps from other authors: what it imports must be models, inside the folder of the model after
    all links are resolved, unless ``allowed`` permits more. ``unsaved`` texts, which an editor has, are read instead of
    the files of these names. ``data`` are columns of files of numbers that were read before.
    """

    def __init__(
        self,
        allowed: Allowed | None = None,
        texts: Mapping[str, str] | None = None,
        unsaved: Mapping[str, str] = {},
        data: Mapping[str, Columns] = {},
    ) -> None:
        self.units: dict[str, SourceUnit] = {}
        self._texts = texts  #: the files by name, if they are not read from the disk
        self._unsaved = {key_of(file): text for file, text in unsaved.items()}
        self._allowed = True if texts is not None else allowed_now() if allowed is None else allowed
        self._root = ""  #: the folder that imports must not leave
        self._home = ""  #: the folder of the model
        self.data: dict[str, Columns] = {path: dict(columns) for path, columns in data.items()}
        self._used: dict[str, Columns] = {}

    @property
    def files(self) -> dict[str, str]:
        """Names of the files, and their texts as read; of files of numbers the columns that are used, as CSV."""
        texts = {unit.file.name: unit.text for unit in self.units.values()}
        return texts | {path: data_files.as_text(columns) for path, columns in self._used.items()}

    @property
    def used(self) -> dict[str, Columns]:
        """The columns of files of numbers that the model uses."""
        return self._used

    def columns(self, name: str, naming: str, x: str | None, y: str | None, span: Span | None) -> list[Column]:
        """Two columns of a file of numbers, which the file ``naming`` names at ``span``.

        Raises
        ------
        ModelError
            If it is not in the folder of the model or below, or cannot be read.
        """
        path = None
        try:
            path = data_files.resolved(name, naming, self._home)
            found = self._columns(path, x, y)
        except data_files.DataError as problem:
            raise data_files.blamed(problem, name, path, span) from None
        kept = self._used.setdefault(path, {})
        kept |= found
        if len({len(column.numbers) for column in kept.values()}) > 1:
            raise ModelError(f"`{name}`: its columns have different lengths", span)
        if sum(len(c.numbers) for columns in self._used.values() for c in columns.values()) > limits.DATA_NUMBERS:
            raise ModelError(f"the files of this model have more than {limits.DATA_NUMBERS} numbers", span)
        return [found[column] for column in (x, y)] if x is not None and y is not None else list(found.values())

    def _columns(self, path: str, x: str | None, y: str | None) -> Columns:
        known = self.data.get(path, {})
        if x in known and y in known:
            return {name: known[name] for name in (x, y)}
        if known and x is None and y is None:
            return dict(known)
        if self._texts is None:
            return data_files.read(path, x, y)
        if path not in self._texts:
            raise data_files.DataError("the stored model has no such file", "load the model from its file")
        return data_files.from_text(self._texts[path], x, y)

    def add(self, text: str, file: str) -> SourceUnit:
        """Add a text and, recursively, all that it imports."""
        if self._allowed is not True:
            folder = os.path.dirname(file) if self._allowed is False else os.fspath(self._allowed)
            self._root = os.path.realpath(folder)
        self._home = os.path.realpath(os.path.dirname(file))
        unit = self._parse(text, file)
        waiting = [unit]
        while waiting:
            waiting += self._import(waiting.pop())
        return unit

    def _parse(self, text: str, file: str) -> SourceUnit:
        unit = SourceUnit(parse(text, file), text)
        self.units[key_of(file)] = unit
        for what, declared in (("model", unit.file.models), ("function", unit.file.functions)):
            seen: dict[str, s.Model | s.Function] = {}
            for x in declared:
                if (first := seen.setdefault(x.name, x)) is not x:
                    note = (("the first one is here", span_of(first.at)),)
                    raise ModelError(f"a second {what} `{x.name}` in this file", span_of(x.at), notes=note)
        return unit

    def unit_of(self, file: str) -> SourceUnit:
        """The file of this name; the main one for texts that are no files, as those of ``--set``."""
        return self.units.get(key_of(file)) or next(iter(self.units.values()))

    def _import(self, unit: SourceUnit) -> list[SourceUnit]:
        """Connect ``unit`` with the files that it imports; return the new ones."""
        new = []
        for item in unit.file.imports:
            path = _resolve(item, unit.file.name)
            known = self.units.get(key_of(path))
            if known is None:
                if len(self.units) >= limits.FILES:
                    raise ModelError(f"more than {limits.FILES} files", span_of(item.at))
                self._refuse_outside(item, path)
                try:
                    text = self._read(path)
                except UsageError as problem:
                    raise ModelError(f"cannot import: {problem.message}", span_of(item.at), problem.hint) from None
                if not _MODEL.match(text):
                    raise ModelError(
                        f"cannot import: {path} is not a model",
                        span_of(item.at),
                        "what is imported begins with `model` or `import`; nothing of other files is shown",
                    )
                known = self._parse(text, path)
                new.append(known)
            if item.alias:
                if item.alias in unit.aliases:
                    raise ModelError(f"`{item.alias}` already names another import", span_of(item.at))
                unit.aliases[item.alias] = known
            elif known is not unit and known not in unit.imports:
                for model in known.file.models:
                    other = unit.find(model.name)
                    if other is not None:
                        raise ModelError(
                            f"`{model.name}` is defined in {known.file.name} and in {other[1].file.name}",
                            span_of(item.at),
                            f'give the import a name: `import "{item.path}" as parts;`, then `parts.{model.name}`',
                            (("the other one is here", span_of(other[0].at)),),
                        )
                unit.imports.append(known)
        return new

    def _read(self, path: str) -> str:
        if key_of(path) in self._unsaved:
            return self._unsaved[key_of(path)]
        if self._texts is None:
            return read(path)
        if path not in self._texts:
            raise UsageError(f"the stored model has no file `{path}`")
        return self._texts[path]

    def _refuse_outside(self, item: s.Import, path: str) -> None:
        """Called before the file is accessed, so that the message does not say whether it exists."""
        if self._allowed is not True and not data_files.is_inside(path, self._root):
            raise ModelError(
                f'the import "{item.path}" leads out of the folder of the model',
                span_of(item.at),
                "if the model can be trusted: --allow-imports, or load(..., allow_imports=True)",
            )


def key_of(file: str) -> str:
    """The same text for all names of a file, as far as they can be compared without accessing it."""
    return os.path.normcase(os.path.abspath(file))


def _resolve(item: s.Import, importing: str) -> str:
    path = item.path
    if "://" in path or path.startswith(("/", "\\", "~")) or path[1:2] == ":":
        raise ModelError(
            f'cannot import "{path}"', span_of(item.at), "an import is a path relative to the importing file"
        )
    if not path or "\0" in path:
        raise ModelError("this import names no file", span_of(item.at))
    return os.path.normpath(os.path.join(os.path.dirname(importing), path))


def read(path: str) -> str:
    """The text of a file, which must be a regular one and of bounded size.

    Raises
    ------
    UsageError
        If it cannot be read as text.
    """
    try:
        status = os.stat(path)
        if stat.S_ISDIR(status.st_mode):
            raise UsageError(f"`{path}` is a directory, expected a .mbd file")
        if not stat.S_ISREG(status.st_mode):
            raise UsageError(f"`{path}` is not a regular file")
        if status.st_size > 4 * limits.FILE_SIZE:
            raise UsageError(f"`{path}` has {status.st_size} bytes; a model has at most {limits.FILE_SIZE} characters")
        return Path(path).read_text(encoding="utf-8-sig")
    except (FileNotFoundError, NotADirectoryError):
        raise UsageError(f"there is no file `{path}`", hint=_close_file(path)) from None
    except UnicodeDecodeError:
        raise UsageError(f"`{path}` is not a text file (UTF-8), expected a .mbd file") from None
    except (OSError, ValueError) as problem:
        reason = getattr(problem, "strerror", None) or "not a valid path"
        raise UsageError(f"cannot read `{path}`: {reason}") from None


def _close_file(path: str) -> str | None:
    folder = os.path.dirname(path) or "."
    try:
        names = [n[:-4] for n in sorted(os.listdir(folder))[:2000] if n.endswith(".mbd")]
    except OSError:
        return None
    close = did_you_mean(os.path.basename(path).removesuffix(".mbd"), names)
    return close.replace("`?", ".mbd`?").replace("` or", ".mbd` or") if close else None
