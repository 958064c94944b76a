"""The edges of the graph of a mechanism: joints and forces."""

from __future__ import annotations

from typing import NamedTuple

from mbdsl.elements.kind import JointKind
from mbdsl.mechanism.scene import Component


class Edge(NamedTuple):
    """A joint or force and the two bodies it connects. ``also`` are the other bodies that its expressions read,
    including those of joints (``reads``) whose reactions they read. Without frames, the ground is one of the two."""

    component: Component
    body_i: str
    body_j: str
    also: tuple[str, ...] = ()
    reads: tuple[str, ...] = ()

    @property
    def name(self) -> str:
        return self.component.name

    @property
    def rows(self) -> int:
        """Rows of the constraints that always hold: not those of rigid contacts."""
        return 0 if getattr(self.component.kind, "unilateral", False) else self.slots

    @property
    def slots(self) -> int:
        """Rows among the unknowns of a step, but for those of velocities that always hold."""
        rows = self.component.kind.rows if isinstance(self.component.kind, JointKind) else 0
        return rows + len(self.component.velocity_constraints) - self.velocity_rows

    @property
    def placing_rows(self) -> int:
        """Rows by which a body can be placed relative to the other one: not those of expressions, without frames."""
        return self.rows if self.component.ports else 0

    @property
    def velocity_rows(self) -> int:
        """Velocity constraints that always hold."""
        return 0 if getattr(self.component.kind, "unilateral", False) else len(self.component.velocity_constraints)

    def other(self, body: str) -> str:
        return self.body_j if body == self.body_i else self.body_i
