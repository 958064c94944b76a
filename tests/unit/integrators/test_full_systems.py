"""Each method converges to the solution of its full system of equations, which is solved here without splitting.

The equations are those of Negrut, Jay and Khude (2009), in a, lam (index 3); a, abar, lam, mu; v', q', lam, mu; and
a, psi_I, psi_II: neither the splitting nor the unknowns that mbdsl iterates on, and with M(q) as a matrix. Newton's
method here has a Jacobian by differences and goes on to rounding, and so does mbdsl, with tolerances of zero.

Positions are found to some eps relative to the mechanism, velocities to eps/h of that or of their own size, multipliers
to eps/h^2 times masses, which is 1e-10 of them and less; taking Phi_q, or M, at the wrong end of the step causes at
least a hundred times the allowed difference.
"""

from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest

import mbdsl
from mbdsl.initial.consistent import initial_state
from mbdsl.integrators.loop import loop_state
from mbdsl.integrators.methods.nstiff import S
from mbdsl.integrators.run import MethodRun
from mbdsl.kernels import buffer_layout as L
from mbdsl.mechanism import graph
from mbdsl.system import System, build

MODELS = Path(__file__).parents[3] / "models"
#: a soft beam that stiffens, by elements, with rotary inertia and damping, in a loop with a modal one
SOFT = """
model Soft
  Ground ground;
  Frame fixed_at(ground, r = {1.6 m, -0.6 m});
  FlexibleBeam beam(length = 1 m, mass = 2 kg, E = 20 MPa, S = 4 cm2, I = 3e-6 m4, rotary = 0.01 kg.m, elements = 1,
                    reference = "clamped-free", alpha = 0.3, beta = 1 ms, frames(p = {0.2 m, 0, 0.3}));
  FlexibleBeam link(length = 0.8 m, mass = 1 kg, E = 20 MPa, S = 3 cm2, I = 2e-6 m4, modes = 3,
                    basis = "craig-bampton");
  Rod arm(m = 0.5 kg, length = 0.4 m);
  Revolute O(ground, beam.a);
  Revolute A(beam.b, link.a);
  Revolute B(link.b, arm.a);
  SpringDamper spring(ground, beam.p, k = 20 N/m, s0 = 0.2 m, c = 0.5 N.s/m);
  Revolute C(arm.b, fixed_at);
initial equation
  beam.phi = -20 deg;
  beam.w = 3 rad/s;
  guess link.phi = -40 deg;
  guess arm.phi = 60 deg;
end Soft;
"""
STEPS = {"slider_crank": 4e-3, "seven_body": 1e-4, "double_pendulum": 2e-3, "flexible_slider_crank": 4e-3, "soft": 2e-3}
FLEXIBLE = ("flexible_slider_crank", "soft")
METHODS = (
    "hht-si2",
    "nstiff-si2",
    "hht-add",
    "newmark",
    "hht-i3",
    "nstiff",
    "generalized-alpha",
    "generalized-alpha-i3",
)
#: steps after which all parts of the mechanism move
LATE = 25
EPS = np.finfo(float).eps
ALPHA, B = -0.1, 0.0
BETA, GAMMA = (1 - ALPHA) ** 2 / 4, 1 / 2 - ALPHA


@dataclass
class Before:
    """The state from which a step starts."""

    system: System
    t: float
    h: float
    q: np.ndarray
    v: np.ndarray
    a: np.ndarray  #: a_n; for hht-add, the acceleration of the applied forces
    lam: np.ndarray
    q1: np.ndarray  #: one step earlier; of generalized-alpha, A_n
    v1: np.ndarray
    first_order: bool  #: backward Euler, for a stiff start
    near: tuple[np.ndarray, ...] = ()  #: the end of the step by mbdsl


def solve(residual, x, d):
    """Newton's method with differences of d in x, until the corrections stop decreasing; d is also their scale."""
    J = np.empty((x.size, x.size))
    last = np.inf
    for _ in range(40):
        for k in range(x.size):
            e = np.zeros(x.size)
            e[k] = d[k]
            J[:, k] = (residual(x + e) - residual(x - e)) / (2 * d[k])
        change = np.linalg.solve(J * d, -residual(x)) * d
        x = x + change
        size = np.abs(change / d).max()
        if size < 1e-4 and size >= 0.5 * last:
            return x
        last = size
    raise AssertionError("no convergence")


