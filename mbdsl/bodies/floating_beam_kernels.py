"""Motion of frames on a beam in a floating frame of reference, and the inertia and elastic forces of the beam.

The coordinates are the origin R = (x, y) of the floating frame, its angle phi, and k elastic coordinates q. In the axes
of this frame, a point of the beam axis is at u(q) = u0 + S q - 1/2 e_x q^T N q; the last term is the foreshortening by
bending (with geometric stiffening only). The section there is rotated by v'(q), which is linear in q. With A = A(phi),
J the rotation by 90 degrees, w = phi':

    r = R + A u,   theta = phi + v',   B = [1, A J u, A u_j; 0, 1, v'_j],   u_j = S_j - e_x (N q)_j

Kinetic energy, with integrals over the mass that are constants of the discretisation (m, I0, S_bar, h1, g0, H, G and
N_bar; H contains the stiffening terms and is complete to second order in q and q'):

    T = m/2 R'.R' + w R'.A J c + R'.A c' + P w^2/2 + w b.q' + 1/2 q'^T M_ff q'
    c = S_bar q - 1/2 e_x q^T N_bar q,   P = I0 + (2 h1 + H q).q,   b = g0 - G q

so that, with c_j = dc/dq_j and the gravity field g,

    M = [[m, A J c, A c_j], [., P, b_j], [., ., M_ff]]
    Q_R   = m g - A (c'' + 2 w J c' - w^2 c),   c'' = -e_x q'^T N_bar q'
    Q_phi = g.A J c - 2 w (h1 + H q).q'
    Q_j   = g.A c_j + w^2 (h1 + H q)_j + 2 w (G q')_j - (K q + D q')_j

Source: A. A. Shabana, Dynamics of Multibody Systems, ch. 5; the foreshortening after T. R. Kane, R. R. Ryan, A. K.
Banerjee, Dynamics of a cantilever beam attached to a moving base, J. Guidance 10 (1987). Record of a body: see
``RECORD``. Record of a frame: number of its elastic coordinates, offset in layout of their list, offsets in numbers of
its constants, of N (or -1), of A u_j now and at the start of the step, first slot.
"""

from mbdsl.bodies.floating_beam_mass import (
    BORDER,
    C_X,
    C_Y,
    CONSTANTS,
    COS,
    ELASTIC,
    ELASTIC_AT,
    ELASTIC_VALUES,
    FIRST,
    FRAME,
    FRAME_RECORD,
    HELD,
    INERTIAL,
    INERTIAL_AT,
    INERTIAL_VALUES,
    KNOWN,
    LISTS,
    N_FRAME,
    NOW,
    OF_FRAMES,
    P_Q,
    PAST,
    SCRATCH,
    SIN,
    SIZE,
    border,
    decompose,
    of_mass,
    parts,
    rates,
    solve,
)
from mbdsl.kernels import buffer_layout as L
from mbdsl.kernels.columns import PLANE as C
from mbdsl.kernels.marks import kernel, rare

MASS = 2  #: the mass matrix depends on q
#: the model that fills the tables
MODEL = "mbdsl.bodies.floating_beam"


