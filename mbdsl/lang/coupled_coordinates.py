"""Joints without frames, which couple coordinates: their dimensions, and the units of their signals."""

from __future__ import annotations

from collections.abc import Mapping

from mbdsl.elements.declaration import ANY
from mbdsl.elements.kind import Kind
from mbdsl.errors import ModelError
from mbdsl.expressions import symbolic
from mbdsl.expressions.printing import text
from mbdsl.expressions.symbolic import Expr
from mbdsl.lang import syntax as s
from mbdsl.lang import units
from mbdsl.lang.quantities import words
from mbdsl.lang.source import span_of
from mbdsl.lang.units import NUMBER, Dimension

LENGTH = units.dimension("m")
#: dimension of a coordinate -> its unit, and that of a generalised force on it
_UNITS = {NUMBER: ("rad", "N.m"), LENGTH: ("m", "N")}

#: functions that have no negative values, and those that have none if their arguments have none
NEVER_NEGATIVE, MONOTONE = ("abs", "sqrt", "hypot", "exp", "cosh"), ("add", "min")


def check_law(name: str, law: Expr, kind: Kind, owner: str) -> None:
    """Check that the coordinate ``name`` of the joint ``owner`` is a function of positions."""
    what, velocity = f"`{name}` of {kind.name} `{owner}`", "velocities are coupled by a VelocityConstraint"
    found = symbolic.leaves(law)
    if symbolic.is_velocity_level(law):
        if getattr(kind, "unilateral", False):
            velocity = "a gap is a distance, such as `b.x`; it reads no velocities and no states"
        raise ModelError(f"{what} depends on a velocity, expected a position or an angle", hint=velocity)
    for leaf in found:
        if leaf.op == "time" or (leaf.op == "input" and not getattr(kind, "unilateral", False)):
            hint = "a function of time is the `offset`" if "offset" in kind.law_parameters else None
            if getattr(kind, "unilateral", False):
                hint = "measure it from a body that a driver moves in this way: `b.x - table.x`"
            raise ModelError(f"{what} depends on `{text(leaf)}`, expected a function of positions alone", hint=hint)
    if not any(leaf.op == "coordinate" for leaf in found):
        hint = "it takes a coordinate of a joint or body, such as `pin.phi`, `slide.s` or `rod.b.x`"
        raise ModelError(f"{what} is constant, expected a coordinate that varies", hint=hint)
    if getattr(kind, "unilateral", False) and _never_negative(law):
        hint = "a gap is negative where the bodies overlap: write `b.x` for `abs(b.x)`, or `hypot(x, y) - r`"
        raise ModelError(f"{what} is not negative at any position, so the contact would never close", hint=hint)


def _never_negative(law: Expr) -> bool:
    """Whether the form of an expression shows that it has no negative values."""
    positive: dict[Expr, bool] = {}
    for x in symbolic.walk(law):
        of = [positive[a] for a in x.args]
        if x.op == "const":
            positive[x] = isinstance(x.value, float | int) and x.value >= 0.0
        elif x.op == "pow":
            even = symbolic.is_const(x.args[1]) and float(x.args[1].value) % 2.0 == 0.0
            positive[x] = even or of[0]
        elif x.op in ("mul", "div"):
            positive[x] = all(of) or (x.op == "mul" and x.args[0] is x.args[1])
        else:
            positive[x] = x.op in NEVER_NEGATIVE or (x.op in MONOTONE and all(of)) or (x.op == "max" and any(of))
    return positive[law]


def checked_units(kind: Kind, owner: str, given: Mapping[str, tuple[Dimension | None, s.Expression | None]]) -> dict:
    """Units of the signals of a Coupling b = ratio a + offset, by the dimensions of the ``given`` values, which are
    None for bare numbers; {} for kinds whose parameters have units.

    Raises
    ------
    ModelError
        If a and b are neither angles nor lengths, or if the dimension of the ratio or of the offset is another one.
    """
    if all(p.unit != ANY for p in kind.parameters):
        return {}
    sizes = {name: dimension for name, (dimension, _) in given.items()}
    a, b, place = sizes["a"], sizes["b"], {name: e for name, (_, e) in given.items()}
    for name in kind.coupled:
        size = sizes[name]
        if size is not None and size not in _UNITS:
            message = f"`{name}` of {kind.name} `{owner}` is {words(size)}, expected an angle or a length"
            raise ModelError(message, _span(place[name]), "as in `pin.phi`, `slide.s` or `rod.b.x`")
    expected = {"ratio": None if a is None or b is None else units_of_ratio(a, b), "offset": b}
    for name, right in expected.items():
        size = NUMBER if place[name] is None and name == "ratio" else sizes[name]  # by default it is a number
        if right is not None and size is not None and size != right:
            hint = f"b = ratio*a + offset, and {' and '.join(_said(x, sizes[x]) for x in kind.coupled)}"
            message = f"`{name}` of {kind.name} `{owner}`: found {words(size)}, expected {words(right)}"
            if place[name] is None:
                message = f"{kind.name} `{owner}` needs `{name}`, {words(right)}"
            raise ModelError(message, _span(place[name] or place["b"]), hint)
    found = {name: _UNITS[size][0] for name, size in (("a", a), ("b", b), ("offset", b)) if size is not None}
    if b is not None:
        found["force"] = _UNITS[b][1]
        if a is not None:
            found["ratio"] = "1" if a == b else f"{_UNITS[b][0]}/{_UNITS[a][0]}"
    return found


def _said(name: str, dimension: Dimension | None) -> str:
    what = {NUMBER: "an angle [rad]", LENGTH: "a length [m]", None: "a number without unit"}
    return f"{name} is {what[dimension]}"


def units_of_ratio(a: Dimension, b: Dimension) -> Dimension:
    """The dimension of b/a."""
    return tuple(y - x for x, y in zip(a, b, strict=True))


def _span(e: s.Expression | None):
    return span_of(e.at) if e is not None else None
