"""Typing mistakes whose cause is not the token that the grammar refuses: the caret points to the cause."""

from __future__ import annotations

import re

from mbdsl.errors import ModelError, SyntaxProblem
from mbdsl.lang import syntax as s
from mbdsl.lang import units
from mbdsl.lang.lexer import NUMERAL, Token, leading
from mbdsl.lang.mistakes.statements import WORDS
from mbdsl.lang.source import span_of
from mbdsl.lang.unparse import write

#: terminals that begin an argument or an element of an array
_ARGUMENTS = frozenset("NAME NUMBER STRING EACH FINAL LBRACE LMATRIX TRUE FALSE NOT".split())
_CLOSING = frozenset("RPAR RBRACE RSQB".split())
_WHOLE = re.compile(r"(?<![0-9A-Za-z_.])[0-9]+,\Z")


def earlier_mistake(token: Token, expected: set[str], before: list[Token], following: Token) -> SyntaxProblem | None:
    """The error for a mistake before ``token``; None if there is none of these."""
    statement = statement_of(before)
    for word in [*statement[-3:], token]:
        if word.type == "NAME" and word.text in WORDS:
            return _at(word, word, f"`{word.text}` is not part of mbdsl", WORDS[word.text])
    previous = before[-1] if before else None
    if previous is None:
        return None
    if previous.text == "assert" and token.type == "LPAR" and len(statement) == 1:
        hint = "write it below the line `equation`, after the components"
        return _at(previous, previous, "an assertion belongs to the equation section", hint)
    return (
        _assignment(token, previous, expected, statement, following)
        or _decimal_comma(token, before, following)
        or _unit_in_parts(token, previous, following)
        or _missing_comma(token, before, expected, following)
    )


def _assignment(
    token: Token, previous: Token, expected: set[str], statement: list[Token], following: Token
) -> SyntaxProblem | None:
    """``:=`` and ``==`` where ``=`` is meant, and ``**``."""
    for colon, equal in ((previous, token), (token, following)):
        if colon.type == "COLON" and equal.type == "EQUAL" and colon.end == equal.start:
            return _at(colon, equal, "`:=` is an assignment, which mbdsl does not have", "write `=`")
    double = next((t for t in statement if t.text == "=="), None)
    if double is not None and token.type == "SEMICOLON" and "EQUAL" in expected:
        return _at(double, double, "found `==`, a comparison, expected `=`", "a value is given with `=`")
    if token.type == previous.type == "STAR" and previous.end == token.start:
        return _at(previous, token, "`**` is not part of mbdsl", "a power is written `^`")
    return None


def _decimal_comma(token: Token, before: list[Token], following: Token) -> SyntaxProblem | None:
    """``2,5 kg``"""
    parts = [*before[-2:], token] if token.type == "NUMBER" else [before[-1], token, following]
    if [t.type for t in parts] != ["NUMBER", "COMMA", "NUMBER"]:
        return None
    first, comma, last = parts
    if first.end != comma.start or comma.end != last.start or not first.text.isdigit():
        return None
    number = token.source.text[first.start : last.end]
    return _at(first, last, f"`{number}` has a decimal comma", _point(number))


def misread_argument(e: s.Expression, after_name: bool) -> ModelError | None:
    """The error for an argument without a name, perhaps after one with a name; None if it may be meant as it is."""
    match e:
        case s.Binary("==", s.Reference((_,)) as name, value):
            sign = "=="
        case s.Range(s.Reference((_,)) as name, None, value):
            sign = ":"
        case s.Number() if after_name and (numbers := number_with_comma(e)) is not None:
            return ModelError(f"`{numbers}` has a decimal comma", span_of(e.at), _point(numbers))
        case _:
            return None
    name, value = write(name), text_of(value)
    return ModelError(f"found `{sign}` after `{name}`, expected `=`", span_of(e.at), f"write `{name} = {value}`")


def number_with_comma(e: s.Number) -> str | None:
    """The text ``2,5 kg`` that ends with ``e``; None if there is no decimal comma."""
    if e.at is None:
        return None
    source, start, end = e.at
    found = _WHOLE.search(source.text, max(0, start - 40), start)
    return found[0] + source.text[start:end] if found and source.text[start].isdigit() else None


def text_of(e: s.Expression) -> str:
    """``e`` as it was typed; without a source as the language writes it."""
    return e.at[0].text[e.at[1] : e.at[2]] if isinstance(e, s.Number) and e.at is not None else write(e)


def _point(number: str) -> str:
    return f"write `{number.replace(',', '.')}`"


def _unit_in_parts(token: Token, previous: Token, following: Token) -> SyntaxProblem | None:
    """``5 N m``, ``2 [kg]``"""
    if previous.type != "NUMBER" or following.type == "EQUAL":
        return None
    bare = NUMERAL.fullmatch(previous.text) is not None
    if token.type in ("LSQB", "LMATRIX") and bare:
        unit = units.scan(token.source.text, following.start)
        if unit is not None and token.source.text[unit[1] : unit[1] + 1] == "]":
            right = f"{previous.text} {unit[0].text}"
            return _at(token, token, "found `[` after a number", f"a unit has no brackets: write `{right}`")
    if token.type == "NAME" and not bare and (unit := units.scan(token.source.text, token.start)) is not None:
        right = f"{previous.text}.{unit[0].text}"
        if units.parse(right[len(leading(right)) :].strip()) is not None:
            end = token._replace(end=unit[1])
            return _at(previous, end, "a unit contains no blanks", f"write `{right}`")
    return None


def _missing_comma(token: Token, before: list[Token], expected: set[str], following: Token) -> SyntaxProblem | None:
    """``Rod rod(m = 1 kg length = 1 m)``"""
    if "COMMA" not in expected or not expected & _CLOSING or token.type not in _ARGUMENTS:
        return None
    previous = first = before[-1]
    for dot, name in zip(before[-2::-2], before[-3::-2], strict=False):
        if dot.type != "DOT":
            break
        first = name
    certain = following.type == "EQUAL" or token.type in ("EACH", "FINAL")
    if previous.type == "NUMBER" and token.type == "NAME" and not certain:
        return None  # an unknown unit
    missing = "`,`" if certain else "`,` or an operator"
    behind = token.source.span(previous.end, previous.end + 1)
    whole = previous._replace(text=token.source.text[first.start : previous.end])
    return SyntaxProblem(f"{missing} is missing between {show(whole)} and {show(token)}", behind)


def statement_of(tokens: list[Token]) -> list[Token]:
    """The tokens after the last end of a statement or section; a description ends it, too."""
    for i in range(len(tokens) - 1, -1, -1):
        if tokens[i].type in ("SEMICOLON", "STRING", "EQUATION", "LOOP", "THEN", "ELSE", "PUBLIC", "PROTECTED"):
            return tokens[i + 1 :]
    return tokens


def _at(first: Token, last: Token, message: str, hint: str | None) -> SyntaxProblem:
    return SyntaxProblem(message, first.source.span(first.start, last.end), hint)


def is_below(token: Token, previous: Token) -> bool:
    """Whether a token is in a later line than the one before it."""
    return "\n" in token.source.text[previous.end : token.start]


def show(token: Token) -> str:
    """A token in a message."""
    if token.type == "$END":
        return "the end of the text"
    text = token.text if len(token.text) <= 40 else token.text[:37] + "..."
    return text if token.type == "STRING" else f"`{text}`"
