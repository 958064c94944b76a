"""What may be typed at a place of a text, from the tokens before it alone: the text is incomplete while it is typed."""

from __future__ import annotations

import re
from dataclasses import dataclass, replace
from itertools import pairwise

from mbdsl.editor.repair import Statement, statements
from mbdsl.lang import lexer
from mbdsl.lang.lexer import NUMERAL, Token

#: what is expected
NOTHING, TOP, STATEMENT, TYPE, BASE, END, MEMBER, UNIT, ARGUMENT, VALUE, FRAME, SETTING, CHOICE, CONDITION = (
    *("nothing", "model", "statement", "type", "base", "end", "member", "unit", "argument", "value", "frame"),
    *("setting", "choice", "condition"),
)
DECLARATIONS, EQUATIONS, INITIAL = "declarations", "equations", "initial values"

_WORD = re.compile(r"[A-Za-z_][A-Za-z0-9_]*\Z")
#: a unit that is being typed, after its number
_UNIT = re.compile(rf"(?<![A-Za-z0-9_.])(?:{NUMERAL.pattern}|\}})[ \t]+([A-Za-zµ][A-Za-zµ0-9./^()-]*)?\Z")
_TOUCHING = re.compile(rf"(?<![A-Za-z0-9_.]){NUMERAL.pattern}([A-Za-zµ][A-Za-zµ0-9./^()-]*)?\Z")
_PREFIXES = frozenset("parameter constant input final inner outer connector".split())


@dataclass(frozen=True)
class Context:
    """What is expected at a place.

    Attributes
    ----------
    expected : str
        One of the constants of this module.
    start : int
        Offset of the word that is being typed.
    model, section : str
        The model that encloses the place, "" for none, and its section.
    path : tuple of str
        Of members: the names before the last dot. Of arguments and values: the names of nested modifiers.
    type : str
        Of arguments and values: the type of the declaration.
    parameter : str
        Of values: the name before `=`.
    given : frozenset of str
        Of arguments: the names that have a value already.
    declared : str
        The name that the statement declares.
    """

    expected: str
    start: int
    model: str = ""
    section: str = ""
    path: tuple[str, ...] = ()
    type: str = ""
    parameter: str = ""
    given: frozenset[str] = frozenset()
    declared: str = ""

    def but(self, expected: str, **values) -> Context:
        """The context with something else expected."""
        return replace(self, expected=expected, **values)


def context(text: str, offset: int) -> Context:
    """The context of an offset."""
    before = text[:offset]
    word = _WORD.search(before)
    start = offset if word is None else word.start()
    tokens = list(lexer.pieces(before))
    if tokens and not tokens[-1].closed:
        if tokens[-1].kind != lexer.STRING:
            return Context(NOTHING, offset)
        before, start = text[: tokens[-1].start], tokens[-1].start + 1
        found = _expected(before, start)
        return found.but(CHOICE if found.expected == VALUE else NOTHING)
    if unit := _UNIT.search(before) or _TOUCHING.search(before):
        began = unit.start(1) if unit[1] else offset
        # A digit alone is not a unit: nothing is offered while a number is typed.
        if unit[1] or before[-1:].isspace():
            return _expected(before[: unit.start()], began).but(UNIT)
        return Context(NOTHING, offset)
    return _expected(text[:start], start)


def _expected(before: str, start: int) -> Context:
    tokens = [p for p in lexer.pieces(before) if p.kind != lexer.COMMENT]
    model, section = _section(tokens)
    whole = list(statements(before))
    last = whole[-1] if whole else Statement(0, 0, True)
    statement = [] if last.complete else [p for p in tokens if p.start >= last.start]
    if statement and _ends_operand(statement[-1]) and "\n" in before[statement[-1].end :] and not _open(statement):
        statement = []  # a semicolon is missing
    return _in_statement(statement, Context(NOTHING, start, model, section))


