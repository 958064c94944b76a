"""Lexer for texts with errors: highlighting and editors need the tokens of incomplete texts.

It cuts the same tokens as :mod:`mbdsl.lang.lexer`, keeps comments, and never raises an error. The time is linear in the
length of the text.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from typing import NamedTuple

from mbdsl.lang import units
from mbdsl.lang.foreign_characters import BLANKS
from mbdsl.lang.lexer import A_NAME_FOLLOWS, KEYWORDS, MODEL_FOLLOWS, TOKEN

COMMENT, STRING, NUMBER, UNIT, KEYWORD, NAME, OPERATOR, WRONG = (
    *("comment", "string", "number", "unit"),
    *("keyword", "name", "operator", "wrong"),
)
_BLANK = re.compile(f"[{BLANKS}]*")
_LINE = re.compile(r"[^\n]*")


class Piece(NamedTuple):
    """A part of a text; ``kind`` is one of the constants of this module, ``start`` and ``end`` are offsets.

    A unit is a piece of its own. Text after a piece that is not ``closed`` would belong to it: a ``//`` comment, and a
    comment or string without end. Such a string extends to the end of its line, such a comment to the end of the text.
    Characters that are not of the language are ``WRONG``.
    """

    kind: str
    text: str
    start: int
    end: int
    closed: bool = True


def pieces(text: str) -> Iterator[Piece]:
    """The tokens and comments of any text, in order; blanks are left out."""
    at, size, strings_end = 0, len(text), True
    literals: list[bool] = []  # for every open bracket, whether it is a literal that takes a unit
    ends_reference = False
    while at < size:
        found = TOKEN.match(text, at) if strings_end or text[at] != '"' else None
        if found is None:
            if text[at] == '"':
                # Later texts are not searched for their ends either, so that the time remains linear.
                strings_end, end = False, _LINE.match(text, at).end()  # type: ignore[union-attr]
                yield Piece(STRING, text[at:end], at, end, False)
            else:
                end = at + 1
                yield Piece(WRONG, text[at], at, end)
            at, ends_reference = end, False
            continue
        end, group, word = found.end(), found.lastgroup, found.group()
        if group == "skip":
            if word.startswith("/"):
                yield Piece(COMMENT, word, at, end, word.startswith("/*"))
            at = end
            continue
        if group == "comment":
            yield Piece(COMMENT, text[at:], at, size, False)
            return
        takes_unit = group == "number"
        if group == "name":
            soft = word in ("guess", "fixed") and A_NAME_FOLLOWS.match(text, end) is not None
            soft = soft or (word == "spatial" and MODEL_FOLLOWS.match(text, end) is not None)
            yield Piece(KEYWORD if word in KEYWORDS or soft else NAME, word, at, end)
        elif group == "operator":
            yield Piece(OPERATOR, word, at, end)
            if word in "([{":
                literals.append(word == "{" or (word == "[" and not ends_reference))
            elif word in ")]}" and literals:
                takes_unit = literals.pop()
        else:
            yield Piece(NUMBER if group == "number" else STRING, word, at, end)
        ends_reference = (group == "name" and word not in KEYWORDS) or word == "]"
        if takes_unit:
            blank = _BLANK.match(text, end).end()  # type: ignore[union-attr]
            if unit := units.scan(text, blank):
                end = unit[1]
                yield Piece(UNIT, unit[0].text, blank, end)
        at = end
