"""Warnings about values that are valid but probably not as intended."""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Mapping

from mbdsl.elements.kind import Kind
from mbdsl.expressions import symbolic
from mbdsl.lang import syntax as s
from mbdsl.lang.modifiers import Modifier
from mbdsl.lang.source import At
from mbdsl.lang.unparse import write
from mbdsl.lang.values import Quantity, Value

#: a unit that is divided by an angle
_PER_ANGLE = re.compile(r"/\s*m?(rev|rad|deg)\b")
#: takes a message, its place and a remedy
Warn = Callable[[str, At, str], None]


def angle(warn: Warn, value: Value, e: s.Expression | None, what: str) -> None:
    """Warn about a number without unit that is an angle of more than a turn."""
    if e is None or e.at is None:  # numbers of a Builder have no units
        return
    for q in value if isinstance(value, tuple) else (value,):
        x = _bare(q)
        if x is not None and abs(x) > 2.0 * math.pi:
            warn(
                f"{what} is {x:g} rad, more than a turn: a number without unit is in radians",
                e.at,
                f"write `{_with_unit(e, x, 'deg')}`; if radians are meant, `{_with_unit(e, x, 'rad')}`",
            )
            return


def undetermined(warn: Warn, d: s.Declaration, what: str) -> None:
    """Warn about a variable that has a start and nothing that changes it."""
    hint = "set it in a `when`" if d.type in ("Integer", "Boolean") else f"write its derivative, `der({d.name}) = ...`"
    hint += f"; a constant is written `parameter {d.type} {d.name} = ...`"
    warn(f"nothing determines {what}: it keeps its start value", d.at, hint)


def pitch_per_angle(warn: Warn, owner: str, value: Value, e: s.Expression | None) -> None:
    """Warn about a pitch in mm/rev or m/rad: angles have no dimension, and a pitch is the length of a turn here."""
    if not isinstance(value, Quantity):
        return
    unit = value.unit
    if unit is not None and e is not None and e.at is not None and _PER_ANGLE.search(unit.text):
        x = value.known
        warn(
            f"the pitch of `{owner}` is a length per angle [{unit.text}], and is read as {x:.3g} m for a turn",
            e.at,
            f"the pitch is the displacement of a turn: write `pitch = {2.0 * math.pi * x:.6g} m`",
        )


def damping_alone(warn: Warn, kind: Kind, owner: str, modifiers: Mapping[str, Modifier]) -> None:
    """Warn about a number without unit for ``c`` of a spring without ``k``: in Modelica, ``c`` is the stiffness."""
    c, stiffness, damping = modifiers.get("c"), kind.parameter("k"), kind.parameter("c")
    if c is None or c.value is None or c.value.at is None or "k" in modifiers or stiffness is None or damping is None:
        return
    x = _bare(c.evaluate())
    if x:
        warn(
            f"{kind.name} `{owner}` has a damping constant c and no stiffness k",
            c.value.at,
            f"c is the stiffness in Modelica; here write `k = {x:g} {stiffness.unit}`, "
            f"or `c = {x:g} {damping.unit}` if a damper is meant",
        )


def one_by_one(warn: Warn, name: str, owner: str, rank: int, e: s.Expression) -> None:
    """Warn about an array that has a value for each of several components, and is a value of one of them, too."""
    what = "one value" if rank == 0 else "one row"
    warn(
        f"`{name}` of `{owner}`: each component of the array takes {what} of `{name}`",
        e.at,
        f"if all of them have the whole of it, write `each {name} = {write(e)}`",
    )


def hidden_signal(warn: Warn, name: str, owner: str, at: At) -> None:
    """Warn about a law with a name of the model that is that of a signal of its component, too."""
    warn(
        f"`{name}` in the law of `{owner}` is the value `{name}` of the model, not the signal `{owner}.{name}`",
        at,
        f"for the signal, write `{owner}.{name}`; if the value is meant, give it another name",
    )


def misplaced_experiment(warn: Warn, notes: tuple[s.Argument, ...], what: str) -> None:
    """Warn about the settings of a simulation in the annotation of a component or connection."""
    for part in notes:
        name = part.name or (write(part.value.function) if isinstance(part.value, s.Call) else "")
        if name.lower() == "experiment":
            at = part.at or (part.value.at if part.value is not None else None)
            warn(
                f"this `experiment` has no effect: its annotation belongs to {what}, not to the model",
                at,
                "is a `;` missing before `annotation`?",
            )


def hidden_pi(warn: Warn, name: str, value: Value | None, at: At) -> None:
    """Warn about a component or value called ``pi``, except for the number itself."""
    if name.rpartition(".")[2].partition("[")[0] != "pi":
        return
    number = getattr(value, "value", None)
    if isinstance(number, symbolic.Expr) and symbolic.is_const(number):
        number = number.value
    if isinstance(number, int | float) and math.isclose(number, math.pi, rel_tol=1e-9):
        return
    what = f", and differs from it by {abs(number - math.pi):.2g}" if isinstance(number, float | int) else ""
    warn(f"`{name}` hides the constant pi{what}", at, "give it another name, or delete it: `pi` is known")


def _with_unit(e: s.Expression, x: float, unit: str) -> str:
    """The expression ``e`` of the value ``x`` with a unit."""
    match e:
        case s.Number() | s.Unary("-", s.Number()) | s.ArrayNode():
            return f"{x:g} {unit}"
        case s.Reference() | s.Call():
            return f"{write(e)}*(1 {unit})"
    return f"({write(e)})*(1 {unit})"


def _bare(q: Value) -> float | None:
    """The value of a number without unit that is known before the start."""
    if isinstance(q, tuple) or not isinstance(q, Quantity) or not q.number or q.varying or q.dimension is not None:
        return None
    return q.known
