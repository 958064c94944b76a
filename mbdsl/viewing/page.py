"""The page of an animation: one HTML file with its data, its script and its style, which loads nothing."""

from __future__ import annotations

import base64
import hashlib
import json
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mbdsl.plotting.escaping import escape, seen
from mbdsl.viewing.motion import GROUND, Motion, Spot, largest_strain
from mbdsl.viewing.shapes import Drawing
from mbdsl.viewing.signals import Plots, Signal
from mbdsl.viewing.vectors import Vector, largest

HERE = Path(__file__).parent
#: the script is the files in this order
SCRIPTS = (
    *("data.js", "motion.js", "drawing.js", "elements.js", "gears.js", "plots.js", "player.js", "marks.js", "view.js"),
    *("controls.js", "pointers.js", "start.js"),
)
STYLE = "player.css"
MODES = "modes.js"  #: after `motion.js`, in pages of mode shapes
#: number of stored numbers from which poses are integers of 16 bits: a 32,767th of the extent, and of half a turn
MANY = 400_000
MOST_POINTS = 400  #: frames that can be traced
FAR = 50  #: distance from the origin, in extents, from which positions are stored relative to the middle


def html(data: dict[str, Any]) -> str:
    """The page as the text of one HTML file.

    Parameters
    ----------
    data : dict
        What ``document`` returns.

    Returns
    -------
    str
        HTML. Its policy allows this script and this style by their digests, and nothing else.
    """
    names = (*SCRIPTS[:2], MODES, *SCRIPTS[2:]) if "modes" in data else SCRIPTS
    return assembled(data, (HERE / STYLE).read_text(encoding="utf-8"), [script_of(names)])


def assembled(data: dict[str, Any], style: str, scripts: Sequence[str]) -> str:
    """A page of these data, this style and these scripts, which are allowed by their digests."""
    allowed = " ".join(_digest(script) for script in scripts)
    policy = f"default-src 'none'; style-src {_digest(style)}; script-src {allowed}"
    # `<` would let a text end the element; as an escape it is the same JSON.
    text = json.dumps(seen(data), ensure_ascii=False, separators=(",", ":"), allow_nan=False)
    return "\n".join(
        (
            '<!DOCTYPE html>\n<html lang="en">\n<head>\n<meta charset="utf-8">',
            f'<meta http-equiv="Content-Security-Policy" content="{escape(policy)}">',
            '<meta name="viewport" content="width=device-width, initial-scale=1">',
            f"<title>{escape(data['name'])}</title>\n<style>{style}</style>\n</head>\n<body>",
            (HERE / "page.html").read_text(encoding="utf-8"),
            f'<script type="application/json" id="data">{text.replace("<", chr(92) + "u003c")}</script>',
            *(f"<script>{script}</script>" for script in scripts),
            "</body>\n</html>\n",
        )
    )


def script_of(names: Sequence[str], folder: Path = HERE) -> str:
    """Files of a script as one, without comment lines and indentation; no text in it spans lines."""
    lines = [line.strip() for name in names for line in (folder / name).read_text(encoding="utf-8").splitlines()]
    return "\n".join(line for line in lines if line and not line.startswith("//"))


def _digest(text: str) -> str:
    return f"'sha256-{base64.b64encode(hashlib.sha256(text.encode()).digest()).decode()}'"


