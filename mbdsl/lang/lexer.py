"""Lexer: text to tokens, of a model that is to be read, and of any text for editors and highlighting.

The tokens are the terminals of ``grammar.lark``. The lexer is not generated, because a unit belongs to the number
before it (``3 kg``, but ``2 m/L2`` is two metres divided by L2), which regular expressions cannot express.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from typing import NamedTuple

from mbdsl.errors import SyntaxProblem
from mbdsl.lang import limits, units
from mbdsl.lang.source import Source

#: class of a regular expression: characters that separate words in a line (Unicode category Zs, and tabs)
BLANKS = " \t\u00a0\u1680\u2000-\u200a\u202f\u205f\u3000"
KEYWORDS = frozenset(
    "model partial end extends import as parameter constant input final each inner outer connector public protected "
    "initial equation for in loop if then elseif else when elsewhen discrete connect annotation and or not true "
    "false".split()
)
PUNCTUATION = {
    "(": "LPAR", ")": "RPAR", "{": "LBRACE", "}": "RBRACE", "[": "LSQB", "]": "RSQB", ";": "SEMICOLON",
    ",": "COMMA", ".": "DOT", ":": "COLON", "=": "EQUAL", "+": "PLUS", "-": "MINUS", "*": "STAR", "/": "SLASH",
    "^": "POWER", "==": "RELATION", "<>": "RELATION", "<=": "RELATION", ">=": "RELATION", "<": "RELATION",
    ">": "RELATION",
}  # fmt: skip

NUMERAL = re.compile(r"(?:[0-9]+(?:\.[0-9]*)?|\.[0-9]+)(?:[eE][+-]?[0-9]+)?")
TOKEN = re.compile(
    rf"(?P<skip>[{BLANKS}\r\n\f\v]+|//[^\n]*|/\*(?s:.*?)\*/)"
    r"|(?P<comment>/\*)"
    rf"|(?P<number>{NUMERAL.pattern})"
    r"|(?P<name>[A-Za-z_][A-Za-z0-9_]*)"
    r'|(?P<string>"(?:[^"\\]|\\(?s:.))*")'
    r"|(?P<operator>==|<>|<=|>=|[-+*/^(){}\[\];,.:=<>])"
)
_BLANK = re.compile(f"[{BLANKS}]*")
MODEL_FOLLOWS = re.compile(r"\s+(?:partial\s+)?model\b")
EMPTY = re.compile(r"\s*\(\s*\)(?!\s*;)")  #: of `initial()`, a function within an expression
#: `guess` and `fixed` are words of the initial section if a name follows; `Frame fixed annotation(...)` declares a name
A_NAME_FOLLOWS = re.compile(rf"[{BLANKS}]+(?!(?:{'|'.join(sorted(KEYWORDS))})\b)[A-Za-z_]")
_NEXT_VALUE = re.compile(rf";[{BLANKS}]*[A-Za-z_]\w*[{BLANKS}]*=[^\n(]*\)")
_PAIRS = {")": "(", "]": "[", "}": "{"}


def leading(text: str) -> str:
    """The numeral at the beginning of a text; "" if there is none."""
    return text[: _end(NUMERAL, text, 0)]


def _end(pattern: re.Pattern[str], text: str, at: int) -> int:
    """The end of what matches at a place of a text; the place itself if nothing does."""
    found = pattern.match(text, at)
    return at if found is None else found.end()


#: kinds of tokens for editors and highlighting
COMMENT, STRING, NUMBER, UNIT = "comment", "string", "number", "unit"
KEYWORD, NAME, OPERATOR, WRONG = "keyword", "name", "operator", "wrong"
_KINDS = {
    **dict.fromkeys(("COMMENT", "LINE_COMMENT", "OPEN_COMMENT"), COMMENT),
    **dict.fromkeys(("STRING", "OPEN_STRING"), STRING),
    **dict.fromkeys(PUNCTUATION.values(), OPERATOR),
    **dict(LMATRIX=OPERATOR, NUMBER=NUMBER, UNIT=UNIT, NAME=NAME, WRONG=WRONG),
}
_BLANK_TYPES = frozenset(("COMMENT", "LINE_COMMENT"))
_OPENS, _CLOSES = frozenset("([{"), frozenset(")]}")
_LINE = re.compile(r"[^\n]*")


class Token(NamedTuple):
    """A part of a text; ``start`` and ``end`` are offsets in the source.

    ``type`` names a terminal of the grammar, or what a model cannot contain: comments, and ``WRONG`` characters.
    """

    type: str
    text: str
    start: int
    end: int
    source: Source

    @property
    def kind(self) -> str:
        """One of the kinds of this module."""
        return _KINDS.get(self.type, KEYWORD)

    @property
    def closed(self) -> bool:
        """Whether text behind it does not belong to it, as it does for a ``//`` comment and a text without end."""
        return self.type not in ("LINE_COMMENT", "OPEN_COMMENT", "OPEN_STRING")


