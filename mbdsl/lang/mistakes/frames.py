"""Parts of Modelica that are frames here: FixedTranslation, FixedRotation and Parts.Fixed.

A frame of the same name takes their place, and ``name.frame_a`` and ``name.frame_b`` mean the same as before. Where the
body is at frame_b, the frame is that of frame_a: turned back first, then moved back along the axes so turned.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping

from mbdsl.lang import syntax as s
from mbdsl.lang.mistakes.values import degrees, floats, is_zero, items, number, numbers, opposite, vector
from mbdsl.lang.unparse import write

#: where the ports of a declaration lead: port -> a frame of a body or of the ground, and True; else what it is
#: connected to, and False; None if this is not known. "" -> the ground
Ends = Callable[[str], tuple[str, bool] | None]
Given = Mapping[str, s.Expression]


def translation(name: str, given: Given, ends: Ends, spatial: bool) -> str:
    return _placed(name, given, ends, spatial, [], [])


def rotation(name: str, given: Given, ends: Ends, spatial: bool) -> str:
    return _placed(name, given, ends, spatial, *_turns(given, spatial))


def _placed(name: str, given: Given, ends: Ends, spatial: bool, turn: list[str], back: list[str]) -> str:
    """A frame on the body at one of the ends; ``turn`` and ``back`` are its orientation and the opposite one."""
    first, second, size = ends("frame_a"), ends("frame_b"), 3 if spatial else 2
    r = items(given.get("r"))
    if first is not None and first[1]:
        return f"write `Frame {name}({', '.join([first[0], *_at(given, spatial), *turn])});`"
    if second is not None and second[1] and r is not None:
        base, before = second[0], ""
        if back:
            before, base = f"Frame {name}_turned({', '.join([second[0], *back])}); ", f"{name}_turned"
        moved = f"r = {vector([opposite(x) for x in r], size)}"
        return (
            f"write `{before}Frame {name}_a({base}, {moved});`, and `{name}_a` instead of `{name}.frame_a` and "
            f"`{second[0]}` instead of `{name}.frame_b`"
        )
    if first is None or second is None:
        shown = ", ".join(["body.c", *_at(given, spatial), *turn])
        return f"a frame at a distance is fixed to a body: write `Frame {name}({shown});`"
    ends_of_link = ", ".join([f"r = {vector(r, size)}" if r else "r = ...", *turn])
    if spatial:
        b = f"b({ends_of_link})"
    else:
        angle = turn[0].removeprefix("phi = ") if turn else ""
        b = f"b = {{{', '.join([*(write(x) for x in (r or ())[:2]), *([angle] if angle else [])])}}}"
    a = "{0, 0, 0}" if spatial else "{0, 0}"
    return f"a link between two joints is a body: write `Body {name}(m = ..., I = ..., frames(a = {a}, {b}));`"


def _at(given: Given, spatial: bool) -> list[str]:
    if "r" not in given:
        return []
    r = items(given["r"])
    return [f"r = {write(given['r']) if r is None or spatial else vector(r, 2)}"]


def fixed(name: str, given: Given, ends: Ends, spatial: bool) -> str:
    world = ends("")
    turn = [f"phi = {write(given['phi'])}"] if "phi" in given and not spatial else []
    return f"write `Frame {name}({', '.join([world[0] if world else 'ground', *_at(given, spatial), *turn])});`"


def _turns(given: Given, spatial: bool) -> tuple[list[str], list[str]]:
    """The orientation of frame_b in frame_a, and that of frame_a in frame_b, as arguments of a Frame."""
    how = write(given["rotationType"]).rpartition(".")[2] if "rotationType" in given else ""
    if "alpha" in given:  # of PlanarMechanics, in rad
        angle = given["alpha"]
        return [f"phi = {write(angle)}"], [f"phi = {write(opposite(angle))}"]
    if how == "TwoAxesVectors" or (not how and ("n_x" in given or "n_y" in given)):
        return _two_axes(given, spatial)
    if how == "PlanarRotationSequence" or (not how and "angles" in given):
        return _sequence(given, spatial)
    angle, n = given.get("angle"), given.get("n")
    if angle is None or is_zero(angle):
        return [], []
    if spatial:
        about = f"n = {write(n) if n is not None else '{1, 0, 0}'}"
        return [about, f"phi = {degrees(angle)}"], [about, f"phi = {degrees(angle, -1)}"]
    z = None if (axis := items(n)) is None else number(axis[2])
    sign = -1 if z is not None and z < 0.0 else 1
    return [f"phi = {degrees(angle, sign)}"], [f"phi = {degrees(angle, -sign)}"]


def _two_axes(given: Given, spatial: bool) -> tuple[list[str], list[str]]:
    n_x = given.get("n_x", s.ArrayNode((s.Number(1), s.Number(0), s.Number(0))))
    n_y = given.get("n_y", s.ArrayNode((s.Number(0), s.Number(1), s.Number(0))))
    x, y = numbers(n_x), numbers(n_y)
    if not spatial:
        if x is None:
            c, sine = (write(e) for e in (items(n_x) or ())[:2])
            return [f"phi = atan2({sine}, {c})"], [f"phi = -atan2({sine}, {c})"]
        angle = math.degrees(math.atan2(x[1], x[0]))
        return [f"phi = {angle:.15g} deg"], [f"phi = {-angle:.15g} deg"]
    back = ["n_x = ...", "n_y = ..."]
    if x is not None and y is not None:
        z = _cross(x, y)
        y = _cross(z, x)
        columns = [[component / math.hypot(*axis) for component in axis] for axis in (x, y, z)]
        back = [f"{key} = {floats([axis[k] for axis in columns])}" for k, key in enumerate(("n_x", "n_y"))]
    return [f"n_x = {write(n_x)}", f"n_y = {write(n_y)}"], back


def _sequence(given: Given, spatial: bool) -> tuple[list[str], list[str]]:
    """Angles in degrees, one after the other about axes of the frame turned so far; backwards in the opposite order."""
    angles = items(given.get("angles"))
    axes: list[s.Expression] | None = items(given.get("sequence"))
    if "sequence" not in given:
        axes = [*map(s.Number, (1, 2, 3))]
    if angles is None or axes is None:
        return ["angles = ...", "sequence = ..."], ["angles = ...", "sequence = ..."]
    if not spatial:
        about_z = [degrees(x) for x, axis in zip(angles, axes, strict=True) if number(axis) == 3.0 and not is_zero(x)]
        total = " + ".join(f"({x})" if x.startswith("-") else x for x in about_z)
        return ([f"phi = {total}"], [f"phi = -({total})"]) if about_z else ([], [])

    def written(angles: list[s.Expression], axes: list[s.Expression], sign: int) -> list[str]:
        return [f"angles = {{{', '.join(degrees(x, sign) for x in angles)}}}", f"sequence = {vector(axes, 3)}"]

    return written(angles, axes, 1), written(angles[::-1], axes[::-1], -1)


def outside(given: Given) -> str | None:
    """The argument of a FixedRotation that turns a frame out of the plane; None if there is none."""
    how = write(given["rotationType"]).rpartition(".")[2] if "rotationType" in given else ""
    if "angles" in given and how in ("", "PlanarRotationSequence"):
        axes = numbers(given["sequence"]) if "sequence" in given else [1.0, 2.0, 3.0]
        pairs = zip(items(given["angles"]) or (), axes or (), strict=False)
        return "angles" if any(axis != 3.0 and not is_zero(x) for x, axis in pairs) else None
    if how in ("", "TwoAxesVectors") and ("n_x" in given or "n_y" in given):
        found = ((key, items(given[key])) for key in ("n_x", "n_y") if key in given)
        return next((key for key, n in found if n is None or not is_zero(n[2])), None)
    return "angle" if "angle" in given and "n" not in given and not is_zero(given["angle"]) else None


def _cross(a: list[float], b: list[float]) -> list[float]:
    return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
