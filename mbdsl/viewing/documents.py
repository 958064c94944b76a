"""A page of sections as one HTML file that loads nothing, with a policy that allows its own style and script only."""

from __future__ import annotations

import base64
import hashlib
from collections.abc import Iterable, Sequence
from functools import cache
from pathlib import Path

from mbdsl import plotting
from mbdsl.plotting.escaping import escape


def document(
    title: str,
    body: Iterable[str],
    styles: Sequence[str],
    scripts: Sequence[str] = (),
    framed: tuple[Sequence[str], Sequence[str]] = ((), ()),
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
    framed : (sequence of str, sequence of str), optional
        Style sheets and scripts of pages in frames, to which the policy of this page applies as well.

    Returns
    -------
    str
        HTML. The policy allows these style sheets and scripts by their digests, and nothing else.
    """
    style, script = "\n".join(styles), "\n".join(scripts)
    allowed = " ".join(map(digest, (style, *framed[0])))
    policy = f"default-src 'none'; style-src {allowed}"
    if script or framed[1]:
        policy += f"; script-src {' '.join(map(digest, dict.fromkeys((*([script] if script else []), *framed[1]))))}"
    return "\n".join(
        (
            '<!DOCTYPE html>\n<html lang="en">\n<head>\n<meta charset="utf-8">',
            f'<meta http-equiv="Content-Security-Policy" content="{escape(policy)}">',
            '<meta name="viewport" content="width=device-width, initial-scale=1">',
            f"<title>{escape(title)}</title>\n<style>{style}</style>\n</head>\n<body>\n<main>",
            *body,
            "</main>",
            f"<script>{script}</script>\n</body>\n</html>\n" if script else "</body>\n</html>\n",
        )
    )


def digest(text: str) -> str:
    """The source expression of a text in a content policy."""
    return f"'sha256-{base64.b64encode(hashlib.sha256(text.encode()).digest()).decode()}'"


@cache
def sheet() -> str:
    """The style sheet of pages with figures and tables, and of the additional parts of sections."""
    pages = Path(plotting.__file__).parent / "page.css"
    return pages.read_text(encoding="utf-8") + (Path(__file__).parent / "sections.css").read_text(encoding="utf-8")
