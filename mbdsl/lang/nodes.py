"""The nodes of the syntax tree, made of the parts that the parser has read.

Lark calls a method of :class:`Nodes` for each rule or alias of ``grammar.lark``, as those of a transformer.
"""

from __future__ import annotations

from typing import Any

from mbdsl.errors import Span, SyntaxProblem
from mbdsl.lang import limits, units
from mbdsl.lang import syntax as s
from mbdsl.lang.lexer import Token, leading, unquote
from mbdsl.lang.source import At, cover, span_of
from mbdsl.lang.unparse import write


class Nodes:
    """Makes the nodes; each method has the name of its rule or alias and takes the list of its parts."""

    def item(self, parts: list) -> Any:
        """The first part; the others are punctuation."""
        return parts[0]

    inner = equation = note = prefix = modifier = item

    # -- files and models --------------------------------------------------------------------------------------

    def file(self, parts: list) -> s.File:
        imports = tuple(p for p in parts if isinstance(p, s.Import))
        models = tuple(p for p in parts if isinstance(p, s.Model))
        return s.File("", imports, models)

    def import_(self, parts: list) -> s.Import:
        alias = parts[3].text if len(parts) == 5 else ""
        return s.Import(unquote(parts[1]), alias, at=_at(parts[1]))

    def model(self, parts: list) -> s.Model:
        spatial = parts[0].type == "SPATIAL"
        partial = parts[int(spatial)].type == "PARTIAL"
        first = spatial + partial
        name, doc, end_name = parts[1 + first], parts[2 + first], parts[-2]
        if name.text != end_name.text:
            raise SyntaxProblem(
                f"`end {end_name.text}` does not match `model {name.text}`",
                _span(end_name),
                f"write `end {name.text};`",
                ((f"the model `{name.text}` begins here", _span(name)),),
            )
        items: list[s.Item] = []
        sections: dict[str, list[s.Item]] = {"equations": [], "initials": []}
        for part in _flat(parts[3 + first : -3]):
            if isinstance(part, tuple):
                sections[part[0]] += part[1]
            else:
                items.append(part)
        for section in sections.values():
            items += (i for i in section if isinstance(i, s.Annotation))
            section[:] = (i for i in section if not isinstance(i, s.Annotation))
        equations, initials = tuple(sections["equations"]), tuple(sections["initials"])
        return s.Model(name.text, doc, tuple(items), equations, initials, partial, spatial, at=_at(name))

    def doc(self, parts: list) -> str:
        return unquote(parts[0]) if parts else ""

    def nothing(self, parts: list) -> list:
        return []

    def equations(self, parts: list) -> tuple:
        return "equations", [p for p in parts if not isinstance(p, Token)]

    def initials(self, parts: list) -> tuple:
        return "initials", [p for p in parts if not isinstance(p, Token)]

    def initial_state(self, parts: list) -> tuple:
        """``initial(state = steady);`` and the initial values after it."""
        at = _at(parts[0], parts[3])
        given = parts[1][0] if len(parts[1]) == 1 else None
        if given is None or not given.name or given.value is None or given.modifiers or given.indices:
            hint = "write `initial(state = steady);`, or `initial equation` before initial values"
            raise SyntaxProblem("found `initial(`, expected the state at the start", span_of(at), hint)
        state = s.Initial("state", s.Reference((s.NamePart(given.name),), at=given.at), given.value, at=at)
        return "initials", [state, *(p for p in parts[4:] if not isinstance(p, Token))]

    def extends(self, parts: list) -> s.Extends:
        arguments = parts[2] if type(parts[2]) is tuple else ()
        return s.Extends(_dotted(parts[1]), arguments, at=_at(parts[1][0], parts[1][-1]))

    def annotation(self, parts: list) -> s.Annotation:
        return s.Annotation(parts[1], at=_at(parts[0]))

    # -- declarations ------------------------------------------------------------------------------------------

    def dotted(self, parts: list) -> list[Token]:
        return [p for p in parts if p.type == "NAME"]

    def type(self, parts: list) -> tuple[list[Token], tuple]:
        return parts[0], parts[1] if len(parts) > 1 else ()

    def component(self, parts: list) -> dict[str, Any]:
        found: dict[str, Any] = {"name": parts[0], "doc": ""}
        following = ""
        for part in parts[1:]:
            if isinstance(part, Token):
                following = "value"
            elif isinstance(part, str):
                found["doc"] = part
                _refuse_quoted_unit(found.get("value"), part)
            elif isinstance(part, s.Annotation):
                found["notes"] = part.arguments
            elif following:
                found[following], following = part, ""
            elif isinstance(part, _Indices):
                found["indices"] = tuple(part)
            elif isinstance(part, _Condition):
                found["condition"] = part.expression
            elif isinstance(part, tuple):
                found["arguments"] = part
        return found

    def condition(self, parts: list) -> _Condition:
        return _Condition(parts[1])

    def typed(self, parts: list) -> list[s.Declaration]:
        prefixes = frozenset(p.text for p in parts if isinstance(p, Token) and p.type != "COMMA")
        tokens, shape = next(p for p in parts if type(p) is tuple)
        type_at = _at(tokens[0], tokens[-1])
        return [_declaration(prefixes, _dotted(tokens), p, tuple(shape), type_at) for p in parts if isinstance(p, dict)]

    def untyped(self, parts: list) -> list[s.Declaration]:
        prefixes = frozenset(p.text for p in parts if isinstance(p, Token) and p.type != "COMMA")
        return [_declaration(prefixes, "", p, (), None) for p in parts if isinstance(p, dict)]

    def arguments(self, parts: list) -> tuple[s.Argument, ...]:
        return tuple(p for p in parts if isinstance(p, s.Argument))

    def argument(self, parts: list) -> s.Argument:
        words = [p.text for p in parts if isinstance(p, Token) and p.type in ("EACH", "FINAL")]
        found = [p for p in parts if isinstance(p, s.Expression)]
        _refuse_quoted_unit(found[-1], parts[-1])
        each, final = "each" in words, "final" in words
        first = found[0]
        if len(found) == 1 and not (isinstance(first, s.Call) and (words or any(a.name for a in first.arguments))):
            return s.Argument("", first, (), (), each, final, at=first.at)
        value = found[1] if len(found) == 2 else None
        target, modifiers = (first.function, first.arguments) if isinstance(first, s.Call) else (first, ())
        if not isinstance(target, s.Reference) or (value is not None and len(target.steps) != 1):
            raise SyntaxProblem(
                f"found `{write(first)}` on the left of `=`, expected a name",
                span_of(first.at),
                "modifiers of inner parts nest: `arm(rod(m = 2 kg))`"
                if isinstance(target, s.Reference)
                else f"write `{write(value)} = {write(first)}`"
                if isinstance(value, s.Reference) and isinstance(first, s.Number)
                else None,
            )
        if len(target.steps) != 1:
            return s.Argument("", first, (), (), each, final, at=first.at)
        step = target.steps[0]
        return s.Argument(step.name, value, modifiers, step.indices, each, final, at=step.at)

    def iterators(self, parts: list) -> tuple[s.Iterator, ...]:
        return tuple(p for p in parts if isinstance(p, s.Iterator))

    def iterator(self, parts: list) -> s.Iterator:
        return s.Iterator(parts[0].text, parts[2], at=_at(parts[0]))

    def for_declarations(self, parts: list) -> s.For:
        return s.For(parts[1], tuple(_flat(parts[3:-3])), at=_at(parts[0]))

    for_equations = for_declarations

    def if_declarations(self, parts: list) -> s.If:
        branches: list[tuple[s.Expression | None, list]] = []
        condition: s.Expression | None = None
        for part in parts[:-3]:
            if isinstance(part, Token):
                if part.type in ("THEN", "ELSE"):
                    branches.append((condition if part.type == "THEN" else None, []))
            elif isinstance(part, s.Expression):
                condition = part
            else:
                branches[-1][1].append(part)
        return s.If(tuple((c, tuple(_flat(items))) for c, items in branches), at=_at(parts[0]))

    if_equations = if_declarations

    def when_equations(self, parts: list) -> s.When:
        branches: list[tuple[s.Expression, list]] = []
        for before, part in zip([None, *parts], parts[:-3], strict=False):
            if isinstance(part, s.Expression) and isinstance(before, Token):
                branches.append((part, []))
            elif not isinstance(part, Token):
                branches[-1][1].append(part)
        return s.When(tuple((c, tuple(_flat(items))) for c, items in branches), at=_at(parts[0]))

    # -- equations ---------------------------------------------------------------------------------------------

    def connect(self, parts: list) -> s.Connect:
        notes = next((part.arguments for part in parts if isinstance(part, s.Annotation)), ())
        return s.Connect(parts[2], parts[4], notes, at=_at(parts[0], parts[5]))

    def relation(self, parts: list) -> s.Relation:
        return s.Relation(parts[0], parts[2] if len(parts) > 3 else None, at=parts[0].at)

    def initial(self, parts: list) -> s.Item:
        if isinstance(parts[0], s.Annotation):
            return parts[0]
        mode = "guess" if isinstance(parts[0], Token) and parts[0].type == "GUESS" else "fixed"
        target, value = [p for p in parts if isinstance(p, s.Expression)]
        return s.Initial(mode, target, value, at=cover(target.at, value.at))

    # -- expressions -------------------------------------------------------------------------------------------

    def number(self, parts: list) -> s.Number:
        token = parts[0]
        digits = leading(token.text)
        rest = token.text[len(digits) :].strip()
        unit = None if (found := units.scan(rest) if rest else None) is None else found[0]
        value: float | int = float(digits)
        if value == float("inf"):
            raise SyntaxProblem("this number is too large", _span(token))
        if unit is None and digits.isdigit() and value <= limits.INTEGER:
            value = int(digits)
        return s.Number(value, unit, at=_at(token))

    def string(self, parts: list) -> s.String:
        return s.String(unquote(parts[0]), at=_at(parts[0]))

    def boolean(self, parts: list) -> s.Boolean:
        return s.Boolean(parts[0].type == "TRUE", at=_at(parts[0]))

    def last(self, parts: list) -> s.Last:
        return s.Last(at=_at(parts[0]))

    def everything(self, parts: list) -> s.Everything:
        return s.Everything(at=_at(parts[0]))

    def step(self, parts: list) -> s.NamePart:
        return s.NamePart(parts[0].text, tuple(parts[1]) if len(parts) > 1 else (), at=_at(parts[0]))

    def subscripts(self, parts: list) -> _Indices:
        found = [p for p in parts if isinstance(p, s.Expression)]
        _deep(*found)
        return _Indices(found)

    def reference(self, parts: list) -> s.Reference:
        steps = tuple(p for p in parts if isinstance(p, s.NamePart))
        inner = [e for step in steps for e in step.indices]
        depth = _deep(*inner) if inner else 1
        return s.Reference(steps, at=cover(steps[0].at, steps[-1].at), depth=depth)

    def parentheses(self, parts: list) -> s.Expression:
        return parts[1]

    def unary(self, parts: list) -> s.Expression:
        at = cover(_at(parts[0]), parts[1].at)
        return s.Unary(parts[0].text, parts[1], at=at, depth=_deep(parts[1]))

    def binary(self, parts: list) -> s.Binary:
        left, operator, right = parts
        # A long sum is deep on its left side only, which is processed without recursion.
        depth = max(_deep(right), left.depth) if isinstance(left, s.Binary) else _deep(left, right)
        return s.Binary(operator.text, left, right, at=cover(left.at, right.at), depth=depth)

    def choice(self, parts: list) -> s.Choice:
        found = [p for p in parts if isinstance(p, s.Expression)]
        branches = tuple(zip(found[:-1:2], found[1::2], strict=True))
        at = cover(_at(parts[0]), found[-1].at)
        return s.Choice(branches, found[-1], at=at, depth=_deep(*found))

    def range(self, parts: list) -> s.Range:
        found = [p for p in parts if isinstance(p, s.Expression)]
        step = found[1] if len(found) == 3 else None
        at = cover(found[0].at, found[-1].at)
        return s.Range(found[0], step, found[-1], at=at, depth=_deep(*found))

    def call(self, parts: list) -> s.Call:
        function, arguments = parts
        inner = [e for a in arguments for e in _expressions(a)]
        return s.Call(function, arguments, at=function.at, depth=_deep(*inner))

    def array(self, parts: list) -> s.ArrayNode:
        items = tuple(p for p in parts if isinstance(p, s.Expression))
        return s.ArrayNode(items, _unit(parts), at=_at(parts[0], parts[-1]), depth=_deep(*items))

    def comprehension(self, parts: list) -> s.Comprehension:
        item, iterators = parts[1], parts[3]
        depth = _deep(item, *(i.values for i in iterators))
        return s.Comprehension(item, iterators, _unit(parts), at=_at(parts[0], parts[-1]), depth=depth)

    def row(self, parts: list) -> s.ArrayNode:
        items = tuple(p for p in parts if isinstance(p, s.Expression))
        return s.ArrayNode(items, at=cover(items[0].at, items[-1].at), depth=_deep(*items))

    def matrix(self, parts: list) -> s.ArrayNode:
        rows = tuple(p for p in parts if isinstance(p, s.Expression))
        return s.ArrayNode(rows, _unit(parts), at=_at(parts[0], parts[-1]), depth=_deep(*rows))


