"""Text to syntax tree, by Lark with ``grammar.lark``."""

from __future__ import annotations

import hashlib
import pickle
import re
import sys
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import replace
from functools import cache, lru_cache
from io import BytesIO
from pathlib import Path
from typing import TYPE_CHECKING, Any

from mbdsl.errors import SyntaxProblem
from mbdsl.lang import limits
from mbdsl.lang import syntax as s
from mbdsl.lang.lexer import Token, tokenize
from mbdsl.lang.mistakes.statements import refuse_mbdyn
from mbdsl.lang.nodes import Nodes
from mbdsl.lang.source import Source
from mbdsl.storage import cache_folder
from mbdsl.version import __version__

if TYPE_CHECKING:
    from lark import Lark
    from lark.parsers.lalr_interactive_parser import InteractiveParser

#: syntax trees that are kept for models that are read again, as with other parameters; characters of the longest
TREES, LONGEST = 16, 200_000
GRAMMAR = Path(__file__).with_name("grammar.lark")
_FUNCTION = re.compile(r"\bfunction\s+\w")


def parse(text: str, file: str = "<text>") -> s.File:
    """The syntax tree of a whole file. A text that is read again has the same tree, which is never changed."""
    return _parsed(text, file) if len(text) <= LONGEST else _parsed.__wrapped__(text, file)


@lru_cache(maxsize=TREES)
def _parsed(text: str, file: str) -> s.File:
    source = Source(file, text)
    if len(text) > limits.FILE_SIZE:
        raise SyntaxProblem(f"{file} is larger than {limits.FILE_SIZE} characters", source.span(0, 1))
    refuse_mbdyn(source)
    tokens = tokenize(source)
    if not _FUNCTION.search(text):
        return _file(tokens)
    from mbdsl.lang import function_blocks

    tokens, blocks = function_blocks.cut(tokens)
    found = [function_blocks.read(block, _file) for block in blocks]
    return replace(_file(tokens), functions=tuple(found))


def parse_expression(text: str, file: str = "<text>") -> s.Expression:
    """The syntax tree of one expression."""
    return read_expression(Source(file, text))


def read_expression(source: Source) -> s.Expression:
    """The syntax tree of the expression that a source consists of."""
    if len(source.text) > limits.FILE_SIZE:
        raise SyntaxProblem(f"an expression of more than {limits.FILE_SIZE} characters")
    return _tree(tokenize(source), "expression")


def _file(tokens: list[Token]) -> s.File:
    source = tokens[-1].source
    return replace(_tree(tokens, "file"), name=source.file, at=(source, 0, len(source.text)))


def _tree(tokens: list[Token], start: str) -> Any:
    """The node of the rule ``start``; statements without effect are passed over, if it has an error otherwise."""
    from lark import UnexpectedToken

    try:
        return _fed(tokens, start)[1]
    except UnexpectedToken:
        from mbdsl.lang.mistakes.statements import pass_over

        kept, passed = pass_over(tokens)
        try:
            if len(kept) == len(tokens):
                raise
            return replace(_fed(kept, start)[1], passed=tuple(passed))
        except UnexpectedToken as problem:
            from mbdsl.lang.mistakes.grammar import explain

            k = next(k for k, token in enumerate(kept) if token is problem.token)
            raise explain(kept, k, expected(kept[:k], start), start) from None


# -- Lark ------------------------------------------------------------------------------------------------------------


@cache
def _lark() -> Lark:
    """The parser of the grammar.

    Lark needs 0.3 s to make its tables, so they are stored in the cache folder, for each version of the grammar, Lark
    and Python. A stored table is read only if other users cannot write the file.
    """
    import lark

    grammar = GRAMMAR.read_bytes()
    version = f"{lark.__version__} {sys.version_info[:2]}".encode()
    digest = hashlib.sha256(grammar + version).hexdigest()[:16]
    name = f"{__version__}-py{sys.version_info[0]}{sys.version_info[1]}-{digest}/grammar.tables"
    stored = cache_folder.read(name)
    if stored is not None:
        with suppress(Exception):  # the file is damaged
            return lark.Lark._load_from_dict(**pickle.loads(stored), transformer=Nodes())
    # The lexer is never asked: the parser is given tokens.
    made = lark.Lark(
        grammar.decode(),
        parser="lalr",
        lexer="basic",
        start=["file", "expression"],
        maybe_placeholders=False,
        transformer=Nodes(),
    )
    stream = BytesIO()
    made.save(stream, exclude_options=["transformer"])
    cache_folder.keep(name, stream.getvalue())
    return made


def _fed(tokens: Sequence[Any], start: str) -> tuple[InteractiveParser, Any]:
    """The parser after tokens, and the node that it has made if ``$END`` is the last of them."""
    run, result = _lark().parse_interactive(start=start), None
    for token in tokens:
        result = run.feed_token(token)  # Lark reads only the type of a token
    return run, result


def expected(tokens: list[Token], start: str = "file") -> set[str]:
    """The terminals that can follow tokens.

    It reads the tokens again: at an error, the parser has already done what follows from the wrong token.
    """
    return _fed(tokens, start)[0].accepts()
