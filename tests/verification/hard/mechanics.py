"""Equations of motion in minimal coordinates, written by hand for ``answers.py``; nothing of mbdsl."""

import numpy as np
from scipy.optimize import brentq

G = 9.81


def links(masses, lengths, knee=0.0):
    """Uniform links hanging from each other; a spring of ``knee`` [N.m/rad] in the second pin. y = angles, rates."""
    mass, L = np.array(masses, float), np.array(lengths, float)
    n = len(L)
    # centre of link i: sum of a[i, j] (cos, sin)(phi_j)
    a = np.tril(np.tile(L, (n, 1)), -1) + np.diag(L / 2)
    B = np.einsum("i,ij,ik->jk", mass, a, a)
    pull = mass @ a

    def rhs(t, y):
        phi, w = y[:n], y[n:]
        d = phi[:, None] - phi[None, :]
        M = B * np.cos(d) + np.diag(mass * L**2 / 12)
        f = -(B * np.sin(d)) @ w**2 - G * pull * np.cos(phi)
        if knee:
            torque = knee * (phi[1] - phi[0])
            f[:2] += torque, -torque
        # mass ratios of 1e9: rows are scaled before the system is solved
        size = np.sqrt(np.diag(M))
        return np.concatenate([w, np.linalg.solve(M / np.outer(size, size), f / size) / size])

    return rhs


def bushed(k):
    """A rod of 1 kg and 1 m whose end is held by springs. y = x, y, phi of its centre, rates."""

    def rhs(t, y):
        x, z, phi, vx, vz, w = y
        fx, fz = -k * (x - 0.5 * np.cos(phi)), -k * (z - 0.5 * np.sin(phi))
        # the force acts at the end, by -0.5 (cos, sin) from the centre
        return [vx, vz, w, fx, fz - G, 12 * (-0.5 * np.cos(phi) * fz + 0.5 * np.sin(phi) * fx)]

    return rhs


L1, L2, M1, M2 = 0.3, 0.6, 3.0, 0.9


def _rod(th, w, side=1):
    """Angle of the rod, its derivative by th and the second one; the slider is at th = 0 on the right."""
    ph = -np.arcsin(L1 * np.sin(th) / L2)
    d = -L1 * np.cos(th) / (L2 * np.cos(ph))
    dd = (L1 * np.sin(th) + L2 * np.sin(ph) * d**2) / (L2 * np.cos(ph))
    if side < 0:  # mirrored: pi - ph
        return np.pi - ph, -d, -dd
    return ph, d, dd


def _crank(y, k, c, side=1):
    """The acceleration of the crank, by the principle of virtual power."""
    th, w = y
    ph, d, dd = _rod(th, w, side)
    # centre of the rod: L1 e(th) + L2/2 e(ph); its derivative by th, and the second
    J = np.array([-L1 * np.sin(th) - L2 / 2 * np.sin(ph) * d, L1 * np.cos(th) + L2 / 2 * np.cos(ph) * d])
    H = np.array([-L1 * np.cos(th) - L2 / 2 * (np.cos(ph) * d**2 + np.sin(ph) * dd),
                  -L1 * np.sin(th) + L2 / 2 * (-np.sin(ph) * d**2 + np.cos(ph) * dd)])  # fmt: skip
    x = L1 * np.cos(th) + L2 * np.cos(ph)
    dx = -L1 * np.sin(th) - L2 * np.sin(ph) * d
    I2 = M2 * L2**2 / 12
    inertia = M1 * L1**2 / 3 + M2 * J @ J + I2 * d**2
    rest = M2 * J @ H + I2 * d * dd
    force = -k * (x - 0.9) - c * dx * w
    gravity = -M1 * G * L1 / 2 * np.cos(th) - M2 * G * J[1]
    return (force * dx + gravity - rest * w**2) / inertia, ph, d, dd, J, H, force


def slider_crank(t, y):
    """With the spring of 100 N/m and damper of 5 N.s/m."""
    return [y[1], _crank(y, 100.0, 5.0)[0]]


def slot(t, y):
    """The force of the slot on the rod's end: moments of the rod about its other end."""
    acc, ph, d, dd, J, H, force = _crank(y, 100.0, 5.0)
    w = y[1]
    a = J * acc + H * w**2
    alpha = d * acc + dd * w**2
    r = L2 / 2 * np.array([np.cos(ph), np.sin(ph)])
    # I alpha + r x m a = r x m g + 2 r x (force, N)
    left = M2 * L2**2 / 12 * alpha + M2 * (r[0] * (a[1] + G) - r[1] * a[0])
    return (left + 2 * r[1] * force) / (2 * r[0])


