"""Scalar coordinates of two frames in space, for written kernels; those of most kinds are made from rows.

d = r_b - r_a; a is an axis of frame a, b one of frame b, given by their first columns in the frame table. Virtual
motions are z = (dr_a, dphi_a, dr_b, dphi_b) in world axes. Each coordinate g has a function that fills row k of G with
dg/dz and, in column VALUE, g itself, and one that adds factor * d(G^T)/dz to H. With a~ the matrix of a x:

    point   d (3 rows)   G = [-I, 0, I, 0]
    dot1    a . b                                             H: b~ a~, -a~ b~; -b~ a~, a~ b~ in (phi_a, phi_b)
    dot2    a . d        G = [-a^T, (a x d)^T, a^T, 0]        H: a~ in (r_a, phi_a), -a~ in (r_b, phi_a),
                                                                 -a~, d~ a~, a~ in the row of phi_a

H is not symmetric, as rotations do not commute. Source: the gradients are classical; E. J. Haug, *Computer Aided
Kinematics and Dynamics of Mechanical Systems* (1989), section 9.2.
"""

from mbdsl.kernels.columns import SPACE as C
from mbdsl.kernels.marks import kernel

#: first columns of the axes of a frame
X, Y, Z = C.AXES, C.AXES + 3, C.AXES + 6
#: first columns of G of the virtual motions
R_A, PHI_A, R_B, PHI_B = 0, 3, 6, 9


@kernel
def point(frames, a, b, G, k):
    """g = d, the position of b relative to a, in rows k, k + 1, k + 2 [m]."""
    for i in range(3):
        G[k + i, C.VALUE] = frames[b, i] - frames[a, i]
        G[k + i, R_A + i], G[k + i, R_B + i] = -1.0, 1.0


@kernel
def dot1_hessian(frames, a, u, b, w, factor, H):
    """H += factor * d(G^T)/dz."""
    dot = frames[a, u] * frames[b, w] + frames[a, u + 1] * frames[b, w + 1] + frames[a, u + 2] * frames[b, w + 2]
    for i in range(3):
        for j in range(3):
            ab = factor * frames[a, u + i] * frames[b, w + j]  # b~ a~ = a b^T - (a . b) I
            ba = factor * frames[b, w + i] * frames[a, u + j]  # a~ b~ = b a^T - (a . b) I
            if i == j:
                ab, ba = ab - factor * dot, ba - factor * dot
            H[PHI_A + i, PHI_A + j] += ab
            H[PHI_A + i, PHI_B + j] -= ba
            H[PHI_B + i, PHI_A + j] -= ab
            H[PHI_B + i, PHI_B + j] += ba


@kernel
def dot2(frames, a, u, b, G, k):
    """g = a . d, the position of b along the axis at column u of frame a [m]."""
    ax, ay, az = frames[a, u], frames[a, u + 1], frames[a, u + 2]
    dx, dy, dz = frames[b, 0] - frames[a, 0], frames[b, 1] - frames[a, 1], frames[b, 2] - frames[a, 2]
    G[k, C.VALUE] = ax * dx + ay * dy + az * dz
    G[k, R_A], G[k, R_A + 1], G[k, R_A + 2] = -ax, -ay, -az
    G[k, PHI_A], G[k, PHI_A + 1], G[k, PHI_A + 2] = ay * dz - az * dy, az * dx - ax * dz, ax * dy - ay * dx
    G[k, R_B], G[k, R_B + 1], G[k, R_B + 2] = ax, ay, az


@kernel
def dot2_hessian(frames, a, u, b, factor, H):
    """H += factor * d(G^T)/dz."""
    ax, ay, az = factor * frames[a, u], factor * frames[a, u + 1], factor * frames[a, u + 2]
    dot = 0.0
    for i in range(3):
        dot += factor * frames[a, u + i] * (frames[b, i] - frames[a, i])
    add_cross(ax, ay, az, H, R_A, PHI_A)
    add_cross(-ax, -ay, -az, H, PHI_A, R_A)
    add_cross(ax, ay, az, H, PHI_A, R_B)
    add_cross(-ax, -ay, -az, H, R_B, PHI_A)
    for i in range(3):
        for j in range(3):
            H[PHI_A + i, PHI_A + j] += factor * frames[a, u + i] * (frames[b, j] - frames[a, j])
        H[PHI_A + i, PHI_A + i] -= dot


@kernel
def point_in_axes(frames, a, b, G, k):
    """g = R_a^T d, the position of b relative to a in the axes of frame a, in rows k, k + 1, k + 2 [m]."""
    dot2(frames, a, X, b, G, k)
    dot2(frames, a, Y, b, G, k + 1)
    dot2(frames, a, Z, b, G, k + 2)


@kernel
def point_in_axes_hessian(frames, a, b, s, H):
    """H += s[0], s[1], s[2] times the derivatives of its gradients."""
    dot2_hessian(frames, a, X, b, s[0], H)
    dot2_hessian(frames, a, Y, b, s[1], H)
    dot2_hessian(frames, a, Z, b, s[2], H)


@kernel
def add_cross(x, y, z, H, i, j):
    """H[i : i + 3, j : j + 3] += (x, y, z)~."""
    H[i, j + 1] -= z
    H[i, j + 2] += y
    H[i + 1, j] += z
    H[i + 1, j + 2] -= x
    H[i + 2, j] -= y
    H[i + 2, j + 1] += x


@kernel
def turn(frames, a, u, G, k):
    """Row k of G is a rotation about the axis of frame a at column u; it has no value."""
    for i in range(3):
        G[k, PHI_A + i], G[k, PHI_B + i] = -frames[a, u + i], frames[a, u + i]


@kernel
def turn_hessian(frames, a, u, factor, H):
    """H += factor * d(G^T)/dz."""
    x, y, z = factor * frames[a, u], factor * frames[a, u + 1], factor * frames[a, u + 2]
    add_cross(x, y, z, H, PHI_A, PHI_A)
    add_cross(-x, -y, -z, H, PHI_B, PHI_A)
