"""The text of a model with syntax highlighting, by the tokens of the language."""

from __future__ import annotations

from collections.abc import Iterator

from mbdsl.elements import kinds
from mbdsl.lang import lexer
from mbdsl.plotting.escaping import escape

#: kind of token -> class in the page
_CLASSES = {lexer.COMMENT: "c", lexer.STRING: "s", lexer.NUMBER: "n", lexer.UNIT: "u", lexer.KEYWORD: "k"}


def highlighted(text: str) -> str:
    """A model as HTML: numbered lines, with classes for keywords, kinds, numbers, units, texts and comments.

    Returns
    -------
    str
        ``<pre>``; its text is that of the model.
    """
    lines: list[list[str]] = [[]]
    for kind, part in _parts(text):
        for k, piece in enumerate(part.split("\n")):
            if k:
                lines.append([])
            if piece:
                lines[-1].append(f'<span class="{kind}">{escape(piece)}</span>' if kind else escape(piece))
    if not lines[-1]:
        lines.pop()
    return '<pre class="code">' + "\n".join(f"<span>{''.join(line)}</span>" for line in lines) + "</pre>"


def _parts(text: str) -> Iterator[tuple[str, str]]:
    """(Class, text) of all parts of a text, in order; "" for the text between tokens."""
    known, at = kinds(), 0
    for piece in lexer.pieces(text):
        yield "", text[at : piece.start]
        is_kind = piece.kind == lexer.NAME and piece.text in known
        yield "e" if is_kind else _CLASSES.get(piece.kind, ""), piece.text
        at = piece.end
    yield "", text[at:]
