"""All errors of a file that do not follow from each other.

Reading a model ends at its first error. The statement with the error is replaced by blanks, and so are all that use the
names that it declares, or whose derivative or value at events it gives; then the text is read again.
"""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import replace
from itertools import groupby

from mbdsl.editor.library import LooseLibrary
from mbdsl.editor.names import NameIndex
from mbdsl.editor.positions import Places
from mbdsl.editor.repair import BLOCK_WORD, WORK, Statement, blank, repaired, statements
from mbdsl.editor.vocabulary import class_of
from mbdsl.errors import MbdslError, Span, SyntaxProblem
from mbdsl.lang import lexer
from mbdsl.lang.connections import NotConnected
from mbdsl.lang.library import key_of
from mbdsl.mechanism.scene import Scene

ERRORS = 10  #: errors of the model, after those of the syntax
_HEADERS = re.compile(r"(extends|import|model|spatial|partial|end(?!\s+(for|if|when)))\b")

#: of a statement that gives a derivative, `der(x) = ...`, or a value at an event, `x = ...` or `x[i] = ...`, up to the
#: name
_GIVES = re.compile(r"der\s*\(\s*(?=\w)|(?=\w+\s*(\[[^\]]*\]\s*)?=[^=])")


def find(text: str, file: str, read: Callable[[str], Scene]) -> tuple[list[MbdslError], Scene | None]:
    """The errors of a text, or its scene.

    Parameters
    ----------
    text : str
        The content of a file.
    file : str
        Its name.
    read : callable
        Makes the scene of a text.

    Returns
    -------
    tuple
        The errors in the order of the text, and the scene if there are none.
    """
    loose = repaired(text, file)
    problems = list(loose.problems)
    left: _Text | None = _Text(loose.text, file)
    if problems:
        left = left.without_names(_lost(text, loose.text)) if left and _models(loose.text) else None
    found = 0
    while left is not None and found < ERRORS:
        try:
            scene = read(left.text)
            if not problems:
                return [], scene
            break
        except MbdslError as problem:
            found += 1
            if problems and isinstance(problem, SyntaxProblem):
                break
            at = left.place(problem.span)
            if not problems or (at is not None and not isinstance(problem, NotConnected)):
                problems.append(problem)
            left = left.without(at) if at is not None and len(text) < WORK else None
    lines = text.split("\n")
    for problem in problems:
        if problem.span is not None and key_of(problem.span.file) == key_of(file):
            line = "".join(lines[problem.span.line - 1 : problem.span.line])
            problem.span = replace(problem.span, text=line)  # without the blanks
    here = [(p.span.line, p.span.column, k) for k, p in enumerate(problems) if p.span is not None]
    return [problems[k] for _, _, k in sorted(here)] or problems, None


def _models(text: str) -> bool:
    return re.search(r"\bmodel\b", text) is not None


def _lost(text: str, left: str) -> set[str]:
    """Names that a text may declare where ``left`` has blanks: those outside of brackets."""
    names: set[str] = set()
    depth, previous = 0, ""
    for piece in lexer.pieces(text):
        depth += (piece.text in ("(", "[", "{")) - (piece.text in (")", "]", "}"))
        if left[piece.start : piece.end].strip():
            depth = 0
        elif piece.kind == lexer.NAME and depth <= 0 and previous != "." and not class_of(piece.text):
            names.add(piece.text)
        previous = piece.text
    return names


class _Text:
    """A text without the statements that had errors."""

    def __init__(self, text: str, file: str) -> None:
        self.text = text
        self.file = file
        self.parts = list(statements(text))

    def place(self, span: Span | None) -> int | None:
        """The offset of a place; None if it is in another file or in the beginning of a model or block."""
        if span is None or key_of(span.file) != key_of(self.file):
            return None
        at = Places(self.text).of_span(span)[0]
        part = self._statement(at)
        return at if part is not None and not _HEADERS.match(self.text, part.start) else None

    def without(self, at: int) -> _Text | None:
        """The text without the statement at an offset; None if too much depends on it."""
        part = self._statement(at)
        return self._without({part}) if part is not None else None

    def without_names(self, names: set[str]) -> _Text | None:
        """The text without the statements that mention one of some names."""
        words = [p for p in lexer.pieces(self.text) if p.kind == lexer.NAME and p.text in names]
        return self._without({part for word in words if (part := self._statement(word.start)) is not None})

    def _statement(self, at: int) -> Statement | None:
        return next((part for part in self.parts if part.start <= at < part.end), None)

    def _given(self, part: Statement | None) -> int | None:
        """The offset of the name whose derivative or value a statement gives."""
        found = _GIVES.match(self.text, part.start) if part is not None else None
        return found.end() if found is not None else None

    def _block(self, part: Statement) -> set[Statement]:
        """All statements of the `for` or `if` that ``part`` begins, ends or divides."""
        opened: list[list[Statement]] = []
        for each in self.parts:
            word = BLOCK_WORD.match(self.text, each.start)
            opened += [[]] if word is not None and word[0] in ("for", "if", "when") else []
            for block in opened:
                block.append(each)
            if word is not None and word[0].startswith("end") and opened:
                # Inner blocks end first, so that the first one with the statement is the innermost.
                if part in (block := opened.pop()):
                    return set(block)
        return set()

    def _without(self, gone: set[Statement]) -> _Text | None:
        """The text without statements and all that uses the names that they declare or give values."""
        names = NameIndex(LooseLibrary(False).add(self.text, self.file))
        owners = [(self._statement(o.start), o) for o in names.occurrences]
        users = {symbol: {part for part, o in owners if o.symbol == symbol} for symbol in {o.symbol for _, o in owners}}
        declared = {
            part: [o.symbol for _, o in group if o.declares or o.start == self._given(part)]
            for part, group in groupby(owners, key=lambda pair: pair[0])
        }
        waiting = list(gone)
        while waiting:
            part = waiting.pop()
            if _HEADERS.match(self.text, part.start):
                return None
            if BLOCK_WORD.match(self.text, part.start):
                new = self._block(part) - gone
                gone |= new
                waiting += new
            for symbol in declared.get(part, ()):
                new = {user for user in users[symbol] if user is not None} - gone
                gone |= new
                waiting += new
        return _Text(blank(self.text, ((part.start, part.end) for part in gone)), self.file)