def _section(tokens: list[Token]) -> tuple[str, str]:
    model, section = "", ""
    for previous, token in pairwise(tokens):
        if token.kind == lexer.NAME and previous.kind == lexer.KEYWORD:
            if previous.text == "model":
                model, section = token.text, DECLARATIONS
            elif previous.text == "end":
                model, section = "", ""
        elif token.kind == lexer.KEYWORD and model:
            if token.text == "equation":
                section = INITIAL if previous.text == "initial" else EQUATIONS
            elif token.text in ("public", "protected"):
                section = DECLARATIONS
    return model, section


def _in_statement(tokens: list[Token], at: Context) -> Context:
    """The context after the tokens of an incomplete statement."""
    found = at.but
    if not tokens:
        return found(STATEMENT if at.model else TOP)
    first, last = tokens[0], tokens[-1]
    if last.text == ".":
        path = _path(tokens[:-1])
        return found(MEMBER, path=path, **_declaration(tokens)) if path else found(NOTHING)
    brackets = _open(tokens)
    if brackets:
        return _in_brackets(tokens, brackets, at)
    words = [t.text for t in tokens]
    if not at.model:
        return found(TOP) if words in (["spatial"], ["partial"], ["spatial", "partial"]) else found(NOTHING)
    if first.text == "end":
        return found(END) if len(tokens) == 1 else found(NOTHING)
    if first.text == "extends":
        return found(BASE) if len(tokens) == 1 else found(NOTHING)
    if first.text in ("import", "model", "spatial", "partial"):
        return found(NOTHING)
    if all(word in _PREFIXES for word in words):
        return found(TYPE)
    if first.text in ("then", "else", "loop", "equation", "public", "protected"):
        return found(STATEMENT)
    declaration = _declaration(tokens)
    if at.section == DECLARATIONS and first.text not in ("for", "if", "elseif"):
        if "=" not in words:
            # after the type a name follows, after the name or its arguments a value, a condition or a description
            behind = declaration["declared"] and _ends_operand(last)
            return found(CONDITION) if behind and last.text != "if" else found(VALUE if "if" in words else NOTHING)
        return found(CONDITION, **declaration) if _ends_operand(last) else found(VALUE, **declaration)
    if _ends_operand(last) and words not in (["guess"], ["fixed"]):
        return found(CONDITION)
    return found(VALUE)


def _in_brackets(tokens: list[Token], brackets: list[int], at: Context) -> Context:
    """The context inside brackets: an argument, or a value."""
    found = at.but
    calls = [k for k in brackets if tokens[k].text == "(" and _callee(tokens, k) >= 0]
    names = [tokens[_callee(tokens, k)].text for k in calls]
    inner = brackets[-1]
    slot = _slot(tokens, inner)
    if names[:1] == ["connect"]:
        return found(FRAME)
    if "annotation" in names:
        path = tuple(names[names.index("annotation") :])
        if inner == calls[-1] and not slot:
            return found(SETTING, path=path, given=_given(tokens, inner))
        return found(VALUE, parameter=_assigned(slot), path=path)
    declaration = _declaration(tokens[: calls[0]]) if calls else {"type": "", "declared": ""}
    if tokens[0].text == "extends" and calls:
        declaration = {"type": "".join(t.text for t in tokens[1 : calls[0]]), "declared": "extends"}
    nested: list[int] = []
    if declaration["declared"]:
        nested = calls[:1]
        for k in calls[1:]:
            # A call inside a value, such as `sin(`, is not a modifier of an inner part.
            before = [t for t in _slot(tokens, nested[-1], k) if t.text not in ("each", "final")]
            if len(before) != 1:
                break
            nested.append(k)
    if not nested:
        return found(VALUE, **declaration)
    path = tuple(tokens[_callee(tokens, k)].text for k in nested[1:])
    assigned = _slot(tokens, nested[-1])
    if inner == nested[-1] and not [t for t in assigned if t.text not in ("each", "final")]:
        return found(ARGUMENT, path=path, given=_given(tokens, inner), **declaration)
    ends = bool(slot) and _ends_operand(slot[-1])
    return found(CONDITION if ends else VALUE, path=path, parameter=_assigned(assigned), **declaration)


