"""Definition, references and renaming of names, over the files of a workspace."""

from __future__ import annotations

import os
import re
from collections.abc import Iterator
from typing import NamedTuple

from mbdsl.editor import entities as e
from mbdsl.editor.entities import Entity, OfKind, Symbol
from mbdsl.editor.names import NameIndex, Occurrence
from mbdsl.editor.repair import repaired
from mbdsl.editor.vocabulary import class_of
from mbdsl.editor.workspace import OpenFiles
from mbdsl.errors import MbdslError, ModelError, UsageError
from mbdsl.lang import lexer, quantities, units
from mbdsl.lang.inheritance import declarations
from mbdsl.lang.lexer import KEYWORDS
from mbdsl.lang.library import key_of
from mbdsl.lang.mistakes import units as unit_mistakes

_NAME = re.compile(r"[A-Za-z_][A-Za-z0-9_]*")


class Location(NamedTuple):
    """Characters of a file."""

    path: str
    start: int
    end: int


def definition(workspace: OpenFiles, path: str, offset: int) -> list[Location]:
    """Where the name at an offset is declared; for an import, the beginning of the file."""
    names = workspace.names(path)
    for item in names.unit.file.imports:
        if item.at is not None and item.at[1] <= offset <= item.at[2]:
            target = os.path.normpath(os.path.join(os.path.dirname(path), item.path))
            units_read = (*names.unit.imports, *names.unit.aliases.values())
            return [Location(u.file.name, 0, 0) for u in units_read if key_of(u.file.name) == key_of(target)]
    symbol = _symbol(names, offset)
    found = names.at(offset)
    if symbol is None and found is not None and isinstance(found.found, OfKind) and found.found.component is not None:
        symbol = found.found.component.symbol  # a parameter or signal of a kind: the declaration of the component
    if symbol is None:
        return []
    # The file that declares it may be imported, and outside of the folders of the workspace.
    for file in (path, *(u.file.name for u in _imported(names)), symbol.file):
        if key_of(file) == symbol.file:
            return [Location(file, o.start, o.end) for o in workspace.names(file).of(symbol) if o.declares]
    return []


def references(workspace: OpenFiles, path: str, offset: int, declared: bool = True) -> list[Location]:
    """All places of the name at an offset, in all files; with or without its declarations."""
    symbol = _symbol(workspace.names(path), offset)
    if symbol is None:
        return []
    found = _occurrences(workspace, path, symbol)
    return [Location(n.unit.file.name, o.start, o.end) for n, os_ in found for o in os_ if declared or not o.declares]


def renamable(workspace: OpenFiles, path: str, offset: int) -> Occurrence:
    """The name at an offset, if it can be renamed.

    Raises
    ------
    UsageError
        If it is a word of the language, or no name.
    """
    names = workspace.names(path)
    found = names.at(offset)
    if found is None:
        raise UsageError("there is no name to rename here")
    if not found.symbol.file:
        raise UsageError(f"`{found.symbol.name}` belongs to the language and cannot be renamed")
    return found


def rename(workspace: OpenFiles, path: str, offset: int, name: str) -> list[Location]:
    """The places where a new name replaces the name at an offset.

    The texts with the new name are read again. Each name must denote the same as before.

    Raises
    ------
    UsageError
        If the new name is not possible, or already has a meaning where it would be used.
    """
    occurrence = renamable(workspace, path, offset)
    symbol = occurrence.symbol
    if not _NAME.fullmatch(name):
        raise UsageError(f"`{name}` is not a name: names are made of letters a-z, digits and `_`")
    if name in KEYWORDS or name in ("time", "guess", "fixed"):
        raise UsageError(f"`{name}` is a word of the language and cannot be a name")
    if name == symbol.name:
        return []
    found = _occurrences(workspace, path, symbol)
    for names, _ in found:
        file = names.unit.file.name
        if problems := repaired(names.unit.text, file).problems:
            line = f" in line {problems[0].span.line}" if problems[0].span else ""
            raise UsageError(f"{os.path.basename(file)} has a syntax error{line}", hint="correct it before renaming")
        _refuse_taken(names, occurrence, name)
    texts = {n.unit.file.name: _replaced(n.unit.text, places, name) for n, places in found}
    _check(workspace, found, texts, symbol, name)
    return [Location(n.unit.file.name, o.start, o.end) for n, places in found for o in places]


def _symbol(names: NameIndex, offset: int) -> Symbol | None:
    found = names.at(offset)
    return found.symbol if found is not None and found.symbol.file else None


def _imported(names: NameIndex) -> Iterator:
    pending, seen = [names.unit], []
    while pending:
        unit = pending.pop()
        if not any(unit is x for x in seen):
            seen.append(unit)
            yield unit
            pending += (*unit.imports, *unit.aliases.values())


