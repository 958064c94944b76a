"""Characters that do not belong to the language, as in texts copied from documents, and what to write for them."""

from __future__ import annotations

import re
import unicodedata

_DEGREE, _QUOTE = "\u00b0", "\u2018"
#: text -> the remedy; longer texts first
_REMEDIES = {
    "!=": "not equal is written `<>`",
    "&&": "write `and`",
    "||": "write `or`",
    "!": "write `not`",
    "'": 'a text is written in double quotes: "..."',
    "?": "write `(if condition then a else b)`",
    "#": "a comment begins with `//`",
    "%": "a comment begins with `//`",
    _DEGREE: "",
    _QUOTE: 'a text is written in straight double quotes: "..."',
    "\u00b7": "a product is written `*`; inside a unit `.`, as in N.m",
    "\u00d7": "a product is written `*`",
    "\u00f7": "a division is written `/`",
    "\u2264": "write `<=`",
    "\u2265": "write `>=`",
    "\u2260": "write `<>`",
    "\u221a": "write `sqrt(...)`",
    "\u00bd": "write `0.5`",
    "\u03c0": "write `pi`",
    "\u03bc": "micro is written `u`, as in `um`",
    "\u2126": "the unit is written `Ohm`",
}
_QUOTES = "\u2018\u2019\u201a\u201b\u201c\u201d\u201e\u201f\u00ab\u00bb\u2039\u203a"
#: characters with the same remedy as another
_LIKE = dict.fromkeys(_QUOTES, _QUOTE)
_LIKE |= {"\u2022": "\u00b7", "\u2219": "\u00b7", "\u22c5": "\u00b7", "\u2217": "\u00d7", "\u2215": "\u00f7"}
_LIKE |= {"\u00ba": _DEGREE, "\u03a9": "\u2126"}
_DASHES = "\u2010\u2011\u2012\u2013\u2014\u2212\ufe63\uff0d"
_NUMBER_BEFORE = re.compile(r"([0-9][0-9.]*)\s*\Z")
_QUOTED = re.compile(rf"([^\"{_QUOTES}]*)[\"{_QUOTES}]")
_VALUE = re.compile(r"[0-9.]+(?: ?[A-Za-z][A-Za-z0-9./]*)?|[A-Za-z]\w*")


def foreign(text: str, at: int) -> tuple[str, int, str]:
    """A message, a number of characters and a remedy for the character at ``at``, which begins no token."""
    c = text[at]
    line = text[at + 1 :].partition("\n")[0]
    if c in _DASHES:
        value = _VALUE.match(line)
        return f"`{c}` is not the minus sign of the language", 1, f"write `-{value[0] if value else '...'}`"
    for odd, remedy in _REMEDIES.items():
        if text.startswith(odd, at) or _LIKE.get(c) == odd:
            if odd == _DEGREE:
                number = _NUMBER_BEFORE.search(text, max(0, at - 40), at)
                remedy = f"write `{number[1]} deg`" if number else "degrees are written `deg`"
            elif odd == "'" and (number := _NUMBER_BEFORE.search(text, max(0, at - 40), at)):
                remedy = f"feet are written `{number[1]} ft`"
            elif odd == _QUOTE and (quoted := _QUOTED.match(line)):
                remedy = f'write "{quoted[1]}", with straight double quotes'
            return f"`{text[at : at + len(odd)]}` is not part of mbdsl", len(odd), remedy
    if unicodedata.category(c) in ("Cf", "Cc", "Co", "Cn"):
        return f"invisible character U+{ord(c):04X}", 1, "delete it; such characters come with copied texts"
    plain = unicodedata.normalize("NFKC", c)
    if plain != c and plain.isascii() and plain.isprintable() and plain.strip():
        if unicodedata.category(c) == "No":
            return f"`{c}` is not part of mbdsl", 1, f"an exponent is a plain digit: `x^{plain}`, in a unit `m{plain}`"
        return f"`{c}` is not part of mbdsl", 1, f"write the ASCII character `{plain}`"
    return f"unexpected `{c}`", 1, "names are made of letters a-z, digits and `_`"
