"""A solid of a picture in space, as data."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

from mbdsl.viewing.tracks import Place

BODY, JOINT, FORCE, DRIVE, SUPPORT = "body", "joint", "force", "drive", "support"


@dataclass(frozen=True)
class Solid:
    """A shape of unit size that is scaled by ``size`` along its axes.

    ``draw`` names its geometry in the page, ``role`` is "body", "joint", "force", "drive" or "support". With two places
    it extends along its z axis from the first to the second.
    """

    draw: str
    role: str
    name: str
    at: tuple[Place, ...]
    size: tuple[float, ...]
    data: dict[str, Any] = field(default_factory=dict)
