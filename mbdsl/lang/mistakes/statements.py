"""Statements of Modelica that mbdsl does not have: what to write instead, and those that are passed over."""

from __future__ import annotations

import re
from collections.abc import Sequence

from mbdsl.errors import SyntaxProblem
from mbdsl.lang import syntax as s
from mbdsl.lang.lexer import Token
from mbdsl.lang.source import Source

_FUNCTION = "write `function f input Real x; output Real y; algorithm y := x^2; end f;`"
_MODIFIED = "components cannot be redeclared, only their values modified"
_CONNECTOR = "connectors are frames: write `connector Frame name;`"
#: words of Modelica that mbdsl does not have -> what to write; they may be names, and are mentioned where they break
#: the syntax
WORDS = {
    "algorithm": "only functions have algorithms: declare `Real y = u;` instead of `y := u;`, and write `when` below "
    "the line `equation`, with `=`",
    **dict.fromkeys(("class", "block"), "write `model`"),
    "package": 'a file is already a collection of models: leave the package out, use `import "file.mbd";`',
    **dict.fromkeys(("function", "operator", "pure", "impure"), _FUNCTION),
    "record": "mbdsl has no records: write `model`, or plain parameters",
    "type": 'mbdsl defines no types: write its own ones, as `Velocity v`, or `Real v(unit = "m/s")`',
    "encapsulated": "leave the word out: a model sees only its own file and its imports",
    "within": "mbdsl has no packages: leave the `within` clause out",
    "while": "a function has one expression for each output, without loops; a model repeats components by "
    "`for i in 1:N loop ... end for;`",
    **dict.fromkeys(("redeclare", "replaceable", "constrainedby"), _MODIFIED),
    "output": "every quantity can be written out: use `mbdsl simulate --signals`",
    **dict.fromkeys(("flow", "stream", "expandable"), _CONNECTOR),
    "external": "mbdsl calls no external code",
}
#: sections and words before a declaration; what follows them begins a statement
_BEFORE = frozenset("INITIAL FINAL PARTIAL SPATIAL INNER OUTER PARAMETER CONSTANT INPUT".split())
_ENDS = frozenset("SEMICOLON EQUATION LOOP THEN ELSE PUBLIC PROTECTED".split())
#: tokens after a name of the model, as in `output.phi = 1` or `type = 2`
_OF_A_NAME = frozenset("DOT LSQB EQUAL COMMA SEMICOLON".split())
_FIRST = re.compile(r'(?:(?:initial|pure|impure)\s+)?(?P<word>[a-z]+)(?:\s+function)?\s*(?P<name>\w*)(?:\s*"[^"]*")?')
#: first word of a block without a name -> its end
_LASTS = {word: rf"\bend\s+{word}\s*;" for word in ("while",)} | {
    "algorithm": r"\b(?=(?:initial\s+)?equation\b|public\b|protected\b|annotation\b|end\s+(?!if|for|while|when)\w+\s*;)"
}
_MBDYN = re.compile(
    r"\A(?:\s|#[^\n]*\n|//[^\n]*\n|/\*.*?\*/|(?:set|include|module load|remark|print symbol table)\b[^;\n]*;)*?"
    r"(begin\s*:\s*(?:data|initial value|control data|nodes|elements)\s*;)",
    re.DOTALL | re.IGNORECASE,
)
_NAMED = frozenset("class block function operator record expandable pure impure".split())


def refuse_mbdyn(source: Source) -> None:
    """Refuse an input file of MBDyn, which has the same suffix."""
    found = _MBDYN.match(source.text[:20_000])
    if found:
        raise SyntaxProblem(
            "this is an input file of MBDyn, which uses the same suffix .mbd; mbdsl cannot read it",
            source.span(*found.span(1)),
            "run it with `mbdyn`; a model of mbdsl begins with `model Name`",
        )


def refuse(token: Token, before: Sequence[Token], following: Token) -> SyntaxProblem | None:
    """The error for a statement that begins with a word of Modelica; None if it does not."""
    end = next((i for i in range(len(before) - 1, -1, -1) if before[i].type in _ENDS), -1)
    words = [t for t in before[end + 1 :] if t.type not in _BEFORE]
    # Behind the end of a declaration without a semicolon a description may follow.
    first, second = (*words, token, following)[:2]
    if first.type != "NAME" or first.text not in WORDS or second.type in _OF_A_NAME:
        return None
    place = first.source.span(first.start, first.end)
    return SyntaxProblem(f"`{first.text}` is not part of mbdsl", place, WORDS[first.text])


def places(text: str, start: int) -> list[tuple[int, int]]:
    """Start and end of the parts of a text that belong to the statement of Modelica at ``start``, none for others.

    They are a whole block, as ``function f ... end f;``, the two ends of a package, or a word before a model.
    """
    found = _FIRST.match(text, start)
    if found is None:
        return []
    word, name = found["word"], found["name"]
    if word == "encapsulated":
        return [found.span("word")]
    ending = _LASTS.get(word) or (rf"\bend\s+{name}\s*;" if name and word in (*_NAMED, "package") else "")
    last = re.compile(ending).search(text, found.end()) if ending else None
    if last is None:
        return []
    return [found.span(), last.span()] if word == "package" else [(start, last.end())]


# -- passed over -----------------------------------------------------------------------------------------------------

#: libraries whose packages need no import
_LIBRARIES = frozenset(("Modelica", "ModelicaServices", "PlanarMechanics"))


def pass_over(tokens: list[Token]) -> tuple[list[Token], list[s.Passed]]:
    """The tokens without ``within`` and imports of Modelica's packages, and these statements; and without the word
    ``output`` before a declaration, because every variable is one."""
    kept: list[Token] = []
    passed: list[s.Passed] = []
    at = 0
    while at < len(tokens):
        if (not kept or kept[-1].type in _BEGIN) and (end := _without_effect(tokens, at)):
            source, start, stop = tokens[at].source, tokens[at].start, tokens[end].end
            passed.append(s.Passed(source.text[start:stop].rstrip("; "), at=(source, start, stop)))
            at = end + 1
            continue
        if not _is_output(tokens, at):
            kept.append(tokens[at])
        at += 1
    return kept, passed


def _is_output(tokens: list[Token], at: int) -> bool:
    """Whether a token is the word in `output Real y`."""
    if tokens[at].text != "output" or not 0 < at < len(tokens) - 2 or tokens[at - 1].type not in _BEGIN:
        return False
    return tokens[at + 1].type == "NAME" and tokens[at + 2].type in ("NAME", "DOT", "LSQB")


_BEGIN = frozenset(("SEMICOLON", "PUBLIC", "PROTECTED", "STRING", "NAME"))


def _without_effect(tokens: list[Token], at: int) -> int:
    """The index of the semicolon of a statement that has no effect here; 0 if it is another statement."""
    end = next((i for i in range(at, min(at + 40, len(tokens))) if tokens[i].type == "SEMICOLON"), 0)
    names = [t.text for t in tokens[at + 1 : end] if t.type not in ("DOT", "EQUAL")]
    if tokens[at].type == "NAME" and tokens[at].text == "within" and at == 0:
        return end if all(t.type in ("NAME", "DOT") for t in tokens[1:end]) else 0
    if tokens[at].type == "IMPORT" and tokens[at + 1].type in ("NAME", "DOT"):
        package = names[1] if tokens[at + 2].type == "EQUAL" and len(names) > 1 else names[0] if names else ""
        return end if package in _LIBRARIES else 0
    return 0
