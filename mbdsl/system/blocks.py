"""The structure of a scene: which loops there are, and over which components. It is what code is emitted from."""

from __future__ import annotations

from dataclasses import dataclass
from types import ModuleType

from mbdsl.elements import modules
from mbdsl.elements.kind import BodyKind, ForceKind, JointKind
from mbdsl.lang.expressions import Expr, expr
from mbdsl.scene import Component, Scene


@dataclass(frozen=True)
class Block:
    """All components that one loop visits; ``role`` is "body", "joint", "spring", "law" or "gamma".

    Joints stand among the laws as well where they have friction, along the coordinate of ``module``.
    """

    role: str
    module: ModuleType
    components: tuple[Component, ...]
    driven: bool = False

    @property
    def rows(self) -> int:
        """Rows of the gradient table a component."""
        return self.module.KIND.rows

    @property
    def name(self) -> str:
        return self.module.__name__.rsplit(".", 1)[-1]

    @property
    def curved(self) -> bool:
        return getattr(self.module, "hessian", None) is not None


def find_blocks(scene: Scene) -> list[Block]:
    """The blocks of ``scene``, in the order in which their loops run."""
    table = modules()
    groups: dict[tuple, list[Component]] = {}
    by_name = {module.__name__: module for module in table.values()}
    for c in scene.components.values():
        module = table[c.kind.name]
        if isinstance(c.kind, BodyKind) and c.kind.coordinates:
            groups.setdefault((0, "body", module.motion.__name__, False), []).append(c)
        elif isinstance(c.kind, JointKind):
            if c.kind.rows:
                groups.setdefault((1, "joint", module.__name__, c.kind.driver is not None), []).append(c)
            if c.velocity_constraints:
                groups.setdefault((2, "gamma", "", False), []).append(c)
            if c.friction is not None:
                along = f"{modules.__module__}.{c.kind.friction_along}"
                groups.setdefault((4, "law", along, False), []).append(c)
        elif isinstance(c.kind, ForceKind):
            order, role = (4, "law") if by_law(c) else (3, "spring")
            groups.setdefault((order, role, module.__name__, False), []).append(c)
    blocks = []
    for key in sorted(groups):
        members = groups[key]
        if key[1] == "body":
            module = table[members[0].kind.name].motion
        else:
            # nonholonomic constraints are expressions, for which one module stands in
            module = table["VelocityConstraint"] if key[1] == "gamma" else by_name[key[2]]
        blocks.append(Block(key[1], module, tuple(members), key[3]))
    return blocks


def by_law(c: Component) -> bool:
    """Whether a force follows an expression rather than linear springs."""
    kind = c.kind
    assert isinstance(kind, ForceKind)
    return kind.springs is None or bool(kind.laws and c.values[kind.laws[0]] is not None)


def law_expressions(c: Component) -> list[Expr]:
    """The magnitudes of a force by expression, or the friction of a joint."""
    if isinstance(c.kind, ForceKind):
        return [expr(c.values[name]) for name in c.kind.laws]
    assert c.friction is not None
    return [c.friction]


def expressions(block: Block, c: Component) -> list[Expr]:
    """The expressions over frames that a component of a block brings."""
    if block.role == "law":
        return law_expressions(c)
    return list(c.velocity_constraints) if block.role == "gamma" else []


def frame_of(leaf: Expr) -> str:
    """The frame of a coordinate leaf."""
    frame, _ = leaf.value  # type: ignore[misc]
    return frame
