"""Poses of frames in space as models give them: a position, and an orientation in one of four ways.

    n, phi              turned by the angle phi about the axis n
    n_x, n_y            the x axis has the direction n_x, and the y axis lies in the plane of n_x and n_y
    angles, sequence    turned by three angles one after the other, each about an axis of the frame turned so far
    quaternion          the quaternion of the rotation, scalar part first

All are in the axes of the base. The names are those of FixedRotation in Modelica's MultiBody library, except for phi.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from math import hypot
from typing import Any

from mbdsl.elements.declaration import Parameter
from mbdsl.errors import ModelError
from mbdsl.lang import argument_checks, values
from mbdsl.lang import syntax as s
from mbdsl.lang.mistakes import doubts
from mbdsl.lang.modifiers import Contexts, Modifier, Modifiers, refuse_inner
from mbdsl.lang.source import At, placed, span_of
from mbdsl.lang.unparse import write
from mbdsl.mechanism import poses
from mbdsl.mechanism.scene_parts import SpatialFrame
from mbdsl.messages import did_you_mean

PARAMETERS = {
    "r": Parameter("r", "m", (0.0, 0.0, 0.0), "position", shape=(3,)),
    "n": Parameter("n", "1", (0.0, 0.0, 1.0), "axis of the rotation phi", shape=(3,)),
    "phi": Parameter("phi", "rad", 0.0, "angle about n"),
    "n_x": Parameter("n_x", "1", None, "direction of the x axis", shape=(3,)),
    "n_y": Parameter("n_y", "1", None, "direction in the xy plane, on the side of the y axis", shape=(3,)),
    "angles": Parameter("angles", "rad", None, "angles about the axes of the sequence", shape=(3,)),
    "sequence": Parameter("sequence", "1", (1.0, 2.0, 3.0), "axes of the angles: 1, 2, 3 for x, y, z", shape=(3,)),
    "quaternion": Parameter("quaternion", "1", None, "quaternion of the rotation, scalar part first", shape=(4,)),
}
#: the ways to give an orientation: parameters that are necessary, and others
WAYS = {("phi",): ("n",), ("n_x", "n_y"): (), ("angles",): ("sequence",), ("quaternion",): ()}
#: parameters that must not be zero -> the expected value, in messages
ZERO = {
    "n": "the direction of an axis, e.g. {0, 0, 1}",
    "n_x": "a direction, e.g. {1, 0, 0}",
    "n_y": "a direction, e.g. {0, 1, 0}",
    "quaternion": "a rotation; for none, write {1, 0, 0, 0}",
}
#: two directions count as parallel if the sine of their angle is below this: the plane would be made of rounding
PARALLEL = 1e-9


def check(modifier: Modifier, what: str) -> None:
    """Check the names in ``tip(r = ..., angles = ...)``; ``what`` is the frame in messages.

    Raises
    ------
    ModelError
        At the first parameter that a frame in space does not have.
    """
    if modifier.value is not None:
        refuse_inner(modifier, what, f"write `{modifier.name}(r = {{x, y, z}}, ...)`")
    for key, inner in modifier.inner.items():
        if key not in PARAMETERS:
            hint = did_you_mean(key, PARAMETERS, "a frame in space has")
            raise ModelError(f"{what} has no `{key}`", span_of(inner.at), hint)
        refuse_inner(inner, f"`{key}` of {what}", f"write `{key} = ...`")


def refuse_loose(frames: Modifiers, owner: str, spatial: bool) -> None:
    """Refuse ``frames(tip = {x, y, z}, n = ..., phi = ...)``: parameters of a frame beside it, not inside.

    Raises
    ------
    ModelError
        At the first of them.
    """
    given = {key: m for key, m in frames.items() if m.value is not None}
    own = [key for key in given if key not in PARAMETERS]
    loose = {key: m for key, m in given.items() if key in PARAMETERS}
    united = {key: isinstance(m.value, s.ArrayNode) and m.value.unit is not None for key, m in given.items()}
    direction = spatial and "n" in loose and not united["n"] and any(united[key] for key in own)
    if not (loose.keys() - {"n", "r"} or (len(loose) > 1 and not own) or direction):
        return  # `n` and `r` may be names of frames
    name, values = own[-1] if own else "tip", {key: write(m.value) for key, m in loose.items()}
    values = {**({"r": write(given[name].value)} if own else {}), **values}
    if "n" in values:
        values.setdefault("phi", "...")
    first = next(iter(loose.values()))
    if spatial:
        right = f"{name}({', '.join(f'{key} = {x}' for key, x in values.items())})"
    else:
        base = given[name].value if own else None
        items = [*base.items[:2]] if isinstance(base, s.ArrayNode) else []
        unit = base.unit if isinstance(base, s.ArrayNode) else None
        shown = [write(s.Number(x.value, unit) if isinstance(x, s.Number) and unit else x) for x in items]
        right = f"{name} = {{{', '.join((*shown, *('x', 'y')[len(shown) :], values.get('phi', 'phi')))}}}"
    message = f"`{first.name}` is not a frame of `{owner}`, but belongs to one"
    raise ModelError(message, span_of(first.at), f"write `frames({right})`")


def pose(
    what: str, modifiers: Modifiers, contexts: Contexts, at: At, warn: doubts.Warn
) -> tuple[tuple[float, ...], float]:
    """Origin and axes (12 numbers) of a frame, relative to its base, and its angle about the z axis with whole turns.

    Parameters
    ----------
    what : str
        The frame in messages, such as ```tip` of `rod```.
    modifiers : Modifiers
        Its parameters.
    contexts : Contexts
        The position in the arrays around it.
    at : At
        Its declaration.
    warn : Warn
        Called with doubts about units of angles.

    Raises
    ------
    ModelError
        If a value is invalid or no direction, or if the orientation is given incompletely or in two ways.
    """
    given: dict[str, Any] = {}
    for key, parameter in PARAMETERS.items():
        modifier = modifiers.get(key)
        if modifier is None or modifier.value is None:
            continue
        with placed(modifier.value.at):
            picked = modifier.pick(modifier.evaluate(), len(parameter.shape), contexts)
            if key == "angles" and values.shape(picked) == (2,):
                raise ModelError(f"`angles` of {what}: found two angles, expected three")
            given[key] = argument_checks.argument_of(parameter, picked, f"`{key}` of {what}", modifier.value)
            if key in ZERO and not any(given[key]):
                raise ModelError(f"`{key}` of {what} is zero, expected {ZERO[key]}")
            if parameter.unit == "rad":
                doubts.angle(warn, picked, modifier.value, f"`{key}` of {what}")
    _one_way(what, given, modifiers, at)
    wrong = next((value for key in ("sequence", "n_y") if key in given and (value := modifiers[key].value)), None)
    with placed(wrong.at if wrong is not None else at):
        axes = _axes(what, given)
    n = given["n"] if "n" in given else PARAMETERS["n"].default
    about_z = given.get("phi", 0.0) * n[2] / abs(n[2]) if n[0] == n[1] == 0.0 else 0.0
    return (*(given["r"] if "r" in given else PARAMETERS["r"].default), *axes), about_z


def _one_way(what: str, given: dict[str, Any], modifiers: Modifiers, at: At) -> None:
    """Check that the orientation is given in one way, and completely."""
    ways = [(needed, more) for needed, more in WAYS.items() if any(key in given for key in (*needed, *more))]
    if len(ways) > 1:
        words = [_words(key for key in (*needed, *more) if key in given) for needed, more in ways]
        last = next(key for key in reversed(given) if key in (*ways[-1][0], *ways[-1][1]))
        raise ModelError(
            f"the orientation of {what} is given twice, by {' and by '.join(words[:2])}",
            modifiers[last].value_span(),
            "keep one of: phi (and n), n_x and n_y, angles (and sequence), quaternion",
        )
    for needed, more in ways:
        for key in needed:
            if key not in given:
                other = next(k for k in (*needed, *more) if k in given)
                examples = {"phi": "phi = 30 deg", "n_x": "n_x = {1, 0, 0}", "n_y": "n_y = {0, 1, 0}"}
                raise ModelError(
                    f"{what} has `{other}`, but no `{key}`",
                    modifiers[other].value_span() or span_of(at),
                    f"add `{examples.get(key, 'angles = {0, 0, 30} deg')}`",
                )


def _words(keys: Iterable[str]) -> str:
    return " and ".join(f"`{key}`" for key in keys)


def _axes(what: str, given: Mapping[str, Any]) -> tuple[float, ...]:
    """The axes (9) for an orientation that is given in one way."""
    if "quaternion" in given:
        return poses.of_quaternion(given["quaternion"])
    if "n_x" in given:
        return _of_two(what, given["n_x"], given["n_y"])
    if "angles" in given:
        sequence = given.get("sequence", (1.0, 2.0, 3.0))
        known = all(k in (1.0, 2.0, 3.0) for k in sequence)
        if not known or sequence[0] == sequence[1] or sequence[1] == sequence[2]:
            shown = ", ".join(f"{k:g}" for k in sequence)
            raise ModelError(
                f"`sequence` of {what} is {{{shown}}}, expected numbers of axes, 1, 2 or 3, no two alike in succession",
                hint="{1, 2, 3} are Cardan angles about x, y, z; {3, 1, 3} are Euler's angles",
            )
        return poses.turned_successively(given["angles"], [int(k) - 1 for k in sequence])
    if "phi" not in given:
        return SpatialFrame.axes
    return poses.about(given.get("n", PARAMETERS["n"].default), given["phi"])


def _of_two(what: str, n_x, n_y) -> tuple[float, ...]:
    """The axes (9) with x along n_x, and y in the plane of n_x and n_y on the side of n_y."""
    x = [a / hypot(*n_x) for a in n_x]
    y = [a / hypot(*n_y) for a in n_y]
    z = poses.product(x, y)
    size = hypot(*z)
    if size < PARALLEL:
        raise ModelError(
            f"`n_x` and `n_y` of {what} are parallel, expected two directions that span the xy plane",
            hint="n_y needs a part at right angles to n_x; it need not be at right angles itself",
        )
    z = [a / size for a in z]
    return *x, *poses.product(z, x), *z