@kernel
def move(block, vectors, frames, numbers, layout):
    """Write pose, rate and lever of every frame, and zero wrenches, to frames; write A u_j to numbers.

    Reads the rows POSITION and VELOCITY of vectors, and the row of MASS_ROW if it is new.
    """
    for e in range(layout[block]):
        o = layout[layout[block + 1] + e]
        d, at = layout[o + FIRST], layout[o + NOW]
        parts(o, L.POSITION, at, vectors, numbers, layout)
        if layout[L.MASS_ROW] != L.POSITION and layout[L.NEW_MASS]:
            parts(o, layout[L.MASS_ROW], layout[o + HELD], vectors, numbers, layout)
        c, s, w = numbers[at + COS], numbers[at + SIN], vectors[L.VELOCITY, d + 2]
        q, v = vectors[L.POSITION, d + 3 :], vectors[L.VELOCITY, d + 3 :]
        for f in range(layout[o + N_FRAME]):
            r, row = layout[o + OF_FRAMES] + FRAME_RECORD * f, layout[o + FRAME] + f
            k, which, n, N, to = layout[r], layout[r + 1], layout[r + 2], layout[r + 3], layout[r + 4]
            px, py, theta, turn = numbers[n], numbers[n + 1], numbers[n + 2], 0.0
            rx, ry = 0.0, 0.0
            n += 3
            for j in range(k):
                i = layout[which + j]
                ux, uy = numbers[n + j], numbers[n + k + j]
                px += ux * q[i]
                py += uy * q[i]
                theta += numbers[n + 2 * k + j] * q[i]
                turn += numbers[n + 2 * k + j] * v[i]
                if N >= 0:
                    Nq = 0.0
                    for l in range(k):
                        Nq += numbers[N + k * j + l] * q[layout[which + l]]
                    ux -= Nq
                    px -= 0.5 * Nq * q[i]
                ux, uy = c * ux - s * uy, s * ux + c * uy
                numbers[to + j], numbers[to + k + j] = ux, uy
                rx += ux * v[i]
                ry += uy * v[i]
            lx, ly = c * px - s * py, s * px + c * py
            frames[row, 0], frames[row, 1], frames[row, 2] = (
                vectors[L.POSITION, d] + lx,
                vectors[L.POSITION, d + 1] + ly,
                vectors[L.POSITION, d + 2] + theta,
            )
            frames[row, 3], frames[row, 4], frames[row, 5] = (
                vectors[L.VELOCITY, d] - ly * w + rx,
                vectors[L.VELOCITY, d + 1] + lx * w + ry,
                w + turn,
            )
            frames[row, C.LEVER], frames[row, C.LEVER + 1] = lx, ly
            for j in range(3):
                frames[row, C.WRENCH + j], frames[row, C.MU_WRENCH + j] = 0.0, 0.0


@kernel
def keep(block, numbers, layout):
    """At the start of a step, copy the parts and A u_j of the last evaluation within numbers, for ``collect_past``."""
    if layout[L.KEEP]:
        for e in range(layout[block]):
            o = layout[layout[block + 1] + e]
            for j in range(LISTS + 7 * layout[o + SIZE] + 6):
                numbers[layout[o + PAST] + j] = numbers[layout[o + NOW] + j]
            if numbers[layout[o + PAST] + KNOWN] == 0.0:
                decompose(o, layout[o + PAST], numbers, layout)
            for f in range(layout[o + N_FRAME]):
                r = layout[o + OF_FRAMES] + FRAME_RECORD * f
                for j in range(2 * layout[r]):
                    numbers[layout[r + 5] + j] = numbers[layout[r + 4] + j]


@kernel
def gather(block, wrench, lever, row, vectors, frames, numbers, layout):
    """vectors[row] += B^T F of every frame, with F and l in the columns of frames from ``wrench`` and ``lever`` on."""
    columns = 5 if row == L.PAST_FORCE else 4  # entry of a frame's record with the offset of A u_j
    for e in range(layout[block]):
        o = layout[layout[block + 1] + e]
        d = layout[o + FIRST]
        for f in range(layout[o + N_FRAME]):
            r, z = layout[o + OF_FRAMES] + FRAME_RECORD * f, frames[layout[o + FRAME] + f]
            fx, fy, tau = z[wrench], z[wrench + 1], z[wrench + 2]
            vectors[row, d] += fx
            vectors[row, d + 1] += fy
            vectors[row, d + 2] += tau - z[lever + 1] * fx + z[lever] * fy
            k, turn, u = layout[r], layout[r + 2] + 3 + 2 * layout[r], layout[r + columns]
            for j in range(k):
                vectors[row, d + 3 + layout[layout[r + 1] + j]] += (
                    numbers[u + j] * fx + numbers[u + k + j] * fy + numbers[turn + j] * tau
                )


@kernel
def collect_with_mu(block, vectors, frames, numbers, layout):
    """``gather`` of the accumulated wrenches to FORCE, and of the wrenches of mu to FORCE2, in one loop."""
    for e in range(layout[block]):
        o = layout[layout[block + 1] + e]
        d = layout[o + FIRST]
        for f in range(layout[o + N_FRAME]):
            r, z = layout[o + OF_FRAMES] + FRAME_RECORD * f, frames[layout[o + FRAME] + f]
            lx, ly, fx, fy, tau = z[C.LEVER], z[C.LEVER + 1], z[C.WRENCH], z[C.WRENCH + 1], z[C.WRENCH + 2]
            gx, gy, mu = z[C.MU_WRENCH], z[C.MU_WRENCH + 1], z[C.MU_WRENCH + 2]
            vectors[L.FORCE, d] += fx
            vectors[L.FORCE, d + 1] += fy
            vectors[L.FORCE, d + 2] += tau - ly * fx + lx * fy
            vectors[L.FORCE2, d] += gx
            vectors[L.FORCE2, d + 1] += gy
            vectors[L.FORCE2, d + 2] += mu - ly * gx + lx * gy
            k, turn, u = layout[r], layout[r + 2] + 3 + 2 * layout[r], layout[r + 4]
            for j in range(k):
                i, ux, uy = d + 3 + layout[layout[r + 1] + j], numbers[u + j], numbers[u + k + j]
                vectors[L.FORCE, i] += ux * fx + uy * fy + numbers[turn + j] * tau
                vectors[L.FORCE2, i] += ux * gx + uy * gy + numbers[turn + j] * mu


