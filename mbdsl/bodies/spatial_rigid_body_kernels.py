"""Motion of frames on a rigid body in space, with the position x of its centre of mass and its attitude R.

R maps body axes to world axes; the velocities are v = x' in world axes and Omega in body axes, R' = R Omega~, where a~
is the matrix of the cross product a x. For a frame at s with axes R_m, both in body axes, l = R s:

    r = x + l,   A = R R_m,   r' = v + omega x l,   omega = R Omega
    B = [[I, -l~], [0, I]],   (B v)_q = [[0, -(omega x l)~], [0, -omega~]],   for small motions in world axes
    d(torque)/dtheta = tau~ + l~ F~,   of the torque in body axes, turned to world axes

Equations of motion and unknowns are in body axes (residuals J Omega' + Omega x J Omega = ...), matrices in world axes:
they change with the motion of the mechanism alone, and not with the spin of its bodies.
:mod:`mbdsl.integrators.loop.rotation_chart` turns residuals and corrections. The attitude is R = R_0 exp(psi~), with
psi in the coordinates and R_0, as a quaternion, in numbers.


Source: O. Bruels, A. Cardona, M. Arnold, Mech. Mach. Theory 48 (2012) 121-137, for the formulation on R^3 x SO(3).
"""

from mbdsl.kernels import buffer_layout as L
from mbdsl.kernels.columns import SPACE
from mbdsl.kernels.marks import kernel, rare
from mbdsl.numerics.rotation import BASE, INVERSE_INERTIA, attitude, inverse_tangent, product, turned, turned_back

#: record of a body in layout: first coordinate, first frame, number of frames, offset in numbers of the frames'
#: (s, R_m), offset in numbers of the rotation (see R below), first of nine slots of the rotations in the iteration
#: matrix, and of a body that carries rotors (:mod:`mbdsl.bodies.gyrostat_kernels`) the offset in layout of their record
FIRST, FRAME, COUNT, POSES, ROTATION, SLOT, ROTORS = range(7)
RECORD = 7
POINT = 12  #: floats of a frame in numbers: s, then the columns of R_m
#: floats of a rotation in numbers: R, row by row; the quaternion of R_0; R at the start of the step; moments of inertia
#: J, row by row, and their inverse; scratch
R, PAST, J, SCRATCH = 0, 13, 22, 40
ROTATION_SIZE = SCRATCH + 27
MASS = 1  #: the mass matrix is constant in body axes
MODEL = "mbdsl.bodies.spatial_rigid_body"


@kernel
def move(block, vectors, frames, numbers, layout):
    """Write pose, rate and lever of every frame, and zero wrenches, to frames. Reads the rows POSITION and VELOCITY."""
    for e in range(layout[block]):
        o = layout[block + 1] + RECORD * e
        d, f0, k = layout[o + FIRST], layout[o + FRAME], layout[o + POSES]
        own = numbers[layout[o + ROTATION] :]
        attitude(vectors[L.POSITION, d + 3 :], own[BASE:], own)
        wx, wy, wz = turned(own, vectors[L.VELOCITY, d + 3], vectors[L.VELOCITY, d + 4], vectors[L.VELOCITY, d + 5])
        for f in range(f0, f0 + layout[o + COUNT]):
            lx, ly, lz = turned(own, numbers[k], numbers[k + 1], numbers[k + 2])
            frames[f, SPACE.LEVER], frames[f, SPACE.LEVER + 1], frames[f, SPACE.LEVER + 2] = lx, ly, lz
            frames[f, 0], frames[f, 1], frames[f, 2] = (
                vectors[L.POSITION, d] + lx,
                vectors[L.POSITION, d + 1] + ly,
                vectors[L.POSITION, d + 2] + lz,
            )
            for j in range(3):
                ax, ay, az = turned(own, numbers[k + 3 + 3 * j], numbers[k + 4 + 3 * j], numbers[k + 5 + 3 * j])
                frames[f, SPACE.AXES + 3 * j], frames[f, SPACE.AXES + 3 * j + 1], frames[f, SPACE.AXES + 3 * j + 2] = (
                    ax,
                    ay,
                    az,
                )
            frames[f, SPACE.RATE], frames[f, SPACE.RATE + 1], frames[f, SPACE.RATE + 2] = (
                vectors[L.VELOCITY, d] + (wy * lz - wz * ly),
                vectors[L.VELOCITY, d + 1] + (wz * lx - wx * lz),
                vectors[L.VELOCITY, d + 2] + (wx * ly - wy * lx),
            )
            frames[f, SPACE.RATE + 3], frames[f, SPACE.RATE + 4], frames[f, SPACE.RATE + 5] = wx, wy, wz
            for j in range(6):
                frames[f, SPACE.WRENCH + j], frames[f, SPACE.MU_WRENCH + j] = 0.0, 0.0
            k += POINT


