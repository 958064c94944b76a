"""Joints in loops of moving bodies: the rows of their origins in axes of the joint in place of axes of the world.

The hinges of a planar loop hold its bodies in their plane several times over: one row along the normal of the plane is
redundant, whatever the pose. In axes of the world this row is another one as soon as a carrier has turned the loop, and
a choice of rows that was right at the start becomes singular. In axes of the joint, the redundant row remains the same.

In a tree no row is redundant, and a planar loop with the ground as a link keeps its plane. There the rows are in axes
of the world, in which they are linear and cost less.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import fields

from mbdsl.elements.in_space.prismatic import X_A, Y_A, Z_A
from mbdsl.elements.in_space.vectors import total
from mbdsl.elements.kind import JointKind, Signal

FORCES: Mapping[str, str] = dict(
    zip(("fx", "fy", "fz"), total(("-lam[1]", X_A), ("-lam[2]", Y_A), ("-lam[3]", Z_A)), strict=True)
)


def in_axes(kind: JointKind) -> JointKind:
    """The variant of a kind in closed loops, whose first three rows are R_a^T (r_b - r_a)."""
    given = {x.name: getattr(kind, x.name) for x in fields(kind)}
    given["reactions"] = tuple(Signal(x.name, x.unit, FORCES.get(x.name, x.formula), x.doc) for x in kind.reactions)
    return JointKind(**{**given, "curved_by_rotations": False, "variant": kind.in_loops, "in_loops": ""})
