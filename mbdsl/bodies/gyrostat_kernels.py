"""Motion of a gyrostat: a rigid body with rotors, each symmetric about its axle, which is fixed in the body.

The mass and the inertia J of all of them together, about their common centre of mass x, are constant in the axes of the
body, however the rotors turn. With the angular velocity Omega of the body, and for each rotor its angle theta, the axle
n, a unit vector, and the moment of inertia C about it:

    2 T = m v . v + Omega . J Omega + sum C (2 theta' n . Omega + theta'^2)

    J Omega' + sum C n theta'' + Omega x (J Omega + sum C theta' n) = torque
    C (n . Omega' + theta'') = n . (torque on the rotor)

Neither equation depends on theta: steps need not resolve the spin. Coordinates are those of a rigid body
(:mod:`mbdsl.bodies.spatial_rigid_body_kernels`, whose kernels do their part), then the angles theta. Frames on a rotor
have their origin on its axle; they turn by theta about it, and a last column of B, (0, R n), belongs to theta.

Record of the rotors in layout, at the offset in the body's record: their number; offset in numbers of n and C of each;
number of frames on rotors; for each of them its row in the frame table, and the number of its rotor. The slots of the
body are followed by those of (rotations, angles), then of (angles, rotations).

Source: J. Wittenburg, Dynamics of Multibody Systems (2008), section 4.6.1 (gyrostats).
"""

from math import cos, sin

from mbdsl.bodies import spatial_rigid_body_kernels as rigid
from mbdsl.bodies.spatial_rigid_body_kernels import (
    COUNT,
    FIRST,
    FRAME,
    INVERSE_INERTIA,
    PAST,
    RECORD,
    ROTATION,
    ROTORS,
    SCRATCH,
    SLOT,
    R,
    frame_jacobian,
    past_jacobian,
    step_jacobian,
)
from mbdsl.bodies.spatial_rigid_body_kernels import keep as keep
from mbdsl.kernels import buffer_layout as L
from mbdsl.kernels.columns import SPACE
from mbdsl.kernels.marks import kernel, rare
from mbdsl.numerics.rotation import inverse_tangent, product, turned, turned_back

ROTOR = 4  #: floats of a rotor in numbers: n, C
ANGLES = 6  #: coordinates of the body before the angles
MASS = 1  #: the mass matrix is constant in body axes
MODEL = "mbdsl.bodies.gyrostat"


@kernel
def move(block, vectors, frames, numbers, layout):
    """As of a rigid body; then turn the frames on rotors."""
    rigid.move(block, vectors, frames, numbers, layout)
    for e in range(layout[block]):
        o = layout[block + 1] + RECORD * e
        d, own, r = layout[o + FIRST] + ANGLES, numbers[layout[o + ROTATION] :], layout[o + ROTORS]
        for k in range(layout[r + 2]):
            f, i = layout[r + 3 + 2 * k], layout[r + 4 + 2 * k]
            nx, ny, nz = axle(i, r, own, numbers, layout)
            theta, rate = vectors[L.POSITION, d + i], vectors[L.VELOCITY, d + i]
            turn_axes(f, cos(theta), sin(theta), nx, ny, nz, frames)
            frames[f, SPACE.RATE + 3] += rate * nx
            frames[f, SPACE.RATE + 4] += rate * ny
            frames[f, SPACE.RATE + 5] += rate * nz


@kernel
def axle(i, r, attitude_of, numbers, layout):
    """n of rotor ``i`` of the record at ``r``, turned by the matrix ``attitude_of``."""
    at = numbers[layout[r + 1] + ROTOR * i :]
    return turned(attitude_of, at[0], at[1], at[2])


@kernel
def turn_axes(f, c, s, nx, ny, nz, frames):
    """Turn the axes of frame ``f`` about n by the angle with this cosine and sine."""
    for j in range(SPACE.AXES, SPACE.AXES + 9, 3):
        x, y, z = frames[f, j], frames[f, j + 1], frames[f, j + 2]
        along = (1.0 - c) * (nx * x + ny * y + nz * z)
        frames[f, j] = c * x + s * (ny * z - nz * y) + along * nx
        frames[f, j + 1] = c * y + s * (nz * x - nx * z) + along * ny
        frames[f, j + 2] = c * z + s * (nx * y - ny * x) + along * nz


