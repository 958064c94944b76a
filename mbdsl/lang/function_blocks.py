"""``function f input Real x; output Real y; algorithm y := x^2; end f;``: blocks of tokens, and their syntax.

A function has one expression for each output and each intermediate value, so that it can be written out where it is
called: no loops, no recursion, no second assignment. The tokens of its block are those of a model, but for the words
``function``, ``output`` and ``algorithm`` and the sign ``:=``.
"""

from __future__ import annotations

from collections.abc import Callable

from mbdsl.errors import SyntaxProblem
from mbdsl.lang import functions
from mbdsl.lang import syntax as s
from mbdsl.lang.lexer import Token
from mbdsl.lang.source import span_of
from mbdsl.lang.unparse import write
from mbdsl.messages import did_you_mean

ONE = "a function has one expression for each output: `y := if x > 0 then x else 0;`"


def cut(tokens: list[Token]) -> tuple[list[Token], list[list[Token]]]:
    """The tokens without the blocks of functions, and the blocks, each from ``function`` to its semicolon.

    Raises
    ------
    SyntaxProblem
        If a block has no end.
    """
    kept: list[Token] = []
    blocks: list[list[Token]] = []
    at = 0
    while at < len(tokens):
        end = _end(tokens, at) if tokens[at].text == "function" and tokens[at].type == "NAME" else 0
        if end:
            blocks.append(tokens[at : end + 1])
            at = end + 1
        else:
            kept.append(tokens[at])
            at += 1
    return kept, blocks


def _end(tokens: list[Token], at: int) -> int:
    """The index of the semicolon of a block that begins at ``at``; 0 if no block begins there."""
    if tokens[at + 1].type != "NAME" or (at and tokens[at - 1].type not in ("SEMICOLON", "NAME", "STRING")):
        return 0
    name = tokens[at + 1].text
    for k in range(at + 2, len(tokens) - 2):
        if tokens[k].type == "END" and tokens[k + 1].text == name and tokens[k + 2].type == "SEMICOLON":
            return k + 2
    place = tokens[at].source.span(tokens[at].start, tokens[at + 1].end)
    raise SyntaxProblem(f"the function `{name}` is not closed", place, f"write `end {name};` after its assignments")


def read(block: list[Token], parse: Callable[[list[Token]], s.File]) -> s.Function:
    """The function of a block; ``parse`` reads the tokens of a file.

    Raises
    ------
    SyntaxProblem
        If it is more than expressions for its outputs.
    """
    rewritten: list[Token] = []
    outputs: set[int] = set()  # places of declarations of outputs
    for k, token in enumerate(block):
        starts = k == 0 or block[k - 1].type in ("SEMICOLON", "PROTECTED", "PUBLIC", "STRING") or k == 2
        if k == 0:
            rewritten.append(token._replace(type="MODEL"))
        elif starts and token.type == "NAME" and token.text == "output":
            outputs.add(k)
        elif starts and token.type == "NAME" and token.text == "algorithm":
            rewritten.append(token._replace(type="EQUATION"))
        elif token.type == "EQUAL" and block[k - 1].type == "COLON" and block[k - 1].end == token.start:
            rewritten[-1] = token._replace(text=":=", start=block[k - 1].start)
        else:
            rewritten.append(token)
    (model,) = parse([*rewritten, block[-1]._replace(type="$END", text="", start=block[-1].end)]).models
    begins = [block[k].start for k in sorted(outputs)]
    ends = [next(t.end for t in block[k:] if t.type == "SEMICOLON") for k in sorted(outputs)]
    declared: dict[str, s.Declaration] = {}
    kinds: dict[str, str] = {}
    for item in model.items:
        if isinstance(item, s.Annotation):
            continue
        if not isinstance(item, s.Declaration):
            raise SyntaxProblem(f"the function `{model.name}` has declarations and assignments only", span_of(item.at))
        assert item.at is not None
        written = any(begin < item.at[1] < end for begin, end in zip(begins, ends, strict=True))
        kind = "input" if "input" in item.prefixes else "output" if written else "protected"
        if item.name in declared:
            raise SyntaxProblem(f"`{item.name}` is declared twice", span_of(item.at))
        declared[item.name], kinds[item.name] = item, kind
    assigned = _assignments(model, declared, kinds)
    _check(model, declared, kinds, assigned)
    comes_in, comes_out = (
        tuple(d for name, d in declared.items() if kinds[name] == kind) for kind in ("input", "output")
    )
    all_names, expressions = tuple(declared.values()), tuple(assigned.items())
    return s.Function(model.name, model.doc, comes_in, comes_out, all_names, expressions, at=model.at)


def _assignments(model: s.Model, declared: dict[str, s.Declaration], kinds: dict[str, str]) -> dict[str, s.Expression]:
    """The expression of each intermediate value and output, in their order."""
    found = {name: d.value for name, d in declared.items() if d.value is not None and kinds[name] != "input"}
    for item in model.equations:
        if isinstance(item, s.For):
            raise SyntaxProblem(f"the function `{model.name}` has a loop", span_of(item.at), ONE)
        if isinstance(item, s.If):
            hint = "write an `if` expression: `y := if x > 0 then x else 0;`"
            raise SyntaxProblem(f"the function `{model.name}` has an `if` statement", span_of(item.at), hint)
        if not isinstance(item, s.Relation) or item.right is None or not isinstance(item.left, s.Reference):
            hint = "assign to an output: `y := x^2;`"
            raise SyntaxProblem(
                f"the function `{model.name}` has a statement that assigns nothing", span_of(item.at), hint
            )
        name = write(item.left)
        if name not in declared:
            hint = did_you_mean(name, [n for n in declared if kinds[n] != "input"]) or "declare it below `protected`"
            raise SyntaxProblem(f"the function `{model.name}` has no output `{name}`", span_of(item.left.at), hint)
        if kinds[name] == "input":
            raise SyntaxProblem(f"`{name}` is an input of the function, it cannot be assigned", span_of(item.left.at))
        if name in found:
            raise SyntaxProblem(f"`{name}` is assigned twice", span_of(item.left.at), ONE)
        found[name] = item.right
    return found


def _check(
    model: s.Model, declared: dict[str, s.Declaration], kinds: dict[str, str], assigned: dict[str, s.Expression]
) -> None:
    if model.name in functions.FUNCTIONS or model.name == "der":
        raise SyntaxProblem(f"`{model.name}` is a function of the language", span_of(model.at), "give it another name")
    outputs = [d for name, d in declared.items() if kinds[name] == "output"]
    if not outputs:
        raise SyntaxProblem(f"the function `{model.name}` has no output", span_of(model.at), "write `output Real y;`")
    for name, d in declared.items():
        if kinds[name] != "input" and name not in assigned:
            raise SyntaxProblem(f"`{name}` has no expression", span_of(d.at), f"write `{name} := ...;`")
    for e in assigned.values():
        for inner in s.inside(e):
            if isinstance(inner, s.Reference) and write(inner) == "time" and "time" not in declared:
                raise SyntaxProblem("a function has no time", span_of(inner.at), "make it an input: `input Time t;`")
            if isinstance(inner, s.Call) and write(inner.function) == "der":
                raise SyntaxProblem("a function has no derivatives", span_of(inner.at), "make the rate an input")
