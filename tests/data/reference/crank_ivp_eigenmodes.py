"""Makes crank_ivp_eigenmodes.json: the crank of the IVP test set with shape functions of one's choice, without mbdsl.

Minimal coordinates: phi1 = 150 t is given, phi2 follows from the guide, q are the rod's elastic coordinates. Points of
the rod are at L1 exp(i phi1) + exp(i phi2) (x + u + i v); all integrals by 40 Gauss points; the slider sits on the end.
With the test set's shapes and its J2 this gives the numbers of the independent model in flexible_crank_ivp.json, which
checks it; with eigenmodes of a rod pinned at one end and guided at the other it is the same model as a beam of mbdsl.
"""

import json
from pathlib import Path

import numpy as np
from scipy.integrate import solve_ivp

L1, L, RHO_A, EA, EI = 0.15, 0.3, 7870 * 0.008**2, 200e9 * 0.008**2, 200e9 * 0.008**4 / 12
SLIDER, W, J2 = 0.075552, 150.0, 0.0045339259
TIMES = [0.0025, 0.005, 0.0075, 0.01, 0.0125, 0.05, 0.1]


class Shapes:
    """Bending (value, second derivative) and axial (value, derivative) functions at points x."""

    def __init__(self, bending, axial):
        self.bending, self.axial = bending, axial


def sines(n):
    k = n * np.pi / L
    return lambda x: (np.sin(k * x), -(k**2) * np.sin(k * x))


def axial_sines(j):
    k = (2 * j - 1) * np.pi / (2 * L)
    return lambda x: (np.sin(k * x), k * np.cos(k * x))


#: the test set's quadratic element: middle and end
ELEMENT = [
    lambda x: (4 * x / L * (1 - x / L), (4 - 8 * x / L) / L),
    lambda x: (x / L * (2 * x / L - 1), (4 * x / L - 1) / L),
]


class Crank:
    def __init__(self, bending, axial, extra_inertia=0.0):
        y, w = np.polynomial.legendre.leggauss(40)
        self.x, self.dm = L * (1 + y) / 2, RHO_A * L * w / 2
        B, A = ([f(self.x) for f in fs] for fs in (bending, axial))
        zero = np.zeros_like(self.x)
        self.shape = np.array([1j * b for b, _ in B] + [a + 0j for a, _ in A])
        strains = np.array([np.sqrt(EI) * b for _, b in B] + [zero] * len(A))
        stretch = np.array([zero] * len(B) + [np.sqrt(EA) * a for _, a in A])
        w = L * w / 2
        self.K = (strains * w) @ strains.T + (stretch * w) @ stretch.T
        self.end = np.array([0.0] * len(B) + [f(np.array([L]))[0][0] for f in axial])
        self.n, self.extra = len(self.end), extra_inertia

    def angle(self, t, q, v):
        length, rate = L + self.end @ q, self.end @ v
        s, c = np.sin(W * t), np.cos(W * t)
        phi = -np.arcsin(L1 * s / length)
        w = -(L1 * c * W + np.sin(phi) * rate) / (length * np.cos(phi))
        bias = (L1 * s * W * W + length * np.sin(phi) * w * w - 2 * np.cos(phi) * w * rate) / (length * np.cos(phi))
        return phi, w, bias, length, rate

    def rates(self, t, y):
        q, v = y[: self.n], y[self.n :]
        phi, w, bias, length, rate = self.angle(t, q, v)
        turn = -np.tan(phi) * self.end / length  # w = turn @ v + ..., and the same of accelerations
        e1, e2 = np.exp(1j * W * t), np.exp(1j * phi)
        local, local_rate = self.x + q @ self.shape, v @ self.shape
        B = e2 * (self.shape + turn[:, None] * (1j * local)[None, :])
        a = -L1 * W * W * e1 + e2 * (1j * bias * local - w * w * local + 2j * w * local_rate)
        M = ((B * self.dm) @ B.conj().T).real + self.extra * np.outer(turn, turn)
        h = -((B.conj() * self.dm) @ a).real - self.K @ q - self.extra * turn * bias
        # the slider, whose x is L1 cos phi1 + length cos phi
        bs = self.end * np.cos(phi) - length * np.sin(phi) * turn
        s = -L1 * W * W * np.cos(W * t) - length * (np.sin(phi) * bias + np.cos(phi) * w * w)
        s -= 2 * np.sin(phi) * w * rate
        M += SLIDER * np.outer(bs, bs)
        h -= SLIDER * bs * s
        return np.concatenate([v, np.linalg.solve(M, h)])

    def history(self, method="DOP853", rtol=1e-12, times=TIMES):
        atol = np.concatenate([np.full(self.n, 1e-17), np.full(self.n, 1e-12)])
        found = solve_ivp(self.rates, (0, times[-1]), np.zeros(2 * self.n), method, times, rtol=rtol, atol=atol)
        out = []
        for t, y in zip(found.t, found.y.T, strict=True):
            phi, w, _, length, rate = self.angle(t, y[: self.n], y[self.n :])
            x3 = L1 * np.cos(W * t) + length * np.cos(phi)
            v3 = -L1 * W * np.sin(W * t) + rate * np.cos(phi) - length * np.sin(phi) * w
            out.append([phi, x3, *y[: self.n], w, v3, *y[self.n :]])
        return np.array(out)


def own(axial=2):
    return Crank([sines(1), sines(2)], [axial_sines(j + 1) for j in range(axial)])


def test_set():
    return Crank([sines(1), sines(2)], ELEMENT, J2 - RHO_A * L**3 / 3)


NAMES = ["phi2", "x3", "q1", "q2", "q3", "q4", "phi2'", "x3'", "q1'", "q2'", "q3'", "q4'"]


def main():
    fine, coarse = own().history(rtol=1e-12), own().history("Radau", 1e-10, TIMES[:5])
    published = json.loads((Path(__file__).parent / "flexible_crank_ivp.json").read_text())["own"]
    published = published["IC2_rigid_consistent__true_axial_mass_true_pi"]
    check = test_set().history(times=[0.05, 0.1])
    other = np.array([published[k][1:7] + published[k][8:] for k in ("y_t0p05", "y_t0p1")])
    data = dict(
        problem="crank of the IVP test set, start rigid and consistent (IC2), bending sin(pi x/L), sin(2 pi x/L), "
        "axial sin(pi x/(2 L)), sin(3 pi x/(2 L)); J2 is that of the uniform rod",
        names=NAMES,
        rows=[dict(t=t, y=[float(v) for v in y]) for t, y in zip(TIMES, fine, strict=True)],
        verified_by="crank_ivp_eigenmodes.py: DOP853, rtol 1e-12; differences of the first five rows to Radau IIA, "
        "rtol 1e-10, and of the program with the test set's shapes and J2 to IC2, true mass, in "
        "flexible_crank_ivp.json at 50 and 100 ms (largest of six coordinates; of six rates)",
        to_radau=[[float(f"{np.abs(d).max():.1e}") for d in (e[:6], e[6:])] for e in fine[:5] - coarse],
        to_published_model=[[float(f"{np.abs(d).max():.1e}") for d in (e[:6], e[6:])] for e in check - other],
    )
    Path(__file__).with_suffix(".json").write_text(json.dumps(data, indent=1) + "\n")


if __name__ == "__main__":
    main()
