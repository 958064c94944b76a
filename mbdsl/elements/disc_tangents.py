"""The common tangent of two discs in space as a scalar coordinate g, see :mod:`~mbdsl.elements.rope_path`.

With the axes n, radii r and centres o of the discs, d = o_b - o_a, c = n_a . n_b, e the direction of the span and

    disc a: rho = r_b c - r_a, f = r_a (e - u);   disc b: rho = r_b - r_a c, f = -r_b (e - u)
    p = d - (n . d) n,  m = n x d,  D = p . p,  s = sqrt(D - rho^2)
    u = (s p - rho m)/D,  w = n x u = (s m + rho p)/D,  tangent point o - r w

the motion of the frames changes g by

    dg = e . (do_b - do_a) + f_a . dw_a + f_b . dw_b - r_a n_a . dphi_a + r_b n_b . dphi_b
    f . dw = X . dd + Y . dn + gamma drho,   h = (rho f - (f . w) 2 p)/D + beta p,  k = s f/D,  beta = (f . m)/(D s)
    X = h - (h . n) n + k x n,  Y = d x k - (h . n) d - (n . d) h,  gamma = (f . p - (f . m) rho/s)/D

f is zero where the span lies in the plane of the disc. The gradient is computed with dual numbers: tuples of a vector
or number and of its derivative along one of the twelve virtual motions.
"""

from math import sqrt

from mbdsl.kernels.columns import SPACE as C
from mbdsl.kernels.marks import kernel

Z = C.AXES + 6
W, U = 4, 5  #: of the result of ``tangent``


@kernel
def product(a, b):
    """a . b of dual vectors."""
    return (
        a[0] * b[0] + a[1] * b[1] + a[2] * b[2],
        a[3] * b[0] + a[4] * b[1] + a[5] * b[2] + a[0] * b[3] + a[1] * b[4] + a[2] * b[5],
    )


@kernel
def crossed(a, b):
    """a x b of dual vectors."""
    return (
        a[1] * b[2] - a[2] * b[1],
        a[2] * b[0] - a[0] * b[2],
        a[0] * b[1] - a[1] * b[0],
        a[4] * b[2] - a[5] * b[1] + a[1] * b[5] - a[2] * b[4],
        a[5] * b[0] - a[3] * b[2] + a[2] * b[3] - a[0] * b[5],
        a[3] * b[1] - a[4] * b[0] + a[0] * b[4] - a[1] * b[3],
    )


@kernel
def mixed(f, a, g, b):
    """f a + g b of dual numbers and vectors."""
    return (
        f[0] * a[0] + g[0] * b[0],
        f[0] * a[1] + g[0] * b[1],
        f[0] * a[2] + g[0] * b[2],
        f[1] * a[0] + f[0] * a[3] + g[1] * b[0] + g[0] * b[3],
        f[1] * a[1] + f[0] * a[4] + g[1] * b[1] + g[0] * b[4],
        f[1] * a[2] + f[0] * a[5] + g[1] * b[2] + g[0] * b[5],
    )


@kernel
def quotient(x, y):
    """x/y of dual numbers."""
    z = x[0] / y[0]
    return z, (x[1] - z * y[1]) / y[0]


@kernel
def times(x, y):
    """x y of dual numbers."""
    return x[0] * y[0], x[1] * y[0] + x[0] * y[1]


@kernel
def less(x, y):
    """x - y of dual numbers."""
    return x[0] - y[0], x[1] - y[1]


@kernel
def root(x):
    """The square root of a dual number, and 0 below zero."""
    y = sqrt(max(x[0], 0.0))
    return y, (0.5 * x[1] / y if y > 0.0 else 0.0)


@kernel
def axis(frames, f, first, j):
    """The z axis of a frame, and its derivative along virtual motion j, if that is one of its rotations."""
    x, y, z = frames[f, Z], frames[f, Z + 1], frames[f, Z + 2]
    i = j - first
    return (
        x,
        y,
        z,
        (z if i == 1 else 0.0) - (y if i == 2 else 0.0),
        (x if i == 2 else 0.0) - (z if i == 0 else 0.0),
        (y if i == 0 else 0.0) - (x if i == 1 else 0.0),
    )


@kernel
def apart(frames, a, b, j):
    """The vector between the origins, and its derivative along virtual motion j."""
    return (
        frames[b, 0] - frames[a, 0],
        frames[b, 1] - frames[a, 1],
        frames[b, 2] - frames[a, 2],
        (1.0 if j == 6 else 0.0) - (1.0 if j == 0 else 0.0),
        (1.0 if j == 7 else 0.0) - (1.0 if j == 1 else 0.0),
        (1.0 if j == 8 else 0.0) - (1.0 if j == 2 else 0.0),
    )