@kernel
def gather(block, wrench, lever, row, vectors, frames, numbers, layout):
    """As of a rigid body; and vectors[row] += the torques about the axles."""
    rigid.gather(block, wrench, lever, row, vectors, frames, numbers, layout)
    for e in range(layout[block]):
        o = layout[block + 1] + RECORD * e
        own = numbers[layout[o + ROTATION] + (PAST if row == L.PAST_FORCE else R) :]
        d, r = layout[o + FIRST] + ANGLES, layout[o + ROTORS]
        for k in range(layout[r + 2]):
            f, i = layout[r + 3 + 2 * k], layout[r + 4 + 2 * k]
            nx, ny, nz = axle(i, r, own, numbers, layout)
            vectors[row, d + i] += nx * frames[f, wrench + 3] + ny * frames[f, wrench + 4] + nz * frames[f, wrench + 5]


@kernel
def jacobians(block, vectors, frames, numbers, layout):
    for e in range(layout[block]):
        o = layout[block + 1] + RECORD * e
        d, own = layout[o + FIRST] + 3, numbers[layout[o + ROTATION] :]
        wx, wy, wz = turned(own, vectors[L.VELOCITY, d], vectors[L.VELOCITY, d + 1], vectors[L.VELOCITY, d + 2])
        for f in range(layout[o + FRAME], layout[o + FRAME] + layout[o + COUNT]):
            B = layout[L.FRAMES] + 2 * f
            frame_jacobian(f, layout[B], wx, wy, wz, frames, numbers[layout[B + 1] :])
        of_angles(o, R, numbers, layout)


@kernel
def of_angles(o, attitude_at, numbers, layout):
    """Write the columns (0, R n) of B, with the R at the offset ``attitude_at`` of the body's rotation."""
    own, r = numbers[layout[o + ROTATION] + attitude_at :], layout[o + ROTORS]
    for k in range(layout[r + 2]):
        B = numbers[layout[layout[L.FRAMES] + 2 * layout[r + 3 + 2 * k] + 1] :]
        # rows of seven columns; the last three contain the angular velocity
        B[27], B[34], B[41] = axle(layout[r + 4 + 2 * k], r, own, numbers, layout)


@kernel
def step_jacobians(block, cK, cD, vectors, frames, numbers, layout):
    for e in range(layout[block] if layout[L.CHART] else 0):
        o = layout[block + 1] + RECORD * e
        W = numbers[layout[o + ROTATION] + SCRATCH :]
        rigid.velocity_by_turn(layout[L.CHART], cK, cD, layout[o + FIRST] + 3, vectors, numbers[layout[o + ROTATION] :])
        for f in range(layout[o + FRAME], layout[o + FRAME] + layout[o + COUNT]):
            B = layout[L.FRAMES] + 2 * f
            step_jacobian(f, layout[B], W, frames, numbers[layout[B + 1] :])
        of_angles(o, R, numbers, layout)


@kernel
def past_jacobians(block, cG, frames, numbers, layout):
    for e in range(layout[block] if cG != 0.0 else 0):
        o = layout[block + 1] + RECORD * e
        own = numbers[layout[o + ROTATION] :]
        Q = own[SCRATCH:]
        rigid.turn_since(own, Q)
        for f in range(layout[o + FRAME], layout[o + FRAME] + layout[o + COUNT]):
            B = layout[L.FRAMES] + 2 * f
            past_jacobian(f, layout[B], Q, frames, numbers[layout[B + 1] :])
        of_angles(o, PAST, numbers, layout)


@kernel
def stiffness(block, cK, frames, numbers, layout, matrix):
    """matrix += -cK d(B^T F)/dq; of the torque about an axle, R n . tau, it is (R n x tau) in the axes of the world."""
    rigid.stiffness(block, cK, frames, numbers, layout, matrix)
    add_stiffness_on_rotors(block, cK, SPACE.WRENCH, frames, numbers, layout, matrix)