def _occurrences(workspace: OpenFiles, path: str, symbol: Symbol) -> list[tuple[NameIndex, list[Occurrence]]]:
    """The files that have the symbol, and its places."""
    found: dict[str, tuple[NameIndex, list[Occurrence]]] = {}
    imported = (unit.file.name for unit in _imported(workspace.names(path)))
    for names in workspace.with_word(path, symbol.name, imported):
        if places := names.of(symbol):
            found.setdefault(key_of(names.unit.file.name), (names, places))
    return list(found.values())


# -- checks of a new name -------------------------------------------------------------------------------------------
def _refuse_taken(names: NameIndex, occurrence: Occurrence, name: str) -> None:
    """Refuse a name that a model which has the symbol has already."""
    symbol, unit = occurrence.symbol, names.unit
    if symbol.form == e.MODEL and (name in unit.names() or class_of(name)):
        raise UsageError(f"there is already a model or kind `{name}`")
    if isinstance(occurrence.found, OfKind) and occurrence.found.component is not None:
        component = occurrence.found.component
        if name in e.of_component(component) or name in e.accelerations(occurrence.found.kind):
            raise UsageError(f"`{component.declaration.name}` already has `{name}`")
    for model in unit.file.models:
        known = e.members(model, unit)
        if symbol.form in (e.VALUE, e.COMPONENT) and known.get(symbol.name) is not None:
            if known[symbol.name].symbol == symbol and name in known:
                raise UsageError(f"`{model.name}` already has `{name}`")
        for d in (d for item in model.items for d in declarations(item)):
            if "outer" in d.prefixes and d.name in (symbol.name, name) and symbol.form == e.COMPONENT:
                raise UsageError(
                    f"`{model.name}` declares `outer {d.type} {d.name}`", hint="inner and outer have the same name"
                )
    if isinstance(occurrence.found, Entity) and symbol.form == e.VALUE:
        unit_text = quantities.type_unit(occurrence.found.declaration.type) or ""
        for piece in lexer.pieces(unit.text):
            if piece.kind == lexer.UNIT and (written := units.parse(piece.text)) is not None:
                try:
                    unit_mistakes.check_readings(written, lambda x: unit_text if x == name else None)
                except ModelError as problem:
                    raise UsageError(problem.message, hint=problem.hint) from None


def _check(
    workspace: OpenFiles,
    found: list[tuple[NameIndex, list[Occurrence]]],
    texts: dict[str, str],
    symbol: Symbol,
    name: str,
) -> None:
    """Refuse a new name with which a text, read again, has another meaning."""
    for before, places in found:
        file = before.unit.file.name
        try:
            after = workspace.names_with(file, {**workspace.texts, **texts})
        except MbdslError as problem:
            raise UsageError(f"with the name `{name}`, {problem.message}") from None
        shift = len(name) - len(symbol.name)

        def moved(at: int, places: list[Occurrence] = places, shift: int = shift) -> int:
            return at + shift * sum(o.start < at for o in places) if at >= 0 else at

        expected = [(moved(o.start), _renamed(o.symbol, symbol, name, moved)) for o in before.occurrences]
        actual = [(o.start, o.symbol) for o in after.occurrences]
        if expected != actual or repaired(after.unit.text, file).problems:
            wrong = next((at for (at, x), y in zip(expected, actual, strict=False) if (at, x) != y), 0)
            line = after.unit.text.count("\n", 0, wrong) + 1
            raise UsageError(f"`{name}` already has another meaning in line {line} of {os.path.basename(file)}")


def _renamed(s: Symbol, symbol: Symbol, name: str, moved) -> Symbol:
    """The symbol after the renaming of another one, which may be its owner."""
    if s == symbol:
        return Symbol(s.form, name, s.file, s.owner, moved(s.place) if s.place >= 0 else -1)
    owner = s.owner
    if s.file == symbol.file:
        model, dot, body = owner.partition(".")
        if symbol.form == e.MODEL and model == symbol.name:
            owner = name + dot + body
        elif symbol.form == e.COMPONENT and (model, body) == (symbol.owner, symbol.name):
            owner = f"{model}.{name}"
    elif s.form == e.SETTING and owner == symbol.name:
        owner = name
    return Symbol(s.form, s.name, s.file, owner, moved(s.place) if s.place >= 0 else -1)


def _replaced(text: str, places: list[Occurrence], name: str) -> str:
    parts, at = [], 0
    for place in sorted(places, key=lambda o: o.start):
        parts += (text[at : place.start], name)
        at = place.end
    return "".join((*parts, text[at:]))
