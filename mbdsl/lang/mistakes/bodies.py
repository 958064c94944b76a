"""Bodies of Modelica's MultiBody library and massless rods: the body, box, cylinder or distance with the same motion.

In BodyBox and BodyCylinder the length is that of r, from frame_a to frame_b, in any direction. The width is across it:
along y, and along x if r is along y (``widthDirection`` and ``lengthDirection`` are at their defaults).
"""

from __future__ import annotations

import math
from collections.abc import Mapping

from mbdsl.lang import syntax as s
from mbdsl.lang.mistakes.frames import Ends, Given
from mbdsl.lang.mistakes.values import (
    ZERO,
    along,
    combined,
    floats,
    is_zero,
    items,
    length,
    metres,
    number,
    numbers,
    sized,
    vector,
)
from mbdsl.lang.unparse import write

#: parameters of the inertia of a body
MOMENTS, PRODUCTS = ("I_11", "I_22", "I_33"), ("I_21", "I_31", "I_32")
DENSITY = s.Number(7700)
#: without another direction, the axis of the width of a box whose length is along x, y or z, and that of its height
_ACROSS = ((1, 2), (0, 2), (1, 0))


def inertia(given: Mapping[str, s.Expression]) -> str:
    """The moments of inertia of a body in space, or its matrix if there are products of inertia."""
    moments = [write(given[name]) if name in given else "..." for name in MOMENTS]
    if not any(name in given for name in PRODUCTS):
        return f"{{{', '.join(moments)}}}"
    xy, xz, yz = (write(given[name]) if name in given else "0" for name in PRODUCTS)
    return _matrix(((moments[0], xy, xz), (xy, moments[1], yz), (xz, yz, moments[2])))


def _matrix(rows) -> str:
    return "{" + ", ".join("{" + ", ".join(row) + "}" for row in rows) + "}"


def shape(name: str, given: Given, ends: Ends, spatial: bool) -> str:
    moments = inertia(given) if spatial else next((write(given[key]) for key in ("I_33", "I") if key in given), "...")
    m = write(given["m"]) if "m" in given else "..."
    return _body(name, m, moments, given.get("r_CM"), given.get("r"), spatial)


def _body(name: str, m: str, moments: str, com: s.Expression | None, r: s.Expression | None, spatial: bool) -> str:
    size = 3 if spatial else 2
    centre, end = items(com), items(r)
    shown = f", com = {_written(com, size)}" if centre is None or not all(map(is_zero, centre)) else ""
    b = vector(end, size) if end is not None else _written(r, size)
    return f"write `Body {name}(m = {m}, I = {moments}{shown}, frames(a = {{{', '.join('0' * size)}}}, b = {b}));`"


def _written(e: s.Expression | None, size: int) -> str:
    found = items(e)
    return write(e) if found is None else vector(found, size)


def box(name: str, given: Given, ends: Ends, spatial: bool) -> str:
    r, l, w = given.get("r"), length(given.get("r")), given.get("width")
    h, hole = given.get("height", w), given.get("innerWidth", ZERO)
    if spatial and along(r) == (0, 1) and is_zero(hole) and not _other_shape(given):
        sizes = f"length = {metres(l)}, width = {metres(w)}, height = {metres(h)}"
        text = f"Box {name}(rho = {write(_density(given))}, {sizes});"
        return f"write `{text}`, whose length is along x, from frame a to frame b"
    if l is None or w is None or h is None or _other_shape(given):
        return _uniform(name, None, [], r, spatial)
    m, moments = _cuboid(given, l, w, h)
    if not is_zero(hole):
        gone, less = _cuboid(given, l, hole, given.get("innerHeight", hole))
        m, moments = combined("-", m, gone), [combined("-", *pair) for pair in zip(moments, less, strict=True)]
    return _uniform(name, m, moments, r, spatial)


def _cuboid(given: Given, l: s.Expression, w: s.Expression, h: s.Expression) -> tuple[s.Expression, list[s.Expression]]:
    """Mass, and moments of inertia about the axes of length, width and height."""
    l, w, h = (sized(x, "m") for x in (l, w, h))
    m = combined("*", _density(given), l, w, h)
    return m, [_over(m, 12, combined("+", _square(a), _square(b))) for a, b in ((w, h), (l, h), (l, w))]


def _over(m: s.Expression, k: int, square: s.Expression) -> s.Expression:
    return combined("/", combined("*", m, square), s.Number(k))


def _square(x: s.Expression) -> s.Expression:
    return combined("*", x, x)


