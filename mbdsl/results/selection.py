"""Selection of signals by names and glob patterns."""

from __future__ import annotations

import fnmatch
import shlex
from collections.abc import Sequence

from mbdsl.errors import UsageError
from mbdsl.messages import did_you_mean


def matching(pattern: str, names: Sequence[str]) -> list[str]:
    """The names that a pattern matches. Brackets are an index first, and a set of characters if no name matches."""
    if pattern in names:
        return [pattern]
    return fnmatch.filter(names, pattern.replace("[", "[[]")) or fnmatch.filter(names, pattern)


def split(text: str) -> list[str]:
    """The parts between commas; a comma in brackets or parentheses belongs to a name or an expression."""
    parts, depth = [""], 0
    for c in text:
        depth += (c in "([{") - (c in ")]}")
        if c == "," and depth <= 0:
            parts.append("")
        else:
            parts[-1] += c
    return [part.strip() for part in parts]


def select(patterns: Sequence[str], names: Sequence[str], where: str, of_file: bool = False) -> list[str]:
    """The names that match at least one pattern, without duplicates; ``of_file``: those of a result file.

    Raises
    ------
    UsageError
        If a pattern matches no name.
    """
    chosen: dict[str, None] = {}
    for pattern in patterns:
        found = matching(pattern, names)
        if not found:
            raise unknown(pattern, names, where, of_file)
        chosen.update(dict.fromkeys(found))
    return list(chosen)


def unknown(name: str, names: Sequence[str], where: str, of_file: bool = False) -> UsageError:
    """The error of a name or pattern without a match, with similar names.

    A file lacks the signals that were not asked for, such as reactions: the hint says how they get into it.
    """
    kind = "that matches" if set(name) & set("*?") else "named"
    hint = did_you_mean(name, names, "signals") or "`mbdsl plot --list RESULT` lists the signals"
    hint += (
        of_file * f"; `mbdsl simulate MODEL --signals {shlex.quote(name)} --output FILE` writes others into a result"
    )
    return UsageError(f"there is no signal {kind} `{name}` in {where}", hint=hint)
