"""Lexer: text to tokens.

The tokens are the terminals of ``grammar.lark``. The lexer is not generated, because a unit belongs to the number
before it (``3 kg``, but ``2 m/L2`` is two metres divided by L2), which regular expressions cannot express.
"""

from __future__ import annotations

import re
from typing import NamedTuple

from mbdsl.errors import SyntaxProblem
from mbdsl.lang import limits, units
from mbdsl.lang.foreign_characters import BLANKS, foreign
from mbdsl.lang.source import Source

KEYWORDS = frozenset(
    "model partial end extends import as parameter constant input final each inner outer connector public protected "
    "initial equation for in loop if then elseif else connect annotation and or not true false".split()
)
PUNCTUATION = {
    "(": "LPAR", ")": "RPAR", "{": "LBRACE", "}": "RBRACE", "[": "LSQB", "]": "RSQB", ";": "SEMICOLON",
    ",": "COMMA", ".": "DOT", ":": "COLON", "=": "EQUAL", "+": "PLUS", "-": "MINUS", "*": "STAR", "/": "SLASH",
    "^": "POWER", "==": "RELATION", "<>": "RELATION", "<=": "RELATION", ">=": "RELATION", "<": "RELATION",
    ">": "RELATION",
}  # fmt: skip

NUMBER = re.compile(r"(?:[0-9]+(?:\.[0-9]*)?|\.[0-9]+)(?:[eE][+-]?[0-9]+)?")
TOKEN = re.compile(
    rf"(?P<skip>[{BLANKS}\r\n\f\v]+|//[^\n]*|/\*(?s:.*?)\*/)"
    r"|(?P<comment>/\*)"
    rf"|(?P<number>{NUMBER.pattern})"
    r"|(?P<name>[A-Za-z_][A-Za-z0-9_]*)"
    r'|(?P<string>"(?:[^"\\]|\\(?s:.))*")'
    r"|(?P<operator>==|<>|<=|>=|[-+*/^(){}\[\];,.:=<>])"
)
_BLANK = re.compile(f"[{BLANKS}]*")
MODEL_FOLLOWS = re.compile(r"\s+(?:partial\s+)?model\b")
#: `guess` and `fixed` are words of the initial section if a name follows; `Frame fixed annotation(...)` declares a name
A_NAME_FOLLOWS = re.compile(rf"[{BLANKS}]+(?!(?:{'|'.join(sorted(KEYWORDS))})\b)[A-Za-z_]")
_NEXT_VALUE = re.compile(rf";[{BLANKS}]*[A-Za-z_]\w*[{BLANKS}]*=[^\n(]*\)")
_PAIRS = {")": "(", "]": "[", "}": "{"}


class Token(NamedTuple):
    """``type`` names a terminal of the grammar; ``start`` and ``end`` are offsets in the source."""

    type: str
    text: str
    start: int
    end: int