def cylinder(name: str, given: Given, ends: Ends, spatial: bool) -> str:
    r, l, d, hole = given.get("r"), length(given.get("r")), given.get("diameter"), given.get("innerDiameter", ZERO)
    axis = along(r)
    if spatial and not _other_shape(given):
        bore = "" if is_zero(hole) else f", bore = {_half(hole)}"
        n = ""
        if axis is None:
            n = f", n = {write(r) if r is not None else '...'}"
        elif axis != (0, 1):
            n = f", n = {floats([axis[1] * (k == axis[0]) for k in range(3)])}"
        text = f"Cylinder {name}(rho = {write(_density(given))}, length = {metres(l)}, radius = {_half(d)}{bore}{n});"
        return f"write `{text}`, with frame a at one end and frame b at the other"
    if l is None or d is None or _other_shape(given):
        return _uniform(name, None, [], r, spatial)
    outside, inside = (_square(sized(x, "m")) for x in (d, hole))
    ring, squares = outside, outside
    if not is_zero(hole):
        ring, squares = combined("-", outside, inside), combined("+", outside, inside)
    pi = s.Reference((s.NamePart("pi"),))
    m = combined("*", _density(given), combined("/", pi, s.Number(4)), ring, l)
    across = combined("+", _over(m, 12, _square(l)), _over(m, 16, squares))
    return _uniform(name, m, [ZERO, ZERO, across], r, spatial)


def _other_shape(given: Given) -> bool:
    """Whether the solid is not along r, so that mass, moments and centre of mass are left to the user."""
    return any(key in given for key in ("r_shape", "lengthDirection", "widthDirection", "length"))


def _uniform(
    name: str, m: s.Expression | None, moments: list[s.Expression], r: s.Expression | None, spatial: bool
) -> str:
    """A body with its centre of mass halfway to r, and moments about the axes of its length, width and height.

    The plane contains length and width. What consists of numbers is computed.
    """
    half, size, axis, known = items(r), 3 if spatial else 2, along(r), numbers(r)
    com = "..." if half is None else vector([combined("/", x, s.Number(2)) for x in half], size)
    com = com if known is None else floats([x / 2 for x in known[:size]])
    com = "..." if m is None else com
    values = [x for x in map(number, moments) if x is not None]
    shown = [_computed(x, "kg.m2") for x in moments]
    written = "..."
    if shown and not spatial:
        written = shown[2]
    elif shown and axis is not None:
        written = f"{{{', '.join(x for _, x in sorted(zip((axis[0], *_ACROSS[axis[0]]), shown, strict=True)))}}}"
    elif shown and known is not None and len(values) == len(moments):
        written = _matrix([[f"{x:.12g}" for x in row] for row in _turned(values, known)]) + " kg.m2"
    frames = f"frames(a = {{{', '.join('0' * size)}}}, b = {_written(r, size)})"
    mass = "..." if m is None else _computed(m, "kg")
    uniform = ", of uniform density" if m is not None else ""
    return f"write `Body {name}(m = {mass}, I = {written}, com = {com}, {frames});`{uniform}"


def _computed(e: s.Expression, unit: str) -> str:
    x = number(e)
    return write(e) if x is None else f"{x:.12g} {unit}"


def _turned(moments: list[float], r: list[float]) -> list[list[float]]:
    """R diag(moments) R^T with the axes of a box along r: length, width (in the plane of r and y), height."""
    x = [c / math.hypot(*r) for c in r]
    z = [-x[2], 0.0, x[0]]  # x cross y
    z = [c / math.hypot(*z) for c in z]
    y = [z[1] * x[2] - z[2] * x[1], z[2] * x[0] - z[0] * x[2], z[0] * x[1] - z[1] * x[0]]
    return [[sum(v * e[i] * e[k] for v, e in zip(moments, (x, y, z), strict=True)) for k in range(3)] for i in range(3)]


def _density(given: Given) -> s.Expression:
    return sized(given.get("density", DENSITY), "kg/m3")


def _half(e: s.Expression | None) -> str:
    if e is None:
        return "..."
    return metres(s.Number(e.value / 2, e.unit) if isinstance(e, s.Number) else combined("/", e, s.Number(2)))


def massless_rod(name: str, given: Given, ends: Ends, spatial: bool) -> str:
    """A rod with two joints that let it turn at its ends: a distance; with a mass, a body with this mass in its middle.

    Without moments of inertia it must not turn about its own axis: the joint at its first end is a Universal.
    """
    size, m = 3 if spatial else 2, given.get("m")
    l = given["rodLength"] if "rodLength" in given else length(given.get("rRod_ia"))
    if m is None or is_zero(m):
        return f"write `Distance {name}(length = {metres(l)});`, a rod without mass; connect it as before"
    first, second = (end[0] if (end := ends(port)) is not None else "..." for port in ("frame_a", "frame_b"))
    zeros = ", ".join("0" * size)
    middle, end = (f"{{{x}{zeros[1:]}}}" for x in (_half(l), metres(l)))
    inertia = "{0, 0, 0}" if spatial else "0"
    values = f"m = {write(sized(m, 'kg'))}, I = {inertia}, com = {middle}"
    body = f"Body {name}({values}, frames(a = {{{zeros}}}, b = {end}));"
    axes = ", n_a = {0, 0, 1}, n_b = {0, 1, 0}" if spatial else ""
    kinds = ("Universal", "Spherical") if spatial else ("Revolute", "Revolute")
    joints = f"{kinds[0]} {name}_a({first}, {name}.a{axes}); {kinds[1]} {name}_b({name}.b, {second});"
    return f"with its mass it is a body between two joints: write `{body} {joints}`, and delete its connections"
