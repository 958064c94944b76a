"""Lexer for Pygments: highlights ```mbd blocks in MkDocs, Sphinx, Jupyter and on the command line.

Installed as an entry point, it is found by its name: ``pygmentize -l mbd``, ``get_lexer_by_name("mbd")``.
"""

from __future__ import annotations

from collections.abc import Iterator

from pygments.lexer import Lexer
from pygments.token import Comment, Error, Keyword, Name, Number, Operator, Punctuation, String, Whitespace

from mbdsl.editor.vocabulary import class_of
from mbdsl.lang import lexer

_TOKENS = {
    lexer.STRING: String.Double,
    lexer.NUMBER: Number,
    lexer.UNIT: Keyword.Type,
    lexer.WRONG: Error,
}
_WORDS = {
    "kind": Name.Class,
    "type": Keyword.Type,
    "function": Name.Builtin,
    "constant": Name.Constant,
}
_OPERATOR_WORDS = frozenset(("and", "or", "not"))


class MbdLexer(Lexer):
    """Lexer for models of mbdsl."""

    name = "mbdsl"
    aliases = ("mbd", "mbdsl")
    filenames = ("*.mbd",)
    url = ""

    def get_tokens_unprocessed(self, text: str) -> Iterator[tuple[int, object, str]]:
        """Cut a text.

        Parameters
        ----------
        text : str
            A model, which may contain errors.

        Yields
        ------
        tuple of (int, token type, str)
            Offset, type and text of each part, blanks included.
        """
        at = 0
        for piece in lexer.pieces(text):
            if at < piece.start:
                yield at, Whitespace, text[at : piece.start]
            yield piece.start, _token(piece), piece.text
            at = piece.end
        if at < len(text):
            yield at, Whitespace, text[at:]


def _token(piece: lexer.Token) -> object:
    if piece.kind == lexer.COMMENT:
        return Comment.Multiline if piece.text.startswith("/*") else Comment.Single
    if piece.kind == lexer.OPERATOR:
        return Punctuation if piece.text in "()[]{};,." else Operator
    if piece.kind in (lexer.NAME, lexer.KEYWORD):
        if piece.text in ("true", "false"):
            return Keyword.Constant
        if piece.text in _OPERATOR_WORDS:
            return Operator.Word
        return Keyword if piece.kind == lexer.KEYWORD else _WORDS.get(class_of(piece.text), Name)
    return _TOKENS[piece.kind]
