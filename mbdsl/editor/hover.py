"""What an editor shows about the name or number under the pointer."""

from __future__ import annotations

import os
from collections.abc import Mapping
from typing import NamedTuple

from mbdsl.editor import descriptions
from mbdsl.editor import entities as e
from mbdsl.editor.entities import Entity, OfKind
from mbdsl.editor.names import NameIndex, Occurrence
from mbdsl.elements import kinds
from mbdsl.lang import lexer


class Hover(NamedTuple):
    """A text in Markdown about the characters from ``start`` to ``end``."""

    text: str
    start: int
    end: int


def hover(names: NameIndex, offset: int, values: Mapping[str, str] = {}, main: str = "") -> Hover | None:
    """The description of the name, word, number or unit at an offset.

    Parameters
    ----------
    names : NameIndex
        The names of the file.
    offset : int
        A place in its text.
    values : mapping of str to str, optional
        Values of parameters and components of the main model, by name, in SI units.
    main : str, optional
        The main model.
    """
    previous, model = None, names.unit.own(main)
    own = e.members(model, names.unit) if model is not None else {}
    known = {name: found.symbol for name, found in own.items()}
    for piece in lexer.pieces(names.unit.text):
        if piece.start > offset:
            break
        if offset < piece.end or (offset == piece.end and piece.kind in (lexer.NAME, lexer.KEYWORD)):
            occurrence = names.at(piece.start) if piece.kind == lexer.NAME else None
            found = occurrence.found if occurrence is not None else None
            found = found.component if isinstance(found, OfKind) else found
            is_own = isinstance(found, Entity) and known.get(found.declaration.name) == found.symbol
            text = _of_piece(piece, previous, occurrence, values if is_own else {})
            return Hover(text, piece.start, piece.end) if text else None
        previous = piece
    return None


def _of_piece(
    piece: lexer.Token, previous: lexer.Token | None, occurrence: Occurrence | None, values: Mapping[str, str]
) -> str:
    if piece.kind == lexer.UNIT:
        text = descriptions.of_unit(piece.text)
        if previous is not None and previous.kind == lexer.NUMBER:
            text += f"\n\n{descriptions.of_number(previous.text, piece.text)}"
        return text
    if piece.kind == lexer.KEYWORD:
        return descriptions.of_word(piece.text)
    if piece.kind != lexer.NAME:
        return ""
    return of_occurrence(occurrence, values) if occurrence is not None else descriptions.of_word(piece.text)


def of_occurrence(occurrence: Occurrence, values: Mapping[str, str]) -> str:
    """The description of a name in Markdown."""
    symbol, found = occurrence.symbol, occurrence.found
    if isinstance(found, Entity):
        return descriptions.of_entity(found, values)
    if isinstance(found, OfKind):
        return descriptions.of_own(found, values)
    if isinstance(found, tuple):
        return descriptions.of_model(found[0], os.path.basename(found[1].file.name))
    if symbol.form == e.COORDINATE:
        return descriptions.of_coordinate(symbol.name)
    if symbol.form == e.OF_KIND:
        return descriptions.of_member({**kinds(spatial=True), **kinds()}[symbol.owner], symbol.name)
    if symbol.form == e.SETTING:
        return descriptions.of_setting(symbol.name) or descriptions.of_word(symbol.name)
    if symbol.form == e.LOOP_VARIABLE:
        return f"`{symbol.name}`: variable of a loop"
    if symbol.form == e.ALIAS:
        return f"`{symbol.name}`: name of an import"
    return descriptions.of_word(symbol.name)
