"""The TextMate grammar of the language, for VS Code, Sublime Text and other editors that read such grammars.

``python -m mbdsl.editor.textmate editors/vscode/syntaxes/mbd.tmLanguage.json`` writes it again after a change of the
language; a name that ends with ``.tmLanguage`` gets the older format, which Sublime Text reads. Its regular expressions
use only what both Oniguruma and Python's `re` understand, so that the tests can run them.
"""

from __future__ import annotations

import json
import plistlib
import re
import sys
from collections.abc import Iterable
from pathlib import Path
from typing import Any

from mbdsl.editor.vocabulary import words
from mbdsl.lang import units
from mbdsl.lang.lexer import BLANKS, NUMERAL

_DECLARING = ("parameter", "constant", "input", "final", "each", "inner", "outer", "connector", "partial", "spatial")
_DECLARING += ("public", "protected", "guess", "fixed", "discrete")
_LOGICAL = ("and", "or", "not")


def grammar() -> dict[str, Any]:
    """The grammar as the content of a ``.tmLanguage.json`` file."""
    vocabulary = words()
    control = set(vocabulary["keyword"]) - set(_DECLARING) - set(_LOGICAL)
    unit = unit_pattern()
    patterns = [
        _range("comment.block.mbd", r"/\*", r"\*/"),
        _match("comment.line.double-slash.mbd", r"//.*$"),
        _range("string.quoted.double.mbd", '"', '"', [_match("constant.character.escape.mbd", r"\\.")]),
        {
            "match": rf"(?<![A-Za-z0-9_.])({NUMERAL.pattern})(?:[{BLANKS}]*({unit}))?",
            "captures": {"1": {"name": "constant.numeric.mbd"}, "2": {"name": "keyword.other.unit.mbd"}},
        },
        {
            "match": rf"(\}})[{BLANKS}]*({unit})",
            "captures": {"2": {"name": "keyword.other.unit.mbd"}},
        },
        # `length = 0.3 m`: the name of a parameter, also if it is a word of the language, as `e`
        _match("variable.parameter.mbd", r"(?<![.\w])[A-Za-z_][A-Za-z0-9_]*(?=[ \t]*=(?!=))"),
        _match("storage.modifier.mbd", _any_of(_DECLARING)),
        _match("keyword.operator.word.mbd", _any_of(_LOGICAL)),
        _match("keyword.control.mbd", _any_of(control)),
        _match("support.class.mbd", _any_of(vocabulary["kind"])),
        _match("support.type.mbd", _any_of(vocabulary["type"])),
        _match("support.function.mbd", _any_of(vocabulary["function"]) + r"(?=[ \t]*\()"),
        _match("constant.language.mbd", _any_of(vocabulary["constant"])),
        _match("keyword.operator.mbd", r"==|<>|<=|>=|[-+*/^=<>:]"),
    ]
    return {
        "$schema": "https://raw.githubusercontent.com/martinring/tmlanguage/master/tmlanguage.json",
        "comment": "Written by `python -m mbdsl.editor.textmate`; changes by hand are lost.",
        "name": "mbdsl",
        "scopeName": "source.mbd",
        "fileTypes": ["mbd"],
        "patterns": patterns,
    }


def unit_pattern() -> str:
    """Regular expression of a unit, as ``units.scan`` reads it; products in parentheses are not nested."""
    # A symbol that continues like a name ("m1", "m_a") is a name, not a unit.
    symbols = "|".join(sorted(units.symbols(), key=lambda name: (-len(name), name)))
    factor = rf"(?:{symbols})(?:{units.EXPONENT})?(?![A-Za-z0-9_µ])"
    product = rf"{factor}(?:[./]{factor})*"
    part = rf"(?:{factor}|\({product}\))"
    return rf"{part}(?:[./]{part})*"


def _any_of(names: Iterable[str]) -> str:
    return rf"(?<![.\w])(?:{'|'.join(map(re.escape, sorted(names)))})\b"


def _match(name: str, pattern: str) -> dict[str, Any]:
    return {"name": name, "match": pattern}


def _range(name: str, begin: str, end: str, patterns: list | None = None) -> dict[str, Any]:
    return {"name": name, "begin": begin, "end": end, **({"patterns": patterns} if patterns else {})}


def content(name: str) -> bytes:
    """The content of a file with this name: JSON for ``.json``, else a property list."""
    if name.endswith(".json"):
        return (json.dumps(grammar(), indent=2, ensure_ascii=False) + "\n").encode()
    return plistlib.dumps(grammar())


if __name__ == "__main__":
    Path(sys.argv[1]).write_bytes(content(sys.argv[1]))
