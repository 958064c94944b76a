"""Slider crank with a flexible rod in the floating frame of reference: writes flexible_slider_crank.json.

Two derivations, neither of mbdsl: `closed` has the inertia in closed integrals, coordinates phi1, phi2, q and one
Lagrange multiplier (the guide force at B); `nodes` puts mass points on Gauss nodes and has the minimal coordinates
phi1, q. Extrapolated midpoint rule (Gragg) in 80-bit arithmetic gives the values, DOP853 and Radau confirm them.
"""

import json
import sys
from pathlib import Path

import mpmath
import numpy as np
from scipy.integrate import solve_ivp

mpmath.mp.dps = 30
TIMES = ["0.1", "0.25", "0.5", "1", "1.5", "2"]

HEAD = dict(
    problem="Slider crank with a flexible connecting rod, floating frame of reference with given shape functions",
    parameters=dict(
        m1=3,
        L1=0.3,
        m2=0.9,
        L2=0.6,
        E=200e9,
        A=5.74e-6,
        second_moment=2.765e-8,
        g=9.81,
        crank="OA, uniform rod, inertia m1 L1^2/3 about O, pinned to the ground at O = (0, 0)",
        rod="AB, Euler-Bernoulli beam, rho A = m2/L2, no rotary inertia, no damping, linear: no foreshortening",
        slider="B on the x axis, y_B = 0, no mass, no friction; gravity along -y",
        initial="phi1 = 0, phi1' = 1 rad/s, crank and rod along +x, undeformed, elastic velocities zero, phi2' = -0.5",
    ),
    shape_functions=(
        "position of the point x from A in the rod's axes (x + s, v); v = sum q_n sin(n pi x/L2), n = 1..nb; "
        "s = sum q_(nb+j) sin((2j-1) pi x/(2 L2)), j = 1..na; the x axis of the rod is the chord AB, angle phi2 from +x"
    ),
    inertia="all terms of T = 1/2 int rho A |r'|^2 dx; V = 1/2 int EI v''^2 + EA s'^2 dx + weight of crank and rod",
    constraint="phi2 = -asin(L1 sin phi1/(L2 + s(L2)))",
    forces=(
        "force_on_crank_at_O of the ground, force_on_rod_at_A of the crank, guide force on the rod at B along +y; from "
        "the multiplier and the momentum of rod and crank; the crank's balance of moments about O holds to 1e-12"
    ),
    trusted_digits=(
        "15 of phi1, phi1', phi2, phi2', xB, relative to 1; q 12, q' 11, forces 11, relative to their largest values; "
        "neither chaotic nor sensitive up to 2 s; parameters rounded to doubles change q by some 1e-12 of their size"
    ),
    verified_by=(
        "flexible_slider_crank.py: two derivations, agreeing in 80-bit arithmetic to 3e-19; values by extrapolation "
        "with two steps and orders, confirmed by DOP853 and by Radau IIA of order 5 (see agreement, in the order of t)"
    ),
)


