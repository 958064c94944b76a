"""The syntax tree of a text with errors.

While a line is typed, the text is rarely a model. Here the statement of the first error is replaced by blanks, and the
text is parsed again, until it has no errors; all other places remain where they are. The errors found on the way are
the syntax errors of the text.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from functools import lru_cache
from itertools import pairwise
from typing import NamedTuple

from mbdsl.editor.positions import Places
from mbdsl.errors import MbdslError, Span
from mbdsl.lang import lexer
from mbdsl.lang import syntax as s
from mbdsl.lang.load import deep
from mbdsl.lang.mistakes.statements import places as foreign_places
from mbdsl.lang.parser import parse

ATTEMPTS = 20  #: errors of one text
WORK = 200_000  #: characters that are parsed for one text with errors, so that the answer does not take long

_BEGINNINGS = frozenset(
    "model spatial partial extends import parameter constant input inner outer connector public protected initial "
    "equation connect guess fixed discrete".split()
)
_WHOLE = re.compile(r"(model|spatial|partial|import)\b")
_FUNCTION = re.compile(r"\bfunction\s+(\w+)\b.*?\bend\s+\1\s*;", re.DOTALL)
BLOCK_WORD = re.compile(r"(for|if|when|elseif|elsewhen|else|end\s+for|end\s+if|end\s+when)\b")
_ELSE_IF = re.compile(r"else\s+(?:if|when)\b")
_MODEL_END = re.compile(r"end\b(?!\s+(?:for|if|when)\b)")
_BLOCKS = frozenset(("for", "if", "elseif", "else", "when", "elsewhen"))


@dataclass(frozen=True)
class Repaired:
    """A syntax tree, with the errors of the text; ``text`` is the text that the tree was read from."""

    file: s.File
    text: str
    problems: tuple[MbdslError, ...]


@lru_cache(maxsize=64)
def repaired(text: str, file: str) -> Repaired:
    """The syntax tree of a text without the statements that have errors.

    Parameters
    ----------
    text : str
        The content of a file.
    file : str
        Its name.
    """
    problems: list[MbdslError] = []
    left = text
    for _ in range(max(2, min(ATTEMPTS, WORK // (len(text) + 1)))):
        try:
            with deep():
                return Repaired(parse(left + _ending(left) if problems else left, file), left, tuple(problems))
        except MbdslError as problem:
            problems.append(problem)
            if problem.span is None or not left.strip():
                break
            at_end = Places(left).of_span(problem.span)[0] >= len(left.rstrip())
            if not (
                len(problems) == 1 and at_end and _ending(left)
            ):  # else the end of the model may be all that is missing
                left = _without(left, problem)
    return Repaired(s.File(file, (), ()), "", tuple(problems))


def _ending(text: str) -> str:
    """The end of the last model, if it is missing."""
    name = _open_model([p for p in lexer.pieces(text) if p.kind in (lexer.KEYWORD, lexer.NAME)])
    return f"\nend {name};" if name else ""


def _open_model(words: list[lexer.Token]) -> str:
    name, functions = "", set[str]()
    for word, following in pairwise(words):
        if word.text == "function":
            functions.add(following.text)
        elif word.text == "end" and following.text in functions:
            continue
        if word.kind == lexer.KEYWORD and following.kind == lexer.NAME:
            if word.text == "model":
                name = following.text
            elif word.text == "end":
                name = ""
    return name


def _without(text: str, problem: MbdslError) -> str:
    """The text with blanks instead of the statement that has the error."""
    places = Places(text)
    at = places.of_span(problem.span)[0] if problem.span is not None else 0
    if block := next((b.span() for b in _FUNCTION.finditer(text) if b.start() <= at < b.end()), None):
        return blank(text, [block])
    # What was opened and not closed is the error, and not the place where the closing is missing.
    if unclosed := _unclosed_when(text, places, problem, at):
        return blank(text, [unclosed])
    for opened in (_opened(places, span) for _, span in problem.notes if span is not None):
        at = at if opened is None else opened
    found = list(statements(text))
    # Behind the last token of a statement a semicolon or an operand is missing.
    k = max((k for k, part in enumerate(found) if part.start <= at), default=0)
    if k and found[k].start == at and not found[k - 1].complete:
        k -= 1
    if k >= len(found):
        return ""
    start, end = found[k].start, _end_of_block(text, found, k)
    if foreign := foreign_places(text, start):
        return blank(text, foreign)
    if not _open_model([p for p in lexer.pieces(text[:start]) if p.kind in (lexer.KEYWORD, lexer.NAME)]):
        # Outside of models, what follows belongs to a model whose beginning is not recognised.
        following = (part for part in found[k + 1 :] if _WHOLE.match(text, part.start))
        end = next((part.start for part in following), len(text))
    return blank(text, [(start, end)])


def _unclosed_when(text: str, places: Places, problem: MbdslError, at: int) -> tuple[int, int] | None:
    """A `when` without its end, of which no statement is left: they mean nothing outside of it."""
    begun = [start for _, span in problem.notes if span is not None and (start := _opened(places, span)) is not None]
    if not begun or not text.startswith("when", begun[0]):
        return None
    part = next((part for part in statements(text) if part.start <= at < part.end), None)
    if part is None or not (ends := re.compile(r"end\b\s*(\w*)").match(text, part.start)):
        return None
    name = _open_model([p for p in lexer.pieces(text[: part.start]) if p.kind in (lexer.KEYWORD, lexer.NAME)])
    return begun[0], part.start if ends[1] == name else part.end


def _end_of_block(text: str, found: list[Statement], k: int) -> int:
    """The end of the statement ``k``; if it begins a block, or a branch of one, the end of this."""
    first = BLOCK_WORD.match(text, found[k].start)
    if first is None or first[0].startswith("end"):
        return found[k].end
    depth = 0
    k += _ELSE_IF.match(text, found[k].start) is not None  # `else when` is meant as one word
    for before, part in pairwise(found[k:]):
        word = BLOCK_WORD.match(text, part.start)
        if _MODEL_END.match(text, part.start):
            return before.end
        if word is None:
            continue
        if depth == 0 and word[0].startswith("e") and first[0].startswith("e"):
            return before.end
        if depth == 0 and word[0].startswith("end"):
            return part.end
        if not word[0].startswith("else"):
            depth += -1 if word[0].startswith("end") else 1
    return found[-1].end


def blank(text: str, parts: Iterable[tuple[int, int]]) -> str:
    """The text with blanks from start to end of some parts."""
    for start, end in parts:
        text = text[:start] + re.sub(r"[^\n]", " ", text[start:end]) + text[end:]
    return text


def _opened(places: Places, span: Span) -> int | None:
    start, end = places.of_span(span)
    return start if places.text[start:end] in ("(", "[", "{", "for", "if", "when") else None


class Statement(NamedTuple):
    """Offsets of a statement; it is not complete if it should end with a semicolon, but does not."""

    start: int
    end: int
    complete: bool


def statements(text: str) -> Iterator[Statement]:
    """All statements of a text.

    A statement ends with its semicolon. One without a semicolon ends where the next line begins like a statement.
    """
    tokens = [p for p in lexer.pieces(text) if p.kind != lexer.COMMENT]
    begin, brackets, previous = -1, [], None
    for k, token in enumerate(tokens):
        if previous is not None and begin >= 0 and "\n" in text[previous.end : token.start]:
            if _begins(text, tokens, k, bool(brackets)):
                yield Statement(begin, previous.end, False)
                begin, brackets = -1, []
        if begin < 0:
            begin, first = token.start, token.text
            name_at = k + 1 + (first in ("spatial", "partial"))
            name_at += first == "spatial" and _next(tokens, k) == "partial"
        if token.kind == lexer.OPERATOR:
            if token.text in "([{":
                brackets.append(token.text)
            elif token.text in ")]}" and brackets:
                brackets.pop()
        ends = token.text == ";" and brackets[-1:] != ["["]
        header = token.kind == lexer.KEYWORD and not brackets
        ends = ends or (header and token.text in ("equation", "public", "protected"))
        ends = ends or (header and token.text in ("loop", "then", "else") and first in _BLOCKS)
        if first in ("model", "spatial", "partial") and k >= name_at:
            ends = not (k + 1 < len(tokens) and tokens[k + 1].kind == lexer.STRING) or token.kind == lexer.STRING
        if ends:
            yield Statement(begin, token.end, True)
            begin, brackets = -1, []
        previous = token
    if begin >= 0 and previous is not None:
        yield Statement(begin, previous.end, False)


def _next(tokens: list[lexer.Token], k: int) -> str:
    """The text of the token after token k; "" at the end."""
    return tokens[k + 1].text if k + 1 < len(tokens) else ""


def _begins(text: str, tokens: list[lexer.Token], k: int, in_brackets: bool) -> bool:
    """Whether the token ``k``, the first one of a line, begins a statement."""
    token = tokens[k]
    following = tokens[k + 1] if k + 1 < len(tokens) else token
    if token.kind == lexer.KEYWORD:
        if token.text == "end":
            return not in_brackets or following.kind == lexer.NAME or following.text in ("for", "if", "when")
        return token.text in _BEGINNINGS or (not in_brackets and token.text in ("for", "when", "annotation"))
    if token.kind != lexer.NAME:
        return False
    operand = tokens[k - 1].kind in (lexer.NAME, lexer.NUMBER, lexer.UNIT, lexer.STRING) or tokens[k - 1].text in ")]}"
    if operand and not in_brackets:
        return True
    # a type, which may have dots, and a name in the same line
    while following.text == "." and k + 3 < len(tokens):
        k += 2
        token, following = tokens[k], tokens[k + 1]
    return following.kind == lexer.NAME and "\n" not in text[token.start : following.start]
