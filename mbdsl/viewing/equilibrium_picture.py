"""A static equilibrium as a picture: the mechanism at rest with its forces, over its pale initial positions."""

from __future__ import annotations

from dataclasses import replace
from functools import cached_property

from mbdsl.simulation.trajectory import Trajectory
from mbdsl.version import __version__
from mbdsl.viewing.animation import Animation
from mbdsl.viewing.saved_page import PAGES, PICTURES
from mbdsl.viewing.shapes import Drawing
from mbdsl.viewing.space.shapes import SpaceDrawing
from mbdsl.viewing.vectors import FORCES, REACTIONS

ROOM = 0.12  #: around the mechanism, of its larger side


class EquilibriumPicture(Animation):
    """A static equilibrium over the initial positions, with forces and reactions as arrows, as one HTML page.

    ``Equilibrium.show`` makes it. A notebook shows it below the cell that returns it.

    Parameters
    ----------
    point : Trajectory
        The equilibrium, one row.
    start : Trajectory or None
        The initial positions, one row; None: they are not drawn.
    stability : str
        The stability in words.
    """

    suffixes = (*PAGES, *PICTURES)
    _one_scale = _with_loads = True

    def __init__(self, point: Trajectory, start: Trajectory | None, stability: str) -> None:
        super().__init__(point, None, (), start, (FORCES, REACTIONS))
        self._stability = stability

    def __repr__(self) -> str:
        return f"<EquilibriumPicture of {self.scene.name}: {self._stability}>"

    @cached_property
    def _pale(self) -> str:
        return "initial positions" if self._ghost is not None else ""

    def _drawing(self) -> Drawing | SpaceDrawing:
        """The shapes, in the plane with room for the arrows."""
        drawn = super()._drawing()
        if isinstance(drawn, SpaceDrawing):
            return drawn
        x0, y0, x1, y1 = drawn.bounds
        room = ROOM * max(x1 - x0, y1 - y0)
        return replace(drawn, bounds=(x0 - room, y0 - room, x1 + room, y1 + room))

    def _about(self) -> list[tuple[str, str]]:
        found = [("model", self.scene.name), ("state", f"static equilibrium at t = {self.motion.t[0]:g} s")]
        return [*found, ("stability", self._stability), ("made by", f"mbdsl {__version__}")]