@kernel
def forces(block, vectors, numbers, layout):
    """vectors[FORCE] += velocity-dependent inertia forces, the variable part of gravity, elastic and damping forces.

    Reads the rows POSITION and VELOCITY, and the parts in numbers; uses SCRATCH.
    """
    for e in range(layout[block]):
        o = layout[layout[block + 1] + e]
        d, k, at = layout[o + FIRST], layout[o + SIZE], layout[o + NOW]
        n, x = layout[o + CONSTANTS], layout[o + SCRATCH]
        c, s, c_x, c_y = numbers[at + COS], numbers[at + SIN], numbers[at + C_X], numbers[at + C_Y]
        q, v, w, f = (
            vectors[L.POSITION, d + 3 :],
            vectors[L.VELOCITY, d + 3 :],
            vectors[L.VELOCITY, d + 2],
            vectors[L.FORCE],
        )
        cx, cy, Hq = numbers[at + LISTS :], numbers[at + LISTS + k :], numbers[at + LISTS + 3 * k :]
        gx, gy = c * numbers[n + 2] + s * numbers[n + 3], c * numbers[n + 3] - s * numbers[n + 2]
        rates(o, v, x, numbers, layout)
        dx, dy, ddx, dP = 0.0, 0.0, 0.0, 0.0
        for j in range(k):
            dx += cx[j] * v[j]
            dy += cy[j] * v[j]
            ddx -= numbers[x + 2 * k + j] * v[j]
            dP += 2.0 * Hq[j] * v[j]
            f[d + 3 + j] += gx * cx[j] + gy * cy[j] + w * (w * Hq[j] + 2.0 * numbers[x + k + j])
        fx, fy = ddx - 2.0 * w * dy - w * w * c_x, 2.0 * w * dx - w * w * c_y
        f[d] -= c * fx - s * fy
        f[d + 1] -= s * fx + c * fy
        f[d + 2] += gy * c_x - gx * c_y - dP * w
        entries, values = layout[o + ELASTIC_AT], layout[o + ELASTIC_VALUES]
        for a in range(layout[o + ELASTIC]):
            i, j = layout[entries + 3 * a], layout[entries + 3 * a + 1]
            f[d + 3 + i] -= numbers[values + 2 * a] * q[j] + numbers[values + 2 * a + 1] * v[j]


@kernel
def inertia(block, task, row, target, vectors, numbers, layout):
    """Tasks of the mass matrix (:mod:`mbdsl.kernels.buffer_layout`): reads vectors[row], writes vectors[target]."""
    for e in range(layout[block]):
        o = layout[layout[block + 1] + e]
        if task == L.TIMES:
            border(o, of_mass(o, layout), 1.0, row, target, vectors, numbers, layout)
        elif task == L.INVERSE:
            decompose(o, of_mass(o, layout), numbers, layout)
            solve(o, of_mass(o, layout), row, target, vectors, numbers, layout)


@kernel
def carry_over(block, vectors, numbers, layout):
    """vectors[PAST_FORCE] = M M_n^{-1} vectors[PAST_FORCE] with M_n at the start of the step; uses row TEMPORARY."""
    for e in range(layout[block]):
        o = layout[layout[block + 1] + e]
        solve(o, layout[o + PAST], L.PAST_FORCE, L.TEMPORARY, vectors, numbers, layout)
        border(o, layout[o + NOW], 1.0, L.TEMPORARY, L.PAST_FORCE, vectors, numbers, layout)
        border(o, layout[o + PAST], -1.0, L.TEMPORARY, L.PAST_FORCE, vectors, numbers, layout)


