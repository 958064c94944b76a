"""The text of a model with syntax highlighting, by the tokens of the parser."""

from __future__ import annotations

from collections.abc import Iterator

from mbdsl.elements import kinds
from mbdsl.errors import MbdslError
from mbdsl.lang.lexer import KEYWORDS, NUMBER, tokenize
from mbdsl.lang.source import Source
from mbdsl.plotting.escaping import escape


def highlighted(text: str, file: str = "") -> str:
    """A model as HTML: numbered lines, with classes for keywords, kinds, numbers, units, texts and comments.

    Parameters
    ----------
    text : str
        The model.
    file : str, optional
        Name of its file.

    Returns
    -------
    str
        ``<pre>``; its text is that of the model.
    """
    lines: list[list[str]] = [[]]
    for kind, part in _parts(text, file):
        for k, piece in enumerate(part.split("\n")):
            if k:
                lines.append([])
            if piece:
                lines[-1].append(f'<span class="{kind}">{escape(piece)}</span>' if kind else escape(piece))
    if not lines[-1]:
        lines.pop()
    return '<pre class="code">' + "\n".join(f"<span>{''.join(line)}</span>" for line in lines) + "</pre>"


def _parts(text: str, file: str) -> Iterator[tuple[str, str]]:
    """(Class, text) of all parts of a text, in order; "" for the text between tokens."""
    try:
        tokens = tokenize(Source(file, text))
    except MbdslError:  # a file that was replaced
        yield "", text
        return
    known, at = kinds(), 0
    for token in tokens:
        yield from _between(text[at : token.start])
        if token.type == "$END":
            return
        word = text[token.start : token.end]
        at = token.end
        if token.type == "NUMBER":
            number = NUMBER.match(word)
            size = number.end() if number else len(word)
            yield "n", word[:size]
            blank = len(word[size:]) - len(word[size:].lstrip())
            yield "", word[size : size + blank]
            yield "u", word[size + blank :]
        elif token.type == "UNIT":
            yield "u", word
        elif token.type == "STRING":
            yield "s", word
        elif word in KEYWORDS or token.type in ("GUESS", "FIXED"):
            yield "k", word
        elif token.type == "NAME" and word in known:
            yield "e", word
        else:
            yield "", word


def _between(text: str) -> Iterator[tuple[str, str]]:
    """Blanks, and the comments between them."""
    at = 0
    while at < len(text):
        if text.startswith("//", at):
            end = text.find("\n", at)
        elif text.startswith("/*", at):
            end = text.find("*/", at) + 2
        else:
            end = min((found for mark in ("//", "/*") if (found := text.find(mark, at)) >= 0), default=-1)
            end = len(text) if end < 0 else end
            yield "", text[at:end]
            at = end
            continue
        end = len(text) if end < at else end
        yield "c", text[at:end]
        at = end
