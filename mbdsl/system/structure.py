"""The structure of a scene: the loops and their components, from which code is emitted."""

from __future__ import annotations

import importlib
from dataclasses import dataclass
from types import ModuleType

from mbdsl.elements import Declared, declaring, find, loaded, modules
from mbdsl.elements.kind import BodyKind, ForceKind, JointKind
from mbdsl.expressions.symbolic import Expr, const, expr
from mbdsl.mechanism.contacts import friction_kind, is_contact, rubbing
from mbdsl.mechanism.scene import Component, Scene
from mbdsl.mechanism.sticking import Sticking
from mbdsl.system.body_models import motion_module, motion_modules


@dataclass(frozen=True)
class Block:
    """All components of one loop; ``role`` is "body", "joint", "spring", "law" or "gamma".

    Joints with friction are also among the laws, along the coordinate of ``module``.
    """

    role: str
    module: ModuleType | Declared
    components: tuple[Component, ...] = ()
    driven: bool = False

    @property
    def rows(self) -> int:
        """Number of rows of the gradient table for each component."""
        return self.module.KIND.rows

    @property
    def spatial(self) -> bool:
        """Whether it belongs to a model in space."""
        return ".in_space." in self.module.__name__

    @property
    def name(self) -> str:
        return self.module.__name__.rsplit(".", 1)[-1]

    @property
    def coupled(self) -> bool:
        """Whether its joints contain a function of a coordinate."""
        return self.role == "joint" and bool(self._joint.functions)

    @property
    def related(self) -> bool:
        """Whether its joints are expressions over frames, which have no kernels."""
        return self.role == "joint" and bool(self._joint.relations)

    @property
    def _joint(self) -> JointKind:
        assert isinstance(self.module.KIND, JointKind)
        return self.module.KIND

    @property
    def curved(self) -> bool:
        return isinstance(self.module, Declared) and self.module.curved


def find_blocks(scene: Scene, general: bool = False) -> list[Block]:
    """The blocks of ``scene``, in the order of their loops; if ``general``, with empty ones of all other kinds."""
    groups: dict[tuple, list[Component]] = {}
    if general:
        groups = {key: [] for module in modules(scene.spatial).values() for key in _every_key(module)}
    declared = {kind: declaring(kind) for kind in {c.kind for c in scene.components.values()}}
    for c in scene.components.values():
        module = declared[c.kind]
        if isinstance(c.kind, BodyKind) and c.kind.coordinates:
            groups.setdefault((0, "body", motion_module(c).__name__, False), []).append(c)
        elif isinstance(c.kind, JointKind):
            if c.kind.rows:
                groups.setdefault((1, "joint", module.__name__, c.kind.driver is not None), []).append(c)
            if c.velocity_constraints:
                groups.setdefault(_GAMMA, []).append(c)
            if is_contact(c) and c.velocity_constraints:
                kind = friction_kind(c.kind.spatial)
                groups.setdefault((4, "law", declaring(kind).__name__, False), []).extend(friction_of(c, kind))
            elif c.friction is not None:
                groups.setdefault((4, "law", _along(c.kind), False), []).append(c)
        elif isinstance(c.kind, ForceKind):
            order, role = (4, "law") if by_law(c) else (3, "spring")
            groups.setdefault((order, role, module.__name__, False), []).append(c)
    for row in (row for joint in scene.sticking for row in rows_holding(joint, scene.spatial)):
        groups.setdefault((1, "joint", declaring(row.kind).__name__, True), []).append(row)
    return [Block(key[1], kernels_of(key[2]), tuple(groups[key]), key[3]) for key in sorted(groups)]


def friction_of(contact: Component, kind: ForceKind) -> list[Component]:
    """The friction of a rigid contact on each frame that slides, which are no components of the scene. In space it is
    not searched for peaks: it is no law of the model, and has many terms."""
    more = {"searched": None} if kind.spatial else {}
    return [
        Component(
            f"{contact.name}.friction({frame})",
            kind,
            dict(zip(kind.laws, loads, strict=True)) | more,
            {"frame_a": frame, "frame_b": frame},
            span=contact.span,
        )
        for frame, loads in rubbing(contact.name, contact.velocity_constraints, kind.spatial)
    ]


def rows_holding(joint: Sticking, spatial: bool) -> list[Component]:
    """The rows that hold a joint whose friction sticks, which are no components of the scene."""
    kind = find("Coupling", spatial)
    assert kind is not None
    given = {"a": const(0.0), "ratio": 1.0, "offset": const(0.0)}
    return [
        Component(name, kind, {**given, "b": row}, span=joint.span, relations=(row,))
        for name, row in zip(joint.rows, joint.holds, strict=True)
    ]


def kernels_of(name: str) -> ModuleType | Declared:
    """The kernels of this name: of bodies, or of a kind."""
    return loaded(name) if name.startswith("mbdsl.elements.") else importlib.import_module(name)


#: nonholonomic constraints are expressions; one module represents them
_GAMMA = (2, "gamma", f"{modules.__module__}.velocity_constraint", False)


def _along(kind: JointKind) -> str:
    """The module whose kernels define the coordinate of friction."""
    return f"{modules.__module__}{'.in_space' if kind.spatial else ''}.{kind.friction_along}"


def _every_key(module: Declared) -> list[tuple]:
    """The blocks that components of a kind may belong to."""
    kind, name = module.KIND, module.__name__
    if isinstance(kind, BodyKind):
        return [(0, "body", m.__name__, False) for m in motion_modules(module)] if kind.coordinates else []
    if isinstance(kind, ForceKind):
        return [(4, "law", name, False)] + ([(3, "spring", name, False)] if kind.springs is not None else [])
    if not isinstance(kind, JointKind):
        return []
    keys: list[tuple] = [(1, "joint", name, kind.driver is not None)] if kind.rows else [_GAMMA]
    return [*keys, (4, "law", _along(kind), False)] if kind.friction_along else keys


def by_law(c: Component) -> bool:
    """Whether a force is given by an expression rather than linear springs."""
    kind = c.kind
    assert isinstance(kind, ForceKind)
    return kind.springs is None or bool(kind.laws and c.values[kind.laws[0]] is not None)


def law_expressions(c: Component) -> list[Expr]:
    """The magnitudes of a force that is given by an expression, or the friction of a joint."""
    if isinstance(c.kind, ForceKind):
        return [expr(c.values[name]) for name in c.kind.laws]
    assert c.friction is not None
    return list(c.friction_rows) or [c.friction]


def expressions(block: Block, c: Component) -> list[Expr]:
    """The expressions over frames that a component contributes to a block."""
    if block.role == "law":
        return law_expressions(c)
    if block.related:
        return list(c.relations)
    return list(c.velocity_constraints) if block.role == "gamma" else []
