"""Motion of frames at a point mass in space, with its position x as coordinates; the frames do not rotate.

r = x,   r' = v,   B = [I; 0]
"""

from mbdsl.kernels import buffer_layout as L
from mbdsl.kernels.columns import SPACE as C
from mbdsl.kernels.marks import kernel

#: record of a body in layout: first coordinate, first frame, number of frames, offset in numbers of their axes
FIRST, FRAME, COUNT, POSES = range(4)
RECORD = 4
MASS = 0  #: the mass matrix is diagonal and constant
MODEL = "mbdsl.bodies.spatial_point_mass"


@kernel
def move(block, vectors, frames, numbers, layout):
    """Write pose and rate of every frame, and zero wrenches, to frames. Reads the rows POSITION and VELOCITY."""
    for e in range(layout[block]):
        o = layout[block + 1] + RECORD * e
        k = layout[o + POSES]
        for f in range(layout[o + FRAME], layout[o + FRAME] + layout[o + COUNT]):
            for j in range(9):
                frames[f, C.AXES + j] = numbers[k + j]
            k += 9
            for j in range(3):
                frames[f, j] = vectors[L.POSITION, layout[o + FIRST] + j]
                frames[f, C.RATE + j] = vectors[L.VELOCITY, layout[o + FIRST] + j]
            for j in range(6):
                frames[f, C.WRENCH + j], frames[f, C.MU_WRENCH + j] = 0.0, 0.0


@kernel
def gather(block, wrench, lever, row, vectors, frames, layout):
    """vectors[row] += the forces on every frame, in the columns of frames from ``wrench`` on."""
    for e in range(layout[block]):
        o = layout[block + 1] + RECORD * e
        for f in range(layout[o + FRAME], layout[o + FRAME] + layout[o + COUNT]):
            for j in range(3):
                vectors[row, layout[o + FIRST] + j] += frames[f, wrench + j]


@kernel
def jacobians(block, vectors, frames, numbers, layout):
    """Write B (6 x 3) of every frame to numbers; all other entries keep their initial value, zero."""
    for e in range(layout[block]):
        o = layout[block + 1] + RECORD * e
        for f in range(layout[o + FRAME], layout[o + FRAME] + layout[o + COUNT]):
            for j in range(3):
                numbers[layout[layout[L.FRAMES] + 2 * f + 1] + 4 * j] = 1.0
