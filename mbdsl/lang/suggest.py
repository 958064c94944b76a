"""Did you mean ...?"""

from __future__ import annotations

import difflib
from collections.abc import Iterable


def did_you_mean(name: str, known: Iterable[str], listed: str = "") -> str | None:
    """A hint with the names closest to ``name``; failing that, and if they are few, all of them behind ``listed``."""
    names = list(dict.fromkeys(known))[:5000]
    lower = {n.lower(): n for n in reversed(names)}
    close = [lower[c] for c in difflib.get_close_matches(name.lower(), lower, 3, 0.6)]
    if close:
        return f"did you mean {' or '.join(f'`{c}`' for c in close)}?"
    if listed and 0 < len(names) <= 25:
        return f"{listed}: {', '.join(names)}"
    return None
