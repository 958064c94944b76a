"""The LALR tables of the parser, and the loop that runs them.

Lark generates the tables from ``grammar.lark``, which takes 0.3 s. Therefore they are stored in ``grammar.json`` (plain
numbers, checked against the grammar's checksum), and a model is parsed without loading Lark. If the file does not match
the grammar, the tables are generated again.

``python -m mbdsl.lang.lalr`` writes the file again.

Lark could run its own tables, more slowly: docs/decisions/parser-loop.md.
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
    """One alternative of the grammar: ``size`` symbols are reduced to the node ``name``."""

    symbol: str
    size: int
    name: str
    inline: bool  #: a single child replaces the node
    splice: list[int]  #: indices of children that are lists, from repetitions


class Tables(NamedTuple):
    """For every state, the action on a symbol: s >= 0 shifts to state s, -1 - r reduces by rule r."""

    states: list[dict[str, int]]
    rules: list[Rule]
    start: dict[str, int]
    accept: dict[str, int]


class Unexpected(Exception):
    """A token that the grammar does not allow; ``expected`` are the allowed terminals."""

    def __init__(self, token: Token, previous: Token | None, expected: set[str]) -> None:
        super().__init__(token.type)
        self.token, self.previous, self.expected = token, previous, expected


@cache
def tables() -> Tables:
    """The tables of the current grammar."""
    checksum = zlib.crc32(GRAMMAR.read_bytes())
    try:
        data = json.loads(TABLES.read_text(encoding="utf-8"))
        if data["checksum"] != checksum:
            data = make()
    except (OSError, ValueError, KeyError):
        data = make()
    rules = [Rule(*rule) for rule in data["rules"]]
    return Tables(data["states"], rules, data["start"], data["accept"])


def make() -> dict[str, Any]:
    """The tables as plain data, generated from the grammar by Lark, without the data of ``Lark.save`` not used here."""
    import pickle
    from io import BytesIO

    from lark import Lark

    source, stream = GRAMMAR.read_bytes(), BytesIO()
    # No lexer is run, but only a parser with one can be saved: a basic lexer without terminals.
    Lark(source.decode(), parser="lalr", lexer="basic", start=list(STARTS), maybe_placeholders=False).save(stream)
    saved = pickle.loads(stream.getvalue())
    table, memo = saved["data"]["parser"]["parser"], saved["memo"]
    # state -> symbol -> (0, next state) or (1, rule)
    found = {
        state: {table["tokens"][k]: (reduces, x["@"] if reduces else x) for k, (reduces, x) in row.items()}
        for state, row in table["states"].items()
    }
    used = sorted({x for row in found.values() for reduces, x in row.values() if reduces})
    number = {rule: i for i, rule in enumerate(used)}
    # States are numbered in the order in which they are reached, so that the same grammar always gives the same file.
    order = [table["start_states"][start] for start in STARTS]
    for state in order:
        following = (x for _, (reduces, x) in sorted(found[state].items()) if not reduces)
        order += [x for x in dict.fromkeys(following) if x not in order]
    position = {state: i for i, state in enumerate(order)}
    states = [
        {symbol: -1 - number[x] if reduces else position[x] for symbol, (reduces, x) in sorted(found[state].items())}
        for state in order
    ]
    rules = []
    for rule in (memo[k] for k in used):
        name, alias, parts = rule["origin"]["name"], rule["alias"], rule["expansion"]
        inline = bool(rule["options"]["expand1"] and not alias)
        splice = [i for i, part in enumerate(parts) if part["name"].startswith("_")]
        rules.append([name, len(parts), alias or name, inline, splice])
    return {
        "checksum": zlib.crc32(source),
        "states": states,
        "rules": rules,
        "start": {start: position[table["start_states"][start]] for start in STARTS},
        "accept": {start: position[table["end_states"][start]] for start in STARTS},
    }


def parse(tokens: list[Token], start: str, builders: dict[str, Callable[[list], Any]]) -> Any:
    """Run the tables over ``tokens``; ``builders[name](children)`` builds each node, from tokens and nodes.

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
                raise Unexpected(token, tokens[i - 1] if i else None, _expected(tokens[:i], start))
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


def _expected(tokens: list[Token], start: str) -> set[str]:
    """The terminals that can follow ``tokens``; the row of a state alone contains too many."""
    states, _, starts, _ = tables()
    stack = [starts[start]]
    for token in tokens:
        _take(stack, token.type, start)
    terminals = (symbol for symbol in states[stack[-1]] if symbol.isupper() or symbol == "$END")
    return {symbol for symbol in terminals if _take(list(stack), symbol, start)}


def _take(stack: list[int], terminal: str, start: str) -> bool:
    """Whether a terminal can follow; updates the stack of states."""
    states, rules, _, accept = tables()
    while not (terminal == "$END" and stack[-1] == accept[start]):
        action = states[stack[-1]].get(terminal)
        if action is None:
            return False
        if action >= 0:
            stack.append(action)
            break
        rule = rules[-1 - action]
        if rule.size:
            del stack[-rule.size :]
        stack.append(states[stack[-1]][rule.symbol])
    return True


if __name__ == "__main__":
    TABLES.write_text(json.dumps(make(), separators=(",", ":")) + "\n", encoding="utf-8")
