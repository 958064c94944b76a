"""The parser's tables and the loop that runs them.

Lark turns ``grammar.lark`` into LALR tables; that takes 0.3 s, so the result is kept beside it in ``grammar.json``
(plain numbers, checked against the grammar's checksum) and a model is parsed without loading Lark at all. Without a
fitting file the tables are made on the spot.

``python -m mbdsl.lang.lalr`` writes the file anew.
"""

from __future__ import annotations

import json
import zlib
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any, NamedTuple

from mbdsl.lang.lexer import Token

HERE = Path(__file__).parent
GRAMMAR, TABLES = HERE / "grammar.lark", HERE / "grammar.json"
STARTS = ("file", "expression")


class Rule(NamedTuple):
    """One alternative of the grammar: ``size`` symbols become the node ``name``."""

    symbol: str
    size: int
    name: str
    inline: bool  #: a single child stands for the node itself
    splice: tuple[int, ...]  #: children that are lists made by repetition


class Tables(NamedTuple):
    """Per state, what to do on a symbol: a number s >= 0 shifts to state s, -1 - r reduces by rule r."""

    states: list[dict[str, int]]
    rules: list[Rule]
    start: dict[str, int]
    accept: dict[str, int]


class Unexpected(Exception):
    """A token that does not fit; ``expected`` are the terminals that would."""

    def __init__(self, token: Token, previous: Token | None, expected: set[str]) -> None:
        super().__init__(token.type)
        self.token, self.previous, self.expected = token, previous, expected


@cache
def tables() -> Tables:
    """The tables of the grammar as it is now."""
    checksum = zlib.crc32(GRAMMAR.read_bytes())
    try:
        data = json.loads(TABLES.read_text(encoding="utf-8"))
        if data["checksum"] != checksum:
            data = make()
    except (OSError, ValueError, KeyError):
        data = make()
    terminals = data["symbols"]
    states = [dict(zip((terminals[i] for i in row[::2]), row[1::2], strict=True)) for row in data["states"]]
    rules = [Rule(r[0], r[1], r[2], r[3], tuple(r[4])) for r in data["rules"]]
    return Tables(states, rules, data["start"], data["accept"])


def make() -> dict[str, Any]:
    """The tables as plain data, from the grammar by Lark."""
    from lark import Lark
    from lark.lexer import Lexer
    from lark.parsers.lalr_analysis import Shift

    class NoLexer(Lexer):
        def __init__(self, conf: object) -> None: ...

        def lex(self, *args: object):  # type: ignore[override]
            return iter(())

    source = GRAMMAR.read_bytes()
    lark = Lark(
        source.decode(), parser="lalr", lexer=NoLexer, start=list(STARTS), maybe_placeholders=False, strict=False
    )
    found = lark.parser.parser._parse_table  # type: ignore[attr-defined]
    used = {r for row in found.states.values() for action, r in row.values() if action is not Shift}
    rules = [rule for rule in lark.rules if rule in used]
    number = {rule: i for i, rule in enumerate(rules)}
    symbols = sorted({str(s) for row in found.states.values() for s in row})
    index = {s: i for i, s in enumerate(symbols)}
    # States in the order in which they are met, so that the same grammar always gives the same file.
    order = [found.start_states[s] for s in STARTS]
    for state in order:
        following = (a for _, (action, a) in sorted(found.states[state].items()) if action is Shift)
        order += [s for s in dict.fromkeys(following) if s not in order]
    position = {state: i for i, state in enumerate(order)}
    states = []
    for state in order:
        row: list[int] = []
        for symbol, (action, argument) in sorted(found.states[state].items()):
            row += [index[str(symbol)], position[argument] if action is Shift else -1 - number[argument]]
        states.append(row)
    return {
        "checksum": zlib.crc32(source),
        "symbols": symbols,
        "states": states,
        "rules": [
            [
                str(r.origin.name),
                len(r.expansion),
                str(r.alias or r.origin.name),
                bool(r.options.expand1 and not r.alias),
                [i for i, s in enumerate(r.expansion) if not s.is_term and s.name.startswith("_")],
            ]
            for r in rules
        ],
        "start": {str(k): position[v] for k, v in found.start_states.items()},
        "accept": {str(k): position[v] for k, v in found.end_states.items()},
    }


def parse(tokens: list[Token], start: str, builders: dict[str, Callable[[list], Any]]) -> Any:
    """Run the tables over ``tokens``; every node is built by ``builders[name](children)``, tokens included.

    Raises
    ------
    Unexpected
        At the first token that does not fit.
    """
    states, rules, starts, accept = tables()
    stack = [starts[start]]
    values: list[Any] = []
    children: list[Any]
    goal = accept[start]
    for i, token in enumerate(tokens):
        kind = token.type
        while True:
            if kind == "$END" and stack[-1] == goal:
                return values[-1]
            action = states[stack[-1]].get(kind)
            if action is None:
                previous = tokens[i - 1] if i else None
                raise Unexpected(token, previous, _acceptable(_states_before(tokens[:i], start)))
            if action >= 0:
                stack.append(action)
                values.append(token)
                break
            rule = rules[-1 - action]
            size = rule.size
            children = values[len(values) - size :]
            if size:
                del stack[-size:], values[-size:]
            if rule.splice:
                # A repetition grows the list of its first part in place, so that long lists take linear time.
                if rule.symbol.startswith("_") and rule.splice[0] == 0:
                    flat: list[Any] = children[0]
                    for i, child in enumerate(children[1:], 1):
                        flat.extend(child) if i in rule.splice else flat.append(child)
                else:
                    flat = []
                    for i, child in enumerate(children):
                        flat.extend(child) if i in rule.splice else flat.append(child)
                children = flat
            if rule.symbol.startswith("_"):
                value = children
            elif rule.inline and len(children) == 1:
                value = children[0]
            else:
                value = builders[rule.name](children)
            stack.append(states[stack[-1]][rule.symbol])
            values.append(value)
    raise AssertionError("tokens end with $END")


def _states_before(tokens: list[Token], start: str) -> list[int]:
    """The stack right after ``tokens``, before the next one made the parser close what it cannot follow."""
    states, rules, starts, _ = tables()
    stack = [starts[start]]
    for token in tokens:
        while (action := states[stack[-1]][token.type]) < 0:
            rule = rules[-1 - action]
            if rule.size:
                del stack[-rule.size :]
            stack.append(states[stack[-1]][rule.symbol])
        stack.append(action)
    return stack


def _acceptable(stack: list[int]) -> set[str]:
    """The terminals that the parser could take next (its row alone would promise too much)."""
    states, rules, _, accept = tables()
    found = set()
    for terminal in states[stack[-1]]:
        if not terminal.isupper() and terminal != "$END":
            continue
        trial = list(stack)
        while True:
            if terminal == "$END" and trial[-1] in accept.values():
                found.add(terminal)
                break
            action = states[trial[-1]].get(terminal)
            if action is None:
                break
            if action >= 0:
                found.add(terminal)
                break
            rule = rules[-1 - action]
            if rule.size:
                del trial[-rule.size :]
            trial.append(states[trial[-1]][rule.symbol])
    return found


if __name__ == "__main__":
    TABLES.write_text(json.dumps(make(), separators=(",", ":")) + "\n", encoding="utf-8")
