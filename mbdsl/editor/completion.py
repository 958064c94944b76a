"""What an editor offers while a model is typed."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass

from mbdsl.editor import context as c
from mbdsl.editor import descriptions
from mbdsl.editor import entities as e
from mbdsl.editor.context import Context, context
from mbdsl.editor.entities import Entity, OfKind
from mbdsl.editor.unit_proposals import proposals
from mbdsl.editor.vocabulary import words
from mbdsl.elements import kinds
from mbdsl.elements.declaration import EFFECTS, REQUIRED
from mbdsl.elements.kind import Kind
from mbdsl.lang import orientations, quantities, shapes
from mbdsl.lang import syntax as s
from mbdsl.lang.entities import EXTRAPOLATION, SMOOTHNESS, TABLE_ARGUMENTS
from mbdsl.lang.event_functions import ACTIONS
from mbdsl.lang.experiment import KEYS
from mbdsl.lang.library import SourceUnit
from mbdsl.lang.parameters import ATTRIBUTES

_STATEMENTS = (
    "parameter constant discrete input for if end extends equation initial annotation inner outer final connector"
)
_IN_EXPRESSIONS = ("if", "true", "false", "not")
_BEHIND = ("if", "then", "else", "elseif", "loop", "and", "or", "for", "annotation")
_FRAME_ARGUMENTS = ("r", "phi")


@dataclass(frozen=True)
class Proposal:
    """A proposal; ``form`` is "kind", "parameter", "signal", "frame", "unit", "keyword", "function", "type",
    "component", "model", "value" or "choice". Proposals are shown by ``rank``, then by label."""

    label: str
    form: str
    detail: str = ""
    doc: str = ""
    rank: int = 5


def complete(unit: SourceUnit, offset: int) -> tuple[int, list[Proposal]]:
    """The proposals at an offset, and the offset of the word that they replace."""
    at = context(unit.text, offset)
    model = unit.own(at.model)
    known = e.members(model, unit) if model is not None else {}
    found = {item.label: item for item in reversed(list(_items(at, known, unit)))}
    return at.start, sorted(found.values(), key=lambda item: (item.rank, item.label))


def _items(at: Context, known: Mapping[str, Entity], unit: SourceUnit) -> Iterator[Proposal]:
    expected = at.expected
    if expected == c.TOP:
        yield from _keywords(("model", "spatial", "partial", "import"))
    elif expected == c.STATEMENT:
        yield from _statement(at, known, unit)
    elif expected == c.TYPE:
        yield from _types()
    elif expected == c.BASE:
        yield from _models(unit)
    elif expected == c.END:
        yield from _keywords(("for", "if", "when"))
        yield Proposal(at.model, "model", rank=1)
    elif expected == c.MEMBER:
        yield from _members(at, known, unit)
    elif expected == c.UNIT:
        yield from (Proposal(*x) for x in proposals(_expected_unit(at, known, unit)))
        yield from _keywords(_BEHIND, 9)
    elif expected == c.FRAME:
        yield from _names(known, frames_first=True)
    elif expected == c.ARGUMENT:
        yield from _arguments(at, known, unit)
    elif expected == c.VALUE:
        yield from _values(at, known, unit)
    elif expected == c.SETTING:
        yield from _settings(at)
    elif expected == c.CHOICE:
        yield from (Proposal(choice, "choice") for choice in _choices(at, known, unit))
    elif expected == c.CONDITION:
        yield from _keywords(_BEHIND)


# -- statements -----------------------------------------------------------------------------------------------------
def _statement(at: Context, known: Mapping[str, Entity], unit: SourceUnit) -> Iterator[Proposal]:
    if at.section == c.EQUATIONS:
        yield from _keywords(("connect", "for", "if", "when", "end", "initial", "annotation"))
        yield from _functions(("assert",))
        return
    if at.section == c.EVENTS:
        yield from (_of_entity(found, 1) for found in known.values() if "discrete" in found.declaration.prefixes)
        yield from (_of_entity(found, 4) for found in known.values() if found.form in (e.VALUE, e.SUB_MODEL))
        yield from _functions(ACTIONS, 2)
        yield from _keywords(("elsewhen", "for", "if", "end"))
        return
    if at.section == c.INITIAL:
        yield from _keywords(("guess", "fixed", "for", "if", "end", "equation", "annotation"))
        yield from (_of_entity(found, 2) for found in known.values() if found.form in (e.COMPONENT, e.SUB_MODEL))
        return
    yield from (Proposal(name, "kind", "kind", descriptions.of_word(name), 2) for name in words()["kind"])
    yield from _models(unit, 3)
    yield from _keywords(_STATEMENTS.split(), 4)
    yield from _types()


def _types() -> Iterator[Proposal]:
    for name in (*words()["type"], *(x for x in quantities.TYPES if x in kinds())):
        yield Proposal(name, "type", quantities.TYPES.get(name, ""), descriptions.of_type(name), 5)


def _models(unit: SourceUnit, rank: int = 5) -> Iterator[Proposal]:
    for name in unit.names():
        if (found := unit.find(name)) is not None:
            yield Proposal(name, "model", "model", descriptions.of_model(found[0], found[1].file.name), rank)


def _functions(names: Iterable[str], rank: int = 6) -> Iterator[Proposal]:
    for name in names:
        yield Proposal(name, "function", "function", descriptions.of_word(name), rank)


def _keywords(names: Iterable[str], rank: int = 6) -> Iterator[Proposal]:
    for name in names:
        yield Proposal(name, "keyword", "", descriptions.of_word(name), rank)


# -- members and names ----------------------------------------------------------------------------------------------
def _members(at: Context, known: Mapping[str, Entity], unit: SourceUnit) -> Iterator[Proposal]:
    """Behind a dot."""
    found: Entity | OfKind | None = known.get(at.path[0])
    if found is None and at.path[0] in unit.aliases and len(at.path) == 1:
        imported = unit.aliases[at.path[0]]
        yield from (
            Proposal(m.name, "model", "model", descriptions.of_model(m, imported.file.name))
            for m in imported.file.models
        )
        return
    for name in at.path[1:]:
        found = e.inside(found).get(name)
    for x, unit in e.coordinates(found).items():
        yield Proposal(x, "signal", unit, descriptions.of_coordinate(x), 2)
    ranks = {"frame": 1, "signal": 2}
    for member in e.inside(found).values():
        item = _of_own(member, 0) if isinstance(member, OfKind) else _of_entity(member, 3)
        if item.label != "frames":
            yield Proposal(item.label, item.form, item.detail, item.doc, ranks.get(item.form, 4))


def _of_entity(found: Entity, rank: int) -> Proposal:
    d = found.declaration
    form = "value" if found.form == e.VALUE else "frame" if found.form == e.FRAME else "component"
    return Proposal(d.name, form, d.type, descriptions.of_entity(found, {}), rank)


def _of_own(found: OfKind, rank: int) -> Proposal:
    doc = descriptions.of_own(found, {})
    if found.form == e.FRAME:
        return Proposal(found.name, "frame", "frame", doc, rank)
    signals = e.signals(found.kind)
    if found.name in signals:
        return Proposal(found.name, "signal", signals[found.name][0], doc, rank)
    parameter = found.kind.parameter(found.name)
    return Proposal(found.name, "parameter", parameter.unit if parameter is not None else "", doc, rank)


def _names(known: Mapping[str, Entity], frames_first: bool = False) -> Iterator[Proposal]:
    for found in known.values():
        part = found.form in (e.COMPONENT, e.SUB_MODEL, e.FRAME)
        yield _of_entity(found, 1 if part == frames_first else 4)


# -- arguments and values -------------------------------------------------------------------------------------------
def _target(at: Context, known: Mapping[str, Entity], unit: SourceUnit) -> tuple[Entity | None, Mapping[str, Entity]]:
    """The declaration whose arguments are typed, or the part of it that nested modifiers belong to, and its members.

    Of `extends` there is no declaration, and the members are those of the base.
    """
    found, model, owner = None, None, unit.own(at.model)
    if at.declared == "extends":
        model = unit.find(at.type)
    elif owner is not None and at.declared:
        whole = known.get(at.declared)
        same = whole is not None and whole.declaration.type == at.type
        found = whole if same else e.entity(s.Declaration(frozenset(), at.type, at.declared), owner, unit)
        model = found.model if found is not None else None
    for name in at.path:
        found = e.members(*model).get(name) if model is not None else None
        model = found.model if found is not None else None
    return found, e.members(*model) if model is not None else {}


def _arguments(at: Context, known: Mapping[str, Entity], unit: SourceUnit) -> Iterator[Proposal]:
    """Names of parameters that are not given yet, and frames that a component may be attached to."""
    target, inner = _target(at, known, unit)
    yield from (_of_entity(x, 1) for name, x in inner.items() if name not in at.given)
    if target is None:
        return
    kind = target.kind
    if kind is not None:
        members = e.of_component(target)
        names = [p.name for p in kind.parameters if p.name not in at.given]
        yield from (_parameter(kind, name) for name in names)
        yield from (_of_own(members[x], 3) for x in kind.ports if x not in at.given)
    elif target.form in (e.VALUE, e.TABLE, e.FRAME):
        of_frame = tuple(orientations.PARAMETERS) if target.owner.spatial else _FRAME_ARGUMENTS
        listed = {e.VALUE: ATTRIBUTES, e.TABLE: TABLE_ARGUMENTS, e.FRAME: of_frame}[target.form]
        yield from (Proposal(x, "parameter", "", descriptions.of_setting(x), 1) for x in listed if x not in at.given)
    if not at.path and ((kind is not None and kind.ports) or target.form in (e.FRAME, e.SUB_MODEL)):
        parts = (x for x in known.values() if x.form in (e.COMPONENT, e.SUB_MODEL, e.FRAME))
        yield from (_of_entity(x, 2) for x in parts if x.declaration.name != at.declared)


def _parameter(kind: Kind, name: str) -> Proposal:
    parameter = kind.parameter(name)
    assert parameter is not None
    rank = 0 if parameter.default is REQUIRED else 1
    return Proposal(name, "parameter", parameter.unit, descriptions.of_member(kind, name), rank)


def _values(at: Context, known: Mapping[str, Entity], unit: SourceUnit) -> Iterator[Proposal]:
    """An expression."""
    target, _ = _target(at, known, unit)
    kind = target.kind if target is not None else None
    frames = kind is not None and at.parameter in kind.ports
    yield from (Proposal(f'"{x}"', "choice", rank=0) for x in _choices(at, known, unit))
    yield from _names(known, frames_first=frames)
    if frames:
        return
    parameter = kind.parameter(at.parameter) if kind is not None else None
    if parameter is not None and isinstance(parameter.default, bool):
        yield from _keywords(("true", "false"), 0)
    if kind is not None and target is not None and parameter is not None and parameter.law:
        own = {
            name: x for name, x in e.of_component(target).items() if name not in (*kind.ports, at.parameter, "frames")
        }
        yield from (_of_own(x, 2) for x in own.values() if x.form != e.FRAME and x.name not in known)
    yield from _functions(x for x in words()["function"] if x not in ACTIONS)
    yield Proposal("initial()", "function", "function", descriptions.of_word("initial"), 6)
    yield from (Proposal(x, "value", "constant", descriptions.of_word(x), 6) for x in words()["constant"])
    yield from _keywords(_IN_EXPRESSIONS, 7)


def _choices(at: Context, known: Mapping[str, Entity], unit: SourceUnit) -> tuple[str, ...]:
    """The texts that a parameter may be."""
    if at.path[:1] == ("annotation",):
        return tuple(EFFECTS) if at.parameter == "Without" else ()
    target, _ = _target(at, known, unit)
    if target is None:
        return ()
    if target.form == e.TABLE:
        return {"smoothness": SMOOTHNESS, "extrapolation": EXTRAPOLATION}.get(at.parameter, ())
    parameter = target.kind.parameter(at.parameter) if target.kind is not None else None
    return parameter.choices if parameter is not None else ()


def _settings(at: Context) -> Iterator[Proposal]:
    """Inside of an annotation."""
    inner = at.path[-1]
    if inner == "annotation":
        names: Iterable[str] = ("experiment", shapes.SHAPE)
    elif inner == "experiment":
        names = KEYS
    elif inner == shapes.SHAPE:
        names = shapes.FIELDS
    else:
        names = shapes.FIELDS.get(inner, ())
    yield from (
        Proposal(x, "parameter", KEYS[x][1] if x in KEYS else "", descriptions.of_setting(x))
        for x in names
        if x not in at.given
    )


def _expected_unit(at: Context, known: Mapping[str, Entity], unit: SourceUnit) -> str:
    """The unit of the value that is typed; "" if it is not known."""
    if at.path[:1] == ("annotation",):
        return KEYS[at.parameter][1] if at.parameter in KEYS else ""
    target, members = _target(at, known, unit)
    if (member := members.get(at.parameter)) is not None:
        return quantities.type_unit(member.declaration.type) or ""
    if target is None or (target.model is not None and at.parameter):
        return ""
    if target.kind is not None and at.parameter:
        parameter = target.kind.parameter(at.parameter)
        return parameter.unit if parameter is not None else ""
    if target.form == e.FRAME:
        return {"r": "m", "phi": "rad"}.get(at.parameter, "")
    return quantities.type_unit(at.type) or ""