@kernel
def jacobians(block, vectors, frames, numbers, layout):
    """Write B, then (B v)_q, of every frame, 3 x (3 + k) each, to numbers. Entries that are always zero keep their
    initial value, zero."""
    for e in range(layout[block]):
        o = layout[layout[block + 1] + e]
        d, at = layout[o + FIRST], layout[o + NOW]
        c, s, w, v = numbers[at + COS], numbers[at + SIN], vectors[L.VELOCITY, d + 2], vectors[L.VELOCITY, d + 3 :]
        for f in range(layout[o + N_FRAME]):
            r, row = layout[o + OF_FRAMES] + FRAME_RECORD * f, layout[o + FRAME] + f
            k, which, turn, N, u = (
                layout[r],
                layout[r + 1],
                layout[r + 2] + 3 + 2 * layout[r],
                layout[r + 3],
                layout[r + 4],
            )
            nb, B = 3 + k, layout[layout[L.FRAMES] + 2 * row + 1]
            lx, ly, rx, ry = frames[row, C.LEVER], frames[row, C.LEVER + 1], 0.0, 0.0
            rate = B + 3 * nb
            for j in range(k):
                ux, uy = numbers[u + j], numbers[u + k + j]
                numbers[B + 3 + j], numbers[B + nb + 3 + j], numbers[B + 2 * nb + 3 + j] = ux, uy, numbers[turn + j]
                rx += ux * v[layout[which + j]]
                ry += uy * v[layout[which + j]]
                Nv = 0.0
                if N >= 0:
                    for l in range(k):
                        Nv += numbers[N + k * j + l] * v[layout[which + l]]
                numbers[rate + 3 + j], numbers[rate + nb + 3 + j] = -uy * w - c * Nv, ux * w - s * Nv
            numbers[B], numbers[B + nb + 1], numbers[B + 2 * nb + 2] = 1.0, 1.0, 1.0
            numbers[B + 2], numbers[B + nb + 2] = -ly, lx
            numbers[rate + 2], numbers[rate + nb + 2] = -lx * w - ry, -ly * w + rx


@kernel
def stiffness(block, cK, frames, numbers, layout, matrix):
    """matrix += cK * (-d(B^T F)/dq) with the accumulated wrenches F, from frames."""
    if cK == 0.0:  # forces may be infinite at rest, as P/w, where M is also asked for
        return
    for e in range(layout[block]):
        o = layout[layout[block + 1] + e]
        c, s = numbers[layout[o + NOW] + COS], numbers[layout[o + NOW] + SIN]
        for f in range(layout[o + N_FRAME]):
            r, z = layout[o + OF_FRAMES] + FRAME_RECORD * f, frames[layout[o + FRAME] + f]
            k, N, u, slot = layout[r], layout[r + 3], layout[r + 4], layout[L.SLOTS] + layout[r + 6]
            fx, fy = cK * z[C.WRENCH], cK * z[C.WRENCH + 1]
            matrix[layout[slot]] += z[C.LEVER] * fx + z[C.LEVER + 1] * fy
            for j in range(k):
                value = numbers[u + k + j] * fx - numbers[u + j] * fy
                matrix[layout[slot + 1 + 2 * j]] += value
                matrix[layout[slot + 2 + 2 * j]] += value
            if N >= 0:
                slot += 1 + 2 * k
                for j in range(k * k):
                    matrix[layout[slot + j]] += numbers[N + j] * (c * fx + s * fy)


@kernel
def inertial_tangents(o, cN, cG, cH, numbers, layout, matrix):
    """matrix -= cN N_bar + cG G + cH H, in the entries of the elastic coordinates."""
    entries, values = layout[o + INERTIAL_AT], layout[o + INERTIAL_VALUES]
    for b in range(layout[o + INERTIAL]):
        H, G, N = numbers[values + 3 * b], numbers[values + 3 * b + 1], numbers[values + 3 * b + 2]
        matrix[layout[layout[L.SLOTS] + layout[entries + 3 * b + 2]]] -= cN * N + cG * G + cH * H


@kernel
def elastic_tangents(o, cK, cD, numbers, layout, matrix):
    """matrix += cK K + cD D, in the entries of the elastic coordinates."""
    entries, values = layout[o + ELASTIC_AT], layout[o + ELASTIC_VALUES]
    for b in range(layout[o + ELASTIC]):
        matrix[layout[layout[L.SLOTS] + layout[entries + 3 * b + 2]]] += (
            cK * numbers[values + 2 * b] + cD * numbers[values + 2 * b + 1]
        )