@rare
def add_stiffness_on_rotors(block, cK, wrench, frames, numbers, layout, matrix):
    if cK == 0.0:  # as in ``rigid.add_stiffness``
        return
    for e in range(layout[block]):
        o = layout[block + 1] + RECORD * e
        own, r = numbers[layout[o + ROTATION] :], layout[o + ROTORS]
        slots = layout[layout[L.SLOTS] + layout[o + SLOT] + 9 + 3 * layout[r] :]
        for k in range(layout[r + 2]):
            f, i = layout[r + 3 + 2 * k], layout[r + 4 + 2 * k]
            nx, ny, nz = axle(i, r, own, numbers, layout)
            tx, ty, tz = frames[f, wrench + 3], frames[f, wrench + 4], frames[f, wrench + 5]
            matrix[slots[3 * i]] -= cK * (ny * tz - nz * ty)
            matrix[slots[3 * i + 1]] -= cK * (nz * tx - nx * tz)
            matrix[slots[3 * i + 2]] -= cK * (nx * ty - ny * tx)


@kernel
def forces(block, vectors, numbers, layout):
    """vectors[FORCE] -= Omega x (J Omega + sum C theta' n)."""
    rigid.forces(block, vectors, numbers, layout)
    for e in range(layout[block]):
        o = layout[block + 1] + RECORD * e
        d = layout[o + FIRST] + 3
        x, y, z = vectors[L.VELOCITY, d], vectors[L.VELOCITY, d + 1], vectors[L.VELOCITY, d + 2]
        hx, hy, hz = momentum(o, L.VELOCITY, vectors, numbers, layout)
        vectors[L.FORCE, d] -= y * hz - z * hy
        vectors[L.FORCE, d + 1] -= z * hx - x * hz
        vectors[L.FORCE, d + 2] -= x * hy - y * hx


@kernel
def momentum(o, row, vectors, numbers, layout):
    """sum C n vectors[row, theta], in body axes."""
    d, r = layout[o + FIRST] + ANGLES, layout[o + ROTORS]
    hx, hy, hz = 0.0, 0.0, 0.0
    for i in range(layout[r]):
        at = numbers[layout[r + 1] + ROTOR * i :]
        h = at[3] * vectors[row, d + i]
        hx, hy, hz = hx + h * at[0], hy + h * at[1], hz + h * at[2]
    return hx, hy, hz


@kernel
def inertia(block, task, row, target, vectors, numbers, layout):
    """vectors[target] += (M without its diagonal) vectors[row], or = M^{-1} vectors[row].

    With (J - sum C n n^T)^{-1} in the place of the inverse inertia, and the forces (tau, Q) on rotations and angles,
    the inverse is Omega' = (J - sum C n n^T)^{-1} (tau - sum n Q), theta'' = Q/C - n . Omega'.
    """
    rigid.inertia(block, task, row, target, vectors, numbers, layout)
    for e in range(layout[block]):
        o = layout[block + 1] + RECORD * e
        d, r = layout[o + FIRST] + 3, layout[o + ROTORS]
        if task == L.TIMES:
            hx, hy, hz = momentum(o, row, vectors, numbers, layout)
            vectors[target, d] += hx
            vectors[target, d + 1] += hy
            vectors[target, d + 2] += hz
        else:
            x, y, z = vectors[row, d], vectors[row, d + 1], vectors[row, d + 2]
            for i in range(layout[r]):
                at, Q = numbers[layout[r + 1] + ROTOR * i :], vectors[row, d + 3 + i]
                x, y, z = x - Q * at[0], y - Q * at[1], z - Q * at[2]
            ax, ay, az = turned(numbers[layout[o + ROTATION] + INVERSE_INERTIA :], x, y, z)
            vectors[target, d], vectors[target, d + 1], vectors[target, d + 2] = ax, ay, az
        for i in range(layout[r]):
            at = numbers[layout[r + 1] + ROTOR * i :]
            if task == L.TIMES:
                x, y, z = vectors[row, d], vectors[row, d + 1], vectors[row, d + 2]
                vectors[target, d + 3 + i] += at[3] * (at[0] * x + at[1] * y + at[2] * z)
            else:
                x, y, z = vectors[target, d], vectors[target, d + 1], vectors[target, d + 2]
                vectors[target, d + 3 + i] = vectors[row, d + 3 + i] / at[3] - (at[0] * x + at[1] * y + at[2] * z)


