"""Motion of the frames of a point mass with q = (x, y): B = [[1, 0], [0, 1], [0, 0]] is constant."""

from mbdsl.bodies.rigid_body_kernels import COUNT, FIRST, FRAME, POSES, RECORD
from mbdsl.kernels import buffer_layout as L
from mbdsl.kernels.columns import PLANE as C
from mbdsl.kernels.marks import kernel

N = 2  #: coordinates
POINT = 3  #: floats of a frame in numbers
MASS = 0  #: the mass matrix is diagonal and constant
MODEL = "mbdsl.bodies.rigid_body"


@kernel
def move(block, vectors, frames, numbers, layout):
    """Write pose and rate of every frame, and zero wrenches, to frames. Reads the rows POSITION and VELOCITY."""
    for e in range(layout[block]):
        o = layout[block + 1] + RECORD * e
        d, f0, k = layout[o + FIRST], layout[o + FRAME], layout[o + POSES]
        for f in range(f0, f0 + layout[o + COUNT]):
            for j in range(C.PAST_WRENCH):
                frames[f, j] = 0.0
            frames[f, 0], frames[f, 1], frames[f, 2] = (
                vectors[L.POSITION, d],
                vectors[L.POSITION, d + 1],
                numbers[k + 2],
            )
            frames[f, C.RATE], frames[f, C.RATE + 1] = vectors[L.VELOCITY, d], vectors[L.VELOCITY, d + 1]
            k += POINT


@kernel
def gather(block, wrench, lever, row, vectors, frames, layout):
    """vectors[row] += B^T F of every frame, with F in the columns of frames from ``wrench`` on."""
    for e in range(layout[block]):
        o = layout[block + 1] + RECORD * e
        for f in range(layout[o + FRAME], layout[o + FRAME] + layout[o + COUNT]):
            vectors[row, layout[o + FIRST]] += frames[f, wrench]
            vectors[row, layout[o + FIRST] + 1] += frames[f, wrench + 1]


@kernel
def jacobians(block, vectors, frames, numbers, layout):
    """Write B, then (B v)_q = 0, of every frame, 3 x 2 each, to numbers."""
    for e in range(layout[block]):
        o = layout[block + 1] + RECORD * e
        for f in range(layout[o + FRAME], layout[o + FRAME] + layout[o + COUNT]):
            k = layout[layout[L.FRAMES] + 2 * f + 1]
            for j in range(2 * C.POSE * N):
                numbers[k + j] = 0.0
            numbers[k], numbers[k + N + 1] = 1.0, 1.0
