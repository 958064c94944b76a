"""Pictures of mode shapes: the mechanism displaced along a mode; pale, its state at rest and the other displacement."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

import numpy as np

from mbdsl.simulation.trajectory import Trajectory
from mbdsl.viewing.projection import pictured
from mbdsl.viewing.svg_picture import still

if TYPE_CHECKING:
    from mbdsl.analysis.eigenmodes import Modes

LARGEST = 0.08  #: largest displacement: an angle [rad], or a length relative to the size of the mechanism


def mode_pictures(modes: Modes, most: int) -> Iterator[str]:
    """Pictures of the first modes.

    Parameters
    ----------
    modes : Modes
        The modes.
    most : int
        Largest number of pictures.

    Yields
    ------
    str
        ``<figure>`` with the displaced mechanism; pale, its state at rest and the opposite displacement.
    """
    for k, mode in enumerate(modes[:most], 1):
        u = LARGEST * mode.shape.real
        q = modes.system.moved(np.stack([modes.q] * 3), np.stack([u, 0.0 * u, -u]))
        done = {"status": "done"}
        moving = pictured(Trajectory(modes.system, modes.t + np.arange(3.0), q, np.zeros_like(q), None, done))
        title = f"mode {k}: {mode.frequency:.6g} Hz"
        picture = still(moving, 0, f"mode-{k}", title, (1, 2), names=False)
        yield f"<figure>{picture}<figcaption>{title}</figcaption></figure>"