class Crank:
    """The mechanism with nb bending and na axial modes of the rod, in numbers of type `real`."""

    def __init__(self, nb, na, real=np.longdouble):
        self.real, self.nb, self.na = real, nb, na
        number = real
        self.m1, self.L1, self.m2, self.L2 = (number(x) for x in ("3", "0.3", "0.9", "0.6"))
        self.g = number("9.81")
        young, area, second = number("200e9"), number("5.74e-6"), number("2.765e-8")
        m, L = self.m2, self.L2
        pi = number(mpmath.nstr(mpmath.pi, 25))
        n, j = np.arange(1, nb + 1).astype(real), np.arange(1, na + 1).astype(real)
        self.kb, self.ka = n * pi / L, (2 * j - 1) * pi / (2 * L)  # wave numbers
        self.k = np.concatenate([young * second * self.kb**4, young * area * self.ka**2]) * L / 2  # stiffnesses
        # integrals over the mass: sin, x sin, and the products of an axial and a bending function
        sign_n, sign_j = (-1) ** np.arange(nb), (-1) ** np.arange(na)
        self.one_b, self.one_a = m * (1 + sign_n) / (self.kb * L), m / (self.ka * L)
        self.x_b, self.x_a = m * sign_n / self.kb, m * sign_j / (self.ka**2 * L)
        d, s = self.ka[:, None] - self.kb[None, :], self.ka[:, None] + self.kb[None, :]
        self.ab = m / (2 * L) * (np.sin(d * L) / d - np.sin(s * L) / s)
        self.end = sign_j.astype(real)  # axial functions at B
        nodes = mpmath.calculus.quadrature.GaussLegendre(mpmath.mp).calc_nodes(4, 110)  # 24 nodes
        self.x = np.array([number(mpmath.nstr((1 + t) / 2, 25)) for t, _ in nodes]) * L
        self.dm = np.array([number(mpmath.nstr(w / 2, 25)) for _, w in nodes]) * m

    def rod(self, phi1, q, w, qd):
        """phi2, its rate, and the rod's length and its rate."""
        qa, qad = q[self.nb :], qd[self.nb :]
        length, rate = self.L2 + self.end @ qa, self.end @ qad
        phi2 = -np.arcsin(self.L1 * np.sin(phi1) / length)
        w2 = -(self.L1 * np.cos(phi1) * w + np.sin(phi2) * rate) / (length * np.cos(phi2))
        return phi2, w2, length, rate

    def solve(self, a, b):
        """Solve a x = b; by iterative refinement beyond double precision."""
        if self.real is np.float64:
            return np.linalg.solve(a, b)
        inverse = np.linalg.inv(a.astype(float))
        x = (inverse @ b.astype(float)).astype(self.real)
        for _ in range(3):
            x = x + inverse @ (b - a @ x).astype(float)
        return x

    def closed(self, y, everything=False):
        """Rates of y = (phi1, q, phi1', q') by closed integrals and a Lagrange multiplier."""
        nb, n, m, L1, g = self.nb, self.nb + self.na, self.m2, self.L1, self.g
        phi1, q, w, qd = y[0], y[1 : n + 1], y[n + 1], y[n + 2 :]
        phi2, w2, length, rate = self.rod(phi1, q, w, qd)
        b, a, bd, ad = q[:nb], q[nb:], qd[:nb], qd[nb:]
        c1, s1, c2, s2 = np.cos(phi1), np.sin(phi1), np.cos(phi2), np.sin(phi2)
        sx, sy = m * self.L2 / 2 + self.one_a @ a, self.one_b @ b  # mass times centre of mass, in the rod's axes
        sxd, syd = self.one_a @ ad, self.one_b @ bd
        # the joint A seen in the rod's axes: unit vector across the crank and its centripetal acceleration
        sd, cd = np.sin(phi1 - phi2), np.cos(phi1 - phi2)
        tx, ty = -sd, cd
        ax, ay = -L1 * w * w * cd, -L1 * w * w * sd
        M = np.zeros((n + 3, n + 3), self.real)
        h = np.zeros(n + 3, self.real)
        M[0, 0] = self.m1 * L1**2 / 3 + m * L1**2
        M[0, 1] = M[1, 0] = L1 * (-tx * sy + ty * sx)
        M[0, 2 : nb + 2] = M[2 : nb + 2, 0] = L1 * ty * self.one_b
        M[0, nb + 2 : n + 2] = M[nb + 2 : n + 2, 0] = L1 * tx * self.one_a
        M[1, 1] = m * self.L2**2 / 3 + 2 * (self.x_a @ a) + m / 2 * (q @ q)
        M[1, 2 : nb + 2] = M[2 : nb + 2, 1] = self.x_b + a @ self.ab
        M[1, nb + 2 : n + 2] = M[nb + 2 : n + 2, 1] = -self.ab @ b
        for i in range(2, n + 2):
            M[i, i] = m / 2
        # minus the inertia forces of zero accelerations, weight (in the rod's axes: -g (s2, c2)) and elastic forces
        bx, by = ax + g * s2, ay + g * c2
        h[0] = -self.m1 * g * L1 / 2 * c1 - L1 * (
            tx * (m * bx - w2 * w2 * sx - 2 * w2 * syd) + ty * (m * by - w2 * w2 * sy + 2 * w2 * sxd)
        )
        h[1] = sy * bx - sx * by - 2 * w2 * (self.x_a @ ad + m / 2 * (q @ qd))
        h[2 : nb + 2] = -self.one_b * by + w2 * w2 * m / 2 * b - 2 * w2 * (ad @ self.ab)
        h[nb + 2 : n + 2] = -self.one_a * bx + w2 * w2 * (self.x_a + m / 2 * a) + 2 * w2 * (self.ab @ bd)
        h[2 : n + 2] -= self.k * q
        # y of B: L1 sin phi1 + length sin phi2 = 0
        G = np.concatenate([[L1 * c1, length * c2], np.zeros(nb, self.real), s2 * self.end])
        M[n + 2, : n + 2] = G
        M[: n + 2, n + 2] = -G
        h[n + 2] = L1 * s1 * w * w + length * s2 * w2 * w2 - 2 * c2 * w2 * rate
        x = self.solve(M, h)
        acc = np.concatenate([x[:1], x[2 : n + 2]])
        if not everything:
            return np.concatenate([y[n + 1 :], acc])
        guide, alpha, w2d = x[n + 2], x[0], x[1]
        # momentum of the rod: force of the crank on the rod at A, then of the ground on the crank at O
        rx = m * (ax + L1 * tx * alpha) - w2 * w2 * sx - 2 * w2 * syd - w2d * sy + self.one_a @ x[nb + 2 : n + 2]
        ry = m * (ay + L1 * ty * alpha) - w2 * w2 * sy + 2 * w2 * sxd + w2d * sx + self.one_b @ x[2 : nb + 2]
        fax, fay = c2 * rx - s2 * ry, s2 * rx + c2 * ry + m * g - guide
        fox = fax + self.m1 * L1 / 2 * (-s1 * alpha - c1 * w * w)
        foy = fay + self.m1 * L1 / 2 * (c1 * alpha - s1 * w * w) + self.m1 * g
        moment = self.m1 * L1**2 / 3 * alpha + self.m1 * g * L1 / 2 * c1 + L1 * (c1 * fay - s1 * fax)  # of crank, 0
        vm = np.concatenate([y[n + 1 : n + 2], [w2], y[n + 2 :]])
        energy = (vm @ M[: n + 2, : n + 2] @ vm) / 2 + (self.k * q) @ q / 2
        energy += g * (self.m1 * L1 / 2 * s1 + m * L1 * s1 + s2 * sx + c2 * sy)
        out = dict(phi1=phi1, omega1=w, phi2=phi2, omega2=w2, q=list(q), qd=list(qd))
        out |= dict(xB=L1 * c1 + length * c2, yB=L1 * s1 + length * s2)
        out["v_mid"] = np.sin(self.kb * self.L2 / 2) @ b if nb else self.real(0)
        out |= dict(energy=energy, force_on_crank_at_O=[fox, foy], force_on_rod_at_A=[fax, fay])
        out |= dict(guide_force_on_rod_at_B=guide, moment_balance_of_crank=moment)
        return out

    def nodes(self, y):
        """The same rates by mass points on Gauss nodes, phi2 eliminated."""
        nb, n, L1 = self.nb, self.nb + self.na, self.L1
        phi1, q, w, qd = y[0], y[1 : n + 1], y[n + 1], y[n + 2 :]
        phi2, w2, length, rate = self.rod(phi1, q, w, qd)
        fb, fa = np.sin(np.outer(self.kb, self.x)), np.sin(np.outer(self.ka, self.x))
        e2 = np.cos(phi2) + 1j * np.sin(phi2)
        e1 = np.cos(phi1) + 1j * np.sin(phi1)
        local = self.x + q[nb:] @ fa + 1j * (q[:nb] @ fb)
        local_d = qd[nb:] @ fa + 1j * (qd[:nb] @ fb)
        turn = np.zeros(n + 1, self.real)  # phi2' = turn @ (phi1', q')
        turn[0] = -L1 * np.cos(phi1) / (length * np.cos(phi2))
        turn[nb + 1 :] = -np.sin(phi2) * self.end / (length * np.cos(phi2))
        bias = (L1 * np.sin(phi1) * w * w + length * np.sin(phi2) * w2 * w2 - 2 * np.cos(phi2) * w2 * rate) / (
            length * np.cos(phi2)
        )
        B = np.concatenate([np.full((1, len(self.x)), 1j * L1 * e1), e2 * 1j * fb, e2 * fa])
        B = B + turn[:, None] * (1j * e2 * local)[None, :]
        acc = -L1 * w * w * e1 + e2 * (1j * bias * local - w2 * w2 * local + 2j * w2 * local_d) + 1j * self.g
        M = ((B * self.dm) @ B.conj().T).real
        M[0, 0] += self.m1 * L1**2 / 3
        h = -((B.conj() * self.dm) @ acc).real
        h[0] -= self.m1 * self.g * L1 / 2 * np.cos(phi1)
        h[1:] -= self.k * q
        return np.concatenate([y[n + 1 :], self.solve(M, h)])

    def start(self):
        y = np.zeros(2 * (self.nb + self.na) + 2, self.real)
        y[self.nb + self.na + 1] = 1
        return y


