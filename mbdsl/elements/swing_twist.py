"""The attitude of frame b relative to frame a: a twist about z_a, then the smallest turn that tilts z_a to z_b.

With the axes of both frames, u = (x_a . z_b, y_a . z_b, z_a . z_b) and the tilt beta, cos(beta) = u_3:

    twist  psi = atan2(y_a . x_b - x_a . y_b, x_a . x_b + y_a . y_b)                     counts turns
    tilt   sigma = f (-u_2, u_1),  f = beta/sin(beta)                                    rotation vector, along x_a, y_a

Both are defined up to a tilt of half a turn, whatever the twist is. Their derivatives, with W = dphi_b - dphi_a:

    dpsi = m . W,  m = (z_a + z_b)/(1 + u_3);   du_i = -c_i . W,  c_i = e_i x z_b with the axes e_i of frame a
    df/du_3 = (f u_3 - 1)/(1 - u_3^2),   d2f/du_3^2 = (f + 3 u_3 df/du_3)/(1 - u_3^2)

From w = 1 - u_3 below SMALL on, f = sum a_n w^n with a_0 = 1, a_n = a_{n-1} n/(2 n + 1), which is the series of
arcsin(x)/(x sqrt(1 - x^2)) in x^2 = w/2.
"""

from math import atan2, floor, pi, sqrt

from mbdsl.elements.coordinates_in_space import PHI_A, PHI_B, X, Y, Z, dot1_hessian
from mbdsl.elements.vectors import W, axis, cross, dot, total
from mbdsl.kernels.columns import SPACE as C
from mbdsl.kernels.marks import kernel

X_A, Y_A, Z_A, X_B, Y_B, Z_B = (axis(f"frame_{f}", i) for f in "ab" for i in "xyz")
#: formulas of the twist and its rate
_SIN, _COS = f"({dot(Y_A, X_B)} - {dot(X_A, Y_B)})", f"({dot(X_A, X_B)} + {dot(Y_A, Y_B)})"
ALONG = total(("1", Z_A), ("1", Z_B))
RATE = f"({dot(W, ALONG)}/(1 + {dot(Z_A, Z_B)}))"
TWIST = f"angle({_SIN}, {_COS}, {RATE})"
#: formulas of the tilt; f is written so that it is 1 without a tilt, where its derivative is zero
_SINE = f"hypot({dot(X_A, Z_B)}, {dot(Y_A, Z_B)})"
_F = f"(1 + ratio(atan2({_SINE}, {dot(Z_A, Z_B)}) - {_SINE}, {_SINE}))"
TILT = (f"(-{_F}*{dot(Y_A, Z_B)})", f"({_F}*{dot(X_A, Z_B)})")

SMALL = 0.1  #: terms of the series fall by 1/20 each, and differences of the closed form lose two digits
TERMS = 14


@kernel
def projections(frames, a, b):
    """u, the components of z_b in the axes of frame a."""
    u1, u2, u3 = 0.0, 0.0, 0.0
    for i in range(3):
        z = frames[b, Z + i]
        u1 += frames[a, X + i] * z
        u2 += frames[a, Y + i] * z
        u3 += frames[a, Z + i] * z
    return u1, u2, u3


@kernel
def stretch(u1, u2, u3):
    """f and its first two derivatives with respect to u_3."""
    w = 1.0 - u3
    if w > SMALL:
        sine2 = u1 * u1 + u2 * u2
        f = atan2(sqrt(sine2), u3) / sqrt(sine2)
        f1 = (f * u3 - 1.0) / sine2
        return f, f1, (f + 3.0 * u3 * f1) / sine2
    f, f1, f2 = 1.0, 0.0, 0.0
    a, power, lower, lowest = 1.0, 1.0, 0.0, 0.0  # a_n, w^n, w^(n - 1), w^(n - 2)
    for n in range(1, TERMS):
        a *= n / (2.0 * n + 1.0)
        lowest, lower, power = lower, power, power * w
        f += a * power
        f1 -= n * a * lower
        f2 += n * (n - 1.0) * a * lowest
    return f, f1, f2


