"""Messages for syntax errors, in the terms of the language."""

from __future__ import annotations

import difflib

from mbdsl.errors import Span, SyntaxProblem
from mbdsl.lang import units
from mbdsl.lang.lexer import KEYWORDS, NUMERAL, PUNCTUATION, Token
from mbdsl.lang.mistakes import statements
from mbdsl.lang.mistakes.tokens import earlier_mistake, is_below, show, statement_of

#: terminals that begin an expression
_EXPRESSION = frozenset("NUMBER TRUE FALSE LAST LPAR LBRACE LMATRIX MINUS PLUS NOT".split())
_OPERATORS = frozenset("PLUS MINUS STAR SLASH POWER RELATION AND OR".split())
_BEGINNINGS = frozenset(
    "MODEL PARTIAL END EXTENDS IMPORT PARAMETER CONSTANT INPUT FINAL INNER OUTER CONNECTOR PUBLIC PROTECTED "
    "INITIAL EQUATION FOR CONNECT ANNOTATION FIXED GUESS NAME $END".split()
)
#: words that begin a statement of the equation section
_STATEMENTS = ("when", "for", "if", "connect", "elsewhen")
_WORDS = {"NAME": "a name", "STRING": "a text in double quotes", "$END": "the end of the text", "UNIT": "a unit"}
_SYMBOLS = {name: f"`{symbol}`" for symbol, name in PUNCTUATION.items() if name != "RELATION"} | {
    "RELATION": "a comparison",
    "LMATRIX": "`[`",
}


def explain(tokens: list[Token], k: int, expected: set[str], start: str) -> SyntaxProblem:
    """The error for the token ``k``, which the grammar does not allow; ``expected`` are the allowed terminals."""
    token, before, source = tokens[k], tokens[:k], tokens[k].source
    previous = before[-1] if before else None
    here = source.span(token.start, max(token.end, token.start + 1))
    blocks = _open_blocks(before)
    following = tokens[k + 1] if k + 1 < len(tokens) else token

    if (foreign := statements.refuse(token, before, following)) is not None:
        return foreign
    if previous is not None and previous.type == "END":
        return _wrong_end(token, blocks, here)
    if previous is not None and "THEN" in expected and _ends_condition(token, before, following):
        behind = source.span(previous.end, previous.end + 1)
        return SyntaxProblem(f"`then` is missing after {show(previous)}", behind)
    if (
        previous is not None
        and "SEMICOLON" in expected
        and token.type in _BEGINNINGS
        and (token.type != "NAME" or is_below(token, previous))
    ):
        behind = source.span(previous.end, previous.end + 1)
        return SyntaxProblem(f"`;` is missing after {show(previous)}", behind)
    if token.type == "$END":
        if start == "file" and blocks:
            kind, opened = blocks[-1]
            closing = f"end {opened.text};" if kind == "model" else f"end {kind};"
            name = f"model `{opened.text}`" if kind == "model" else f"`{kind}`"
            note = (f"the {name} begins here", source.span(opened.start, opened.end))
            return SyntaxProblem(f"the text ends inside the {name}; `{closing}` is missing", here, notes=(note,))
        return SyntaxProblem(f"the text ends, expected {_list(expected)}", here)
    special = _misplaced_unit(token, expected, before, following)
    if special is None and (mistake := earlier_mistake(token, expected, before, following)) is not None:
        return mistake
    special = special or _special(token, previous, expected, before, following)
    if special is not None:
        message, hint = special
        return SyntaxProblem(message, here, hint)
    hint = _misspelt(before)
    if token.type == "NAME" and (close := difflib.get_close_matches(token.text, KEYWORDS, 1, 0.75)):
        hint = f"did you mean `{close[0]}`?"
    return SyntaxProblem(f"found {show(token)}, expected {_list(expected)}", here, hint)


def _ends_condition(token: Token, before: list[Token], following: Token) -> bool:
    """Whether ``token`` begins a statement behind the condition of a `when` or of an `if` of statements."""
    first = statement_of(before)[:1]
    if not first or first[0].type not in ("WHEN", "ELSEWHEN", "IF", "ELSEIF"):
        return False
    return is_below(token, before[-1]) or following.type == "EQUAL" or following.type == "LPAR"


def _misspelt(before: list[Token]) -> str | None:
    """A hint if the statement begins with a misspelt keyword."""
    for token in reversed(before[-3:]):
        if token.type != "NAME":
            break
        if close := difflib.get_close_matches(token.text, KEYWORDS, 1, 0.8):
            return f"did you mean `{close[0]}` instead of `{token.text}`?"
    return None