def extrapolate(f, y, steps, H, k):
    """Steps of size H of the midpoint rule with 2, 4, ..., 2k substeps, extrapolated to order 2k."""
    for _ in range(steps):
        f0 = f(y)
        table = []
        for j in range(1, k + 1):
            h = H / (2 * j)
            z0, z1 = 0 * y, h * f0  # increments are summed, which loses less to rounding
            for _ in range(2 * j - 1):
                z0, z1 = z1, z0 + 2 * h * f(y + z1)
            row = [z1]
            for i in range(1, j):
                row.append(row[i - 1] + (row[i - 1] - table[-1][i - 1]) / ((type(H)(j) / (j - i)) ** 2 - 1))
            table.append(row)
        y = y + table[-1][-1]
    return y


def by_extrapolation(model, per_second, k):
    one = model.real(1)
    y, done, states = model.start(), 0, []
    for t in TIMES:
        upto = round(float(t) * per_second)
        y, done = extrapolate(model.closed, y, upto - done, one / per_second, k), upto
        states.append(y)
    return np.array(states)


def by_scipy(rates, y0, method, rtol, atol):
    times = [float(t) for t in TIMES]
    return solve_ivp(rates, (0, 2), y0, method=method, t_eval=times, rtol=rtol, atol=atol).y.T