def pieces(text: str) -> Iterator[Token]:
    """The tokens and comments of any text, in order; blanks are left out, and units are pieces of their own."""
    return scan(Source("<text>", text))


def scan(source: Source) -> Iterator[Token]:
    """The tokens and comments of any text, without an error, in a time linear in its length.

    A string without end extends to the end of its line, a comment without end to the end of the text.
    """
    text, match = source.text, TOKEN.match
    brackets: list[tuple[str, bool]] = []  # character, and whether it is a literal that takes a unit
    at, size, last, strings_end = 0, len(text), "", True
    while at < size:
        found = match(text, at) if strings_end or text[at] != '"' else None
        if found is None:
            if text[at] == '"':
                # Later texts are not searched for their ends either, so that the time remains linear.
                strings_end, last, end = False, "OPEN_STRING", _end(_LINE, text, at)
            else:
                last, end = "WRONG", at + 1
            yield Token(last, text[at:end], at, end, source)
            at = end
            continue
        end, group, word = found.end(), found.lastgroup, found.group()
        if group == "skip":
            if word[0] == "/":
                yield Token("COMMENT" if word[1] == "*" else "LINE_COMMENT", word, at, end, source)
            at = end
            continue
        if group == "comment":
            yield Token("OPEN_COMMENT", text[at:], at, size, source)
            return
        takes_unit = group == "number"
        if group == "name":
            last = _word(word, text, end, bool(brackets) and brackets[-1][0] == "[")
        elif group == "operator":
            if word in _OPENS:
                literal = word == "{" or (word == "[" and last not in ("NAME", "RSQB"))
                brackets.append((word, literal))
                last = "LMATRIX" if word == "[" and literal else PUNCTUATION[word]
            else:
                last = PUNCTUATION[word]
                takes_unit = word in _CLOSES and bool(brackets) and brackets.pop()[1]
        else:
            last = "NUMBER" if takes_unit else "STRING"
        yield Token(last, word, at, end, source)
        if takes_unit:
            blank = _end(_BLANK, text, end)
            if unit := units.scan(text, blank):
                last, end = "UNIT", unit[1]
                yield Token(last, unit[0].text, blank, end, source)
        at = end


def _word(word: str, text: str, end: int, in_brackets: bool) -> str:
    """The terminal of a word that ends at an offset; ``end`` in the brackets of indices is the last index."""
    if word in KEYWORDS and not (word == "initial" and EMPTY.match(text, end)):
        return "LAST" if word == "end" and in_brackets else word.upper()
    soft = word in ("guess", "fixed") and A_NAME_FOLLOWS.match(text, end) is not None
    soft = soft or (word == "spatial" and MODEL_FOLLOWS.match(text, end) is not None)
    return word.upper() if soft else "NAME"