def index_3(s, motion, alpha, mass_at):
    """q, v, lam of the methods that differ in how q and v follow a alone, and in alpha."""
    S, h, n, m, t = s.system, s.h, s.system.n, s.system.m, s.t + s.h
    f0 = S.evaluate(s.t, s.q, s.v, s.lam)[0]

    def residual(x):
        a, lam = np.split(x, [n])
        q, v = motion(a)
        f, Phi, _ = S.evaluate(t, q, v, lam)
        Ma = S.M(t, q if mass_at is None else mass_at) @ a
        return np.concatenate([Ma / (1 + alpha) - f + alpha / (1 + alpha) * f0, Phi / h**2])

    x = solve(residual, np.concatenate([s.a, s.lam]), np.repeat([1e-3 / h, 1.0], [n, m]))
    return *motion(x[:n]), x[n:]


def newmark_motion(s, beta, gamma):
    h = s.h
    return lambda a: (
        s.q + h * s.v + h**2 / 2 * ((1 - 2 * beta) * s.a + 2 * beta * a),
        s.v + h * ((1 - gamma) * s.a + gamma * a),
    )


def newmark(s, mass_at=None):
    return index_3(s, newmark_motion(s, 0.55**2, 0.6), 0.0, mass_at)


def hht_i3(s, mass_at=None):
    mass_at = s.q + (1 + ALPHA) * s.h * s.v if mass_at is None else mass_at
    return index_3(s, newmark_motion(s, BETA, GAMMA), ALPHA, mass_at)


def nstiff(s, mass_at=None):
    h, q, v, q1, v1 = s.h, s.q, s.v, s.q1, s.v1

    def motion(a):
        if s.first_order:
            return q + h * v + h**2 * a, v + h * a
        return (
            4 / 3 * q - q1 / 3 + h * (8 / 9 * v - 2 / 9 * v1) + 4 / 9 * h**2 * a,
            4 / 3 * v - v1 / 3 + 2 / 3 * h * a,
        )

    return index_3(s, motion, 0.0, mass_at)


def hht_si2(s, pose=None, mass_at=None):
    """q, v, lam, mu at the end of the step. ``pose``: where the second Phi_q is evaluated, if not at q_{n+1};
    ``mass_at``: the same for M, if not where the method evaluates it."""
    S, h, n, m, t = s.system, s.h, s.system.n, s.system.m, s.t + s.h
    M = S.M(t, s.q + (1 + ALPHA) * h * s.v if mass_at is None else mass_at)
    f0 = S.evaluate(s.t, s.q, s.v, s.lam)[0]

    def parts(x):
        a, abar, lam, mu = np.split(x, [n, 2 * n, 2 * n + m])
        q = s.q + h * s.v + h**2 / 2 * ((1 - 2 * BETA) * s.a + 2 * BETA * a) + h**2 / 2 * abar
        return q, s.v + h * ((1 - GAMMA) * s.a + GAMMA * a), a, abar, lam, mu

    def residual(x):
        q, v, a, abar, lam, mu = parts(x)
        f, Phi, dPhi = S.evaluate(t, q, v, lam)
        G = S.Phi_q(t, q if pose is None else pose)
        R1 = M @ a / (1 + ALPHA) - f + ALPHA / (1 + ALPHA) * f0
        return np.concatenate([R1, M @ abar + G.T @ mu, Phi / h**2, dPhi / h])

    x = solve(residual, np.concatenate([s.a, 0 * s.a, s.lam, 0 * s.lam]), np.repeat([1e-3 / h, 1.0], [2 * n, 2 * m]))
    q, v, _a, _abar, lam, mu = parts(x)
    return q, v, lam, mu


def nstiff_si2(s, pose=None, mass_at=None):
    S, h, n, m, t = s.system, s.h, s.system.n, s.system.m, s.t + s.h
    k = 1.0 if s.first_order else 2 / 3
    q0, v0 = (s.q, s.v) if s.first_order else (4 / 3 * s.q - s.q1 / 3, 4 / 3 * s.v - s.v1 / 3)

    def parts(x):
        a, dq, lam, mu = np.split(x, [n, 2 * n, 2 * n + m])
        return q0 + k * h * dq, v0 + k * h * a, a, dq, lam, mu

    def residual(x):
        q, v, a, dq, lam, mu = parts(x)
        f, Phi, dPhi = S.evaluate(t, q, v, lam)
        G = S.Phi_q(t, q if pose is None else pose)
        M = S.M(t, q if mass_at is None else mass_at)
        return np.concatenate([M @ a - f, (v - dq + G.T @ mu) / h, Phi / (k * h) / h, dPhi / (k * h)])

    x = np.concatenate([s.a, s.v, s.lam, 0 * s.lam])
    x = solve(residual, x, np.repeat([1e-3 / h, 1e-3, 1.0, 1e-3], [n, n, m, m]))
    q, v, _a, _dq, lam, mu = parts(x)
    return q, v, lam, mu