@kernel
def tangent(n, d, rho):
    """p, m, D, s, w and u of a disc."""
    one, zero = (1.0, 0.0), (0.0, 0.0)
    q = product(n, d)
    p, m = mixed(one, d, (-q[0], -q[1]), n), crossed(n, d)
    D = product(p, p)
    s = root(less(D, times(rho, rho)))
    sine, cosine = quotient(rho, D), quotient(s, D)
    u = mixed(cosine, p, less(zero, sine), m)
    return p, m, D, s, mixed(cosine, m, sine, p), u


@kernel
def of_direction(n, d, rho, f, disc):
    """X, Y and gamma: f . dw as a function of dd, dn and drho; ``disc`` is the result of ``tangent``."""
    p, m, D, s, w, _ = disc
    one, zero = (1.0, 0.0), (0.0, 0.0)
    fm, q = product(f, m), product(n, d)
    beta, along = quotient(fm, times(D, s)), quotient(product(f, w), D)
    h = mixed(quotient(rho, D), f, (beta[0] - 2.0 * along[0], beta[1] - 2.0 * along[1]), p)
    scale, hn = quotient(s, D), product(h, n)
    k = mixed(scale, f, zero, f)
    X = mixed(one, mixed(one, h, less(zero, hn), n), one, crossed(k, n))
    Y = mixed(one, crossed(d, k), (-1.0, 0.0), mixed(hn, d, q, h))
    gamma = quotient(less(product(f, p), quotient(times(fm, rho), s)), D)
    return X, Y, gamma


@kernel
def slopes(frames, a, b, ra, rb, j):
    """The length of the span, and the dual vectors of the gradient: with respect to o_b, phi_a and phi_b."""
    one, zero = (1.0, 0.0), (0.0, 0.0)
    na, nb, d = axis(frames, a, 3, j), axis(frames, b, 9, j), apart(frames, a, b, j)
    c, cross = product(na, nb), crossed(na, nb)
    rho_a, rho_b = (rb * c[0] - ra, rb * c[1]), (rb - ra * c[0], -ra * c[1])
    none = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
    span, force, turn_a, turn_b = d, none, mixed((-ra, 0.0), na, zero, na), mixed((rb, 0.0), nb, zero, nb)
    disc_a = disc_b = (none, none, one, one, none, none)
    if ra != 0.0:
        disc_a = tangent(na, d, rho_a)
        span = mixed(one, span, (ra, 0.0), disc_a[W])
    if rb != 0.0:
        disc_b = tangent(nb, d, rho_b)
        span = mixed(one, span, (-rb, 0.0), disc_b[W])
    length = root(product(span, span))
    e = none
    if length[0] > 0.0:
        e = mixed(quotient(one, length), span, zero, span)
    kappa = zero
    if ra != 0.0:
        f = mixed((ra, 0.0), e, (-ra, 0.0), disc_a[U])
        X, Y, gamma = of_direction(na, d, rho_a, f, disc_a)
        force, turn_a = mixed(one, force, one, X), mixed(one, turn_a, one, crossed(na, Y))
        kappa = (kappa[0] + rb * gamma[0], kappa[1] + rb * gamma[1])
    if rb != 0.0:
        f = mixed((-rb, 0.0), e, (rb, 0.0), disc_b[U])
        X, Y, gamma = of_direction(nb, d, rho_b, f, disc_b)
        force, turn_b = mixed(one, force, one, X), mixed(one, turn_b, one, crossed(nb, Y))
        kappa = (kappa[0] - ra * gamma[0], kappa[1] - ra * gamma[1])
    force = mixed(one, force, one, e)
    turn_a, turn_b = mixed(one, turn_a, kappa, cross), mixed(one, turn_b, less(zero, kappa), cross)
    return length[0], force, turn_a, turn_b


@kernel
def span_gradient(frames, a, b, ra, rb, G, k):
    """Row k of G: g = length of the span, and the gradient of g."""
    G[k, C.VALUE], force, turn_a, turn_b = slopes(frames, a, b, ra, rb, -1)
    for i in range(3):
        G[k, i], G[k, 3 + i], G[k, 6 + i], G[k, 9 + i] = -force[i], turn_a[i], force[i], turn_b[i]


@kernel
def span_hessian(frames, a, b, ra, rb, factor, H):
    """H += factor * d(G^T)/dz."""
    for j in range(12):
        _, force, turn_a, turn_b = slopes(frames, a, b, ra, rb, j)
        for i in range(3):
            H[i, j] -= factor * force[3 + i]
            H[3 + i, j] += factor * turn_a[3 + i]
            H[6 + i, j] += factor * force[3 + i]
            H[9 + i, j] += factor * turn_b[3 + i]
