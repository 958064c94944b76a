"""The parts of mbdsl that serve models in the plane only."""

from __future__ import annotations

from mbdsl.errors import UsageError
from mbdsl.mechanism.scene import Scene


def planar_only(scene: Scene, what: str, hint: str | None = None) -> None:
    """Refuse a model in space.

    Raises
    ------
    UsageError
        If ``scene`` is a model in space; ``what`` is the part of mbdsl, in the plural.
    """
    if scene.spatial:
        raise UsageError(f"{what} are not available for models in space, and {scene.name} is one", hint=hint)
