"""The page of an animation: one HTML file with its data, its scripts and its style, which loads nothing."""

from __future__ import annotations

import base64
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mbdsl.plotting import documents
from mbdsl.viewing.display import Item, values_of
from mbdsl.viewing.shapes import Drawing
from mbdsl.viewing.signals import Plots, PlottedSignal
from mbdsl.viewing.space.shapes import SpaceDrawing
from mbdsl.viewing.space.solid import Solid
from mbdsl.viewing.tracks import GROUND, UNTURNED, AnyMotion, Place, Spot, largest_strain
from mbdsl.viewing.vectors import Vector

HERE = Path(__file__).parent
LIBRARY = HERE / "space" / "three" / "three.min.js"
#: a script is the files in this order
SCRIPTS = (
    *("data.js", "motion.js", "plots.js", "player.js", "marks.js", "canvas.js", "view.js"),
    *("controls.js", "pointers.js", "start.js"),
)
SCRIPTS_IN_SPACE = (
    *("data.js", "motion.js", "space/motion.js", "plots.js", "player.js", "marks.js"),
    *("space/geometry.js", "space/solids.js", "space/stage.js", "space/view.js"),
    *("controls.js", "space/controls.js", "pointers.js", "start.js"),
)
STYLE, STYLE_IN_SPACE = "player.css", "space/space.css"
MODES = "modes.js"  #: before `plots.js`, in pages of mode shapes
#: number of stored numbers from which poses are integers of 16 bits: a 32,767th of the extent, and of half a turn
MANY = 400_000
MOST_POINTS = 400  #: frames that can be traced
FAR = 50  #: distance from the origin, in extents, from which positions are stored relative to the middle


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
    spatial = "solids" in data
    names = SCRIPTS_IN_SPACE if spatial else SCRIPTS
    if "modes" in data:
        k = names.index("plots.js")
        names = (*names[:k], MODES, *names[k:])
    style = "".join(_text(name) for name in ((STYLE, STYLE_IN_SPACE) if spatial else (STYLE,)))
    scripts = [_text(str(LIBRARY)), script_of(names)] if spatial else [script_of(names)]
    content = (_text("page.html"), documents.data_script(dict(data), ' id="data"'))
    return documents.page(data["name"], content, style, scripts)


def _text(name: str) -> str:
    return documents.asset(name, HERE)


def script_of(names: Sequence[str]) -> str:
    """Files of a script as one, without comment lines and indentation; no text in it spans lines."""
    lines = [line.strip() for name in names for line in _text(name).splitlines()]
    return "\n".join(line for line in lines if line and not line.startswith("//"))


def document(
    motion: AnyMotion,
    drawing: Drawing | SpaceDrawing,
    plots: Plots,
    vectors: Sequence[Vector] = (),
    traced: Sequence[str] = (),
    ghost: tuple[AnyMotion, Drawing | SpaceDrawing] | None = None,
) -> dict[str, Any]:
    """The data of a page.

    Parameters
    ----------
    motion, drawing : AnyMotion, Drawing or SpaceDrawing
        Poses, and shapes in the plane or solids in space.
    plots : Plots
        Signals that can be plotted.
    vectors : sequence of Vector, optional
        Arrows.
    traced : sequence of str, optional
        Names of points whose path is drawn at first.
    ghost : (AnyMotion, Drawing or SpaceDrawing), optional
        Another motion, which is drawn pale with the first at the same time.

    Returns
    -------
    dict
        Values of JSON; arrays as {"kind", "data"} in base64, little-endian. Positions are relative to "origin".
    """
    bounds = np.reshape(drawing.bounds, (2, -1))
    if ghost is not None:
        other = np.reshape(ghost[1].bounds, (2, -1))
        bounds = np.stack([np.minimum(bounds[0], other[0]), np.maximum(bounds[1], other[1])])
    extent = float((bounds[1] - bounds[0]).max())
    far = float(np.abs(bounds).max()) > FAR * extent
    origin = bounds.mean(axis=0) if far else np.zeros(bounds.shape[1])
    bounds = bounds - origin
    pack = _Packing(origin, motion, float(np.abs(bounds).max()))
    found = {
        "name": motion.scene.name,
        "doc": motion.scene.doc,
        "origin": origin.tolist(),
        "bounds": [[short(x) for x in row] for row in bounds.tolist()],
        **_plotted(plots, motion.t),
        **pack.mechanism(drawing),
        "points": {name: pack.spot(spot) for name, spot in list(motion.spots.items())[:MOST_POINTS]},
        "traced": list(traced),
        "vectors": [
            {"name": v.name, "group": v.group, "key": v.key, "kind": v.kind, "at": pack.spot(v.at)}
            | {"size": v.values.shape[1], "values": array(np.nan_to_num(v.values), "f4")}
            for v in vectors
        ],
        "strain": largest_strain(motion.curves),
        "ghost": None if ghost is None else _Packing(origin, ghost[0], pack.reach, False).mechanism(ghost[1]),
    }
    return found | pack.stage(drawing) if isinstance(drawing, SpaceDrawing) else found


def _plotted(plots: Plots, t: NDArray[np.float64]) -> dict[str, Any]:
    """Signals of a page whose frames have the times t (N,) [s]."""
    return {
        "times": None if np.array_equal(plots.times, t) else array(plots.times, "f8"),
        "signals": [
            {"name": s.name, "unit": s.unit, "low": _finite(s.low), "high": _finite(s.high), "y": _line(s)}
            | ({"doc": s.doc} if s.doc else {})
            | ({"held": True} if s.held else {})
            for s in plots.signals
        ],
        "shown": plots.shown,
        "events": [[mark.t, mark.text] for mark in plots.events],
    }


