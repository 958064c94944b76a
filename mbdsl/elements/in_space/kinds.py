"""Declarations in space that follow from those in the plane."""

from __future__ import annotations

from dataclasses import fields
from typing import TypeVar

from mbdsl.elements.kind import Kind

K = TypeVar("K", bound=Kind)


def in_space(kind: K, **changes: object) -> K:
    """The declaration of a kind in space: that in the plane with ``changes``."""
    return type(kind)(**{f.name: getattr(kind, f.name) for f in fields(kind)} | {"spatial": True} | changes)