@kernel
def across(frames, a, e, b):
    """c, the product of the axis of frame a at column e with z_b."""
    x, y, z = frames[b, Z], frames[b, Z + 1], frames[b, Z + 2]
    ax, ay, az = frames[a, e], frames[a, e + 1], frames[a, e + 2]
    return ay * z - az * y, az * x - ax * z, ax * y - ay * x


@kernel
def tilt(frames, a, b, G, k):
    """g = sigma in rows k and k + 1 [rad]."""
    u1, u2, u3 = projections(frames, a, b)
    f, f1, _f2 = stretch(u1, u2, u3)
    c1, c2, c3 = across(frames, a, X, b), across(frames, a, Y, b), across(frames, a, Z, b)
    G[k, C.VALUE], G[k + 1, C.VALUE] = -f * u2, f * u1
    for i in range(3):
        first, second = -f1 * u2 * c3[i] - f * c2[i], f1 * u1 * c3[i] + f * c1[i]
        G[k, PHI_A + i], G[k, PHI_B + i] = first, -first
        G[k + 1, PHI_A + i], G[k + 1, PHI_B + i] = second, -second


@kernel
def tilt_hessian(frames, a, b, s1, s2, H):
    """H += d(G^T s)/dz, from the derivatives of s . sigma with respect to u."""
    u1, u2, u3 = projections(frames, a, b)
    f, f1, f2 = stretch(u1, u2, u3)
    along = s2 * u1 - s1 * u2
    dot1_hessian(frames, a, X, b, Z, f * s2, H)
    dot1_hessian(frames, a, Y, b, Z, -f * s1, H)
    dot1_hessian(frames, a, Z, b, Z, f1 * along, H)
    c1, c2, c3 = across(frames, a, X, b), across(frames, a, Y, b), across(frames, a, Z, b)
    for i in range(3):
        for j in range(3):
            h = f1 * s2 * (c1[i] * c3[j] + c3[i] * c1[j]) - f1 * s1 * (c2[i] * c3[j] + c3[i] * c2[j])
            add(h + f2 * along * c3[i] * c3[j], i, j, H)


@kernel
def add(h, i, j, H):
    """Add a second derivative with respect to W."""
    H[PHI_A + i, PHI_A + j] += h
    H[PHI_A + i, PHI_B + j] -= h
    H[PHI_B + i, PHI_A + j] -= h
    H[PHI_B + i, PHI_B + j] += h


@kernel
def twist(frames, a, b, p, G, k):
    """g = psi [rad]. p[0] is its value at the end of the last accepted step, p[1] becomes that of this evaluation."""
    sine, cosine, u3 = 0.0, 0.0, 0.0
    for i in range(3):
        sine += frames[a, Y + i] * frames[b, X + i] - frames[a, X + i] * frames[b, Y + i]
        cosine += frames[a, X + i] * frames[b, X + i] + frames[a, Y + i] * frames[b, Y + i]
        u3 += frames[a, Z + i] * frames[b, Z + i]
    g = atan2(sine, cosine)
    p[1] = g + 2.0 * pi * floor((p[0] - g) / (2.0 * pi) + 0.5)
    G[k, C.VALUE] = p[1]
    for i in range(3):
        m = (frames[a, Z + i] + frames[b, Z + i]) / (1.0 + u3)
        G[k, PHI_A + i], G[k, PHI_B + i] = -m, m


@kernel
def twist_hessian(frames, a, b, factor, H):
    """H += factor * d(G^T)/dz, with dm = (dphi_a x z_a + dphi_b x z_b - m du_3)/(1 + u_3)."""
    u3 = 0.0
    for i in range(3):
        u3 += frames[a, Z + i] * frames[b, Z + i]
    c = factor / (1.0 + u3)
    n = across(frames, a, Z, b)
    for j in range(3):
        for i in range(3):
            m = (frames[a, Z + i] + frames[b, Z + i]) / (1.0 + u3)
            add(c * m * n[j], i, j, H)
    for f, column in ((a, PHI_A), (b, PHI_B)):
        for i in range(3):  # e_j x z = -(z~) e_j
            j, k = (i + 1) % 3, (i + 2) % 3
            z = c * frames[f, Z + k]
            H[PHI_B + i, column + j] += z
            H[PHI_B + j, column + i] -= z
            H[PHI_A + i, column + j] -= z
            H[PHI_A + j, column + i] += z