def tokenize(source: Source) -> list[Token]:
    """The tokens of a model, closed by one of type ``$END``; the unit of a number is a part of its token.

    Raises
    ------
    SyntaxProblem
        For characters that are not of the language, brackets that do not match, texts and comments without end.
    """
    text, size = source.text, len(source.text)
    tokens: list[Token] = []
    brackets: list[Token] = []
    last = Token("$END", "", 0, 0, source)
    for token in scan(source):
        kind, word, at, end, _ = token
        if kind in _BLANK_TYPES:
            continue
        if kind == "UNIT" and last.type == "NUMBER":
            token = tokens[-1] = Token("NUMBER", text[last.start : end], last.start, end, source)
        elif last.type == "NUMBER" and last.end == at and (word[0].isalnum() or word[0] == "_"):
            raise _glued(source, last.start, last.end)
        elif kind in ("WRONG", "OPEN_STRING"):
            raise _strange(source, at)
        elif kind == "OPEN_COMMENT":
            raise SyntaxProblem("this comment has no end", source.span(at, at + 2), "close it with `*/`")
        else:
            if word in _OPENS:
                brackets.append(token)
                if len(brackets) > limits.NESTING:
                    raise SyntaxProblem(f"more than {limits.NESTING} brackets inside each other", source.span(at, end))
            elif word in _CLOSES:
                if not brackets or brackets[-1].text != _PAIRS[word]:
                    raise _unbalanced(source, at, brackets)
                brackets.pop()
            elif kind == "SEMICOLON" and brackets and brackets[-1].type != "LMATRIX":
                raise _unclosed(source, at, brackets[-1])  # in a matrix `;` separates rows
            elif kind == "STRING" and end - at > limits.TEXT and last.type == "EQUAL":
                raise SyntaxProblem(f"a text longer than {limits.TEXT} characters", source.span(at, at + 1))
            tokens.append(token)
        last = token
    if brackets:
        raise _unclosed(source, size, brackets[-1])
    tokens.append(Token("$END", "", size, size, source))
    return tokens


def unquote(token: Token) -> str:
    """The value of a string literal."""
    text = token.text[1:-1]
    if "\\" not in text:
        return text
    out, at = [], 0
    while at < len(text):
        if text[at] == "\\":
            at += 1
            out.append({"n": "\n", "t": "\t", "r": "\r"}.get(text[at], text[at]))
        else:
            out.append(text[at])
        at += 1
    return "".join(out)


def _glued(source: Source, at: int, end: int) -> SyntaxProblem:
    stop = end
    while stop < len(source.text) and (source.text[stop].isalnum() or source.text[stop] == "_"):
        stop += 1
    word = source.text[end:stop]
    number = source.text[at:end]
    meant = units.meant(word) if NUMERAL.fullmatch(number) else None
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
    from mbdsl.lang.mistakes.characters import foreign

    message, length, remedy = foreign(text, at)
    return SyntaxProblem(message, source.span(at, at + length), remedy)


def _unbalanced(source: Source, at: int, brackets: list[Token]) -> SyntaxProblem:
    found = source.text[at]
    if not brackets:
        return SyntaxProblem(f"`{found}` closes nothing: no `{_PAIRS[found]}` is open", source.span(at, at + 1))
    opened, where = brackets[-1].text, brackets[-1].start
    return SyntaxProblem(
        f"`{found}` does not close `{opened}`",
        source.span(at, at + 1),
        notes=((f"`{opened}` was opened here", source.span(where, where + 1)),),
    )


def _unclosed(source: Source, at: int, bracket: Token) -> SyntaxProblem:
    opened, where = bracket.text, bracket.start
    closing = next(c for c, o in _PAIRS.items() if o == opened)
    found = "the text ends" if at >= len(source.text) else f"found `{source.text[at]}`"
    hint = "values are separated by `,`" if _NEXT_VALUE.match(source.text, at) else None
    return SyntaxProblem(
        f"{found}, but `{opened}` is still open; `{closing}` is missing",
        source.span(at, at + 1),
        hint,
        notes=((f"`{opened}` was opened here", source.span(where, where + 1)),),
    )