def generalized_motion(s, rho=0.8):
    h, am, af = s.h, (2 * rho - 1) / (rho + 1), rho / (rho + 1)
    g = 1 / 2 + af - am
    b = (g + 1 / 2) ** 2 / 4

    def motion(a, abar=0.0):
        A = ((1 - af) * a + af * s.a - am * s.q1) / (1 - am)
        return s.q + h * s.v + h**2 * ((1 / 2 - b) * s.q1 + b * A + abar / 2), s.v + h * ((1 - g) * s.q1 + g * A)

    return motion


def generalized_alpha_i3(s, mass_at=None):
    return index_3(s, generalized_motion(s), 0.0, mass_at)


def generalized_alpha(s, pose=None, mass_at=None):
    S, h, n, m, t, motion = s.system, s.h, s.system.n, s.system.m, s.t + s.h, generalized_motion(s)

    def residual(x):
        a, abar, lam, mu = np.split(x, [n, 2 * n, 2 * n + m])
        q, v = motion(a, abar)
        f, Phi, dPhi = S.evaluate(t, q, v, lam)
        G, M = S.Phi_q(t, q if pose is None else pose), S.M(t, q if mass_at is None else mass_at)
        return np.concatenate([M @ a - f, M @ abar + G.T @ mu, Phi / h**2, dPhi / h])

    x = solve(residual, np.concatenate([s.a, 0 * s.a, s.lam, 0 * s.lam]), np.repeat([1e-3 / h, 1.0], [2 * n, 2 * m]))
    a, abar, lam, mu = np.split(x, [n, 2 * n, 2 * n + m])
    return *motion(a, abar), lam, mu


def hht_add(s, pose=None, mass_at=None):
    """q, v, psi_I, psi_II, with M at both ends of the step. Newton's method starts near mbdsl's end of the step: from
    the start of the step it would not converge in the stiff pendulum's transient."""
    S, h, n, m, t = s.system, s.h, s.system.n, s.system.m, s.t + s.h
    M0, G0 = S.M(s.t, s.q), S.Phi_q(s.t, s.q)
    fa0 = np.linalg.solve(M0, S.Q(s.t, s.q, s.v))

    def parts(x, G, M):
        a, psi1, psi2 = np.split(x, [n, n + m])
        R_I, R_II = -np.linalg.solve(M0, G0.T @ psi1), -np.linalg.solve(M, G.T @ psi2)
        q = s.q + h * s.v + h**2 / 2 * ((1 - 2 * BETA) * s.a + 2 * BETA * a) + h**2 / 2 * ((1 - B) * R_I + B * R_II)
        return q, s.v + h * ((1 - GAMMA) * s.a + GAMMA * a) + h / 2 * (R_I + R_II), a, psi1, psi2

    def at_end(x):
        # b = 0: q_{n+1} does not depend on R_II, so that Phi_q(q_{n+1}) is known before it is asked for
        q = parts(x, G0, M0)[0]
        return S.Phi_q(t, q if pose is None else pose), S.M(t, q if mass_at is None else mass_at)

    def residual(x):
        G, M = at_end(x)
        q, v, a, _psi1, _psi2 = parts(x, G, M)
        fa = np.linalg.solve(M, S.Q(t, q, v))
        _f, Phi, dPhi = S.evaluate(t, q, v)
        return np.concatenate([a - (1 + ALPHA) * fa + ALPHA * fa0, Phi / h**2, dPhi / h])

    assert B == 0.0
    near = [np.linalg.solve(S.M(t, s.near[0]), S.Q(t, s.near[0], s.near[1])), 1.01 * s.near[2], 0.99 * s.near[3]]
    x = solve(residual, np.concatenate(near), np.repeat([1e-3 / h, 1.0], [n, 2 * m]))
    q, v, _a, psi1, psi2 = parts(x, *at_end(x))
    return q, v, psi1, psi2


SPLIT = {
    "hht-si2": hht_si2, "nstiff-si2": nstiff_si2, "hht-add": hht_add, "generalized-alpha": generalized_alpha
}  # fmt: skip
INDEX_3 = {"newmark": newmark, "hht-i3": hht_i3, "nstiff": nstiff, "generalized-alpha-i3": generalized_alpha_i3}
FULL = {**SPLIT, **INDEX_3}


