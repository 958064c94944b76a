"""The frames that an expression depends on, and its derivatives with respect to their motions."""

from __future__ import annotations

from mbdsl.expressions import spatial_coordinates
from mbdsl.expressions.derivatives import diff
from mbdsl.expressions.symbolic import COORDINATES, Expr, coordinate, leaves


def frames_in(root: Expr) -> list[str]:
    """The frames that an expression depends on."""
    return list(dict.fromkeys(leaf.value[0] for leaf in leaves(root) if leaf.op == "coordinate"))


def by_motion(root: Expr, frame: str, spatial: bool) -> list[Expr]:
    """Derivatives of ``root`` with respect to the pose of a frame, in space its virtual displacement and rotation."""
    if spatial:
        return spatial_coordinates.virtual(root, frame)
    return diff(root, *(coordinate(frame, key) for key in COORDINATES[:3]))


def by_rate(root: Expr, frame: str, spatial: bool) -> list[Expr]:
    """Derivatives of ``root`` with respect to the velocities of a frame."""
    return diff(
        root, *(coordinate(frame, key) for key in (spatial_coordinates.VELOCITIES if spatial else COORDINATES[3:]))
    )