@kernel
def keep(block, numbers, layout):
    """At the start of a step, store R for ``gather`` of PAST_FORCE."""
    for e in range(layout[block] if layout[L.KEEP] else 0):
        own = numbers[layout[layout[block + 1] + RECORD * e + ROTATION] :]
        for j in range(9):
            own[PAST + j] = own[R + j]


@kernel
def gather(block, wrench, lever, row, vectors, frames, numbers, layout):
    """vectors[row] += B^T F of every frame, with F and l in the columns of frames from ``wrench`` and ``lever`` on; the
    torque is turned to body axes, of PAST_FORCE to those at the start of the step."""
    for e in range(layout[block]):
        o = layout[block + 1] + RECORD * e
        d, f0, count = layout[o + FIRST], layout[o + FRAME], layout[o + COUNT]
        x, y, z, tx, ty, tz = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
        for f in range(f0, f0 + count):
            fx, fy, fz = frames[f, wrench], frames[f, wrench + 1], frames[f, wrench + 2]
            lx, ly, lz = frames[f, lever], frames[f, lever + 1], frames[f, lever + 2]
            x, y, z = x + fx, y + fy, z + fz
            tx += frames[f, wrench + 3] + (ly * fz - lz * fy)
            ty += frames[f, wrench + 4] + (lz * fx - lx * fz)
            tz += frames[f, wrench + 5] + (lx * fy - ly * fx)
        own = numbers[layout[o + ROTATION] + (PAST if row == L.PAST_FORCE else R) :]
        tx, ty, tz = turned_back(own, tx, ty, tz)
        vectors[row, d] += x
        vectors[row, d + 1] += y
        vectors[row, d + 2] += z
        vectors[row, d + 3] += tx
        vectors[row, d + 4] += ty
        vectors[row, d + 5] += tz


@kernel
def jacobians(block, vectors, frames, numbers, layout):
    """Write B, then (B v)_q, of every frame, 6 x 6 each, to numbers. Entries that are always zero keep their initial
    value, zero."""
    for e in range(layout[block]):
        o = layout[block + 1] + RECORD * e
        for f in range(layout[o + FRAME], layout[o + FRAME] + layout[o + COUNT]):
            wx, wy, wz = frames[f, SPACE.RATE + 3], frames[f, SPACE.RATE + 4], frames[f, SPACE.RATE + 5]
            frame_jacobian(f, 6, wx, wy, wz, frames, numbers[layout[layout[L.FRAMES] + 2 * f + 1] :])


@kernel
def frame_jacobian(f, n, wx, wy, wz, frames, B):
    """Write B and (B v)_q of frame ``f``, 6 x n each, in their first six columns; (wx, wy, wz) is the angular velocity
    of the body in world axes."""
    C = B[6 * n :]
    lx, ly, lz = frames[f, SPACE.LEVER], frames[f, SPACE.LEVER + 1], frames[f, SPACE.LEVER + 2]
    for j in range(6):
        B[(n + 1) * j] = 1.0
    minus_cross(lx, ly, lz, n, B, 3)
    minus_cross(wy * lz - wz * ly, wz * lx - wx * lz, wx * ly - wy * lx, n, C, 3)
    minus_cross(frames[f, SPACE.RATE + 3], frames[f, SPACE.RATE + 4], frames[f, SPACE.RATE + 5], n, C, 3 * n + 3)


@kernel
def step_jacobians(block, cK, cD, vectors, frames, numbers, layout):
    """In a step, add B W = [[0, -l~ W], [0, W]] to (B v)_q of every frame."""
    for e in range(layout[block] if layout[L.CHART] else 0):
        o = layout[block + 1] + RECORD * e
        W = numbers[layout[o + ROTATION] + SCRATCH :]
        velocity_by_turn(layout[L.CHART], cK, cD, layout[o + FIRST] + 3, vectors, numbers[layout[o + ROTATION] :])
        for f in range(layout[o + FRAME], layout[o + FRAME] + layout[o + COUNT]):
            step_jacobian(f, 6, W, frames, numbers[layout[layout[L.FRAMES] + 2 * f + 1] :])


