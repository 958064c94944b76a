"""The page of an animation of a model in space, and its projected pictures."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from functools import cached_property
from typing import Any

from mbdsl.simulation.trajectory import Trajectory
from mbdsl.viewing import projection
from mbdsl.viewing.projection import SpatialMotion, projected
from mbdsl.viewing.signals import signals
from mbdsl.viewing.space import page, shapes
from mbdsl.viewing.space.motion import SpaceMotion, motion
from mbdsl.viewing.space.vectors import SpaceVector, largest, loads, vectors
from mbdsl.viewing.svg_picture import still
from mbdsl.viewing.vectors import Vector


class InSpace:
    """A motion in space: as a page, and projected to the plane of films and pictures.

    Parameters
    ----------
    trajectory : Trajectory
        The states over time.
    ghost : Trajectory or None
        Another motion, which is drawn pale with the first.
    view : str or None
        "iso" (default), "front", "side" or "top".

    Raises
    ------
    UsageError
        If there is no such view, or a trajectory is empty.
    """

    def __init__(self, trajectory: Trajectory, ghost: Trajectory | None, view: str | None) -> None:
        self._trajectory, self._other, self._view = trajectory, ghost, view or "iso"
        projection.view(trajectory.scene, self._view)  # whether there is one of this name
        self.motion: SpaceMotion = motion(trajectory)
        self._ghost = None if ghost is None else motion(ghost)

    @cached_property
    def flat(self) -> SpatialMotion:
        """The motion in the plane of films and pictures."""
        return projected(self._trajectory, self._view)

    @cached_property
    def flat_ghost(self) -> SpatialMotion | None:
        """The other motion in the plane of films and pictures."""
        return None if self._other is None else projected(self._other, self._view)

    def vectors(self, with_loads: bool) -> list[SpaceVector]:
        """Arrows; ``with_loads``: with weights and the forces of springs."""
        found = vectors(self._trajectory, self.motion)
        return [*found, *loads(self._trajectory, self.motion)] if with_loads else found

    def flat_vectors(self, with_loads: bool) -> list[Vector]:
        """Arrows in the plane of films and pictures."""
        return projection.projected_vectors(self.vectors(with_loads), self.flat, self.motion)

    def html(
        self,
        patterns: Iterable[str] | None,
        traced: Sequence[str],
        with_loads: bool,
        one_scale: bool,
        more: dict[str, Any],
    ) -> str:
        """The page, with the picture of the start for browsers without WebGL."""
        arrows, scene = self.vectors(with_loads), self.motion.scene
        data = page.document(
            self.motion,
            shapes.drawing(self.motion),
            signals(self._trajectory, patterns),
            arrows,
            largest(arrows, one_scale),
            traced,
            None if self._ghost is None else (self._ghost, shapes.drawing(self._ghost)),
            self._view,
        )
        picture = still(projected(self._trajectory, self._view, 2), 0, "still", f"{scene.name} at the start")
        return page.html(data | more | {"picture": picture})
