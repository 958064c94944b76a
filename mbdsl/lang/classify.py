"""Classification of declarations by the names of their types."""

from __future__ import annotations

from collections.abc import Callable

from mbdsl.elements import find, kinds
from mbdsl.elements.kind import BodyKind, Kind
from mbdsl.errors import ModelError
from mbdsl.lang import modelica_names, quantities
from mbdsl.lang import syntax as s
from mbdsl.lang.library import SourceUnit
from mbdsl.lang.mistakes import equations
from mbdsl.lang.mistakes import kinds as other_kinds
from mbdsl.lang.mistakes import names as other_names
from mbdsl.lang.source import span_of
from mbdsl.lang.unparse import write, write_argument
from mbdsl.messages import did_you_mean

FRAME_TYPES = ("Frame", "Frame_a", "Frame_b")
VALUE_TYPES = ("", "Real", "Integer", "Boolean", "String")


def is_frame_type(name: str) -> bool:
    """Whether declarations of this type are frames or connectors."""
    return modelica_names.kind(name) in FRAME_TYPES


def classify(
    d: s.Declaration,
    unit: SourceUnit,
    around: Callable[[], list[s.Item]] = list,
    spatial: bool = False,
    defined: bool = False,
) -> str | tuple[s.Model, SourceUnit]:
    """The class of a declaration: "value", "frame", "table", the name of a kind, or a model.

    An equation defines it, so that a Force is a value, if it is ``defined``.
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
    kind = modelica_names.kind(name)
    quantity = quantities.type_unit(name) is not None
    given = defined or d.value is not None or d.prefixes & {"parameter", "constant", "input", "discrete"}
    if quantity and (_known(kind) is None or given):
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
    counterpart = other_kinds.IN_PLANE.get(kind)
    in_plane = f"in the plane it is a {counterpart}; for a model in space " if counterpart else ""
    return ModelError(
        f"{kind} belongs to models in space, and this model is in the plane",
        span_of(d.type_at),
        f"{in_plane}write `spatial model` at the beginning of the model",
    )


def no_type(
    d: s.Declaration, unit: SourceUnit, around: Callable[[], list[s.Item]] = list, spatial: bool = False
) -> ModelError:
    """The error for a declaration of an unknown type."""
    if d.prefixes & {"parameter", "constant"}:
        known = [*VALUE_TYPES[1:], *quantities.TYPES]
        return ModelError(f"`{d.type}` is not a type of a parameter", span_of(d.type_at), did_you_mean(d.type, known))
    if (foreign := equations.definition(d)) is not None:
        return ModelError(foreign[0], span_of(d.type_at), foreign[1])
    message = f"there is no kind of component or model called `{d.type}`"
    instead = other_kinds.instead(d, lambda port: _end(d, port, around()), spatial)
    if instead is not None:
        return ModelError(message, span_of(d.type_at), instead)
    known = [*kinds(spatial), *modelica_names.KINDS, "Table", "Frame", *unit.names()]
    known += (*VALUE_TYPES[1:], *quantities.TYPES) if d.value is not None or not d.arguments else ()
    hint = did_you_mean(d.type.rpartition(".")[2], known) or f"the kinds are {', '.join(kinds(spatial))}"
    return ModelError(message, span_of(d.type_at), hint)


def _end(d: s.Declaration, port: str, around: list[s.Item]) -> tuple[str, bool] | None:
    """The frame that a port of ``d`` leads to and True if it is that of a body, of the ground, or fixed to one.

    Otherwise what it is connected to, and False; None if it is not connected. Without a port, the ground.
    """
    declared = {x.name: x for x in around if isinstance(x, s.Declaration)}
    if not port:
        ground = (x for x in declared.values() if modelica_names.kind(x.type) == "Ground")
        return next(((x.name, True) for x in ground), None)
    return _leads(f"{d.name}.{port}", declared, _Joined(around, d), ())


def attached(d: s.Declaration, around: list[s.Item]) -> other_names.Attached:
    """The frames and other arguments of the declaration of a joint, except for its axis n."""
    joined, ports = _Joined(around, d), (f"{d.name}.frame_a", f"{d.name}.frame_b")
    found = [names[0] if (names := joined.of(port)) else "..." for port in ports]
    connects = any(write(e) in ports for x in around if isinstance(x, s.Connect) for e in (x.first, x.second))
    names = ("", "n", "r", "frame_a", "frame_b")
    rest = [a for a in d.arguments if a.name not in names and not modelica_names.has_no_effect(a.name, a.value)]
    return other_names.Attached((found[0], found[1]), "".join(f", {write_argument(a)}" for a in rest), connects)


class _Joined:
    """What the connections of a model, and the frames in declarations, say of which frames are the same."""

    def __init__(self, around: list[s.Item], d: s.Declaration) -> None:
        self._pairs = [(write(x.first), write(x.second)) for x in around if isinstance(x, s.Connect)]
        for x in {id(x): x for x in (*around, d)}.values():
            if isinstance(x, s.Declaration):
                free = [port for port in ("frame_a", "frame_b") if all(a.name != port for a in x.arguments)]
                named = [(a.name, a.value) for a in x.arguments if a.name in ("frame_a", "frame_b")]
                positional = [a.value for a in x.arguments if not a.name]
                for port, e in (*named, *zip(free, positional, strict=False)):
                    if isinstance(e, s.Reference):
                        self._pairs.append((f"{x.name}.{port}", write(e)))

    def of(self, frame: str) -> list[str]:
        """All names of a frame, except this one, the nearest first."""
        found = [frame]
        for name in found:
            found += [there for pair in self._pairs for here, there in (pair, pair[::-1]) if here == name]
            found[:] = dict.fromkeys(found)
        return found[1:]


def _leads(
    frame: str, declared: dict[str, s.Declaration], joined: _Joined, seen: tuple[str, ...]
) -> tuple[str, bool] | None:
    names = joined.of(frame)
    for name in names:
        owner = declared.get(name.partition(".")[0].partition("[")[0])
        if owner is None or owner.name in seen:
            continue
        kind, end = modelica_names.kind(owner.type), name.rpartition(".")[2]
        if isinstance(_known(kind), BodyKind) or any(owner.type.endswith(x) for x in other_kinds.BODIES):
            return name, True
        if is_frame_type(owner.type) and (owner.arguments or owner.value is not None):
            return name, True
        if any(owner.type.endswith(x) for x in other_kinds.FRAMES):
            if owner.type.endswith("Parts.Fixed"):
                return name, True
            other = "frame_b" if end == "frame_a" else "frame_a"
            at_other_end = _leads(f"{owner.name}.{other}", declared, joined, (*seen, owner.name))
            if at_other_end is not None and at_other_end[1]:
                return (name if end == "frame_b" else f"{owner.name}_a"), True
    return (names[0], False) if names else None
