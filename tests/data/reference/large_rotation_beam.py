"""Shear-rigid, extensible beam with large rotations, by global polynomials: for spin_up_beam.py, flexible_pendulum.py.

The axis is z(x, t) = x + u1 + i u2 in a frame that turns with the angle psi(t); strain |z'| - 1, curvature
Im(z''/z'), so that potential energy is the integral of EA/2 strain^2 + EI/2 curvature^2. One polynomial over the whole
length, orthonormal in the mass, clamped (u = 0, u2' = 0) or pinned (u = 0) at x = 0.
"""

import numpy as np
from numba import njit
from numpy.polynomial import legendre
from scipy.integrate import solve_ivp


@njit
def _rates(y, x, w, f1, d1, c1, f2, d2, c2, data):
    EA, EI, rhoA, rhoI, gravity, omega, alpha = data
    n1, n = f1.shape[1], f1.shape[1] + f2.shape[1]
    q1, q2, v1, v2 = y[:n1], y[n1:n], y[n : n + n1], y[n + n1 :]
    z = x + f1 @ q1 + 1j * (f2 @ q2)
    z1 = 1 + d1 @ q1 + 1j * (d2 @ q2)
    z2 = c1 @ q1 + 1j * (c2 @ q2)
    load = (gravity + (omega**2 - 1j * alpha) * z) * (rhoA * w)
    if omega != 0:
        load -= 2j * omega * rhoA * w * (f1 @ v1 + 1j * (f2 @ v2))
    length, moment = np.abs(z1), EI * (z2 / z1).imag
    # the strain's variation Re(conj(z')/|z'| dz'), the curvature's Im(dz''/z' - z'' dz'/z'^2)
    first = (EA * (length - 1) / length * z1 - 1j * moment * np.conj(z2 / z1**2)) * w
    if rhoI:
        ratio = (d1 @ v1 + 1j * (d2 @ v2)) / z1
        first += w * rhoI * (alpha - (ratio**2).imag) * 1j * np.conj(1 / z1)
    second = 1j * w * moment * np.conj(1 / z1)
    out = np.empty(2 * n)
    out[:n] = y[n:]
    out[n : n + n1] = load.real.copy() @ f1 - first.real.copy() @ d1 - second.real.copy() @ c1
    out[n + n1 :] = load.imag.copy() @ f2 - first.imag.copy() @ d2 - second.imag.copy() @ c2
    if rhoI:
        turn = np.empty((len(x), n))
        for i in range(len(x)):
            turn[i, :n1] = (1 / z1[i]).imag * np.sqrt(w[i] * rhoI) * d1[i]
            turn[i, n1:] = (1 / z1[i]).real * np.sqrt(w[i] * rhoI) * d2[i]
        out[n:] = np.linalg.solve(np.eye(n) + turn.T @ turn, out[n:])
    return out


class Beam:
    def __init__(self, L, EA, EI, rhoA, degree, rhoI=0.0, gravity=0j, clamped=True, spin=None):
        self.EA, self.EI, self.rhoA, self.rhoI, self.gravity, self.spin = EA, EI, rhoA, rhoI, gravity, spin
        s, w = legendre.leggauss(2 * degree + 8)
        s, w = np.append((1 + s) / 2, 1.0), np.append(w / 2 * L, 0.0)  # the last point is the tip
        self.x, self.w = s * L, w
        self.basis = [self._basis(s, w, L, degree, 1), self._basis(s, w, L, degree, 2 if clamped else 1)]
        self.n1, self.n2 = (b[0].shape[1] for b in self.basis)
        self.n = self.n1 + self.n2

    def _basis(self, s, w, L, degree, power):
        """Values and first two derivatives at the points of s^power times polynomials up to the degree."""
        count = degree + 1 - power
        p = [legendre.legvander(2 * s - 1, count - 1)]
        for order in (1, 2):
            rows = [legendre.legval(2 * s - 1, legendre.legder(e, order)) for e in np.eye(count)]
            p.append(np.array(rows).T * 2**order)
        a, b, c = s[:, None] ** power, power * s[:, None] ** (power - 1), power * (power - 1) * np.ones_like(s)[:, None]
        f = [a * p[0], (a * p[1] + b * p[0]) / L, (a * p[2] + 2 * b * p[1] + c * p[0]) / L**2]
        turn = np.linalg.inv(np.linalg.qr(np.sqrt(w * self.rhoA)[:, None] * f[0])[1])
        return [np.ascontiguousarray(g @ turn) for g in f]

    def field(self, q, order):
        f1, f2 = self.basis[0][order], self.basis[1][order]
        return f1 @ q[: self.n1] + 1j * (f2 @ q[self.n1 :])

    def rates(self, t, y):
        _, omega, alpha = self.spin(t) if self.spin else (0.0, 0.0, 0.0)
        (f1, d1, c1), (f2, d2, c2) = self.basis
        data = (self.EA, self.EI, self.rhoA, self.rhoI, self.gravity, omega, alpha)
        return _rates(y, self.x, self.w, f1, d1, c1, f2, d2, c2, data)

    def energy(self, y):
        """Without rotary inertia and spin."""
        z, z1, z2 = self.x + self.field(y[: self.n], 0), 1 + self.field(y[: self.n], 1), self.field(y[: self.n], 2)
        density = self.EA / 2 * (np.abs(z1) - 1) ** 2 + self.EI / 2 * (z2 / z1).imag ** 2
        return self.w @ (density - self.rhoA * (np.conj(self.gravity) * z).real) + y[self.n :] @ y[self.n :] / 2

    def run(self, end, times, method="DOP853", rtol=1e-12, atol=1e-13):
        start = np.zeros(2 * self.n)
        return solve_ivp(self.rates, (0, end), start, method=method, t_eval=times, rtol=rtol, atol=atol).y.T

    def tip(self, y):
        """Complex displacement and rotation of the tip, of each row."""
        f = [np.concatenate([b1[-1], 1j * b2[-1]]) for b1, b2 in zip(*self.basis, strict=True)]
        return y[:, : self.n] @ f[0], np.angle(1 + y[:, : self.n] @ f[1])