def tokenize(source: Source) -> list[Token]:
    """All tokens of ``source``, closed by one of type ``$END``.

    Raises
    ------
    SyntaxProblem
        For characters that are not of the language, brackets that do not match, texts and comments without end.
    """
    text, match = source.text, TOKEN.match
    tokens: list[Token] = []
    brackets: list[tuple[str, int, bool]] = []  # character, offset, and whether it is a literal that takes a unit
    at, size = 0, len(text)
    while at < size:
        found = match(text, at)
        if found is None:
            raise _strange(source, at)
        end = found.end()
        group = found.lastgroup
        if group == "comment":
            raise SyntaxProblem("this comment has no end", source.span(at, end), "close it with `*/`")
        if group == "name":
            word = text[at:end]
            if word in KEYWORDS:
                kind = word.upper()
                if word == "end" and brackets and brackets[-1][0] == "[":
                    kind = "LAST"
                tokens.append(Token(kind, word, at, end))
            else:
                soft = word in ("guess", "fixed") and A_NAME_FOLLOWS.match(text, end) is not None
                soft = soft or (word == "spatial" and MODEL_FOLLOWS.match(text, end) is not None)
                tokens.append(Token(word.upper() if soft else "NAME", word, at, end))
        elif group == "number":
            unit = units.scan(text, _BLANK.match(text, end).end())  # type: ignore[union-attr]
            end = unit[1] if unit else end
            if text[end : end + 1].isalnum() or text[end : end + 1] == "_":
                raise _glued(source, at, end)
            tokens.append(Token("NUMBER", text[at:end], at, end))
        elif group == "operator":
            word = text[at:end]
            if word in "([{":
                literal = word == "{" or (word == "[" and not _ends_reference(tokens))
                brackets.append((word, at, literal))
                if len(brackets) > limits.NESTING:
                    raise SyntaxProblem(f"more than {limits.NESTING} brackets inside each other", source.span(at, end))
            tokens.append(Token("LMATRIX" if word == "[" and brackets[-1][2] else PUNCTUATION[word], word, at, end))
            if word in ")]}":
                if not brackets or brackets[-1][0] != _PAIRS[word]:
                    raise _unbalanced(source, at, brackets)
                blank = _BLANK.match(text, end).end()  # type: ignore[union-attr]
                if brackets.pop()[2] and (unit := units.scan(text, blank)):
                    end = unit[1]
                    tokens.append(Token("UNIT", unit[0].text, blank, end))
            elif word == ";" and brackets:
                # In a matrix `;` separates rows; anywhere else a bracket is still open.
                if not (brackets[-1][0] == "[" and brackets[-1][2]):
                    raise _unclosed(source, at, brackets[-1])
        elif group == "string":
            if end - at > limits.TEXT and tokens and tokens[-1].type == "EQUAL":
                raise SyntaxProblem(f"a text longer than {limits.TEXT} characters", source.span(at, at + 1))
            tokens.append(Token("STRING", text[at:end], at, end))
        at = end
    if brackets:
        raise _unclosed(source, size, brackets[-1])
    tokens.append(Token("$END", "", size, size))
    return tokens


def _ends_reference(tokens: list[Token]) -> bool:
    return bool(tokens) and tokens[-1].type in ("NAME", "RSQB")


def _glued(source: Source, at: int, end: int) -> SyntaxProblem:
    stop = end
    while stop < len(source.text) and (source.text[stop].isalnum() or source.text[stop] == "_"):
        stop += 1
    word = source.text[end:stop]
    number = source.text[at:end]
    meant = units.meant(word) if NUMBER.fullmatch(number) else None
    hint = f"did you mean `{meant}`?" if meant else None
    name = "pi" if word == "\u03c0" else word
    hint = (
        hint or f"a product is written with `*`, as in `{number}*{name}`; units are e.g. kg, m/s2, N.m/rad, deg, 1 ms"
    )
    return SyntaxProblem(
        f"found `{source.text[at:stop]}`: `{word}` is not a unit, and a name does not begin with a digit",
        source.span(end, stop),
        hint,
    )


def _strange(source: Source, at: int) -> SyntaxProblem:
    text = source.text
    if text.startswith('"', at):
        inches = re.search(r"[0-9.]+\Z", text[max(0, at - 20) : at])
        hint = f"inches are written `{inches[0]} in`" if inches else 'close it with `"`'
        return SyntaxProblem("this text is not closed", source.span(at, at + 1), hint)
    message, length, remedy = foreign(text, at)
    return SyntaxProblem(message, source.span(at, at + length), remedy)


def _unbalanced(source: Source, at: int, brackets: list[tuple[str, int, bool]]) -> SyntaxProblem:
    found = source.text[at]
    if not brackets:
        return SyntaxProblem(f"`{found}` closes nothing: no `{_PAIRS[found]}` is open", source.span(at, at + 1))
    opened, where, _ = brackets[-1]
    return SyntaxProblem(
        f"`{found}` does not close `{opened}`",
        source.span(at, at + 1),
        notes=((f"`{opened}` was opened here", source.span(where, where + 1)),),
    )


def _unclosed(source: Source, at: int, bracket: tuple[str, int, bool]) -> SyntaxProblem:
    opened, where, _ = bracket
    closing = next(c for c, o in _PAIRS.items() if o == opened)
    found = "the text ends" if at >= len(source.text) else f"found `{source.text[at]}`"
    hint = "values are separated by `,`" if _NEXT_VALUE.match(source.text, at) else None
    return SyntaxProblem(
        f"{found}, but `{opened}` is still open; `{closing}` is missing",
        source.span(at, at + 1),
        hint,
        notes=((f"`{opened}` was opened here", source.span(where, where + 1)),),
    )
