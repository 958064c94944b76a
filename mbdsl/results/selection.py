"""Selection of signals by names and glob patterns."""

from __future__ import annotations

import fnmatch
from collections.abc import Sequence

from mbdsl.errors import UsageError
from mbdsl.messages import did_you_mean


def matching(pattern: str, names: Sequence[str]) -> list[str]:
    """The names that a pattern matches. Brackets are an index first, and a set of characters if no name matches."""
    if pattern in names:
        return [pattern]
    return fnmatch.filter(names, pattern.replace("[", "[[]")) or fnmatch.filter(names, pattern)


def select(patterns: Sequence[str], names: Sequence[str], where: str) -> list[str]:
    """The names that match at least one pattern, without duplicates.

    Raises
    ------
    UsageError
        If a pattern matches no name.
    """
    chosen: dict[str, None] = {}
    for pattern in patterns:
        found = matching(pattern, names)
        if not found:
            raise unknown(pattern, names, where)
        chosen.update(dict.fromkeys(found))
    return list(chosen)


def unknown(name: str, names: Sequence[str], where: str) -> UsageError:
    """The error of a name or pattern without a match, with similar names."""
    kind = "that matches" if set(name) & set("*?") else "named"
    hint = did_you_mean(name, names, "signals") or "`mbdsl plot --list RESULT` lists the signals"
    return UsageError(f"there is no signal {kind} `{name}` in {where}", hint=hint)
