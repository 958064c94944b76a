"""Scalar coordinates of two frames, from which joints, drivers and forces are made.

z = (x_a, y_a, phi_a, x_b, y_b, phi_b); d = r_b - r_a; t, n are the x and y axes of frame a. Each coordinate g has a
function that fills row k of G with dg/dz and, in column VALUE, g itself, and one that adds factor * d^2 g/dz^2 to H.
"""

from math import cos, sin, sqrt

from mbdsl.compilation.buffer_layout import VALUE
from mbdsl.compilation.marks import kernel


@kernel
def slide(frames, a, b, G, k):
    """g = t . d, the position of b along the x axis of a [m]."""
    c, s = cos(frames[a, 2]), sin(frames[a, 2])
    dx, dy = frames[b, 0] - frames[a, 0], frames[b, 1] - frames[a, 1]
    G[k, VALUE] = c * dx + s * dy
    G[k, 0], G[k, 1], G[k, 2] = -c, -s, c * dy - s * dx
    G[k, 3], G[k, 4] = c, s


@kernel
def slide_hessian(frames, a, b, factor, H):
    """H += factor * d^2 g/dz^2."""
    c, s = factor * cos(frames[a, 2]), factor * sin(frames[a, 2])
    rotation_terms(-s, c, H)
    H[2, 2] -= c * (frames[b, 0] - frames[a, 0]) + s * (frames[b, 1] - frames[a, 1])


@kernel
def offset(frames, a, b, G, k):
    """g = n . d, the distance of b from the x axis of a, positive to its left [m]."""
    c, s = cos(frames[a, 2]), sin(frames[a, 2])
    dx, dy = frames[b, 0] - frames[a, 0], frames[b, 1] - frames[a, 1]
    G[k, VALUE] = c * dy - s * dx
    G[k, 0], G[k, 1], G[k, 2] = s, -c, -c * dx - s * dy
    G[k, 3], G[k, 4] = -s, c


@kernel
def offset_hessian(frames, a, b, factor, H):
    """H += factor * d^2 g/dz^2."""
    c, s = factor * cos(frames[a, 2]), factor * sin(frames[a, 2])
    rotation_terms(-c, -s, H)
    H[2, 2] -= c * (frames[b, 1] - frames[a, 1]) - s * (frames[b, 0] - frames[a, 0])


@kernel
def rotation_terms(ux, uy, H):
    """d^2 g / (d phi_a d d) = u, for r_b (+) and r_a (-), symmetric."""
    H[2, 3] += ux
    H[3, 2] += ux
    H[2, 4] += uy
    H[4, 2] += uy
    H[2, 0] -= ux
    H[0, 2] -= ux
    H[2, 1] -= uy
    H[1, 2] -= uy


@kernel
def angle(frames, a, b, G, k):
    """g = phi_b - phi_a [rad]."""
    G[k, VALUE] = frames[b, 2] - frames[a, 2]
    G[k, 2], G[k, 5] = -1.0, 1.0


@kernel
def distance(frames, a, b, G, k):
    """g = |d| [m]; at zero length the direction is undefined, and the force is zero."""
    dx, dy = frames[b, 0] - frames[a, 0], frames[b, 1] - frames[a, 1]
    l = sqrt(dx * dx + dy * dy)  # hypot fails for lengths beyond 1e154, and takes longer than the rest
    G[k, VALUE] = l
    if l > 0.0:
        dx, dy = dx / l, dy / l
    G[k, 0], G[k, 1], G[k, 3], G[k, 4] = -dx, -dy, dx, dy


@kernel
def distance_hessian(frames, a, b, factor, H):
    """H += factor * d^2 g/dz^2."""
    dx, dy = frames[b, 0] - frames[a, 0], frames[b, 1] - frames[a, 1]
    l = sqrt(dx * dx + dy * dy)
    if l > 0.0:
        dx, dy = dx / l, dy / l
        hxx, hxy, hyy = factor * dy * dy / l, -factor * dx * dy / l, factor * dx * dx / l
        for i in (0, 3):
            for j in (0, 3):
                sign = 1.0 if i == j else -1.0
                H[i, j] += sign * hxx
                H[i, j + 1] += sign * hxy
                H[i + 1, j] += sign * hxy
                H[i + 1, j + 1] += sign * hyy