@kernel
def step_jacobian(f, n, W, frames, B):
    """Add B W to (B v)_q of frame ``f``, 6 x n each."""
    C = B[6 * n :]
    lx, ly, lz = frames[f, SPACE.LEVER], frames[f, SPACE.LEVER + 1], frames[f, SPACE.LEVER + 2]
    for j in range(3):
        x, y, z = W[j], W[3 + j], W[6 + j]
        C[(n + 1) * j + 3], C[(n + 1) * j + 3 * n + 3] = 0.0, 0.0  # not set otherwise
        for i in range(3):  # after ``past_jacobians``
            B[n * (3 + i) + 3 + j] = 1.0 if i == j else 0.0
        B[(n + 1) * j + 3] = 0.0
        C[3 + j] -= ly * z - lz * y
        C[n + 3 + j] -= lz * x - lx * z
        C[2 * n + 3 + j] -= lx * y - ly * x
        C[3 * n + 3 + j] += x
        C[4 * n + 3 + j] += y
        C[5 * n + 3 + j] += z


@kernel
def velocity_by_turn(chart, cK, cD, d, vectors, own):
    """SCRATCH <- the matrix W, in world axes, of which B W is a part of (B v)_q in a step.

    Velocities are functions of the rotation vector psi (entry ``d``) in a step, and a small rotation of the body
    changes psi by T(psi)^{-1} times that rotation. The terms of the velocity in a matrix, cD B + cK (B v)_q, have to be
    cD B T^{-1} + cK (B v)_q; hence W = cD/cK (T^{-1} - I), and zero in matrices without cD, which are derivatives by
    positions at constant velocities. For methods with accelerations psi'', W = omega~/2, to first order in psi; the
    product (Phi_q v)_q v does not depend on it.
    """
    W, q, v = own[SCRATCH:], vectors[L.POSITION, d:], vectors[L.VELOCITY, d:]
    for j in range(9):
        W[j] = 0.0
    if chart == 2:
        x, y, z = turned(own, v[0], v[1], v[2])
        W[1], W[2], W[3], W[5], W[6], W[7] = -0.5 * z, 0.5 * y, 0.5 * z, -0.5 * x, -0.5 * y, 0.5 * x
    elif cK != 0.0 and cD != 0.0:
        psi = own[SCRATCH + 9 :]
        psi[0], psi[1], psi[2] = turned(own, q[0], q[1], q[2])
        inverse_tangent(psi, W)
        for j in range(3):
            W[4 * j] -= 1.0
        for j in range(9):
            W[j] *= cD / cK


@kernel
def past_jacobians(block, cG, frames, numbers, layout):
    """If cG is not zero, overwrite B with that of the start of the step, [[I, -l~ Q^T], [0, Q^T]], for small rotations
    in the axes of which Q = R_{n+1} R_n^T makes the present ones."""
    for e in range(layout[block] if cG != 0.0 else 0):
        o = layout[block + 1] + RECORD * e
        own = numbers[layout[o + ROTATION] :]
        Q = own[SCRATCH:]
        turn_since(own, Q)
        for f in range(layout[o + FRAME], layout[o + FRAME] + layout[o + COUNT]):
            past_jacobian(f, 6, Q, frames, numbers[layout[layout[L.FRAMES] + 2 * f + 1] :])


@kernel
def turn_since(own, Q):
    """Q <- R R_n^T, the rotation since the start of the step."""
    for i in range(3):
        for j in range(3):
            Q[3 * i + j] = (
                own[R + 3 * i] * own[PAST + 3 * j]
                + own[R + 3 * i + 1] * own[PAST + 3 * j + 1]
                + own[R + 3 * i + 2] * own[PAST + 3 * j + 2]
            )