class _Indices(list):
    """Indices, distinguished from arguments by their type."""


class _Condition:
    def __init__(self, expression: s.Expression) -> None:
        self.expression = expression


def _expressions(argument: s.Argument) -> list[s.Expression]:
    found = [argument.value] if argument.value is not None else []
    for inner in argument.modifiers:
        found += _expressions(inner)
    return found


def _flat(parts: list) -> list:
    """Items of a section, without punctuation; one declaration may make several."""
    found = []
    for part in parts:
        if isinstance(part, list):
            found += part
        elif not isinstance(part, Token):
            found.append(part)
    return found


def _dotted(tokens: list[Token]) -> str:
    return ".".join(t.text for t in tokens)


def _declaration(
    prefixes: frozenset[str], type_name: str, found: dict[str, Any], shape: tuple, type_at: At
) -> s.Declaration:
    name = found["name"]
    if isinstance(name, list):
        if len(name) > 1:
            raise SyntaxProblem(
                f"`{_dotted(name)}` is not a name for a declaration; a name has no dots",
                _span(name[0], name[-1]),
            )
        name = name[0]
    return s.Declaration(
        prefixes,
        type_name,
        name.text,
        found.get("indices", ()) + shape,
        found.get("arguments", ()),
        found.get("value"),
        found.get("condition"),
        found["doc"],
        found.get("notes", ()),
        at=_at(name),
        type_at=type_at,
    )