def _misplaced_unit(token: Token, expected: set[str], before: list[Token], following: Token) -> tuple[str, str] | None:
    """A unit after an expression that is not a number, as in ``2*pi rad/s``."""
    unit = units.scan(token.source.text, token.start)
    if token.type != "NAME" or not before or "STAR" not in expected or unit is None or following.type == "EQUAL":
        return None
    previous = before[-1]
    if previous.type not in ("NAME", "RPAR") or is_below(token, previous):
        return None
    text = unit[0].text
    right = f"(...)*(1 {text})" if previous.type == "RPAR" else f"{previous.text}*(1 {text})"
    if previous.type == "NAME" and [t.type for t in before[-3:-1]] == ["NUMBER", "STAR"]:
        number = before[-3].text
        if NUMERAL.fullmatch(number):
            right = f"{number} {text}*{previous.text}"
    return f"found {show(token)} after {show(previous)}", f"a unit follows a number only: write `{right}`"


def _wrong_end(token: Token, blocks: list[tuple[str, Token]], here: Span) -> SyntaxProblem:
    found = f"`end {token.text}`" if token.text else "the end of the text"
    if not blocks:
        return SyntaxProblem(f"found {found}, but nothing is open here", here)
    kind, opened = blocks[-1]
    right = f"end {opened.text};" if kind == "model" else f"end {kind};"
    name = f"model `{opened.text}`" if kind == "model" else f"`{kind}`"
    if token.type == "SEMICOLON":
        found = "`end;`"
    return SyntaxProblem(
        f"{found} does not match the {name} that is open here",
        here,
        f"write `{right}`",
        ((f"the {name} begins here", opened.source.span(opened.start, opened.end)),),
    )


def _special(
    token: Token, previous: Token | None, expected: set[str], before: list[Token], following: Token
) -> tuple[str, str | None] | None:
    """Mistakes that have a message of their own."""
    section = next((t.type for t in reversed(before) if t.type in ("EQUATION", "MODEL", "PUBLIC", "PROTECTED")), "")
    kind, text = token.type, token.text
    if not any(t.type == "MODEL" for t in before) and kind in ("NAME", "PARAMETER", "CONSTANT", "EQUATION", "CONNECT"):
        if len(before) == 0 or before[-1].type == "SEMICOLON":
            close = difflib.get_close_matches(text.lower(), ["model", "import", "partial", "spatial"], 1, 0.7)
            hint = f"did you mean `{close[0]}`?" if close and close[0] != text else None
            return f"found {show(token)}, but a file consists of `model Name ... end Name;`", hint
    if (kind == "IMPORT" and following.type == "NAME") or (previous is not None and previous.type == "IMPORT"):
        return (
            "an import names a file in quotes; packages of Modelica cannot be imported",
            "delete this line: names such as `SI.Mass`, `sin` and `Joints.Revolute` are known without it",
        )
    if kind == "IMPORT" and before:
        where = "inside" if _open_blocks(before) else "after"
        return f"found `import` {where} a model", "imports go at the beginning of the file"
    if kind == "CONNECT" and section != "EQUATION":
        return "`connect` belongs in the equation section", "write `equation` on a line before it"
    if section == "EQUATION" and (
        kind in ("PARAMETER", "CONSTANT", "INPUT", "EXTENDS", "FINAL", "CONNECTOR", "INNER", "OUTER")
        or (kind == "NAME" and previous is not None and previous.type == "NAME")
    ):
        if previous is not None and (close := difflib.get_close_matches(previous.text, _STATEMENTS, 1, 0.7)):
            return f"found {show(token)} after {show(previous)}", f"did you mean `{close[0]}`?"
        return "found a declaration in the equation section", "declarations come before `equation`"
    if kind in ("PARAMETER", "CONSTANT", "INPUT", "FINAL") and "NAME" in expected and previous is not None:
        if previous.type == "LOOP":
            return "parameters cannot be declared in a loop", "declare an array: `parameter Real k[N] = ...;`"
    return _within(token, previous, expected, before, section)