def text(value):
    if isinstance(value, list):
        return [text(v) for v in value]
    if isinstance(value, dict):
        return {k: text(v) for k, v in value.items()}
    return np.format_float_scientific(value, 18, unique=False) if isinstance(value, np.floating) else value


def check_derivations(nb, na):
    """Largest relative difference of the accelerations of the two derivations at random states."""
    model, rng, worst = Crank(nb, na), np.random.default_rng(1), 0
    for _ in range(200):
        y = rng.standard_normal(2 * (nb + na) + 2).astype(np.longdouble)
        y[1 : nb + na + 1] *= 0.03
        a, b = model.closed(y), model.nodes(y)
        worst = max(worst, float(np.max(np.abs(a - b)) / np.max(np.abs(a))))
    return worst


def case(nb, na, fine, coarse):
    """The values by the finer extrapolation, and how far the others are from them."""
    model, double = Crank(nb, na), Crank(nb, na, np.float64)
    y, other = by_extrapolation(model, *fine), by_extrapolation(model, *coarse)
    n = nb + na
    scale = np.max(np.abs(y), axis=0)

    def compare(z):
        error = np.abs(z - y)
        groups = dict(phi1=error[:, 0], omega1=error[:, n + 1])
        if n:
            relative = error / scale
            groups |= dict(q_relative_to_largest=np.max(relative[:, 1 : n + 1], axis=1))
            groups |= dict(qd_relative_to_largest=np.max(relative[:, n + 2 :], axis=1))
        return {name: [f"{float(v):.1e}" for v in e] for name, e in groups.items()}

    start = model.start()
    rows, energy = [], model.closed(start, True)["energy"]
    for t, state in zip(TIMES, y, strict=True):
        out = model.closed(state, True)
        rows.append(dict(t=t) | text({k: v for k, v in out.items() if k != "moment_balance_of_crank"}))
        assert abs(out["moment_balance_of_crank"]) < 1e-12 and abs(out["energy"] - energy) < 1e-13
    atol = np.full(2 * n + 2, 1e-13)
    loose = np.full(2 * n + 2, 1e-12)
    atol[1 : n + 1], atol[n + 2 :], loose[1 : n + 1] = 1e-19, 1e-16, 1e-14
    start = start.astype(float)
    return dict(
        bending_modes=nb,
        axial_modes=na,
        elastic_coordinates=[f"q{i + 1} ({'bending' if i < nb else 'axial'})" for i in range(n)],
        rows=rows,
        agreement={
            f"extrapolation of order {2 * fine[1]}, {fine[0]} steps/s, and {2 * coarse[1]}, {coarse[0]}": compare(
                other
            ),
            "DOP853, rtol 1e-13, closed integrals": compare(
                by_scipy(lambda t, z: double.closed(z), start, "DOP853", 1e-13, atol)
            ),
            "Radau, rtol 1e-11, Gauss nodes": compare(
                by_scipy(lambda t, z: double.nodes(z), start, "Radau", 1e-11, loose)
            ),
            "accelerations of the two derivations, relative, 200 random states": f"{check_derivations(nb, na):.1e}",
            "energy at 2 s": f"{float(out['energy'] - energy):.1e}",
        },
    )


def main():
    target = Path(__file__).with_suffix(".json")
    cases = {
        "flexible_3_bending_1_axial": ((3, 1), (20000, 8), (16000, 9)),
        "flexible_2_bending": ((2, 0), (20000, 8), (16000, 8)),
        "rigid": ((0, 0), (8000, 8), (4000, 9)),
    }
    if len(sys.argv) > 1:  # one case, written to a file of its own
        name, target = sys.argv[1], Path(sys.argv[2])
        target.write_text(json.dumps({name: case(*cases[name][0], *cases[name][1:])}, indent=1) + "\n")
        return
    data = {name: case(*args[0], *args[1:]) for name, args in cases.items()}
    target.write_text(json.dumps(HEAD | dict(data=data), indent=1) + "\n")


if __name__ == "__main__":
    main()
