"""Shapes of bodies for pictures: ``Rod crank(...) annotation(Shape(Circle(radius = 2 cm), Line(points = {...})));``.

The names are those of Modelica's graphical annotations where the meaning is the same; the coordinates are lengths in
the axes of the body.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from difflib import get_close_matches
from math import cos, isfinite, sin

from mbdsl.errors import ModelError
from mbdsl.lang import limits, shape_values, svg_path
from mbdsl.lang import syntax as s
from mbdsl.lang.evaluate import Names, evaluate
from mbdsl.lang.source import At, placed, span_of
from mbdsl.lang.unparse import write
from mbdsl.lang.values import Value
from mbdsl.mechanism.drawn_shapes import DrawnShape, Point
from mbdsl.messages import did_you_mean

SHAPE, ICON = "Shape", "Icon"
EXAMPLE = "Polygon(points = {{0, 0}, {20, 0}, {10, 15}} mm)"
PLACED, LINED, FILLED = ("origin", "rotation"), ("lineColor", "lineThickness", "pattern"), ("fillColor", "fillPattern")
FIELDS = {
    "Polygon": ("points", *LINED, *FILLED, *PLACED),
    "Rectangle": ("extent", *LINED, *FILLED, *PLACED),
    "Circle": ("radius", "center", *LINED, *FILLED, *PLACED),
    "Ellipse": ("extent", *LINED, *FILLED, *PLACED),
    "Line": ("points", "color", "thickness", *LINED, *PLACED),
    "Path": ("d", "scale", *LINED, *FILLED, *PLACED),
}
REQUIRED = {"Polygon": "points", "Rectangle": "extent", "Circle": "radius", "Ellipse": "extent", "Line": "points"}
REQUIRED |= {"Path": "d"}
LENGTHS = ("points", "extent", "radius", "center", "origin", "lineThickness", "thickness", "scale")
#: Modelica names without the same meaning here -> the remedy
OTHERS = {
    "Text": "the page shows the names of bodies with the key L; letters are not drawn on bodies",
    "Bitmap": 'give the outline of the part: `Path(d = "M 0 0 L 10 0 ...", scale = 1 mm)`; no file is read',
    "coordinateSystem": "coordinates of a shape are lengths in the axes of the body: give them a unit, "
    "`points = {{0, 0}, {20, 0}} mm`",
    "smooth": 'give curves as `Path(d = "M 0 0 C ...", scale = 1 mm)`',
    "startAngle": 'give an arc as `Path(d = "M 10 0 A 10 10 0 0 1 0 10", scale = 1 mm)`',
    "arrow": "draw the arrowhead as a Polygon",
    "visible": "leave the shape out",
    "textString": "letters are not drawn on bodies",
    "borderPattern": "leave it out",
}
OTHERS |= {"endAngle": OTHERS["startAngle"], "closure": OTHERS["startAngle"]}
OTHERS |= {"Image": OTHERS["Bitmap"], "Picture": OTHERS["Bitmap"]}


@dataclass(frozen=True)
class Called:
    """``name(arguments)`` in an annotation."""

    name: str
    arguments: tuple[s.Argument, ...]
    at: At


def shapes_among(arguments: tuple[s.Argument, ...]) -> list[Called]:
    """The shapes among the arguments of an annotation.

    Raises
    ------
    ModelError
        If an argument is a misspelled shape; annotations of other programs are ignored.
    """
    found = []
    for argument in arguments:
        called = _called(argument)
        if called is None:
            continue
        if called.name in (SHAPE, ICON):
            if argument.value is not None and argument.name:
                hint = f"write `annotation({called.name}({EXAMPLE}))`"
                raise ModelError(f"`{called.name}` has no value", span_of(argument.at), hint)
            found.append(called)
        elif called.name in FIELDS or called.name == "graphics":
            raise ModelError(
                f"`{called.name}` is a part of a Shape", span_of(called.at), f"write `annotation(Shape({EXAMPLE}))`"
            )
        elif get_close_matches(called.name.lower(), ("shape", "icon"), cutoff=0.75):
            hint = f"write `annotation(Shape({EXAMPLE}))`"
            raise ModelError(f"there is no annotation `{called.name}`", span_of(called.at), hint)
    return found


def read_shapes(arguments: tuple[s.Argument, ...], scope: Names) -> tuple[DrawnShape, ...] | None:
    """The shapes in the annotation of a body.

    Parameters
    ----------
    arguments : tuple of Argument
        The arguments of ``annotation(...)``.
    scope : Names
        Where names in it are looked up.

    Returns
    -------
    tuple of DrawnShape or None
        None if there is no Shape; an empty Shape hides the body.

    Raises
    ------
    ModelError
        If a shape is invalid.
    """
    given = shapes_among(arguments)
    if not given:
        return None
    found: list[DrawnShape] = []
    for whole in given:
        for part in _parts(whole):
            found += _primitive(part, scope, whole.name == ICON)
    return tuple(found)


def _called(argument: s.Argument) -> Called | None:
    """``name(arguments)`` or a bare name; None for other expressions."""
    if argument.name:
        return Called(argument.name, argument.modifiers, argument.at)
    return _call(argument.value)


def _call(e: s.Expression | None) -> Called | None:
    if isinstance(e, s.Call) and len(e.function.steps) == 1:
        return Called(e.function.steps[0].name, e.arguments, e.at)
    if isinstance(e, s.Reference) and len(e.steps) == 1:
        return Called(e.steps[0].name, (), e.at)
    return None


def _parts(whole: Called) -> Iterator[Called]:
    """The polygons, circles, ... of a Shape, written as its arguments or as ``graphics = {...}``."""
    for argument in whole.arguments:
        if argument.name == "graphics":
            if not isinstance(argument.value, s.ArrayNode):
                raise ModelError("`graphics` is a list", span_of(argument.at), f"write `graphics = {{{EXAMPLE}}}`")
            items: list[tuple[Called | None, At]] = [(_call(e), e.at) for e in argument.value.items]
        else:
            named = argument.name and argument.value is not None
            items = [(None if named and argument.name not in OTHERS else _called(argument), argument.at)]
        for called, at in items:
            if called is None or called.name not in FIELDS:
                name = called.name if called is not None else argument.name
                what = f"{whole.name} has no `{name}`" if name else f"{whole.name} takes polygons, circles, ..."
                hint = OTHERS.get(name) or did_you_mean(name, FIELDS, "it has") or f"it has {', '.join(FIELDS)}"
                raise ModelError(what, span_of(at), hint)
            yield called


class _Fields:
    """The arguments of one primitive, evaluated when they are requested."""

    def __init__(self, part: Called, scope: Names, units_needed: bool = False) -> None:
        self.name, self.scope, self.units_needed = part.name, scope, units_needed
        self.given: dict[str, s.Expression] = {}
        known = FIELDS[part.name]
        for a in part.arguments:
            if not a.name or a.value is None or a.modifiers or a.indices:
                shown = write(a.value) if a.value is not None else a.name
                hint = f"write `{part.name}({REQUIRED[part.name]} = ...)`"
                raise ModelError(f"{part.name} takes arguments by name, found `{shown}`", span_of(a.at), hint)
            if a.name not in known:
                hint = OTHERS.get(a.name) or did_you_mean(a.name, known, "it has")
                raise ModelError(f"{part.name} has no `{a.name}`", span_of(a.at), hint)
            if a.name in self.given:
                raise ModelError(f"`{a.name}` is given twice", span_of(a.at))
            self.given[a.name] = a.value
        if REQUIRED[part.name] not in self.given:
            hint = f"write `{part.name}({REQUIRED[part.name]} = ...)`"
            raise ModelError(f"{part.name} needs `{REQUIRED[part.name]}`", span_of(part.at), hint)

    def read(self, name: str, check: Callable[[Value, str], object], default: object = None):
        """The checked value of an argument; its error points at it."""
        if name not in self.given:
            return default
        e = self.given[name]
        value = evaluate(e, self.scope)
        with placed(e.at):
            if self.units_needed and name in LENGTHS and shape_values.bare(value):
                hint = f"write `{name} = {write(e)} mm`"
                raise ModelError(f"`{name}` of {self.name} in an Icon has no unit; on a body it is a length", hint=hint)
            return check(value, f"`{name}` of {self.name}")

    def choice(self, name: str) -> bool | None:
        """True for ``FillPattern.Solid``, False for ``FillPattern.None``, None if nothing is given."""
        if name not in self.given:
            return None
        prefix = "FillPattern" if name == "fillPattern" else "LinePattern"
        found = write(self.given[name])
        if found not in (f"{prefix}.Solid", f"{prefix}.None"):
            hint = f"write `{prefix}.Solid` or `{prefix}.None`"
            raise ModelError(f"`{name}` of {self.name}: found `{found}`", span_of(self.given[name].at), hint)
        return found.endswith("Solid")


def _primitive(part: Called, scope: Names, units_needed: bool) -> Iterator[DrawnShape]:
    fields = _Fields(part, scope, units_needed)
    x, y = fields.read("origin", shape_values.point, (0.0, 0.0))
    phi = fields.read("rotation", shape_values.angle, 0.0)
    c, sn = cos(phi), sin(phi)

    def moved(points: tuple[Point, ...]) -> tuple[Point, ...]:
        return tuple((x + c * u - sn * w, y + sn * u + c * w) for u, w in points)

    solid, filled = fields.choice("pattern"), fields.choice("fillPattern")
    line = fields.read("lineColor", shape_values.colour) or fields.read("color", shape_values.colour, "")
    width = fields.read("lineThickness", shape_values.width) or fields.read("thickness", shape_values.width, 0.0)
    fill = fields.read("fillColor", shape_values.colour, "")
    look = {"fill": "none" if filled is False else fill, "line": "none" if solid is False else line, "width": width}
    if part.name == "Polygon":
        yield DrawnShape("area", (moved(fields.read("points", shape_values.points(3))),), **look)
    elif part.name == "Line":
        yield DrawnShape("line", (moved(fields.read("points", shape_values.points(2))),), **{**look, "fill": "none"})
    elif part.name == "Rectangle":
        (x0, y0), (x1, y1) = fields.read("extent", shape_values.extent)
        yield DrawnShape("area", (moved(((x0, y0), (x1, y0), (x1, y1), (x0, y1))),), **look)
    elif part.name in ("Circle", "Ellipse"):
        if part.name == "Circle":
            centre, radius = (
                fields.read("center", shape_values.point, (0.0, 0.0)),
                fields.read("radius", shape_values.length),
            )
            a = b = radius
        else:
            (x0, y0), (x1, y1) = fields.read("extent", shape_values.extent)
            centre, a, b = ((x0 + x1) / 2, (y0 + y1) / 2), abs(x1 - x0) / 2, abs(y1 - y0) / 2
        yield DrawnShape("ellipse", (moved((centre,)),), (a, b, phi), **look)
    else:
        scale = fields.read("scale", shape_values.length)
        if scale is None:
            hint = "write `scale = 1 mm` if the unit of the drawing is a millimetre"
            raise ModelError("Path needs `scale`, the length of one unit of its coordinates", span_of(part.at), hint)
        for form, lines in _outlines(fields, scale):
            yield DrawnShape(form, tuple(map(moved, lines)), **(look if form == "area" else {**look, "fill": "none"}))


def _outlines(fields: _Fields, scale: float) -> Iterator[tuple[str, list[tuple[Point, ...]]]]:
    """Closed and open lines of a path; its y axis points down."""
    text = fields.read("d", shape_values.text)
    try:
        found = svg_path.flattened(text)
    except svg_path.PathError as problem:
        raise ModelError(f"`d` of Path: {problem}", span_of(fields.given["d"].at)) from None
    if not found:
        raise ModelError("`d` of Path draws nothing", span_of(fields.given["d"].at), 'write `d = "M 0 0 L 10 0 ..."`')
    for form, closed in (("area", True), ("line", False)):
        lines = [tuple((scale * x, -scale * y) for x, y in points) for points, ends in found if ends is closed]
        if not all(isfinite(v) and abs(v) <= shape_values.FAR for line in lines for point in line for v in point):
            raise ModelError(
                f"`d` of Path: a coordinate is beyond {shape_values.FAR:g} m", span_of(fields.given["d"].at)
            )
        if lines:
            yield form, lines


def total(shapes: tuple[DrawnShape, ...], before: int, at: At) -> int:
    """The number of points including those of further shapes.

    Raises
    ------
    ModelError
        If there are too many points for a page.
    """
    found = before + sum(map(len, shapes))
    if found > limits.SHAPE_POINTS:
        raise ModelError(
            f"the shapes of the model have more than {limits.SHAPE_POINTS} points", span_of(at), "simplify the outlines"
        )
    return found
