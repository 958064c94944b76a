"""Columns of the buffers and sizes of blocks: those of models in the plane, and those of models in space.

A pose in the plane is x, y, phi; rates, wrenches and gradients have the same three entries. A pose in space has 12
entries: the origin r and the axes x, y, z of the frame in world coordinates. Rates, wrenches and gradients in space
have 6: velocity and angular velocity, force and torque, virtual displacement and rotation, in world axes.

Loops that are the same in the plane and in space take ``C``, one of :data:`PLANE` and :data:`SPACE`, which is a
constant of their translation. Files for one of them write ``from mbdsl.kernels.columns import SPACE as C``.
"""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Columns:
    """Columns and sizes."""

    # -- columns of frames: the pose, then: ---------------------------------------------------------------------------
    AXES: int  #: of the pose in space: x axis, y axis, z axis; the origin is before them
    RATE: int  #: rates of the pose
    WRENCH: int  #: accumulated force and torque
    LEVER: int  #: from the centre of mass to the origin, of frames on rigid bodies
    MU_WRENCH: int  #: wrench of mu
    PAST_WRENCH: int  #: wrench of psi
    PAST_LEVER: int  #: lever; this and the wrench of psi are those of the pose at the start of the step
    COLUMNS: int
    POSE: int  #: entries of a rate, of a wrench, and of a virtual displacement
    CARRIED: int  #: entries of a pose and its rates, of frames that are functions of time
    LEVERS: int  #: entries of a lever
    # -- columns of gradients: dg/dz, then: ---------------------------------------------------------------------------
    VALUE: int  #: g
    MAGNITUDE: int  #: s, of forces
    GRADIENT_RATE: int  #: rate of the gradient, w^T d^2g/dz^2
    PAST_GRADIENT: int  #: dg/dz at the start of the step
    GRADIENT_COLUMNS: int
    PAIR_POSE: int  #: entries of z (virtual displacements of both frames), and therefore of dg/dz
    # -- blocks in numbers --------------------------------------------------------------------------------------------
    SQUARE: int  #: a matrix over the poses of a pair, row by row
    HALF: int  #: the upper half of that matrix, which belongs to the first frame
    BLOCK_SIZE: int  #: a matrix over one pose
    TANGENT_SCRATCH: int  #: scratch of the tangents, at the end of numbers
    # -- records in layout --------------------------------------------------------------------------------------------
    LEAF: int  #: ints of a leaf: a frame, and the registers of the derivatives with respect to pose and rate
    MOVED: int  #: ints of a moving frame: its row; registers of pose, rates and accelerations


def _columns(carried: int, pose: int, levers: int) -> Columns:
    """The columns for poses and rates of ``carried`` entries, rates of ``pose``, and levers of ``levers``."""
    lever, pair = carried + pose, 2 * pose
    past = lever + levers + pose
    return Columns(
        AXES=3,
        RATE=carried - pose,
        WRENCH=carried,
        LEVER=lever,
        MU_WRENCH=lever + levers,
        PAST_WRENCH=past,
        PAST_LEVER=past + pose,
        COLUMNS=past + pose + levers,
        POSE=pose,
        CARRIED=carried,
        LEVERS=levers,
        VALUE=pair,
        MAGNITUDE=pair + 1,
        GRADIENT_RATE=pair + 2,
        PAST_GRADIENT=2 * pair + 2,
        GRADIENT_COLUMNS=3 * pair + 2,
        PAIR_POSE=pair,
        SQUARE=pair**2,
        HALF=pose * pair,
        BLOCK_SIZE=pose**2,
        TANGENT_SCRATCH=2 * pair**2,
        LEAF=1 + pair,
        MOVED=1 + carried + pose,
    )


PLANE, SPACE = _columns(6, 3, 2), _columns(18, 6, 3)


def columns_of(spatial: bool) -> Columns:
    """The columns of a model in the plane or in space."""
    return SPACE if spatial else PLANE
