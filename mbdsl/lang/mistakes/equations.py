"""Equations and definitions of types, which the grammar accepts and mbdsl does not have, as declarations."""

from __future__ import annotations

from collections.abc import Sequence

from mbdsl.lang import quantities
from mbdsl.lang import syntax as s
from mbdsl.lang.assertions import is_assertion
from mbdsl.lang.mistakes.statements import WORDS
from mbdsl.lang.states import derivative, target_of
from mbdsl.lang.unparse import write


def definition(d: s.Declaration) -> tuple[str, str] | None:
    """Message and remedy for ``type Speed = Real(unit = "m/s")``, read as a declaration; None if it is another one."""
    if d.type not in WORDS:
        return None
    unit = next((a.value for a in d.value.arguments if a.name == "unit"), None) if isinstance(d.value, s.Call) else None
    remedy = WORDS[d.type]
    if d.type == "type" and isinstance(d.value, s.Call) and write(d.value.function) == "enumeration":
        names = [write(a.value) for a in d.value.arguments if a.value is not None]
        numbers = ", ".join(f"{name} = {k}" for k, name in enumerate(names, 1))
        remedy = f"write `parameter Integer {numbers};`, and `Integer` where `{d.name}` is used"
    elif d.type == "type" and isinstance(d.value, s.Call | s.Reference):
        base = write(d.value.function if isinstance(d.value, s.Call) else d.value)
        same = next((t for t, u in quantities.TYPES.items() if isinstance(unit, s.String) and u == unit.value), base)
        given = f", or `{write(d.value)}`" if same == base == "Real" and unit is not None else ""
        remedy = f"mbdsl defines no types: write `{same}`{given} where `{d.name}` is used"
    return f"`{d.type}` is not part of mbdsl", remedy


def variable(item: s.Relation | s.If, around: Sequence[s.Item]) -> str | None:
    """The declarations with the meaning of an equation, or of an `if` of equations, for variables; None for others."""
    declared = {d.name: d for d in around if isinstance(d, s.Declaration)}
    made = _assigned(item)
    return " ".join(f"{_head(declared.get(name), name)} = {write(e)};" for name, e in made.items()) or None


def _head(d: s.Declaration | None, name: str) -> str:
    """A declaration without its value, with its unit."""
    if d is None:
        return f"Real {name}"
    unit = next((f"(unit = {write(a.value)})" for a in d.arguments if a.name == "unit" and a.value is not None), "")
    return f"{d.type} {name}{unit}"


def solved_for_derivative(item: s.Relation) -> str | None:
    """The remedy for an equation that contains `der(x)` within an expression; None for others."""
    for side, other in ((item.left, item.right), (item.right, item.left)):
        calls = [e for e in s.inside(side) if isinstance(e, s.Call)] if side is not None else []
        found = [e for e in calls if (x := derivative(e)) is not None and len(x.steps) == 1]
        if len(found) != 1 or other is None:
            continue
        rate = write(found[0])
        if (twice := next((e for e in calls if _is_der_of(e, found[0])), None)) is not None:
            name = write(found[0].arguments[0].value)
            rest = "..." if side is not twice else write(other)
            return f"a second derivative has two states: `der({name}) = {name}_rate; der({name}_rate) = {rest};`"
        if isinstance(side, s.Binary) and side.operator == "*" and found[0] in (side.left, side.right):
            factor = side.right if side.left is found[0] else side.left
            return f"write `{rate} = ({write(other)})/({write(factor)});`"
        return f"solve it for `{rate}`: `{rate} = ...;`"
    return None


def _is_der_of(e: s.Expression, inner: s.Expression) -> bool:
    """Whether ``e`` is `der(inner)`."""
    return isinstance(e, s.Call) and write(e.function) == "der" and any(a.value is inner for a in e.arguments)


def first_equation(item: s.Item) -> s.Relation | None:
    """The first equation inside of `for` and `if` that is neither an assertion nor that of a state; None if there is
    none."""
    inner = [item] if isinstance(item, s.Relation) else getattr(item, "items", ())
    inner = [x for _, items in item.branches for x in items] if isinstance(item, s.If) else inner
    found = (x if isinstance(x, s.Relation) else first_equation(x) for x in inner)
    return next((x for x in found if x is not None and not is_assertion(x) and target_of(x) is None), None)


def _assigned(item: s.Item) -> dict[str, s.Expression]:
    """Name and value of an equation ``name = value``, or of an `if` of such equations for the same names."""
    if isinstance(item, s.Relation):
        left, right = item.left, item.right
        if not isinstance(left, s.Reference) and isinstance(right, s.Reference):
            left, right = right, left
        plain = isinstance(left, s.Reference) and len(left.steps) == 1 and not left.steps[0].indices
        return {write(left): right} if plain and right is not None else {}
    if not isinstance(item, s.If) or item.branches[-1][0] is not None:
        return {}
    inner = []
    for _, items in item.branches:
        found = [_assigned(x) for x in items]
        inner.append({name: e for each in found for name, e in each.items()} if all(found) else {})
    if any(branch.keys() != inner[0].keys() for branch in inner):
        return {}
    conditions = [c for c, _ in item.branches if c is not None]
    return {
        name: s.Choice(tuple((c, b[name]) for c, b in zip(conditions, inner[:-1], strict=True)), inner[-1][name])
        for name in inner[0]
    }
