"""What may be typed at a place of a text, from the tokens before it alone: the text is incomplete while it is typed."""

from __future__ import annotations

import re
from dataclasses import dataclass, field, replace
from itertools import pairwise

from mbdsl.editor.repair import Statement, statements
from mbdsl.lang import lexer
from mbdsl.lang.lexer import NUMERAL, Token

#: what is expected
NOTHING, TOP, STATEMENT, TYPE, BASE, END, MEMBER, UNIT, ARGUMENT, VALUE, FRAME, SETTING, CHOICE, CONDITION = (
    *("nothing", "model", "statement", "type", "base", "end", "member", "unit", "argument", "value", "frame"),
    *("setting", "choice", "condition"),
)
DECLARATIONS, EQUATIONS, INITIAL, EVENTS = "declarations", "equations", "initial values", "events"

_WORD = re.compile(r"[A-Za-z_][A-Za-z0-9_]*\Z")
#: a unit that is being typed, after its number
_UNIT = re.compile(rf"(?<![A-Za-z0-9_.])(?:{NUMERAL.pattern}|\}})[ \t]+([A-Za-zµ][A-Za-zµ0-9./^()-]*)?\Z")
_TOUCHING = re.compile(rf"(?<![A-Za-z0-9_.]){NUMERAL.pattern}([A-Za-zµ][A-Za-zµ0-9./^()-]*)?\Z")
_PREFIXES = frozenset("parameter constant discrete input final inner outer connector".split())


@dataclass(frozen=True)
class Context:
    """What is expected at a place."""

    expected: str  #: one of the constants of this module
    start: int  #: offset of the word that is being typed
    #: the model that encloses the place, "" for none, and its section
    model: str = ""
    section: str = ""
    #: Of members: the names before the last dot. Of arguments and values: the names of nested modifiers.
    path: tuple[str, ...] = ()
    type: str = ""  #: of arguments and values: the type of the declaration
    parameter: str = ""  #: of values: the name before `=`
    given: frozenset[str] = frozenset()  #: of arguments: the names that have a value already
    declared: str = ""  #: the name that the statement declares

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
    if (
        statement
        and _ends_operand(statement[-1])
        and "\n" in before[statement[-1].end :]
        and len(_open(statement)) == 1
    ):
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
            elif token.text == "when" and section in (EQUATIONS, EVENTS):
                section = EQUATIONS if previous.text == "end" else EVENTS
            elif token.text in ("public", "protected"):
                section = DECLARATIONS
    return model, section


@dataclass
class _Bracket:
    """A bracket that is open at the end of a statement; the first of a statement is the statement itself.

    ``callee`` is the name before it, ``at`` its index. ``slot`` are the tokens after the last comma inside, without
    those of inner brackets, and ``given`` the names that have a value or modifiers. ``commas``: there is a comma.
    """

    sign: str = ""
    callee: Token | None = None
    at: int = 0
    slot: list[Token] = field(default_factory=list)
    given: set[str] = field(default_factory=set)
    commas: bool = False


def _open(tokens: list[Token]) -> list[_Bracket]:
    """The statement, and the brackets that are open at its end."""
    found = [_Bracket()]
    for k, token in enumerate(tokens):
        inner = found[-1]
        if token.kind == lexer.OPERATOR and token.text in "([{":
            before = _without_indices(inner.slot)
            name = before[-1] if before and before[-1].kind in (lexer.NAME, lexer.KEYWORD) else None
            found.append(_Bracket(token.text, name, k))
        elif token.kind == lexer.OPERATOR and token.text in ")]}" and len(found) > 1:
            found.pop()
            found[-1].slot.append(token)
        elif token.text == ",":
            inner.slot, inner.commas = [], True
        else:
            inner.slot.append(token)
            if token.kind == lexer.NAME and k + 1 < len(tokens) and tokens[k + 1].text in ("=", "("):
                inner.given.add(token.text)
    return found


def _without_indices(slot: list[Token]) -> list[Token]:
    """Tokens without the indices at the end, of which only the brackets at the end are in a slot."""
    end = len(slot)
    while end and slot[end - 1].text == "]":
        end -= 1
    return slot[:end]


