"""Rotations: quaternions, the exponential of a rotation vector, and its tangent; kernels, and the same for arrays.

With t = |psi|, and psi~ the matrix of the cross product psi x:

    exp(psi~) as a quaternion:  (cos(t/2), sin(t/2)/t psi)
    exp((psi + d)~) = exp(psi~) exp((T d)~) to first order in d
    T(psi)      = I - (1 - cos t)/t^2 psi~ + (t - sin t)/t^3 psi~^2
    T(psi)^{-1} = I + psi~/2 + (1 - t/2 cot(t/2))/t^2 psi~^2
    Omega = T(psi) psi',   Omega' = T(psi) psi'' + (T(psi))' psi'

Matrices in flat arrays are stored row by row. Quaternions p = (p0, p1, p2, p3) have the scalar part first.

Source: O. Bruels, A. Cardona, M. Arnold, Mech. Mach. Theory 48 (2012) 121-137.
"""

from math import atan2, cos, sin, sqrt

from mbdsl.kernels.marks import kernel

#: below this angle [rad], series replace quotients of small numbers
SMALL = 1e-2
#: offsets in the buffer ``numbers`` from the R of a rotation R = R_0 exp(psi~): of the quaternion of R_0, and of the
#: inverse of the body's moments of inertia, which is zero if they are singular
BASE, INVERSE_INERTIA = 9, 31


@kernel
def half(x, y, z):
    """cos(t/2) and sin(t/2)/t of a rotation vector."""
    t2 = x * x + y * y + z * z
    if t2 < SMALL * SMALL:
        return 1.0 - t2 / 8.0 * (1.0 - t2 / 48.0 * (1.0 - t2 / 120.0)), 0.5 - t2 / 48.0 * (1.0 - t2 / 80.0)
    t = sqrt(t2)
    return cos(0.5 * t), sin(0.5 * t) / t


@kernel
def composed(p, x, y, z):
    """The quaternion of R(p) exp((x, y, z)~)."""
    c, s = half(x, y, z)
    x, y, z = s * x, s * y, s * z
    return (
        p[0] * c - (p[1] * x + p[2] * y + p[3] * z),
        p[1] * c + p[0] * x + (p[2] * z - p[3] * y),
        p[2] * c + p[0] * y + (p[3] * x - p[1] * z),
        p[3] * c + p[0] * z + (p[1] * y - p[2] * x),
    )


@kernel
def logarithm(p0, p1, p2, p3):
    """The rotation vector, of a length up to pi, of a unit quaternion."""
    size = sqrt(p1 * p1 + p2 * p2 + p3 * p3)
    # sin(t/2) = size and cos(t/2) = |p0|
    k = 2.0 * atan2(size, abs(p0)) / size if size > 1e-150 else 2.0
    if p0 < 0.0:  # -p is the same rotation
        k = -k
    return k * p1, k * p2, k * p3


@kernel
def attitude(psi, base, R):
    """Write the matrix R(base) exp(psi~), row by row, to R."""
    w, x, y, z = composed(base, psi[0], psi[1], psi[2])
    R[0], R[1], R[2] = 1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y - w * z), 2.0 * (x * z + w * y)
    R[3], R[4], R[5] = 2.0 * (x * y + w * z), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z - w * x)
    R[6], R[7], R[8] = 2.0 * (x * z - w * y), 2.0 * (y * z + w * x), 1.0 - 2.0 * (x * x + y * y)


@kernel
def turned(R, x, y, z):
    """R (x, y, z)."""
    return (
        R[0] * x + R[1] * y + R[2] * z,
        R[3] * x + R[4] * y + R[5] * z,
        R[6] * x + R[7] * y + R[8] * z,
    )


@kernel
def turned_back(R, x, y, z):
    """R^T (x, y, z)."""
    return (
        R[0] * x + R[3] * y + R[6] * z,
        R[1] * x + R[4] * y + R[7] * z,
        R[2] * x + R[5] * y + R[8] * z,
    )


@kernel
def turn(w, x, y, z, a):
    """Multiply the vector ``a`` by the rotation matrix of the unit quaternion (w, x, y, z)."""
    # a + 2 w (p x a) + 2 p x (p x a) with p = (x, y, z)
    i, j, k = y * a[2] - z * a[1], z * a[0] - x * a[2], x * a[1] - y * a[0]
    a[0] += 2.0 * (w * i + y * k - z * j)
    a[1] += 2.0 * (w * j + z * i - x * k)
    a[2] += 2.0 * (w * k + x * j - y * i)


@kernel
def product(A, B, C):
    """C <- A B, 3 x 3."""
    for i in range(3):
        for j in range(3):
            C[3 * i + j] = A[3 * i] * B[j] + A[3 * i + 1] * B[3 + j] + A[3 * i + 2] * B[6 + j]


@kernel
def square_coefficient(t2):
    """(1 - t/2 cot(t/2))/t^2, the factor of psi~^2 in T^{-1}, from t^2."""
    if t2 < SMALL * SMALL:
        return 1.0 / 12.0 + t2 / 720.0 * (1.0 + t2 / 42.0)
    t = sqrt(t2)
    return (1.0 - 0.5 * t * cos(0.5 * t) / sin(0.5 * t)) / t2


