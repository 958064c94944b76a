"""The builder of all pages: one HTML file that loads nothing; its policy allows its own style and script only."""

from __future__ import annotations

import base64
import hashlib
import html
import json
import re
from collections.abc import Iterable, Mapping, Sequence
from functools import cache
from pathlib import Path
from types import MappingProxyType
from typing import Any

from mbdsl.plotting.escaping import escape, seen

HERE = Path(__file__).parent


def document(
    title: str,
    body: Iterable[str],
    styles: Sequence[str],
    scripts: Sequence[str] = (),
    frames: Sequence[str] = (),
) -> str:
    """A page.

    Parameters
    ----------
    title : str
        Its title.
    body : iterable of str
        Its content, as HTML.
    styles, scripts : sequence of str
        Its style sheets and scripts.
    frames : sequence of str, optional
        Pages in frames. The policy of this page applies to them as well, and allows what their own policies allow.

    Returns
    -------
    str
        HTML. The policy allows these style sheets and scripts by their digests, and nothing else.
    """
    style, script = "\n".join(styles), "\n".join(scripts)
    more: dict[str, list[str]] = {"style-src": [], "script-src": []}
    for own in frames:
        for key, allowed in _allowed(own).items():
            more[key] += allowed
    return page(title, ("<main>", *body, "</main>"), style, [script] if script else [], more)


def page(
    title: str,
    content: Iterable[str],
    style: str,
    scripts: Sequence[str],
    allowed: Mapping[str, Sequence[str]] = MappingProxyType({}),
) -> str:
    """A page of this content, this style and these scripts.

    Its policy allows the style and the scripts by their digests, what ``allowed`` lists, and nothing else.
    """
    own = {"style-src": [style], "script-src": scripts}
    rules = ["default-src 'none'"]
    for key, texts in own.items():
        if found := dict.fromkeys([*map(digest, texts), *allowed.get(key, ())]):
            rules.append(f"{key} {' '.join(found)}")
    return "\n".join(
        (
            '<!DOCTYPE html>\n<html lang="en">\n<head>\n<meta charset="utf-8">',
            f'<meta http-equiv="Content-Security-Policy" content="{escape("; ".join(rules))}">',
            '<meta name="viewport" content="width=device-width, initial-scale=1">',
            f"<title>{escape(title)}</title>\n<style>{style}</style>\n</head>\n<body>",
            *content,
            *(f"<script>{script}</script>" for script in scripts),
            "</body>\n</html>\n",
        )
    )


def frame(content: str, title: str) -> str:
    """A page in a frame of its own."""
    look = 'sandbox="allow-scripts allow-modals"'
    return f'<iframe title="{escape(title)}" srcdoc="{html.escape(content)}" {look}></iframe>'


def _allowed(content: str) -> dict[str, list[str]]:
    """The digests in the policy of a page."""
    found = re.search(r'http-equiv="Content-Security-Policy" content="([^"]*)"', content)
    assert found, "a page in a frame has a policy"
    rules = [rule.split() for rule in html.unescape(found[1]).split(";")]
    return {rule[0]: rule[1:] for rule in rules if rule[0] in ("style-src", "script-src")}


def digest(text: str) -> str:
    """The source expression of a text in a content policy."""
    return f"'sha256-{base64.b64encode(hashlib.sha256(text.encode()).digest()).decode()}'"


def data_script(data: Any, attributes: str = "") -> str:
    """Data of a page as an element that its scripts read; control characters of texts are escaped."""
    text = json.dumps(seen(data), ensure_ascii=False, separators=(",", ":"), allow_nan=False)
    # `<` would let a text end the element; as an escape it is the same JSON.
    return f'<script type="application/json"{attributes}>{text.replace("<", chr(92) + "u003c")}</script>'


@cache
def asset(name: str, folder: Path = HERE) -> str:
    """The text of a style sheet, a script or a part of a page."""
    return (folder / name).read_text(encoding="utf-8")


def sheet() -> str:
    """The style sheet of pages with figures and tables, and of the additional parts of sections."""
    return asset("page.css") + asset("sections.css")
