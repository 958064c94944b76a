"""What names of a model denote for an editor: members of models and of components, found in the syntax tree alone.

The builder of scenes resolves the same names with values (:mod:`mbdsl.lang.scope`). Here a model may be incomplete.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from mbdsl.elements import find
from mbdsl.elements.kind import BodyKind, JointKind, Kind, PairKind
from mbdsl.errors import MbdslError
from mbdsl.expressions import spatial_coordinates
from mbdsl.lang import modelica_names, quantities
from mbdsl.lang import syntax as s
from mbdsl.lang.classify import classify
from mbdsl.lang.events import assigned
from mbdsl.lang.inheritance import declarations
from mbdsl.lang.library import SourceUnit, key_of
from mbdsl.lang.states import derived
from mbdsl.mechanism import signal_names, wrenches

#: forms of entities
VALUE, FRAME, TABLE, COMPONENT, SUB_MODEL, UNKNOWN = "value", "frame", "table", "component", "sub-model", "unknown"
#: further forms of symbols: words of the language, and names that are not members of models
MODEL, ALIAS, LOOP_VARIABLE, OF_KIND, COORDINATE, WORD, SETTING = (
    *("model", "name of an import", "loop variable"),
    *("member of a kind", "coordinate", "word", "setting"),
)
#: frames that bodies have without a declaration
BODY_FRAMES = {"a": "one end of the body", "b": "the other end of the body", "c": "the centre of mass"}


@dataclass(frozen=True)
class Symbol:
    """The meaning of a name: names with equal symbols are renamed together.

    ``file`` is the key of the file that declares it, "" for words of the language; ``owner`` is the model (for frames
    of bodies: the model and the body), or the kind. ``place`` distinguishes loop variables.
    """

    form: str
    name: str
    file: str = ""
    owner: str = ""
    place: int = -1


@dataclass(frozen=True)
class Entity:
    """A member of a model: its declaration, and what its type denotes."""

    form: str
    declaration: s.Declaration
    owner: s.Model  #: the model that declares it
    unit: SourceUnit  #: the file of this model
    kind: Kind | None = None  #: of components
    model: tuple[s.Model, SourceUnit] | None = None  #: of sub-models

    @property
    def symbol(self) -> Symbol:
        form = VALUE if self.form == VALUE else COMPONENT
        return Symbol(form, self.declaration.name, key_of(self.unit.file.name), self.owner.name)


@dataclass(frozen=True)
class OfKind:
    """A parameter, signal, port or frame of a component."""

    kind: Kind
    name: str
    form: str = VALUE
    component: Entity | None = field(default=None, compare=False)
    argument: s.Argument | None = field(default=None, compare=False)  #: that declares a frame of this component

    @property
    def symbol(self) -> Symbol:
        if self.component is not None and self.argument is not None:
            declared = self.component.symbol
            return Symbol(FRAME, self.name, declared.file, f"{declared.owner}.{declared.name}")
        return Symbol(OF_KIND, self.name, owner=self.kind.name)


def entity(d: s.Declaration, owner: s.Model, unit: SourceUnit) -> Entity:
    """The entity that a declaration makes."""
    # a Force without a value is a value if an equation defines it
    unclear = d.value is None and quantities.type_unit(d.type) is not None
    defined = unclear and d.name in {*derived(owner.equations), *assigned(owner.equations)}
    try:
        found = classify(d, unit, defined=defined)
    except MbdslError:
        return Entity(UNKNOWN, d, owner, unit)
    if isinstance(found, tuple):
        return Entity(SUB_MODEL, d, owner, unit, model=found)
    if found in (VALUE, FRAME, TABLE):
        return Entity(found, d, owner, unit)
    return Entity(COMPONENT, d, owner, unit, kind=find(found, owner.spatial) or find(found, not owner.spatial))


def members(model: s.Model, unit: SourceUnit, below: tuple[s.Model, ...] = ()) -> dict[str, Entity]:
    """The members of a model by name, with those of the models that it extends; the first declaration counts."""
    found: dict[str, Entity] = {}
    for item in model.items:
        if isinstance(item, s.Extends):
            base = unit.find(item.base)
            if base is not None and len(below) < 20 and not any(base[0] is m for m in (model, *below)):
                for name, inherited in members(*base, (*below, model)).items():
                    found.setdefault(name, inherited)
        else:
            for d in declarations(item):
                found.setdefault(d.name, entity(d, model, unit))
    return found


def of_component(component: Entity) -> dict[str, OfKind]:
    """The members of a component: frames, ports, signals and parameters."""
    kind = component.kind
    assert kind is not None
    frames: list[str] = []
    if isinstance(kind, BodyKind) and not kind.is_frame:
        frames = [x for x in BODY_FRAMES if x == "c" or kind.parameter("length") is not None]
    found = {x: OfKind(kind, x, FRAME, component) for x in (*frames, *kind.ports)}
    for argument in component.declaration.arguments:
        if argument.name == "frames" and isinstance(kind, BodyKind):
            declared = (x for x in argument.modifiers if x.name)
            found |= {x.name: OfKind(kind, x.name, FRAME, component, x) for x in declared}
    for name in (*signals(kind), *(p.name for p in kind.parameters)):
        found.setdefault(name, OfKind(kind, name, VALUE, component))
    return found


def signals(kind: Kind) -> dict[str, tuple[str, str]]:
    """Signal -> (unit, description), of all that components of a kind may have."""
    found = {p.name: (p.unit, p.doc) for p in kind.parameters if p.law}
    found |= {x.name: (x.unit, x.doc) for x in kind.signals}
    found |= {x.name: (x.unit, x.doc) for x in kind.outputs}
    if isinstance(kind, JointKind):
        found |= {x.name: (x.unit, x.doc) for x in kind.resistance}
    return found


def accelerations(kind: Kind) -> Mapping[str, str]:
    """Accelerations of a body, which are results only -> units."""
    if not (isinstance(kind, BodyKind) and kind.coordinates):
        return {}
    return signal_names.accelerations(kind)


def inside(found: Entity | OfKind | None) -> Mapping[str, Entity | OfKind]:
    """The members that a name before a dot has."""
    if isinstance(found, Entity):
        if found.form == SUB_MODEL and found.model is not None:
            return members(*found.model)
        if found.form == COMPONENT:
            return of_component(found)
    return {}


def by_other_name(found: Entity | OfKind | None, name: str) -> OfKind | None:
    """The port or frame of a component that has ``name`` in Modelica: `rod.frame_a`, `pin.a`."""
    if not isinstance(found, Entity) or found.kind is None:
        return None
    kind = found.kind
    if isinstance(kind, BodyKind):
        frames = tuple(key for key, x in of_component(found).items() if x.form == FRAME)
        centred = all(a.name != "com" for a in found.declaration.arguments)
        own = modelica_names.frame_of_body(name, frames, kind.is_frame, centred)
    else:
        own = modelica_names.PORTS.get(name)
        own = own if own in kind.ports else None
    return OfKind(kind, own, FRAME, found) if own is not None else None


def is_frame(found: Entity | OfKind | None) -> bool:
    """Whether a name denotes a frame, whose members are coordinates."""
    if isinstance(found, OfKind):
        return found.form == FRAME
    if found is None:
        return False
    return found.form == FRAME or (isinstance(found.kind, BodyKind) and found.kind.is_frame)


def coordinates(found: Entity | OfKind | None) -> Mapping[str, str]:
    """The coordinates of a frame, and what an element exerts on a port, with their units; none of other things."""
    if found is None or not is_frame(found):
        return {}
    spatial = found.kind.spatial if isinstance(found, OfKind) else found.owner.spatial
    units = spatial_coordinates.UNITS if spatial else signal_names.UNITS
    on_port = isinstance(found, OfKind) and isinstance(found.kind, PairKind)
    return {**units, **wrenches.units(spatial)} if on_port else units