class _Packing:
    """Numbers of one motion: positions relative to an origin, as 32-bit numbers or as integers of 16 bits."""

    def __init__(self, origin: NDArray[np.float64], motion: AnyMotion, reach: float, strained: bool = True) -> None:
        self.motion, self.origin, self.reach = motion, origin, reach
        self.strained = strained  # whether beams are coloured by their strain
        self.level = (reach or 1.0) / 32767

    def mechanism(self, drawing: Drawing | SpaceDrawing) -> dict[str, Any]:
        """Poses, and shapes or solids."""
        motion = self.motion
        found: dict[str, Any] = {
            "unit": short(drawing.unit),
            "t": array(motion.t, "f8"),
            "tracks": motion.tracks,
            "poses": self.poses(),
            "curves": self.curves(),
            "bodies": {c.name: self.spot(motion.spots[f"{c.name}.c"]) for c in motion.scene.bodies()},
            "elastic": [curve.body for curve in motion.curves],
        }
        if isinstance(drawing, SpaceDrawing):
            return found | {"solids": [self.solid(s) for s in drawing.solids]}
        return found | {"items": [self.item(item) for shape in drawing.shapes for item in shape.items]}

    def stage(self, drawing: SpaceDrawing) -> dict[str, Any]:
        """What the stage of a model in space needs in addition."""
        from mbdsl.viewing.projection import VIEWS, view

        front, floor = view(self.motion.scene, "front"), drawing.floor
        return {
            "axes": [axis.tolist() for axis in (front.right, -front.towards, front.up)],
            "size": short(drawing.size),
            "views": {name: list(angles) for name, angles in VIEWS.items()},
            "followed": drawing.followed,
            "floor": None if floor is None else self.spot(Place(GROUND, floor.r, floor.p)),
        }

    def spot(self, spot: Spot | Place) -> list[float]:
        """[track, x, y, angle] without zeros at its end, or [track, x, y, z, w, x, y, z] without a unit quaternion."""
        shift = self.origin if spot.track == GROUND else 0.0 * self.origin
        if isinstance(spot, Place):
            r = [short(x) for x in (np.array(spot.r) - shift).tolist()]
            p = [short(x) for x in spot.p]
            return [spot.track, *r, *(p if tuple(p) != UNTURNED else ())]
        found = [short(spot.x - shift[0]), short(spot.y - shift[1]), short(spot.phi)]
        while found and found[-1] == 0.0:
            found.pop()
        return [spot.track, *found]

    def item(self, item: Item) -> dict[str, Any]:
        at = getattr(item, "at", ())
        return {"at": [self.spot(spot) for spot in at], **_all_short(values_of(item))}

    def solid(self, s: Solid) -> dict[str, Any]:
        own = _all_short({"size": s.size, **s.data})
        return {"draw": s.draw, "role": s.role, "name": s.name, "at": [self.spot(place) for place in s.at], **own}

    def poses(self) -> dict[str, Any]:
        """Poses, and the scales of positions and of angles or quaternions."""
        poses, d = self.motion.poses.copy(), len(self.origin)
        poses[..., :d] -= self.origin
        if self.motion.poses.size <= MANY:
            return {**array(poses, "f4"), "scale": [1.0, 1.0]}
        turn = 1 / 32767
        if d == 2:
            poses[..., d] = np.angle(np.exp(1j * poses[..., d]))
            turn = np.pi / 32767
        steps = np.array([self.level] * d + [turn] * (poses.shape[-1] - d))
        return {**levels(poses / steps), "scale": [self.level, turn]}

    def curves(self) -> list[dict[str, Any]]:
        found, most = [], largest_strain(self.motion.curves)
        for curve in self.motion.curves:
            shades = np.nan_to_num(255 * curve.strain() / (most or 1.0) * self.strained).round()
            points = {**levels((curve.points - self.origin) / self.level), "scale": self.level}
            found.append({"points": points, "count": len(curve.along), "colours": array(shades, "u1")})
        return found


def array(values: Any, kind: str) -> dict[str, str]:
    """Numbers as {"kind", "data"}: base64 of "f8", "f4", "i2" or "u1", little-endian."""
    with np.errstate(over="ignore"):
        stored = np.ascontiguousarray(values, dtype=f"<{kind}")
    return {"kind": kind, "data": base64.b64encode(stored.tobytes()).decode()}


def levels(values: NDArray[np.float64]) -> dict[str, str]:
    """Numbers between -32767 and 32767 as integers of 16 bits."""
    return array(np.clip(np.nan_to_num(np.rint(values)), -32767, 32767), "i2")


def _line(signal: PlottedSignal) -> dict[str, str]:
    """Values as integers of 16 bits, -32767 at the lowest and 32767 at the highest; -32768 for nan."""
    half = (signal.high - signal.low) / 2
    with np.errstate(invalid="ignore", divide="ignore", over="ignore"):
        levels = np.rint(32767 * ((signal.values - signal.low) / half - 1.0)) if half > 0.0 else 0.0 * signal.values
    return array(np.where(np.isfinite(levels), levels, -32768), "i2")


def short(value: float) -> float:
    """A number of at most nine digits."""
    return float(f"{value:.9g}")


def _finite(value: float) -> float | None:
    return float(value) if np.isfinite(value) else None


def _all_short(x: Any) -> Any:
    """Data with numbers of at most nine digits."""
    if isinstance(x, float | np.floating):
        return short(float(x))
    if isinstance(x, dict):
        return {key: _all_short(value) for key, value in x.items()}
    return [_all_short(y) for y in x] if isinstance(x, list | tuple) else x