def free_crank(side):
    """Without spring, the slider on the right (1) or left (-1)."""
    return lambda t, y: [y[1], _crank(y, 0.0, 0.0, side)[0]]


def massless(t, y):
    """Crank of 2 kg, slider of 1 kg, nothing between."""
    th, w = y
    ph, d, dd = _rod(th, w)
    dx = -L1 * np.sin(th) - L2 * np.sin(ph) * d
    ddx = -L1 * np.cos(th) - L2 * (np.cos(ph) * d**2 + np.sin(ph) * dd)
    inertia = 2 * L1**2 / 3 + dx**2
    return [w, (-2 * G * L1 / 2 * np.cos(th) - dx * ddx * w**2) / inertia]


def _folding_inertia(th):
    """Of crank and rod, 1 kg and 0.5 m each, with rod.phi = -crank.phi: (inertia, its derivative)."""
    L = 0.5
    value = L**2 / 3 + L**2 / 12 + L**2 * (2.25 * np.sin(th) ** 2 + 0.25 * np.cos(th) ** 2)
    return value, L**2 * 4.0 * np.sin(th) * np.cos(th)


def folding(t, y):
    inertia, slope = _folding_inertia(y[0])
    return [y[1], -0.5 * slope * y[1] ** 2 / inertia]


def folding_energy(th, w):
    return 0.5 * _folding_inertia(th)[0] * w**2


def on_a_belt(t, y, vs=1e-3):
    """A block of 1 kg on a belt of 0.1 m/s, on a spring of 100 N/m, pressed by 10 N."""
    v = y[1] - 0.1
    return [y[1], -100 * y[0] - 10 * (0.3 + 0.2 * np.exp(-((v / (40 * vs)) ** 2))) * np.tanh(v / vs)]


def bounced(t, k, g=10.0, height=1.0):
    """Height of a ball of 1 kg that falls on a spring, at times t."""
    fall = np.sqrt(2 * height / g)
    v, w = g * fall, np.sqrt(k)

    def arc(s):  # since the contact: y'' = -k y - g
        return -v / w * np.sin(w * s) + g / k * (np.cos(w * s) - 1)

    contact = brentq(arc, 1.5 / w, 5.0 / w, xtol=1e-16)
    s = np.mod(np.asarray(t) + fall, 2 * fall + contact)  # since it left the spring
    flying = s < 2 * fall
    return np.where(flying, v * s - g / 2 * s**2, arc(s - 2 * fall))


def rattled(t, k, gap):
    """Position of a mass of 1 kg between two springs, from the middle at 1 m/s."""
    w = np.sqrt(k)
    half = 2 * gap + np.pi / w
    n, s = np.divmod(np.asarray(t) + gap, half)  # since it left the stop on one side
    return (-1.0) ** n * np.where(s < 2 * gap, s - gap, gap + np.sin(w * (s - 2 * gap)) / w)


def pushed(t, knots, forces):
    """Position and velocity of 1 kg under a force of straight lines that then stays."""
    knots, forces = [*knots, 1e9], [*forces, forces[-1]]
    x, v, found = 0.0, 0.0, {}
    for a, b, f, g in zip(knots, knots[1:], forces, forces[1:], strict=False):
        slope = (g - f) / (b - a)
        for one in t:
            if a <= one <= b:
                s = one - a
                found[one] = (x + v * s + f * s**2 / 2 + slope * s**3 / 6, v + f * s + slope * s**2 / 2)
        s = b - a
        x, v = x + v * s + f * s**2 / 2 + slope * s**3 / 6, v + f * s + slope * s**2 / 2
    return np.array([found[one] for one in t]).T


def dropped_cantilever(t, g):
    """Tip of a cantilever of 1 kg, 1 m and EI = 1 N.m2 under gravity from t = 0 on: w_i = beta_i^2."""
    tip = np.zeros(len(t))
    for i in range(30):

        def frequency(b):  # cos(b) cosh(b) + 1, divided by cosh(b)
            return np.cos(b) + 1 / np.cosh(b)

        b = brentq(frequency, max(1.0, np.pi * (i + 0.5) - 0.4), np.pi * (i + 0.5) + 0.4, xtol=1e-14)
        sigma = (np.cosh(b) + np.cos(b)) / (np.sinh(b) + np.sin(b))
        shape = 2.0 * (-1) ** i  # at the tip, for a mean square of 1
        tip -= shape * 2 * sigma / b * g / b**4 * (1 - np.cos(b**2 * t))
    return tip
