"""Motion of frames on a planar rigid body with the coordinates q = (x, y, phi) of its centre of mass.

For a frame at s (body axes), l = A(phi) s:

    r = (x, y) + l,  phi_f = phi + phi0
    B = dz/dq = [[1, 0, -l_y], [0, 1, l_x], [0, 0, 1]],   (B v)_q = [[0, 0, -l_x w], [0, 0, -l_y w], [0, 0, 0]]
    d(B^T F)/dq = -(l . F) in (phi, phi)

Joints and forces access a body through these functions only.
"""

from math import cos, sin

from mbdsl.kernels import buffer_layout as L
from mbdsl.kernels.columns import PLANE as C
from mbdsl.kernels.marks import kernel

#: record of a body in layout: first coordinate, first frame, number of frames, offset in numbers of the frames'
#: (s_x, s_y, phi0), slot of (phi, phi) in the iteration matrix
FIRST, FRAME, COUNT, POSES, SLOT = range(5)
RECORD = 5
POINT = 3  #: floats of a frame in numbers: s_x, s_y, phi0
MASS = 0  #: the mass matrix is diagonal and constant
MODEL = "mbdsl.bodies.rigid_body"


@kernel
def move(block, vectors, frames, numbers, layout):
    """Write pose, rate and lever of every frame, and zero wrenches, to frames. Reads the rows POSITION and VELOCITY."""
    for e in range(layout[block]):
        o = layout[block + 1] + RECORD * e
        d, f0, k = layout[o + FIRST], layout[o + FRAME], layout[o + POSES]
        x, y, phi = vectors[L.POSITION, d], vectors[L.POSITION, d + 1], vectors[L.POSITION, d + 2]
        vx, vy, w = vectors[L.VELOCITY, d], vectors[L.VELOCITY, d + 1], vectors[L.VELOCITY, d + 2]
        c, s = cos(phi), sin(phi)
        for f in range(f0, f0 + layout[o + COUNT]):
            sx, sy = numbers[k], numbers[k + 1]
            lx, ly = c * sx - s * sy, s * sx + c * sy
            frames[f, 0], frames[f, 1], frames[f, 2] = x + lx, y + ly, phi + numbers[k + 2]
            frames[f, C.RATE], frames[f, C.RATE + 1], frames[f, C.RATE + 2] = vx - ly * w, vy + lx * w, w
            frames[f, C.LEVER], frames[f, C.LEVER + 1] = lx, ly
            frames[f, C.WRENCH], frames[f, C.WRENCH + 1], frames[f, C.WRENCH + 2] = 0.0, 0.0, 0.0
            frames[f, C.MU_WRENCH], frames[f, C.MU_WRENCH + 1], frames[f, C.MU_WRENCH + 2] = 0.0, 0.0, 0.0
            k += POINT


@kernel
def gather(block, wrench, lever, row, vectors, frames, layout):
    """vectors[row] += B^T F of every frame, with F and l in the columns of frames from ``wrench`` and ``lever`` on."""
    for e in range(layout[block]):
        o = layout[block + 1] + RECORD * e
        d = layout[o + FIRST]
        for f in range(layout[o + FRAME], layout[o + FRAME] + layout[o + COUNT]):
            fx, fy = frames[f, wrench], frames[f, wrench + 1]
            vectors[row, d] += fx
            vectors[row, d + 1] += fy
            vectors[row, d + 2] += frames[f, wrench + 2] - frames[f, lever + 1] * fx + frames[f, lever] * fy


@kernel
def collect_with_mu(block, vectors, frames, layout):
    """``gather`` of the accumulated wrenches to FORCE, and of the wrenches of mu to FORCE2, in one loop."""
    for e in range(layout[block]):
        o = layout[block + 1] + RECORD * e
        d = layout[o + FIRST]
        x, y, phi, mu_x, mu_y, mu_phi = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
        for f in range(layout[o + FRAME], layout[o + FRAME] + layout[o + COUNT]):
            lx, ly = frames[f, C.LEVER], frames[f, C.LEVER + 1]
            x += frames[f, C.WRENCH]
            y += frames[f, C.WRENCH + 1]
            phi += frames[f, C.WRENCH + 2] - ly * frames[f, C.WRENCH] + lx * frames[f, C.WRENCH + 1]
            mu_x += frames[f, C.MU_WRENCH]
            mu_y += frames[f, C.MU_WRENCH + 1]
            mu_phi += frames[f, C.MU_WRENCH + 2] - ly * frames[f, C.MU_WRENCH] + lx * frames[f, C.MU_WRENCH + 1]
        vectors[L.FORCE, d] += x
        vectors[L.FORCE, d + 1] += y
        vectors[L.FORCE, d + 2] += phi
        vectors[L.FORCE2, d] = mu_x
        vectors[L.FORCE2, d + 1] = mu_y
        vectors[L.FORCE2, d + 2] = mu_phi


@kernel
def jacobians(block, vectors, frames, numbers, layout):
    """Write B, then (B v)_q, of every frame, 3 x 3 each, to numbers. Entries that are always zero keep their initial
    value, zero."""
    for e in range(layout[block]):
        o = layout[block + 1] + RECORD * e
        w = vectors[L.VELOCITY, layout[o + FIRST] + 2]
        for f in range(layout[o + FRAME], layout[o + FRAME] + layout[o + COUNT]):
            k = layout[layout[L.FRAMES] + 2 * f + 1]
            lx, ly = frames[f, C.LEVER], frames[f, C.LEVER + 1]
            numbers[k], numbers[k + 4], numbers[k + 8] = 1.0, 1.0, 1.0
            numbers[k + 2], numbers[k + 5] = -ly, lx
            numbers[k + 11], numbers[k + 14] = -lx * w, -ly * w


@kernel
def stiffness(block, cK, frames, layout, matrix):
    """matrix += cK * (-d(B^T F)/dq) with the accumulated wrenches F, from frames."""
    if cK == 0.0:  # forces may be infinite at rest, as P/w, where M is also asked for
        return
    for e in range(layout[block]):
        o = layout[block + 1] + RECORD * e
        for f in range(layout[o + FRAME], layout[o + FRAME] + layout[o + COUNT]):
            lx, ly, fx, fy = frames[f, C.LEVER], frames[f, C.LEVER + 1], frames[f, C.WRENCH], frames[f, C.WRENCH + 1]
            matrix[layout[layout[L.SLOTS] + layout[o + SLOT]]] += cK * (lx * fx + ly * fy)