@rare
def tangents(block, factors, vectors, numbers, layout, matrix):
    """matrix += cM (M - its constant part) + cA (M a)_q - cK Q_q - cD Q_v, with the forces Q of ``forces``, and with a
    in the row TANGENT_ROW of vectors. Uses SCRATCH of numbers."""
    cM, cK, cD, cA = factors.cM, factors.cK, factors.cD, factors.cA
    for e in range(layout[block]):
        o = layout[layout[block + 1] + e]
        d, k, at = layout[o + FIRST], layout[o + SIZE], layout[o + NOW]
        n, x = layout[o + CONSTANTS], layout[o + SCRATCH]
        c, s, c_x, c_y = numbers[at + COS], numbers[at + SIN], numbers[at + C_X], numbers[at + C_Y]
        cx, cy, Hq = numbers[at + LISTS :], numbers[at + LISTS + k :], numbers[at + LISTS + 3 * k :]
        v, w, a = vectors[L.VELOCITY, d + 3 :], vectors[L.VELOCITY, d + 2], vectors[layout[L.TANGENT_ROW], d:]
        ax, ay, alpha = c * a[0] + s * a[1], c * a[1] - s * a[0], cA * a[2]
        gx, gy = c * numbers[n + 2] + s * numbers[n + 3], c * numbers[n + 3] - s * numbers[n + 2]
        ex, ey = cA * ax - cK * gx, cA * ay - cK * gy
        rates(o, v, x, numbers, layout)
        rates(o, a[3:], x + 3 * k, numbers, layout)
        Hv, Gv, Nv = numbers[x:], numbers[x + k :], numbers[x + 2 * k :]
        Ga, Na = numbers[x + 4 * k :], numbers[x + 5 * k :]
        m = of_mass(o, layout)
        mc, ms, mx, my = numbers[m + COS], numbers[m + SIN], numbers[m + C_X], numbers[m + C_Y]
        mcx, mcy, mb = numbers[m + LISTS :], numbers[m + LISTS + k :], numbers[m + LISTS + 2 * k :]
        dx, dy, ddx, dP, qx, qy = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
        for j in range(k):
            dx += cx[j] * v[j]
            dy += cy[j] * v[j]
            ddx -= Nv[j] * v[j]
            dP += 2.0 * Hq[j] * v[j]
            qx += cx[j] * a[3 + j]
            qy += cy[j] * a[3 + j]
        # entries (R, phi): computed in the axes of the floating frame, then rotated
        tx = -c_y * alpha + cA * qx + cK * (ddx - 2.0 * w * dy - w * w * c_x)
        ty = c_x * alpha + cA * qy + cK * (2.0 * w * dx - w * w * c_y)
        tx, ty = -ty - 2.0 * cD * (dy + w * c_x), tx + 2.0 * cD * (dx - w * c_y)
        slot = layout[L.SLOTS] + layout[o + BORDER]
        Mx, My = -cM * (ms * mx + mc * my), cM * (mc * mx - ms * my)
        matrix[layout[slot]] += c * tx - s * ty + Mx
        matrix[layout[slot + 1]] += s * tx + c * ty + My
        matrix[layout[slot + 2]] += Mx
        matrix[layout[slot + 3]] += My
        matrix[layout[slot + 4]] += cM * numbers[m + P_Q] - ex * c_x - ey * c_y + cD * dP
        slot += 5
        for j in range(k):
            tx = -cy[j] * alpha - cA * Na[j] - cK * w * w * cx[j] - 2.0 * cD * (Nv[j] + w * cy[j])
            ty = cx[j] * alpha - cK * w * (2.0 * Nv[j] + w * cy[j]) + 2.0 * cD * w * cx[j]
            Mx, My = cM * (mc * mcx[j] - ms * mcy[j]), cM * (ms * mcx[j] + mc * mcy[j])
            turned = ey * cx[j] - ex * cy[j]
            matrix[layout[slot]] += c * tx - s * ty + Mx
            matrix[layout[slot + 1]] += s * tx + c * ty + My
            matrix[layout[slot + 2]] += Mx
            matrix[layout[slot + 3]] += My
            matrix[layout[slot + 4]] += (
                turned + 2.0 * alpha * Hq[j] + cA * Ga[j] + 2.0 * w * (cK * Hv[j] + cD * Hq[j]) + cM * mb[j]
            )
            matrix[layout[slot + 5]] += turned - 2.0 * cD * (w * Hq[j] + Gv[j]) + cM * mb[j]
            slot += 6
        inertial_tangents(o, ex, alpha + 2.0 * cD * w, cK * w * w, numbers, layout, matrix)
        elastic_tangents(o, cK, cD, numbers, layout, matrix)