@kernel
def inverse_tangent(psi, T):
    """Write T(psi)^{-1}, row by row, to T."""
    x, y, z = psi[0], psi[1], psi[2]
    t2 = x * x + y * y + z * z
    c = square_coefficient(t2)
    T[0], T[4], T[8] = 1.0 + c * (x * x - t2), 1.0 + c * (y * y - t2), 1.0 + c * (z * z - t2)
    T[1], T[3] = c * x * y - 0.5 * z, c * x * y + 0.5 * z
    T[2], T[6] = c * x * z + 0.5 * y, c * x * z - 0.5 * y
    T[5], T[7] = c * y * z - 0.5 * x, c * y * z + 0.5 * x


@kernel
def untangled(psi, x, y, z):
    """T(psi)^{-1} (x, y, z) = d + psi x d/2 + c psi x (psi x d)."""
    a, b, c = psi[0], psi[1], psi[2]
    k = square_coefficient(a * a + b * b + c * c)
    u, v, w = b * z - c * y, c * x - a * z, a * y - b * x
    return (
        x + 0.5 * u + k * (b * w - c * v),
        y + 0.5 * v + k * (c * u - a * w),
        z + 0.5 * w + k * (a * v - b * u),
    )


@kernel
def untangled_back(psi, x, y, z):
    """T(psi)^{-T} (x, y, z) = T(psi)^{-1} d - psi x d."""
    a, b, c = psi[0], psi[1], psi[2]
    i, j, k = untangled(psi, x, y, z)
    return i - (b * z - c * y), j - (c * x - a * z), k - (a * y - b * x)


@kernel
def tangent_coefficients(t2):
    """b = (1 - cos t)/t^2 and c = (t - sin t)/t^3, the factors of -psi~ and psi~^2 in T, and their derivatives with
    respect to t^2."""
    if t2 < 1.0:
        # sums of (-t^2)^k/(2 k + 2)! and of (-t^2)^k/(2 k + 3)!, and their derivatives
        b, c, b1, c1, even, odd, power, before = 0.0, 0.0, 0.0, 0.0, 0.5, 1.0 / 6.0, 1.0, 0.0
        for k in range(10):
            b, c, b1, c1 = b + even * power, c + odd * power, b1 + k * even * before, c1 + k * odd * before
            before, power = power, power * t2
            even, odd = -even / ((2 * k + 3) * (2 * k + 4)), -odd / ((2 * k + 4) * (2 * k + 5))
        return b, c, b1, c1
    t = sqrt(t2)
    b, c = (1.0 - cos(t)) / t2, (t - sin(t)) / (t2 * t)
    return b, c, (0.5 * sin(t) / t - b) / t2, (0.5 * b - 1.5 * c) / t2


@kernel
def tangled(psi, x, y, z):
    """T(psi) (x, y, z) = d - b psi x d + c psi x (psi x d)."""
    p, q, r = psi[0], psi[1], psi[2]
    b, c, _, _ = tangent_coefficients(p * p + q * q + r * r)
    u, v, w = q * z - r * y, r * x - p * z, p * y - q * x
    return (
        x - b * u + c * (q * w - r * v),
        y - b * v + c * (r * u - p * w),
        z - b * w + c * (p * v - q * u),
    )


@kernel
def tangled_back(psi, x, y, z):
    """T(psi)^T (x, y, z) = T(psi) d + 2 b psi x d."""
    p, q, r = psi[0], psi[1], psi[2]
    b, _, _, _ = tangent_coefficients(p * p + q * q + r * r)
    b = 2.0 * b
    i, j, k = tangled(psi, x, y, z)
    return i + b * (q * z - r * y), j + b * (r * x - p * z), k + b * (p * y - q * x)


@kernel
def turning(psi, i, j, k):
    """(T(psi))' psi' with psi' = (i, j, k)."""
    p, q, r = psi[0], psi[1], psi[2]
    _, c, b1, c1 = tangent_coefficients(p * p + q * q + r * r)
    rate = 2.0 * (p * i + q * j + r * k)  # of t^2
    b1, c1 = rate * b1, rate * c1
    u, v, w = q * k - r * j, r * i - p * k, p * j - q * i
    return (
        c1 * (q * w - r * v) - b1 * u + c * (j * w - k * v),
        c1 * (r * u - p * w) - b1 * v + c * (k * u - i * w),
        c1 * (p * v - q * u) - b1 * w + c * (i * v - j * u),
    )


@kernel
def chart_acceleration(psi, spin, x, y, z):
    """psi'' = T(psi)^{-1} (Omega' - (T(psi))' psi') from the angular velocity ``spin`` and Omega' = (x, y, z)."""
    i, j, k = untangled(psi, spin[0], spin[1], spin[2])
    u, v, w = turning(psi, i, j, k)
    return untangled(psi, x - u, y - v, z - w)


@kernel
def spin_acceleration(psi, rate, x, y, z):
    """Omega' = T(psi) psi'' + (T(psi))' psi' from psi' = ``rate`` and psi'' = (x, y, z)."""
    u, v, w = turning(psi, rate[0], rate[1], rate[2])
    x, y, z = tangled(psi, x, y, z)
    return x + u, y + v, z + w