def _within(
    token: Token, previous: Token | None, expected: set[str], before: list[Token], section: str
) -> tuple[str, str | None] | None:
    """Mistakes within a statement that have a message of their own."""
    kind, text = token.type, token.text
    if kind == "EQUAL" and "RELATION" in expected:
        return "found `=` in an expression", "a comparison is written `==`"
    if kind == "RELATION" and any(t.type == "RELATION" for t in before[-12:]) and "STAR" in expected:
        return f"found `{text}` after another comparison", "write e.g. `a < b and b < c`"
    if kind == "RELATION" and text == "==" and "EQUAL" in expected:
        return "found `==`, expected `=`", None
    if kind == "NAME" and previous is not None and "STAR" in expected:
        if previous.type == "NUMBER" and "." not in text:
            meant = units.meant(text) if NUMERAL.fullmatch(previous.text) else None
            hint = f"did you mean `{meant}`?" if meant else None
            return (
                f"unknown unit {show(token)} after {previous.text}",
                hint or "units are e.g. kg, m/s2, N.m/rad, deg, ms; a product is written with `*`",
            )
    if kind == "IF" and "NUMBER" in expected:
        return "found `if` inside an expression", "put it in parentheses: `1 + (if a then b else c)`"
    if kind in ("ELSE", "ELSEIF") and [name for name, _ in _open_blocks(before)][-1:] == ["when"]:
        return f"found `{text}` in a `when`", "another branch is `elsewhen condition then`"
    if kind == "INITIAL" and "NAME" in expected and previous is not None and previous.type != "SEMICOLON":
        return "found `initial`, expected an expression", "the start is the condition `initial()`"
    if kind.lower() in KEYWORDS and "NAME" in expected and text:
        hint = (
            "the frames at the ends of a body are `a` and `b`" if kind == "END" and before[-1].type == "DOT" else None
        )
        if kind == "WHEN":
            hint = "a `when` stands in the section `equation`"
        return f"`{text}` is a word of the language and cannot be a name here", hint or _misspelt(before)
    if kind == "LBRACE" and "LPAR" in expected and previous is not None and previous.type == "NAME":
        return "found `{`, expected `(`", f"values go in parentheses: `{previous.text}(m = 1 kg)`"
    if kind == "EQUAL" and expected == {"IN"} and previous is not None:
        return "found `=`, expected `in`", f"write `for {previous.text} in ...`"
    if kind == "EQUAL" and expected <= {"NAME", "LSQB", "DOT"} and section != "EQUATION":
        return "found an equation among the declarations", "initial values go under `initial equation`"
    if kind == "NUMBER" and previous is not None and previous.type in ("NAME", "RSQB") and "STAR" in expected:
        return f"found {show(token)}, expected an operator before it", None
    if kind == "LSQB" and previous is not None and previous.type == "RPAR":
        return "found `[` after `)`", "indices follow a name: `name[i](...)`"
    return None


def _open_blocks(tokens: list[Token]) -> list[tuple[str, Token]]:
    """The blocks that are open after ``tokens``: ("model", its name), ("for", ...), ("if", ...) or ("when", ...)."""
    blocks: list[tuple[str, Token]] = []
    depth, branch, begun = 0, False, False  # branch: whether the next `then` begins statements of a `when`
    for i, token in enumerate(tokens):
        last = tokens[i - 1].type if i else ""
        depth += (token.text in ("(", "{", "[")) - (token.text in (")", "}", "]"))
        if last == "END":
            if blocks and token.type in ("NAME", "FOR", "IF", "WHEN"):
                blocks.pop()
        elif token.type == "NAME" and last == "MODEL":
            blocks.append(("model", token))
        elif depth == 0 and token.type == "FOR":
            blocks.append(("for", token))
        elif token.type == "IF" and (last in ("SEMICOLON", "LOOP", "EQUATION", "PUBLIC", "PROTECTED") or begun):
            blocks.append(("if", token))
        elif token.type == "WHEN":
            blocks.append(("when", token))
        begun = branch and token.type == "THEN"
        branch = token.type in ("WHEN", "ELSEWHEN") or (branch and not begun)
    return blocks


def _list(expected: set[str]) -> str:
    """The terminals in words, the usual ones first."""
    rest = set(expected)
    words = []
    if rest >= {"NUMBER", "LPAR", "LBRACE", "NAME"}:
        words.append("an expression")
        rest -= _EXPRESSION | {"NAME", "STRING", "IF", "COLON"}
    elif len(rest & _OPERATORS) >= 4:
        words.append("an operator")
        rest -= _OPERATORS
        rest -= {"COLON", "LPAR", "LSQB", "DOT", "FOR", "UNIT"}
    if rest >= {"PARAMETER", "NAME", "END"}:
        return "a declaration, `equation`, or `end`"
    if "PARAMETER" in rest and "CONSTANT" in rest:
        rest -= {"PARAMETER", "CONSTANT", "INPUT", "FINAL", "INNER", "OUTER", "CONNECTOR", "NAME"}
        words.append("a declaration")
    order = ["SEMICOLON", "COMMA", "RPAR", "RBRACE", "RSQB", "EQUAL"]
    rest.discard("STRING" if len(rest) > 1 else "")
    for name in sorted(rest, key=lambda n: (order.index(n) if n in order else len(order), n)):
        words.append(_WORDS.get(name) or _SYMBOLS.get(name) or f"`{name.lower()}`")
    if len(words) > 6:
        words = words[:6]
    return words[0] if len(words) == 1 else f"{', '.join(words[:-1])} or {words[-1]}" if words else "nothing more"
