"""The frame of a state x: a point at s on the x axis that moves with s' = x; B = [1, 0, ...]^T.

The loops take the ``columns`` of the plane or of space.
"""

from mbdsl.bodies.rigid_body_kernels import COUNT, FIRST, FRAME, RECORD
from mbdsl.kernels import buffer_layout as L
from mbdsl.kernels.columns import PLANE as C
from mbdsl.kernels.marks import kernel

MASS = 0  #: the mass matrix is diagonal and constant
MODEL = "mbdsl.bodies.state"


@kernel
def place(columns, block, vectors, frames, layout):
    """Write s and x of every state to its frame, and zero wrenches."""
    for e in range(layout[block]):
        o = layout[block + 1] + RECORD * e
        for f in range(layout[o + FRAME], layout[o + FRAME] + layout[o + COUNT]):
            for j in range(columns.PAST_WRENCH):
                frames[f, j] = 0.0
            frames[f, 0] = vectors[L.POSITION, layout[o + FIRST]]
            frames[f, columns.RATE] = vectors[L.VELOCITY, layout[o + FIRST]]


@kernel
def gather(block, wrench, lever, row, vectors, frames, layout):
    """vectors[row] += the force along x on every frame, in the columns of frames from ``wrench`` on."""
    for e in range(layout[block]):
        o = layout[block + 1] + RECORD * e
        for f in range(layout[o + FRAME], layout[o + FRAME] + layout[o + COUNT]):
            vectors[row, layout[o + FIRST]] += frames[f, wrench]


@kernel
def jacobians(block, vectors, frames, numbers, layout):
    """Write B of every frame to numbers; all other entries keep their initial value, zero."""
    for e in range(layout[block]):
        o = layout[block + 1] + RECORD * e
        for f in range(layout[o + FRAME], layout[o + FRAME] + layout[o + COUNT]):
            numbers[layout[layout[L.FRAMES] + 2 * f + 1]] = 1.0


@kernel
def move(block, vectors, frames, numbers, layout):
    """Write s and x of every state to its frame, and zero wrenches."""
    place(C, block, vectors, frames, layout)