def integration(model, method):
    """A system, and a run of it whose iteration stops at rounding."""
    scene = mbdsl.parse(SOFT) if model == "soft" else mbdsl.load(MODELS / f"{model}.mbd")
    mechanism = graph.build(scene)
    system, h = build(scene, mechanism), STEPS[model]
    start = initial_state(system, mechanism, 0.0)
    run = MethodRun(system, method, h, 0.0, 1000 * h, np.array([]))
    run.reals[loop_state.VELOCITY_TOL] = run.reals[loop_state.RELATIVE_TOL] = 0.0
    run.begin(start.q, start.v, start.a, start.lam)
    return system, run


def steps(model, method, done):
    """The state after ``done`` steps of a run, before the next one; and q, v and multipliers after the next one."""
    system, run = integration(model, method)
    n, h = system.n, run.h
    assert not done or run.advance(done) == loop_state.RUNNING
    Y = run.vectors.copy()
    a = Y[L.KEPT if method == "hht-add" else L.UNKNOWN0]
    euler = method.startswith("nstiff") and run.memory[S] == 1.0
    q, v, lam = Y[L.POSITION0, :n], Y[L.VELOCITY0, :n], Y[L.UNKNOWN0, n:]
    kept = Y[L.KEPT, :n], Y[L.KEPT2, :n]
    before = Before(system, done * h, h, q, v, a[:n], lam, *kept, euler)
    assert run.advance(1) == loop_state.RUNNING
    Y = run.vectors
    before.near = (Y[L.POSITION0, :n], Y[L.VELOCITY0, :n], Y[L.UNKNOWN0, n:])
    if method in SPLIT:
        before.near += (Y[L.UNKNOWN0 + L.PAST, n:],)
    return before, before.near


@pytest.mark.parametrize("model", FLEXIBLE)
def test_hht_si2_looks_at_the_mass_matrix_once_a_step(model):
    """Evaluated at the predictor, for any number of iterations; other methods evaluate it at every iterate."""
    for method in ("hht-si2", "nstiff-si2"):
        S, run = integration(model, method)
        for _ in range(4):
            q, v = (
                run.vectors[L.POSITION0, : S.n].copy(),
                run.vectors[L.VELOCITY0, : S.n].copy(),
            )
            iterations = run.integers[loop_state.ITERATIONS]
            assert run.advance(1) == loop_state.RUNNING
            assert run.integers[loop_state.ITERATIONS] > iterations + 1
            assert run.layout[L.NEW_MASS] == 0
            used, end = run.vectors[L.MASS_POSITION, : S.n], run.vectors[L.POSITION0, : S.n]
            a = run.vectors[L.UNKNOWN0, : S.n]
            if method == "hht-si2":
                assert np.array_equal(used, q + (1 + ALPHA) * run.h * v)
                beside = (S.M(0.0, used) - np.diag(S.mass())) @ a
                assert run.vectors[L.MX, : S.n] == pytest.approx(
                    beside, rel=0, abs=1e-9 * max(1.0, np.abs(beside).max())
                )
            else:
                assert not used.any() and run.layout[L.MASS_ROW] == L.POSITION
            assert np.abs(end - q).max() > 1e-6


def distances(found, expected):
    return np.array([np.abs(x - y).max() for x, y in zip(found, expected, strict=True)])


def tolerances(s, method, expected):
    """Differences of q, v, lam (or psi_I) and mu (or psi_II)."""
    q = 256 * EPS * max(1.0, np.abs(s.q).max())
    v = max(2 * q / s.h, 256 * EPS * np.abs(s.v).max())
    force = 1e-10 * np.abs(expected[2]).max()
    if method == "nstiff-si2":  # v - q' + Phi_q^T mu = 0
        smallest = np.linalg.svd(s.system.Phi_q(s.t, s.q), compute_uv=False)[-1]
        return np.array([q, v, force, q / s.h / smallest / 16])
    return np.array([q, v, force, force])[: len(expected)]


@pytest.mark.parametrize("done", [0, 1, 2, LATE])
@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("model", STEPS)
def test_a_step(model, method, done):
    if model == "double_pendulum" and not method.startswith("nstiff"):
        done += 2  # its start is stiff: two steps of backward Euler come first
    s, found = steps(model, method, done)
    expected = FULL[method](s)
    off, allowed = distances(found, expected), tolerances(s, method, expected)
    assert (off < allowed).all(), (off, allowed)
    if done >= LATE and model in FLEXIBLE:  # the test would detect M of the step's start
        other = distances(FULL[method](s, mass_at=s.q), expected)
        assert (other / allowed).max() > 100
    if done >= LATE and method in SPLIT:  # or a Phi_q of the step's start
        other = distances(FULL[method](s, pose=s.q), expected)
        assert (other / allowed).max() > 100
