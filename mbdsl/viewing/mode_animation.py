"""Mode shapes as a page with a list of the modes, or one of them as a film."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mbdsl.errors import UsageError
from mbdsl.mechanism.scene import Scene
from mbdsl.system.system import System
from mbdsl.version import __version__
from mbdsl.viewing import page
from mbdsl.viewing.animation import drawn_of
from mbdsl.viewing.mode_shapes import PICTURES, ModeShapes, mode_shapes
from mbdsl.viewing.overlays import Overlays
from mbdsl.viewing.projection import drawing, flat
from mbdsl.viewing.saved_page import SavedPage
from mbdsl.viewing.shapes import Drawing
from mbdsl.viewing.signals import Plots
from mbdsl.viewing.space.shapes import SpaceDrawing
from mbdsl.viewing.svg_picture import still
from mbdsl.viewing.tracks import AnyMotion, SpaceMotion

PHASES = 60  #: steps of the page's cycle


@dataclass(frozen=True)
class ModeRow:
    """A mode in the list of the page: frequencies [Hz], damping ratio, the bodies that move, and whether it grows."""

    frequency: float
    damped: float
    damping: float
    moves: str
    unstable: bool


class ModeAnimation(SavedPage):
    """Mode shapes of a mechanism about a state, as one HTML page that loads nothing.

    ``Modes.animate`` makes it. A notebook shows it below the cell that returns it.

    Parameters
    ----------
    system : System
        The equations of motion.
    t : float [s]
        Time of the state.
    q : (n,) [m, rad]
        Coordinates of the state.
    shapes : (M, n) complex [m, rad]
        Displacements of the coordinates in each mode.
    rows : sequence of ModeRow
        Frequencies and damping.
    about : str
        The state in words.
    first : int, optional
        Index of the mode that the page shows first, and that a film shows. Default: the first that oscillates.

    Raises
    ------
    UsageError
        If there are no modes.
    """

    def __init__(
        self,
        system: System,
        t: float,
        q: NDArray[np.float64],
        shapes: NDArray[np.complex128],
        rows: Sequence[ModeRow],
        about: str,
        first: int | None = None,
    ) -> None:
        if not len(shapes):
            raise UsageError(f"{system.scene.name} has no modes to show", hint="nothing in it can vibrate")
        self.shapes: ModeShapes = mode_shapes(system, t, q, shapes)
        self.rows, self._about = list(rows), about
        self.first = next((k for k, row in enumerate(rows) if row.damped > 0.0), 0) if first is None else first
        if not 0 <= self.first < len(rows):
            raise UsageError(f"there is no mode {self.first + 1}", hint=f"modes 1 ... {len(rows)} are computed")

    def __repr__(self) -> str:
        return f"<ModeAnimation of {self.scene.name}: {len(self.rows)} modes>"

    @property
    def scene(self) -> Scene:
        """The model."""
        return self.shapes.rest.scene

    @cached_property
    def _drawing(self) -> Drawing | SpaceDrawing:
        return drawn_of(self.shapes.together())

    @cached_property
    def html(self) -> str:
        """The page as the text of one HTML file."""
        rest = self.shapes.rest
        about = [("model", self.scene.name), ("state", self._about), ("modes", str(len(self.rows)))]
        data = page.document(rest, self._drawing, Plots(rest.t, [], []), ghost=(rest, self._drawing))
        data |= {"about": [*about, ("made by", f"mbdsl {__version__}")], "largest": {}, "pale": "at rest"}
        if isinstance(rest, SpaceMotion):
            data |= {"view": "iso", "picture": still(flat(rest), 0, "still", f"{self.scene.name} at rest")}
        return page.html(data | {"modes": self._modes()})

    def _modes(self) -> dict[str, Any]:
        found = self.shapes
        bends = [c.edge * np.gradient(a, c.along, axis=1) for a, c in zip(found.angles, found.rest.curves, strict=True)]
        most = np.max([np.abs(b).max(axis=1) for b in bends], axis=0) if bends else np.zeros(len(self.rows))
        return {
            "list": [
                {
                    "f": row.frequency,
                    "damped": row.damped,
                    "damping": row.damping if abs(row.damping) > 1e-9 else 0.0,
                    "moves": row.moves,
                    "unstable": row.unstable,
                    "largest": float(largest),
                }
                for row, largest in zip(self.rows, found.largest, strict=True)
            ],
            "first": self.first,
            "phases": PHASES,
            "tracks": page.array(found.tracks.view(float), "f4"),
            "curves": [
                {
                    "points": page.array(p.view(float), "f4"),
                    "bends": page.array((b / np.where(most > 0.0, most, 1.0)[:, None]).view(float), "f4"),
                }
                for p, b in zip(found.points, bends, strict=True)
            ],
        }

    def cycle(self, mode: int | None = None) -> AnyMotion:
        """One cycle of a mode, as a motion of 2 s.

        Parameters
        ----------
        mode : int, optional
            Index of the mode, from 0.

        Returns
        -------
        Motion or SpaceMotion
            Its first and its last row are equal.
        """
        phases = np.linspace(0.0, 2 * np.pi, PICTURES + 1)
        return self.shapes.cycle(self.first if mode is None else mode, phases)

    def _content(self, suffix: str, width: int, height: int) -> bytes:
        from mbdsl.viewing.film import film

        cycle, rest = flat(self.cycle()), flat(self.shapes.rest)
        drawn = self._drawing if isinstance(self._drawing, Drawing) else drawing(flat(self.shapes.together()))
        return film(cycle, suffix, width, height, Overlays(ghost=rest), drawn)
