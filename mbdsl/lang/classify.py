"""Classification of declarations by the names of their types."""

from __future__ import annotations

from collections.abc import Callable

from mbdsl.elements import find, kinds
from mbdsl.elements.kind import BodyKind, Kind
from mbdsl.errors import ModelError
from mbdsl.lang import foreign_equations, foreign_kinds, foreign_names, quantities
from mbdsl.lang import syntax as s
from mbdsl.lang.library import Unit
from mbdsl.lang.source import span_of
from mbdsl.lang.unparse import write
from mbdsl.messages import did_you_mean

FRAME_TYPES = ("Frame", "Frame_a", "Frame_b")
VALUE_TYPES = ("", "Real", "Integer", "Boolean", "String")


def is_frame_type(name: str) -> bool:
    """Whether declarations of this type are frames or connectors."""
    return foreign_names.kind(name) in FRAME_TYPES


def classify(
    d: s.Declaration, unit: Unit, around: Callable[[], list[s.Item]] = list, spatial: bool = False
) -> str | tuple[s.Model, Unit]:
    """The class of a declaration: "value", "frame", "table", the name of a kind, or a model.

    ``around()`` are the other items and equations of its model, and ``spatial`` says whether this is a model in space,
    for the message about an unknown type.
    """
    name = d.type
    if name in VALUE_TYPES:
        return "value"
    found = unit.find(name)
    if found is not None:
        return found
    if is_frame_type(name):
        return "frame"
    if name == "Table":
        return "table"
    kind = foreign_names.kind(name)
    quantity = quantities.type_unit(name) is not None
    if quantity and (_known(kind) is None or d.value is not None or d.prefixes & {"parameter", "constant", "input"}):
        return "value"
    if _known(kind) is not None:
        return kind
    raise no_type(d, unit, around, spatial)


def _known(kind: str) -> Kind | None:
    """The kind of this name, of models in the plane or in space."""
    return find(kind) or find(kind, spatial=True)


def other_dimension(kind: str, spatial: bool, d: s.Declaration) -> ModelError:
    """The error for a kind that does not exist in models of this dimension."""
    if spatial:
        return ModelError(
            f"there is no {kind} in models in space",
            span_of(d.type_at),
            f"the kinds in space are {', '.join(kinds(spatial=True))}",
        )
    counterpart = foreign_kinds.IN_PLANE.get(kind)
    in_plane = f"in the plane it is a {counterpart}; for a model in space " if counterpart else ""
    return ModelError(
        f"{kind} belongs to models in space, and this model is in the plane",
        span_of(d.type_at),
        f"{in_plane}write `spatial model` at the beginning of the model",
    )


def no_type(
    d: s.Declaration, unit: Unit, around: Callable[[], list[s.Item]] = list, spatial: bool = False
) -> ModelError:
    """The error for a declaration of an unknown type."""
    if d.prefixes & {"parameter", "constant"}:
        known = [*VALUE_TYPES[1:], *quantities.TYPES]
        return ModelError(f"`{d.type}` is not a type of a parameter", span_of(d.type_at), did_you_mean(d.type, known))
    if (foreign := foreign_equations.definition(d)) is not None:
        return ModelError(foreign[0], span_of(d.type_at), foreign[1])
    message = f"there is no kind of component or model called `{d.type}`"
    instead = foreign_kinds.instead(d, lambda port: _end(d, port, around()), spatial)
    if instead is not None:
        return ModelError(message, span_of(d.type_at), instead)
    known = [*kinds(spatial), *foreign_names.KINDS, "Table", "Frame", *unit.names()]
    known += (*VALUE_TYPES[1:], *quantities.TYPES) if d.value is not None or not d.arguments else ()
    hint = did_you_mean(d.type.rpartition(".")[2], known) or f"the kinds are {', '.join(kinds(spatial))}"
    return ModelError(message, span_of(d.type_at), hint)


def _end(d: s.Declaration, port: str, around: list[s.Item]) -> tuple[str, bool] | None:
    """The frame that a port of ``d`` is connected to, and whether it is that of a body; None if it is not known.

    Without a port, the ground.
    """
    if not port:
        ground = (x for x in around if isinstance(x, s.Declaration) and foreign_names.kind(x.type) == "Ground")
        return next(((x.name, True) for x in ground), None)
    found = next((a.value for a in d.arguments if a.name == port), None)
    positional = [a.value for a in d.arguments if not a.name]
    if found is None and (index := int(port == "frame_b")) < len(positional):
        found = positional[index]
    for item in around:
        if isinstance(item, s.Connect):
            for here, there in ((item.first, item.second), (item.second, item.first)):
                if write(here) == f"{d.name}.{port}":
                    found = there
    if not isinstance(found, s.Reference):
        return None
    owner = next((x for x in around if isinstance(x, s.Declaration) and x.name == found.steps[0].name), None)
    known = _known(foreign_names.kind(owner.type)) if owner is not None else None
    return write(found), isinstance(known, BodyKind)
