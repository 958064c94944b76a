"""A shape of a picture, as data."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

from mbdsl.viewing.motion import Spot


@dataclass(frozen=True)
class Shape:
    """A shape of the page: ``draw`` names its drawing in the player, ``at`` are the spots that it is attached to."""

    draw: str
    name: str
    at: tuple[Spot, ...] = ()
    data: dict[str, Any] = field(default_factory=dict)