@kernel
def past_jacobian(f, n, Q, frames, B):
    """Overwrite B of frame ``f``, 6 x n."""
    lx, ly, lz = frames[f, SPACE.PAST_LEVER], frames[f, SPACE.PAST_LEVER + 1], frames[f, SPACE.PAST_LEVER + 2]
    for j in range(3):
        x, y, z = Q[3 * j], Q[3 * j + 1], Q[3 * j + 2]  # column j of Q^T
        B[3 + j], B[n + 3 + j], B[2 * n + 3 + j] = lz * y - ly * z, lx * z - lz * x, ly * x - lx * y
        B[3 * n + 3 + j], B[4 * n + 3 + j], B[5 * n + 3 + j] = x, y, z


@kernel
def minus_cross(x, y, z, n, B, k):
    """Write -(x, y, z)~ to the matrix B with n columns, from entry k on."""
    B[k + 1], B[k + 2] = z, -y
    B[k + n], B[k + n + 2] = -z, x
    B[k + 2 * n], B[k + 2 * n + 1] = y, -x


@kernel
def stiffness(block, cK, frames, numbers, layout, matrix):
    """matrix += cK * (-d(B^T F)/dq) = -cK (tau~ + l~ F~) with the accumulated wrenches F, from frames."""
    add_stiffness(block, cK, SPACE.WRENCH, frames, layout, matrix)


@rare
def add_stiffness(block, cK, wrench, frames, layout, matrix):
    """``stiffness`` with the wrenches in the columns of frames from ``wrench`` on."""
    if cK == 0.0:  # forces may be infinite at rest, as P/w, where M is also asked for
        return
    for e in range(layout[block]):
        o = layout[block + 1] + RECORD * e
        tx, ty, tz, lf = 0.0, 0.0, 0.0, 0.0
        xx, xy, xz, yx, yy, yz, zx, zy, zz = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
        for f in range(layout[o + FRAME], layout[o + FRAME] + layout[o + COUNT]):
            fx, fy, fz = frames[f, wrench], frames[f, wrench + 1], frames[f, wrench + 2]
            lx, ly, lz = frames[f, SPACE.LEVER], frames[f, SPACE.LEVER + 1], frames[f, SPACE.LEVER + 2]
            tx, ty, tz = tx + frames[f, wrench + 3], ty + frames[f, wrench + 4], tz + frames[f, wrench + 5]
            lf += lx * fx + ly * fy + lz * fz
            # l~ F~ = F l^T - (l . F) I
            xx, xy, xz = xx + fx * lx, xy + fx * ly, xz + fx * lz
            yx, yy, yz = yx + fy * lx, yy + fy * ly, yz + fy * lz
            zx, zy, zz = zx + fz * lx, zy + fz * ly, zz + fz * lz
        slots = layout[layout[L.SLOTS] + layout[o + SLOT] :]
        matrix[slots[0]] -= cK * (xx - lf)
        matrix[slots[1]] -= cK * (xy - tz)
        matrix[slots[2]] -= cK * (xz + ty)
        matrix[slots[3]] -= cK * (yx + tz)
        matrix[slots[4]] -= cK * (yy - lf)
        matrix[slots[5]] -= cK * (yz - tx)
        matrix[slots[6]] -= cK * (zx - ty)
        matrix[slots[7]] -= cK * (zy + tx)
        matrix[slots[8]] -= cK * (zz - lf)


@kernel
def angular_momentum(own, x, y, z):
    """J (x, y, z), in body axes."""
    return turned(own[J:], x, y, z)


@kernel
def forces(block, vectors, numbers, layout):
    """vectors[FORCE] -= Omega x J Omega."""
    for e in range(layout[block]):
        o = layout[block + 1] + RECORD * e
        d, own = layout[o + FIRST] + 3, numbers[layout[o + ROTATION] :]
        x, y, z = vectors[L.VELOCITY, d], vectors[L.VELOCITY, d + 1], vectors[L.VELOCITY, d + 2]
        hx, hy, hz = angular_momentum(own, x, y, z)
        vectors[L.FORCE, d] -= y * hz - z * hy
        vectors[L.FORCE, d + 1] -= z * hx - x * hz
        vectors[L.FORCE, d + 2] -= x * hy - y * hx


