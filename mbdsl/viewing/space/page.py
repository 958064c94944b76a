"""The page of an animation in space: one HTML file with its data, its scripts, three.js and its style."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mbdsl.viewing import page
from mbdsl.viewing.motion import GROUND
from mbdsl.viewing.page import array, levels, numbers, plotted, short
from mbdsl.viewing.projection import VIEWS, view
from mbdsl.viewing.signals import Plots
from mbdsl.viewing.space.motion import UNTURNED, Place, SpaceMotion
from mbdsl.viewing.space.shapes import SpaceDrawing
from mbdsl.viewing.space.solid import Solid
from mbdsl.viewing.space.vectors import SpaceVector

HERE = Path(__file__).parent
LIBRARY = HERE / "three" / "three.min.js"
#: the script is the files in this order; those of pages of planar models are in the folder above
SCRIPTS = (
    *("../data.js", "motion.js", "../plots.js", "../player.js", "../marks.js"),
    *("geometry.js", "solids.js", "stage.js", "overlay.js", "view.js"),
    *("../controls.js", "controls.js", "../pointers.js", "../start.js"),
)


def html(data: Mapping[str, Any]) -> str:
    """The page as the text of one HTML file.

    Parameters
    ----------
    data : mapping
        What ``document`` returns.

    Returns
    -------
    str
        HTML. Its policy allows its scripts and its style by their digests, and nothing else.
    """
    style = (page.HERE / page.STYLE).read_text(encoding="utf-8") + (HERE / "space.css").read_text(encoding="utf-8")
    return page.assembled(dict(data), style, [LIBRARY.read_text(encoding="utf-8"), page.script_of(SCRIPTS, HERE)])


def document(
    motion: SpaceMotion,
    drawing: SpaceDrawing,
    plots: Plots,
    vectors: Sequence[SpaceVector] = (),
    largest: Mapping[str, float] | None = None,
    traced: Sequence[str] = (),
    ghost: tuple[SpaceMotion, SpaceDrawing] | None = None,
    seen_from: str = "iso",
) -> dict[str, Any]:
    """The data of a page.

    Parameters
    ----------
    motion, drawing : SpaceMotion, SpaceDrawing
        Poses and solids.
    plots : Plots
        Signals that can be plotted.
    vectors : sequence of SpaceVector, optional
        Arrows.
    largest : mapping of str to float, optional
        The length of the longest arrows, by key.
    traced : sequence of str, optional
        Names of points whose path is drawn at first.
    ghost : (SpaceMotion, SpaceDrawing), optional
        Another motion, which is drawn pale with the first at the same time.
    seen_from : str, optional
        The view: "iso", "front", "side" or "top".

    Returns
    -------
    dict
        Values of JSON; arrays as {"kind", "data"} in base64, little-endian. Positions are relative to "origin".
    """
    bounds = drawing.bounds
    if ghost is not None:
        other = ghost[1].bounds
        bounds = np.stack([np.minimum(bounds[0], other[0]), np.maximum(bounds[1], other[1])])
    extent = float((bounds[1] - bounds[0]).max())
    far = float(np.abs(bounds).max()) > page.FAR * extent
    origin = bounds.mean(axis=0) if far else np.zeros(3)
    bounds = bounds - origin
    pack = _Packing(origin, float(np.abs(bounds).max()))
    front = view(motion.scene, "front")
    floor = drawing.floor
    return {
        "name": motion.scene.name,
        "doc": motion.scene.doc,
        "origin": origin.tolist(),
        "bounds": [[short(x) for x in row] for row in bounds.tolist()],
        "axes": [axis.tolist() for axis in (front.right, -front.towards, front.up)],
        "size": short(drawing.size),
        "view": seen_from,
        "views": {name: list(angles) for name, angles in VIEWS.items()},
        "followed": drawing.followed,
        "floor": None if floor is None else pack.spot(Place(GROUND, floor.r, floor.p)),
        **plotted(plots, motion.t),
        **pack.mechanism(motion, drawing),
        "points": {name: pack.spot(spot) for name, spot in list(motion.spots.items())[: page.MOST_POINTS]},
        "traced": list(traced),
        "vectors": [
            {"name": v.name, "group": v.group, "key": v.key, "kind": v.kind, "at": pack.spot(v.at)}
            | {"values": array(np.nan_to_num(v.values), "f4")}
            for v in vectors
        ],
        "largest": dict(largest or {}),
        "ghost": None if ghost is None else pack.mechanism(*ghost),
    }


class _Packing:
    """Numbers of the page: positions relative to an origin, as 32-bit numbers or as integers of 16 bits."""

    def __init__(self, origin: NDArray[np.float64], reach: float) -> None:
        self.origin = origin
        self.level = (reach or 1.0) / 32767

    def mechanism(self, motion: SpaceMotion, drawing: SpaceDrawing) -> dict[str, Any]:
        """Poses and solids of one motion."""
        return {
            "unit": short(drawing.unit),
            "t": array(motion.t, "f8"),
            "tracks": motion.tracks,
            "poses": self.poses(motion),
            "curves": [],
            "solids": [self.solid(s) for s in drawing.solids],
            "bodies": {c.name: self.spot(motion.spots[f"{c.name}.c"]) for c in motion.scene.bodies()},
        }

    def spot(self, place: Place) -> list[float]:
        """[track, x, y, z, w, x, y, z]: a position and a quaternion; without the quaternion if it does not turn."""
        shift = self.origin if place.track == GROUND else np.zeros(3)
        r = [short(x) for x in (np.array(place.r) - shift).tolist()]
        p = [short(x) for x in place.p]
        return [place.track, *r, *(p if tuple(p) != UNTURNED else ())]

    def solid(self, s: Solid) -> dict[str, Any]:
        at = [self.spot(place) for place in s.at]
        own = numbers({"size": s.size, **s.data})
        return {"draw": s.draw, "role": s.role, "name": s.name, "at": at, **own}

    def poses(self, motion: SpaceMotion) -> dict[str, Any]:
        poses = motion.poses.copy()
        poses[..., :3] -= self.origin
        if motion.poses.size <= page.MANY:
            return {**array(poses, "f4"), "scale": [1.0, 1.0]}
        steps = np.repeat([self.level, 1 / 32767], [3, 4])
        return {**levels(poses / steps), "scale": [self.level, 1 / 32767]}
