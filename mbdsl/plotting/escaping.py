"""Texts of models and messages in pages and pictures: without markup and control characters."""

from __future__ import annotations

import html
from typing import Any

from mbdsl.messages import visible


def escape(text: str) -> str:
    """``text`` escaped for the content of an element or an attribute."""
    return html.escape(visible(text))


def seen(data: Any) -> Any:
    """The data with the control and format characters of all texts escaped."""
    if isinstance(data, str):
        return visible(data)
    if isinstance(data, dict):
        return {seen(key): seen(value) for key, value in data.items()}
    return [seen(x) for x in data] if isinstance(data, list | tuple) else data