def document(
    motion: Motion,
    drawing: Drawing,
    plots: Plots,
    vectors: Sequence[Vector] = (),
    traced: Sequence[str] = (),
    about: Sequence[tuple[str, str]] = (),
    ghost: tuple[Motion, Drawing] | None = None,
) -> dict[str, Any]:
    """The data of a page.

    Parameters
    ----------
    motion, drawing : Motion, Drawing
        Poses and shapes.
    plots : Plots
        Signals that can be plotted.
    vectors : sequence of Vector, optional
        Arrows.
    traced : sequence of str, optional
        Names of points whose path is drawn at first.
    about : sequence of (str, str), optional
        Facts about the run.
    ghost : (Motion, Drawing), optional
        Another motion, which is drawn pale behind the first at the same time.

    Returns
    -------
    dict
        Values of JSON; arrays as {"kind", "data"} in base64, little-endian. Positions are relative to "origin".
    """
    bounds = np.array(drawing.bounds)
    if ghost is not None:
        other = ghost[1].bounds
        bounds = np.concatenate([np.minimum(bounds[:2], other[:2]), np.maximum(bounds[2:], other[2:])])
    extent = float(max(bounds[2:] - bounds[:2]))
    far = float(np.abs(bounds).max()) > FAR * extent
    origin = (bounds[:2] + bounds[2:]) / 2 if far else np.zeros(2)
    bounds = bounds - np.tile(origin, 2)
    pack = _Packing(origin, motion, float(np.abs(bounds).max()))
    return {
        "name": motion.scene.name,
        "doc": motion.scene.doc,
        "origin": origin.tolist(),
        "bounds": [short(x) for x in bounds.tolist()],
        **plotted(plots, motion.t),
        **_mechanism(pack, drawing),
        "points": {name: pack.spot(spot) for name, spot in list(motion.spots.items())[:MOST_POINTS]},
        "traced": list(traced),
        "vectors": [_vector(v, pack) for v in vectors],
        "largest": largest(vectors),
        "strain": largest_strain(motion.curves),
        "about": [list(item) for item in about],
        "ghost": None if ghost is None else _mechanism(_Packing(origin, ghost[0], pack.reach, False), ghost[1]),
    }


def plotted(plots: Plots, t: NDArray[np.float64]) -> dict[str, Any]:
    """Signals of a page whose frames have the times t (N,) [s]."""
    return {
        "times": None if np.array_equal(plots.times, t) else array(plots.times, "f8"),
        "signals": [
            {"name": s.name, "unit": s.unit, "low": _finite(s.low), "high": _finite(s.high), "y": _line(s)}
            | ({"doc": s.doc} if s.doc else {})
            for s in plots.signals
        ],
        "shown": plots.shown,
    }


def _mechanism(pack: _Packing, drawing: Drawing) -> dict[str, Any]:
    """Poses and shapes of one motion."""
    motion = pack.motion
    return {
        "unit": short(drawing.unit),
        "t": array(motion.t, "f8"),
        "tracks": motion.tracks,
        "poses": pack.poses(),
        "curves": pack.curves(),
        "shapes": [
            {"draw": s.draw, "name": s.name, "at": [pack.spot(spot) for spot in s.at], **numbers(s.data)}
            for s in drawing.shapes
        ],
        "bodies": {c.name: pack.spot(motion.spots[f"{c.name}.c"]) for c in motion.scene.bodies()},
        "elastic": [curve.body for curve in motion.curves],
    }


def _vector(v: Vector, pack: _Packing) -> dict[str, Any]:
    values = array(np.nan_to_num(v.values), "f4")
    return {"name": v.name, "group": v.group, "at": pack.spot(v.at), "size": v.values.shape[1], "values": values}


class _Packing:
    """Numbers of the page: positions relative to an origin, as 32-bit numbers or as integers of 16 bits."""

    def __init__(self, origin: NDArray[np.float64], motion: Motion, reach: float, strained: bool = True) -> None:
        self.motion, self.origin, self.reach = motion, origin, reach
        self.strained = strained  # whether beams are coloured by their strain
        self.small = motion.poses.size > MANY
        self.level = (reach or 1.0) / 32767

    def spot(self, spot: Spot) -> list[float]:
        shift = self.origin if spot.track == GROUND else (0.0, 0.0)
        numbers = [short(spot.x - shift[0]), short(spot.y - shift[1]), short(spot.phi)]
        while numbers and numbers[-1] == 0.0:
            numbers.pop()
        return [spot.track, *numbers]

    def poses(self) -> dict[str, Any]:
        poses = self.motion.poses.copy()
        poses[:, :, :2] -= self.origin
        if not self.small:
            return {**array(poses, "f4"), "scale": [1.0, 1.0]}
        poses[:, :, 2] = np.angle(np.exp(1j * poses[:, :, 2]))
        return {**levels(poses / (self.level, self.level, np.pi / 32767)), "scale": [self.level, np.pi / 32767]}

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


def _line(signal: Signal) -> dict[str, str]:
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


def numbers(data: dict[str, Any]) -> dict[str, Any]:
    """Numbers of a shape's data with at most nine digits."""

    def all_short(x: Any) -> Any:
        if isinstance(x, float | np.floating):
            return short(float(x))
        return [all_short(y) for y in x] if isinstance(x, list | tuple) else x

    return {key: all_short(value) for key, value in data.items()}