def _in_statement(tokens: list[Token], at: Context) -> Context:
    """The context after the tokens of an incomplete statement."""
    found = at.but
    if not tokens:
        return found(STATEMENT if at.model else TOP)
    first, last = tokens[0], tokens[-1]
    whole, *brackets = _open(tokens)
    declaration = _declaration(tokens, whole)
    if last.text == ".":
        path = _path((brackets or [whole])[-1].slot[:-1])
        return found(MEMBER, path=path, **declaration) if path else found(NOTHING)
    if brackets:
        return _in_brackets(tokens, [whole, *brackets], at)
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
    if at.section == DECLARATIONS and first.text not in ("for", "if", "elseif"):
        if "=" not in words:
            # after the type a name follows, after the name or its arguments a value, a condition or a description
            behind = declaration["declared"] and _ends_operand(last)
            return found(CONDITION) if behind and last.text != "if" else found(VALUE if "if" in words else NOTHING)
        return found(CONDITION, **declaration) if _ends_operand(last) else found(VALUE, **declaration)
    if _ends_operand(last) and words not in (["guess"], ["fixed"]):
        return found(CONDITION)
    return found(VALUE)


def _in_brackets(tokens: list[Token], opened: list[_Bracket], at: Context) -> Context:
    """The context inside brackets: an argument, or a value."""
    found = at.but
    whole, inner = opened[0], opened[-1]
    calls = [b for b in opened if b.sign == "(" and b.callee is not None]
    names = [b.callee.text for b in calls if b.callee is not None]
    if names[:1] == ["connect"]:
        return found(FRAME)
    if "annotation" in names:
        path = tuple(names[names.index("annotation") :])
        if inner is calls[-1] and not inner.slot:
            return found(SETTING, path=path, given=frozenset(inner.given))
        return found(VALUE, parameter=_assigned(inner.slot), path=path)
    declaration = _declaration(tokens[: calls[0].at], whole) if calls else {"type": "", "declared": ""}
    if tokens[0].text == "extends" and calls:
        declaration = {"type": "".join(t.text for t in tokens[1 : calls[0].at]), "declared": "extends"}
    if not declaration["declared"]:
        return found(VALUE, **declaration)
    nested = 1
    # A call inside a value, such as `sin(`, is not a modifier of an inner part.
    while nested < len(calls) and len(_words(calls[nested - 1].slot)) == 1:
        nested += 1
    path, parameters = tuple(names[1:nested]), calls[nested - 1]
    if inner is parameters and not _words(parameters.slot):
        return found(ARGUMENT, path=path, given=frozenset(inner.given), **declaration)
    ends = bool(inner.slot) and _ends_operand(inner.slot[-1])
    return found(CONDITION if ends else VALUE, path=path, parameter=_assigned(parameters.slot), **declaration)


def _words(slot: list[Token]) -> list[Token]:
    """The tokens of an argument without its prefixes."""
    return [t for t in slot if t.text not in ("each", "final")]


def _assigned(slot: list[Token]) -> str:
    """The name before `=` in an argument; "" if there is none."""
    words = _words(slot)
    return words[0].text if "=" in (t.text for t in words) else ""


def _path(slot: list[Token]) -> tuple[str, ...]:
    """The names of the reference at the end: `arm.link[3]` as ("arm", "link")."""
    found: list[str] = []
    while (slot := _without_indices(slot)) and slot[-1].kind == lexer.NAME:
        found.insert(0, slot[-1].text)
        if len(slot) == 1 or slot[-2].text != ".":
            return tuple(found)
        slot = slot[:-2]
    return ()


def _declaration(tokens: list[Token], whole: _Bracket) -> dict[str, str]:
    """Type and name that the statement declares; "" if it is not a declaration."""
    k = 0
    while k < len(tokens) and tokens[k].text in _PREFIXES:
        k += 1
    names: list[str] = []
    while k < len(tokens) and tokens[k].kind == lexer.NAME:
        names.append(tokens[k].text)
        k += 1
        if k == len(tokens) or tokens[k].text != ".":
            break
        k += 1
    if k < len(tokens) and tokens[k].kind == lexer.NAME:
        # `Rod first(...), second(...)`: the last name at this level
        last = whole.slot[0] if whole.commas and whole.slot else tokens[k]
        return {"type": ".".join(names), "declared": (last if last.kind == lexer.NAME else tokens[k]).text}
    if names and k > 1 and tokens[0].text in _PREFIXES:
        return {"type": "", "declared": names[-1]}
    return {"type": ".".join(names), "declared": ""}


def _ends_operand(token: Token) -> bool:
    """Whether a value may end with the token, so that an operator follows."""
    if token.kind in (lexer.NAME, lexer.NUMBER, lexer.UNIT, lexer.STRING):
        return True
    return token.text in (")", "]", "}", "true", "false")
