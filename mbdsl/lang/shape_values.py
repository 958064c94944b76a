"""Values of shapes: lengths, points, angles and colours, checked."""

from __future__ import annotations

import re
from collections.abc import Callable
from typing import Any

from mbdsl.errors import ModelError
from mbdsl.lang import argument_checks, units, values
from mbdsl.lang.values import Quantity, Value, describe
from mbdsl.mechanism.drawn_shapes import Point
from mbdsl.messages import did_you_mean

FAR = 1e9  #: largest coordinate [m]
#: colours by name; all others are texts "#rrggbb" or {red, green, blue} from 0 to 255
COLOURS = {
    "black": "#000000",
    "white": "#ffffff",
    "red": "#d62728",
    "green": "#2ca02c",
    "blue": "#1f77b4",
    "orange": "#ff7f0e",
    "yellow": "#f2c80f",
    "purple": "#9467bd",
    "brown": "#8c564b",
    "pink": "#e377c2",
    "cyan": "#17becf",
    "gray": "#7f7f7f",
    "grey": "#7f7f7f",
    "lightgray": "#d3d3d3",
    "lightgrey": "#d3d3d3",
    "darkgray": "#4d4d4d",
    "darkgrey": "#4d4d4d",
    "steel": "#8fa1b3",
    "none": "none",
}


def lengths(value: Value, what: str) -> Any:
    found = argument_checks.floats(argument_checks.fit(value, units.dimension("m"), what, "m"), what)
    pending = [found]
    while pending:
        x = pending.pop()
        if isinstance(x, tuple):
            pending += x
        elif abs(x) > FAR:
            raise ModelError(f"{what} is {x:g} m; the largest coordinate is {FAR:g} m")
    return found


def points(least: int) -> Callable[[Value, str], tuple[Point, ...]]:
    def check(value: Value, what: str) -> tuple[Point, ...]:
        shape = values.shape(value)
        if len(shape) != 2 or shape[1] != 2 or shape[0] < least:
            raise ModelError(
                f"{what}: found {words(value)}, expected at least {least} points {{x, y}}",
                hint="write `points = {{0, 0}, {20, 0}, {10, 15}} mm`",
            )
        return lengths(value, what)

    return check


def extent(value: Value, what: str) -> tuple[Point, Point]:
    if values.shape(value) != (2, 2):
        hint = "write `extent = {{-10, -5}, {10, 5}} mm`"
        raise ModelError(f"{what}: found {words(value)}, expected two corners {{{{x1, y1}}, {{x2, y2}}}}", hint=hint)
    (x0, y0), (x1, y1) = lengths(value, what)
    if x0 == x1 or y0 == y1:
        raise ModelError(f"{what} has no area: {{{{{x0:g}, {y0:g}}}, {{{x1:g}, {y1:g}}}}} m")
    return (x0, y0), (x1, y1)


def point(value: Value, what: str) -> Point:
    if values.shape(value) != (2,):
        raise ModelError(f"{what}: found {words(value)}, expected a position {{x, y}}")
    return lengths(value, what)


def length(value: Value, what: str) -> float:
    found = width(value, what)
    if found == 0.0:
        raise ModelError(f"{what} is 0; it must be positive")
    return found


def width(value: Value, what: str) -> float:
    found = lengths(value, what)
    if isinstance(found, tuple):
        raise ModelError(f"{what}: found {words(value)}, expected a single length")
    if found < 0.0:
        raise ModelError(f"{what} is {found:g} m; it must not be negative")
    return found


def angle(value: Value, what: str) -> float:
    if isinstance(value, Quantity) and value.number and value.dimension is None and value.value != 0:
        raise ModelError(f"{what} has no unit", hint=f"write `rotation = {value.value} deg`, or rad")
    found = argument_checks.floats(argument_checks.fit(value, units.NUMBER, what, "rad"), what)
    if isinstance(found, tuple):
        raise ModelError(f"{what}: found {words(value)}, expected a single angle")
    return found


def text(value: Value, what: str) -> str:
    if isinstance(value, tuple) or not isinstance(value.value, str):
        raise ModelError(f"{what}: found {describe(value)}, expected a text")
    return value.value


def colour(value: Value, what: str) -> str:
    hint = 'a colour is "#1f77b4", {31, 119, 180}, or one of ' + ", ".join(COLOURS)
    if isinstance(value, tuple):
        fitted = argument_checks.floats(argument_checks.fit(value, units.NUMBER, what), what)
        if values.shape(value) != (3,) or not all(0 <= x <= 255 for x in fitted):
            raise ModelError(f"{what}: expected three numbers from 0 to 255", hint=hint)
        return "#" + "".join(f"{round(x):02x}" for x in fitted)
    if not isinstance(value.value, str):
        raise ModelError(f"{what}: found {describe(value)}, expected a colour", hint=hint)
    text = value.value.strip().lower()
    if re.fullmatch("#[0-9a-f]{3}", text):
        text = "#" + "".join(2 * c for c in text[1:])
    if text in COLOURS or re.fullmatch("#[0-9a-f]{6}", text):
        return COLOURS.get(text, text)
    raise ModelError(f'{what}: "{value.value}" is not a colour', hint=did_you_mean(text, COLOURS) or hint)


def words(value: Value) -> str:
    shape = values.shape(value)
    return argument_checks.shape_words(shape) if shape else describe(value)


def bare(value: Value) -> bool:
    """Whether a value contains a number other than zero without a unit."""
    if isinstance(value, tuple):
        return any(map(bare, value))
    return value.number and value.dimension is None and value.value != 0