@kernel
def inertia(block, task, row, target, vectors, numbers, layout):
    """vectors[target] += (J without its diagonal) vectors[row], or = J^{-1} vectors[row], of rotations in body axes."""
    for e in range(layout[block]):
        o = layout[block + 1] + RECORD * e
        d, own = layout[o + FIRST] + 3, numbers[layout[o + ROTATION] :]
        x, y, z = vectors[row, d], vectors[row, d + 1], vectors[row, d + 2]
        if task == L.TIMES:
            vectors[target, d] += own[J + 1] * y + own[J + 2] * z
            vectors[target, d + 1] += own[J + 3] * x + own[J + 5] * z
            vectors[target, d + 2] += own[J + 6] * x + own[J + 7] * y
        else:
            ax, ay, az = turned(own[INVERSE_INERTIA:], x, y, z)
            vectors[target, d], vectors[target, d + 1], vectors[target, d + 2] = ax, ay, az


@rare
def tangents(block, factors, vectors, numbers, layout, matrix):
    """matrix += R [cM J + cD (Omega~ J - (J Omega)~)] T^{-1} R^T - cM diag(J), of rotations in world axes.

    T(psi), the tangent of the exponential, relates the rotation to the change of psi. In matrices without forces (cK
    and cD are zero), which have to be symmetric, outside of a step, and for methods with accelerations psi'' instead of
    Omega', T is the unit matrix.
    """
    cM, cK, cD = factors.cM, factors.cK, factors.cD
    for e in range(layout[block]):
        o = layout[block + 1] + RECORD * e
        d, own = layout[o + FIRST] + 3, numbers[layout[o + ROTATION] :]
        S, P = own[SCRATCH:], own[SCRATCH + 9 :]
        x, y, z = vectors[L.VELOCITY, d], vectors[L.VELOCITY, d + 1], vectors[L.VELOCITY, d + 2]
        hx, hy, hz = angular_momentum(own, x, y, z)
        for j in range(3):
            a, b, c = own[J + j], own[J + 3 + j], own[J + 6 + j]
            S[j] = cM * a + cD * (y * c - z * b)
            S[3 + j] = cM * b + cD * (z * a - x * c)
            S[6 + j] = cM * c + cD * (x * b - y * a)
        S[1], S[2] = S[1] + cD * hz, S[2] - cD * hy
        S[3], S[5] = S[3] - cD * hz, S[5] + cD * hx
        S[6], S[7] = S[6] + cD * hy, S[7] - cD * hx
        if layout[L.CHART] == 1 and (cK != 0.0 or cD != 0.0):
            inverse_tangent(vectors[L.POSITION, d:], own[SCRATCH + 18 :])
            product(S, own[SCRATCH + 18 :], P)
            S, P = own[SCRATCH + 9 :], own[SCRATCH:]
        product(own[R:], S, P)
        slots = layout[layout[L.SLOTS] + layout[o + SLOT] :]
        for i in range(3):
            for j in range(3):
                value = (
                    P[3 * i] * own[R + 3 * j] + P[3 * i + 1] * own[R + 3 * j + 1] + P[3 * i + 2] * own[R + 3 * j + 2]
                )
                matrix[slots[3 * i + j]] += value - cM * own[J + 4 * i] if i == j else value


@rare
def step_tangents(block, factors, vectors, frames, numbers, layout, matrix):
    """matrix += cU (tau~ + l~ F~) with the wrenches F of Phi_q^T mu, and R (cM J + cE I) (T^{-1} - I) R^T, in matrices
    with cU."""
    cM, cU, cE = factors.cM, factors.cU, factors.cE
    if cU == 0.0:
        return
    add_stiffness(block, -cU, SPACE.MU_WRENCH, frames, layout, matrix)
    for e in range(layout[block] if layout[L.CHART] == 1 else 0):
        o = layout[block + 1] + RECORD * e
        own = numbers[layout[o + ROTATION] :]
        S, P, Q = own[SCRATCH:], own[SCRATCH + 9 :], own[SCRATCH + 18 :]
        for j in range(9):
            S[j] = cM * own[J + j]
        inverse_tangent(vectors[L.POSITION, layout[o + FIRST] + 3 :], Q)
        for j in range(3):
            S[4 * j] += cE
            Q[4 * j] -= 1.0
        product(S, Q, P)
        product(own[R:], P, S)
        slots = layout[layout[L.SLOTS] + layout[o + SLOT] :]
        for i in range(3):
            for j in range(3):
                matrix[slots[3 * i + j]] += (
                    S[3 * i] * own[R + 3 * j] + S[3 * i + 1] * own[R + 3 * j + 1] + S[3 * i + 2] * own[R + 3 * j + 2]
                )
