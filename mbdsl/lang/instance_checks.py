"""What a model may not declare: unknown modifiers, misplaced shapes, changes of outer components, free equations."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

from mbdsl.elements import find
from mbdsl.elements.kind import BodyKind
from mbdsl.errors import ModelError
from mbdsl.lang import syntax as s
from mbdsl.lang.entities import TABLE_ARGUMENTS
from mbdsl.lang.mistakes import equations, events
from mbdsl.lang.modifiers import Modifier, Modifiers, refuse_inner
from mbdsl.lang.source import At, span_of
from mbdsl.lang.unparse import write
from mbdsl.messages import did_you_mean

if TYPE_CHECKING:
    from mbdsl.lang.instantiate import Instance

#: index of an element of an array -> its modifier
Elements = Mapping[tuple[int, ...], Modifier]


def refuse_unknown_modifiers(instance: Instance) -> None:
    """Refuse modifiers of names that the model does not have."""
    for name, modifier in instance.modifiers.items():
        if name not in instance.namespace.places:
            owner = instance.namespace.name or instance.model.name
            hint = did_you_mean(name, instance.namespace.places, f"{instance.model.name} has")
            raise ModelError(f"`{owner}` has no `{name}`", span_of(modifier.at), hint)


def refuse_unknown_elements(instance: Instance) -> None:
    """Refuse modifiers of elements that an array does not have."""
    for name, modifier in instance.modifiers.items():
        items = getattr(instance.namespace.members.get(name), "items", {})
        for index in modifier.elements:
            if index not in items:
                shown = f"{name}[{', '.join(map(str, index))}]"
                raise ModelError(f"there is no `{shown}` to modify", span_of(modifier.at))


def refuse_shapes(instance: Instance, d: s.Declaration, kind: object) -> None:
    """Refuse a Shape of anything except a body or the ground at its declaration."""
    from mbdsl.lang.shapes import ICON, shapes_among

    known = find(kind, instance.assembly.spatial) if isinstance(kind, str) else None
    if isinstance(known, BodyKind) and "outer" not in d.prefixes:
        return
    for shape in shapes_among(d.notes):
        if shape.name != ICON:
            what = "is declared in an enclosing model" if "outer" in d.prefixes else "is not a body"
            hint = "give it to a body or to the ground, after its declaration"
            raise ModelError(f"`{d.name}` {what}; a Shape belongs to a body", span_of(shape.at), hint)


def refuse_loose_shapes(instance: Instance) -> None:
    """Refuse a Shape in the annotation of a model; its Icon is for diagrams and is ignored."""
    for annotation in instance.content.annotations:
        for a in annotation.arguments:
            function = a.value.function if isinstance(a.value, s.Call) else None
            if "Shape" in (a.name, write(function)):
                hint = "write it after the declaration of the body: `Rod rod(...) annotation(Shape(...));`"
                raise ModelError("a Shape belongs to a body, not to a model", span_of(a.at), hint)


def check_table(d: s.Declaration, positional: Sequence[s.Expression], modifiers: Modifiers) -> None:
    """Check the names of the arguments of a Table."""
    if positional:
        raise ModelError("a Table takes `table = [...]`, or `file = ...`", span_of(positional[0].at))
    for name, modifier in modifiers.items():
        if name not in TABLE_ARGUMENTS:
            hint = did_you_mean(name, TABLE_ARGUMENTS, "a Table has")
            raise ModelError(f"a Table has no `{name}`", span_of(modifier.at), hint)
        refuse_inner(modifier, f"`{name}` of Table `{d.name}`", f"write `{name} = ...`")


def refuse_elements(d: s.Declaration, elements: Elements) -> None:
    """Single elements of an array can be modified if they are components or sub-models."""
    for index, modifier in elements.items():
        shown = f"{d.name}[{', '.join(map(str, index))}]"
        raise ModelError(f"`{shown}` cannot be modified alone", span_of(modifier.at), f"modify all of `{d.name}`")


def refuse_changes_of_outer(d: s.Declaration, given: Modifier | None) -> None:
    """Refuse changes of an outer component, whose values are given where it is declared."""
    where = d.arguments[0].at if d.arguments else d.value.at if d.value is not None else None
    if given is not None:
        where = given.at
    elif not (d.arguments or d.value is not None or d.indices):
        return
    raise ModelError(
        f"`{d.name}` is declared in a model around this one and cannot be changed here",
        span_of(where or d.at),
        f"write `outer {d.type} {d.name};`, and give it its values where it is declared",
    )


def no_equation(item: s.Relation, remedy: str | None, at: At = None) -> ModelError:
    """The error of an equation that is neither a connection nor an assertion."""
    if item.right is None:
        if (action := events.outside_of_when(item)) is not None:
            return action
        return ModelError(
            f"found `{write(item.left)}`, expected `connect(a, b);`",
            span_of(item.left.at),
        )
    if (solved := equations.solved_for_derivative(item)) is not None:
        return ModelError(
            "an equation of a state has its derivative alone on one side", span_of(at or item.left.at), solved
        )
    return ModelError(
        "mbdsl has no free equations: the equation section holds `connect(a, b);` and `der(x) = ...;`",
        span_of(at or item.left.at),
        f"give a variable its value where it is declared, `{remedy or 'Real F = 2 N*sin(3*time);'}`; "
        "initial values go under `initial equation`",
    )