def _callee(tokens: list[Token], bracket: int) -> int:
    """Index of the name before a bracket, which may have indices; -1 if there is none."""
    k, depth = bracket - 1, 0
    while k >= 0 and (depth or tokens[k].text == "]"):
        depth += (tokens[k].text == "]") - (tokens[k].text == "[")
        k -= 1
    return k if k >= 0 and tokens[k].kind in (lexer.NAME, lexer.KEYWORD) else -1


def _assigned(slot: list[Token]) -> str:
    """The name before `=` in an argument; "" if there is none."""
    words = [t for t in slot if t.text not in ("each", "final")]
    return words[0].text if "=" in (t.text for t in words) else ""


def _open(tokens: list[Token]) -> list[int]:
    """Indices of the brackets that are open at the end."""
    found: list[int] = []
    for k, token in enumerate(tokens):
        if token.kind == lexer.OPERATOR:
            if token.text in "([{":
                found.append(k)
            elif token.text in ")]}" and found:
                found.pop()
    return found


def _slot(tokens: list[Token], bracket: int, end: int | None = None) -> list[Token]:
    """The tokens after the last comma inside a bracket, without those of inner brackets."""
    found: list[Token] = []
    depth = 0
    for token in tokens[bracket + 1 : end]:
        if token.kind == lexer.OPERATOR and token.text in "([{":
            depth += 1
        if depth == 0:
            if token.text == ",":
                found = []
            else:
                found.append(token)
        if token.kind == lexer.OPERATOR and token.text in ")]}":
            depth -= 1
            if depth == 0:
                found.append(token)
    return found


def _given(tokens: list[Token], bracket: int) -> frozenset[str]:
    """Names that are followed by `=` inside a bracket."""
    found, depth = set(), 0
    for token, following in zip(tokens[bracket + 1 :], tokens[bracket + 2 :], strict=False):
        if token.kind == lexer.OPERATOR:
            depth += (token.text in "([{") - (token.text in ")]}")
        if depth == 0 and token.kind == lexer.NAME and following.text in ("=", "("):
            found.add(token.text)
    return frozenset(found)


def _path(tokens: list[Token]) -> tuple[str, ...]:
    """The names of the reference at the end: `arm.link[3]` as ("arm", "link")."""
    found: list[str] = []
    k = len(tokens) - 1
    while k >= 0:
        if tokens[k].text == "]":
            depth = 0
            while k >= 0:
                depth += (tokens[k].text == "]") - (tokens[k].text == "[")
                k -= 1
                if depth == 0:
                    break
        if k < 0 or tokens[k].kind != lexer.NAME:
            return ()
        found.insert(0, tokens[k].text)
        if k == 0 or tokens[k - 1].text != ".":
            return tuple(found)
        k -= 2
    return ()


def _declaration(tokens: list[Token]) -> dict[str, str]:
    """Type and name that the statement declares; "" if it is not a declaration."""
    k = 0
    while k < len(tokens) and tokens[k].text in _PREFIXES:
        k += 1
    names: list[str] = []
    while k < len(tokens) and tokens[k].kind == lexer.NAME:
        names.append(tokens[k].text)
        k += 1
        if k < len(tokens) and tokens[k].text == ".":
            k += 1
            continue
        break
    if k < len(tokens) and tokens[k].kind == lexer.NAME:
        # `Rod first(...), second(...)`: the last name at this level
        declared, depth = tokens[k].text, 0
        for token, following in zip(tokens[k:], tokens[k + 1 :], strict=False):
            depth += (token.text in ("(", "[", "{")) - (token.text in (")", "]", "}"))
            if depth == 0 and token.text == "," and following.kind == lexer.NAME:
                declared = following.text
        return {"type": ".".join(names), "declared": declared}
    if names and k > 1 and tokens[0].text in _PREFIXES:
        return {"type": "", "declared": names[-1]}
    return {"type": ".".join(names), "declared": ""}


def _ends_operand(token: Token) -> bool:
    """Whether a value may end with the token, so that an operator follows."""
    if token.kind in (lexer.NAME, lexer.NUMBER, lexer.UNIT, lexer.STRING):
        return True
    return token.text in (")", "]", "}", "true", "false")