@rare
def tangents(block, factors, vectors, numbers, layout, matrix):
    """matrix += -cD R h~ T^{-1} R^T with h = sum C theta' n, of rotations; R C (cM n + cD Omega x n) in the columns of
    angles, cM C n^T T^{-1} R^T in their rows; with T as of a rigid body."""
    cM, cK, cD = factors.cM, factors.cK, factors.cD
    rigid.tangents(block, factors, vectors, numbers, layout, matrix)
    for e in range(layout[block]):
        o = layout[block + 1] + RECORD * e
        d, own, r = layout[o + FIRST] + 3, numbers[layout[o + ROTATION] :], layout[o + ROTORS]
        S, P, T = own[SCRATCH:], own[SCRATCH + 9 :], own[SCRATCH + 18 :]
        slots = layout[layout[L.SLOTS] + layout[o + SLOT] :]
        set_turn(layout[L.CHART] == 1 and (cK != 0.0 or cD != 0.0), vectors[L.POSITION, d:], T)
        add_in_rows(cM, r, own, T, numbers, layout, slots, matrix)
        hx, hy, hz = momentum(o, L.VELOCITY, vectors, numbers, layout)
        S[0], S[1], S[2] = 0.0, cD * hz, -cD * hy
        S[3], S[4], S[5] = -cD * hz, 0.0, cD * hx
        S[6], S[7], S[8] = cD * hy, -cD * hx, 0.0
        product(S, T, P)
        product(own[R:], P, S)
        for i in range(3):
            for j in range(3):
                matrix[slots[3 * i + j]] += (
                    S[3 * i] * own[R + 3 * j] + S[3 * i + 1] * own[R + 3 * j + 1] + S[3 * i + 2] * own[R + 3 * j + 2]
                )
        wx, wy, wz = vectors[L.VELOCITY, d], vectors[L.VELOCITY, d + 1], vectors[L.VELOCITY, d + 2]
        for i in range(layout[r]):
            at = numbers[layout[r + 1] + ROTOR * i :]
            nx, ny, nz, C = at[0], at[1], at[2], at[3]
            x = C * (cM * nx + cD * (wy * nz - wz * ny))
            y = C * (cM * ny + cD * (wz * nx - wx * nz))
            z = C * (cM * nz + cD * (wx * ny - wy * nx))
            x, y, z = turned(own, x, y, z)
            matrix[slots[9 + i]] += x
            matrix[slots[9 + layout[r] + i]] += y
            matrix[slots[9 + 2 * layout[r] + i]] += z


@kernel
def set_turn(in_step, psi, T):
    """T <- T(psi)^{-1} in a step, else the unit matrix."""
    if in_step:
        inverse_tangent(psi, T)
    else:
        for j in range(9):
            T[j] = 0.0
        T[0], T[4], T[8] = 1.0, 1.0, 1.0


@kernel
def add_in_rows(cM, r, own, T, numbers, layout, slots, matrix):
    """matrix += cM C n^T T R^T in the rows of angles, of the record of rotors at ``r``."""
    for i in range(layout[r]):
        at = numbers[layout[r + 1] + ROTOR * i :]
        x, y, z = turned_back(T, at[0], at[1], at[2])
        x, y, z = turned(own, x, y, z)
        first = 9 + 3 * layout[r] + 3 * i
        matrix[slots[first]] += cM * at[3] * x
        matrix[slots[first + 1]] += cM * at[3] * y
        matrix[slots[first + 2]] += cM * at[3] * z


@rare
def step_tangents(block, factors, vectors, frames, numbers, layout, matrix):
    """As of a rigid body, with the angles' rows cM C n^T (T^{-1} - I) R^T."""
    cM, cU = factors.cM, factors.cU
    rigid.step_tangents(block, factors, vectors, frames, numbers, layout, matrix)
    if cU == 0.0:
        return
    add_stiffness_on_rotors(block, -cU, SPACE.MU_WRENCH, frames, numbers, layout, matrix)
    for e in range(layout[block] if layout[L.CHART] == 1 else 0):
        o = layout[block + 1] + RECORD * e
        own = numbers[layout[o + ROTATION] :]
        Q = own[SCRATCH + 18 :]
        inverse_tangent(vectors[L.POSITION, layout[o + FIRST] + 3 :], Q)
        for j in range(3):
            Q[4 * j] -= 1.0
        slots = layout[layout[L.SLOTS] + layout[o + SLOT] :]
        add_in_rows(cM, layout[o + ROTORS], own, Q, numbers, layout, slots, matrix)