def _refuse_quoted_unit(value: s.Expression | None, doc: str) -> None:
    """Refuse ``2 "kg"``: the text would be a description, and 2 in SI units."""
    if doc and isinstance(value, s.Number) and value.unit is None and units.parse(doc) is not None and doc != "1":
        raise SyntaxProblem(
            f'found "{doc}" after `{write(value)}`; a text is a description, not a unit',
            span_of(value.at),
            f"a unit has no quotes: write `{write(value)} {doc}`",
        )


def _unit(parts: list) -> units.Unit | None:
    last = parts[-1]
    return units.parse(last.text) if last.type == "UNIT" else None


def _at(first: Any, last: Any = None) -> At:
    """The place from one token or node to another."""
    last = first if last is None else last
    source, start = (first.source, first.start) if isinstance(first, Token) else first.at[:2]
    return source, start, last.end if isinstance(last, Token) else last.at[2]


def _span(first: Token, last: Token | None = None) -> Span:
    return first.source.span(first.start, (last or first).end)


def _deep(*children: s.Expression | None) -> int:
    """The depth of an expression, from those inside it."""
    depth = 1 + max((c.depth for c in children if c is not None), default=0)
    if depth > limits.NESTING:
        place = next(c for c in children if c is not None and c.depth == depth - 1)
        raise SyntaxProblem(
            f"more than {limits.NESTING} operations inside each other",
            span_of(place.at),
            "give parts of it a name with `parameter` or `Real`",
        )
    return depth
