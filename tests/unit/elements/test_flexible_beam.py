"""Flexible beams of all kinds in one chain: their forces satisfy Lagrange's equations, their kernels agree with their
models, and the operations with the mass matrix agree with the matrix itself.

Differences are five-point with step H, of energies that are quadratic in the rates and trigonometric in one angle:
truncation H^4/30 f^(5) = 3e-14 f^(5) and rounding eps/H = 2e-13 of values up to 1e3.
"""

from functools import cache

import numpy as np
import pytest

from mbdsl import Builder
from mbdsl.bodies.contract import POSITIONS, VELOCITIES
from mbdsl.kernels import buffer_layout as L
from mbdsl.system import build
from mbdsl.system.tables import gravity

H, TOLERANCE = 1e-3, 1e-9
#: the kinds of beams, all with one structure of the code
BEAMS = {
    "pinned": dict(elements=2, rotary=0.02, alpha=0.3, beta=0.1),
    "clamped": dict(elements=3, reference='"clamped-free"', rotary=0.05),
    "linear": dict(elements=2, stiffening=False, rotary=0.1),
    "modes": dict(modes=5, axial=2, elements=4, rotary=0.03, zeta=0.1),
    "ends": dict(modes=6, elements=3, basis='"craig-bampton"', reference='"clamped-free"'),
    "free": dict(modes=5, elements=3, basis='"craig-bampton"', reference='"mean-axis"', rotary=0.05, alpha=0.2),
    "one": dict(modes=1, elements=2, stiffening=False),
}
DAMPING = ("alpha", "beta", "zeta")


@cache
def chain(damped=True):
    """All of them between the ground and a rigid rod, each held at two places off its ends."""
    rng = np.random.default_rng(5)
    builder = Builder("Chain")
    builder.Ground("ground", n=(0.6, -0.8))
    builder.Rod("rod", m=1.0, length=1.0)
    before = "ground"
    for name, given in BEAMS.items():
        length, S, I, E = rng.uniform(0.8, 1.6, 4)
        frames = {"p": (-0.31 * length, 0.0, 0.3), "q": (0.23 * length, 0.0, -0.4)}
        used = {key: value for key, value in given.items() if damped or key not in DAMPING}
        beam = dict(length=length, S=S, I=I, E=E, mass=rng.uniform(0.5, 2.0))
        builder.FlexibleBeam(name, **beam, **used, frames=frames)
        builder.Revolute(f"to_{name}", before, f"{name}.p")
        before = f"{name}.q"
    builder.Revolute("to_rod", before, "rod.a")
    builder.experiment(stop=1.0)
    return build(builder.scene())


def beams(s):
    for name in BEAMS:
        body = s.tables.models[name]
        yield name, slice(s.tables.coordinates[name], s.tables.coordinates[name] + body.n), body


def state(s, seed=0, bent=0.01):
    rng = np.random.default_rng(seed)
    q, v = rng.uniform(-2, 2, s.n), rng.normal(size=s.n)
    for _, at, body in beams(s):
        q[at] = body.placed(q[at][:3])[0] + bent * rng.uniform(-1, 1, body.n)
    return q, v, rng.normal(size=s.m)


def jacobian(f, x):
    return np.array(
        [(8 * (f(x + e) - f(x - e)) - f(x + 2 * e) + f(x - 2 * e)) / (12 * H) for e in H * np.eye(len(x))]
    ).T


def close(found, expected, tolerance=TOLERANCE):
    size = max(1.0, np.abs(expected).max(initial=0.0))
    np.testing.assert_allclose(found, expected, rtol=0, atol=tolerance * size)


# -- forces and frames -----------------------------------------------------------------------------------------------


@pytest.mark.parametrize("seed", range(3))
def test_forces_are_those_of_lagranges_equations(seed):
    """d/dt (M v) - T_q + V_q = M v' - Q, with T and V from ``energies``, at v' = 0."""
    s = chain(damped=False)
    q, v, _ = state(s, seed)
    g, Q = gravity(s.scene), s.Q(0.0, q, v)
    close(g, 9.81 * np.array([0.6, -0.8]))
    for _name, at, body in beams(s):
        x, w = q[at], v[at]
        assert np.linalg.eigvalsh(body.M(x)).min() > 0.0
        T, _ = body.energies(x[None], w[None], g)
        close(T[0], w @ body.M(x) @ w / 2, 1e-13)
        momentum_rate = jacobian(lambda y, b=body, w=w: b.M(y) @ w, x) @ w
        T_q, V_q = (jacobian(lambda y, k=k, b=body, w=w: b.energies(y[None], w[None], g)[k][0], x) for k in (0, 1))
        close(Q[at], T_q - V_q - momentum_rate)


def test_damping_takes_energy_and_nothing_else():
    s, free = chain(), chain(damped=False)
    q, v, _ = state(s)
    force = s.Q(0.0, q, v) - free.Q(0.0, q, v)
    for name, at, body in beams(s):
        D = s.damping(0.0, q, 0 * v)[at, at]
        close(force[at], -D @ v[at], 1e-12)
        assert not D[:3].any() and not D[:, :3].any()
        close(D, D.T, 1e-13)
        if set(BEAMS[name]) & set(DAMPING):
            assert np.linalg.eigvalsh(D[3:, 3:]).min() > 0.0
        else:
            assert not D.any()
        assert body.k == len(D) - 3


def test_frames_move_as_the_models_say():
    s = chain()
    q, v, _ = state(s)
    s.evaluate(0.0, q, v)
    Z = s._work.frames
    for name, at, body in beams(s):
        for frame in ("p", "q"):
            pose = s.scene.frames[f"{name}.{frame}"]
            pose = (pose.x, pose.y, pose.phi)
            z = Z[s.tables.frames[f"{name}.{frame}"]]

            def at_state(x, w, keys, pose=pose, body=body):
                return np.array([body.frame(pose, key, x[None], w[None])[0] for key in keys])

            x, w = q[at], v[at]
            close(z[:6], at_state(x, w, POSITIONS + VELOCITIES), 1e-13)
            B, rate = body.gradient(pose, x, w)
            close(B, jacobian(lambda y, w=w, f=at_state: f(y, w, POSITIONS), x))
            close(B @ w, z[3:6], 1e-13)
            close(rate, jacobian(lambda y, w=w, f=at_state: f(y, w, VELOCITIES), x))
            own = np.flatnonzero((B != 0.0).any(axis=0) | (rate != 0.0).any(axis=0))
            assert set(own) <= set(body.dofs(pose))


# -- tasks of the mass matrix ----------------------------------------------------------------------------------------


def evaluated(s, sets=2, seed=0):
    """A workspace with the state evaluated in it, M and random vectors."""
    q, v, lam = state(s, seed)
    w = s.workspace()
    w.vectors[L.POSITION, : s.n], w.vectors[L.VELOCITY, : s.n] = q, v
    w.vectors[L.UNKNOWN : L.UNKNOWN2 + 1] = np.random.default_rng(seed + 9).normal(size=w.vectors[:2].shape)
    w.vectors[L.UNKNOWN, s.n : s.unknowns] = lam
    kernels = s.kernels(sets)
    kernels.evaluate(0.0, w.vectors, w.frames, w.gradients, w.numbers, w.layout)
    return w, kernels, q, s.M(0.0, q)


def test_evaluate_multiplies_with_what_m_has_beside_its_diagonal():
    s = chain()
    w, _, q, M = evaluated(s)
    off, x = M - np.diag(s.mass()), w.vectors[:, : s.n]
    assert not np.allclose(off, np.diag(off.diagonal())) and np.abs(off.diagonal()).max() > 1e-3
    close(x[L.MX], off @ x[L.UNKNOWN], 1e-13)
    close(x[L.MX2], off @ x[L.UNKNOWN2], 1e-13)
    # and the rows are those that a method names
    w.layout[L.INERTIA_ROW], w.layout[L.INERTIA_ROW2] = (
        L.VELOCITY,
        L.UNKNOWN,
    )
    s.kernels(2).evaluate(0.0, w.vectors, w.frames, w.gradients, w.numbers, w.layout)
    close(x[L.MX], off @ x[L.VELOCITY], 1e-13)
    close(x[L.MX2], off @ x[L.UNKNOWN], 1e-13)
    assert np.array_equal(x[L.POSITION], q)


def test_times_and_inverse():
    s = chain()
    w, kernels, _, M = evaluated(s)
    x, inertia = w.vectors[:, : s.n], kernels.inertia
    inertia(L.TIMES, L.UNKNOWN2, L.TEMPORARY, w.vectors, w.numbers, w.layout)
    close(x[L.TEMPORARY], (M - np.diag(s.mass())) @ x[L.UNKNOWN2], 1e-13)
    inertia(L.INVERSE, L.UNKNOWN, L.TEMPORARY2, w.vectors, w.numbers, w.layout)
    close(M @ x[L.TEMPORARY2], x[L.UNKNOWN], 1e-10)
    close(x[L.TEMPORARY2], s.solve_mass(0.0, x[L.POSITION], x[L.UNKNOWN]), 1e-10)
    # at other coordinates
    other = state(s, 1)[0]
    w.vectors[L.POSITION, : s.n] = other
    kernels.evaluate(0.0, w.vectors, w.frames, w.gradients, w.numbers, w.layout)
    inertia(L.INVERSE, L.UNKNOWN, L.TEMPORARY2, w.vectors, w.numbers, w.layout)
    there = s.M(0.0, other)
    close(there @ x[L.TEMPORARY2], x[L.UNKNOWN], 1e-10)
    assert np.abs(M @ x[L.TEMPORARY2] - x[L.UNKNOWN]).max() > 1e-2
    assert np.array_equal(x[L.POSITION], other)


def test_m_at_coordinates_of_its_own():
    """A method may keep M: M is then evaluated at the state and time where it was kept, in values and in tangents."""
    s = chain()
    w, kernels, q, M = evaluated(s)
    Y, n, A = w.vectors, s.n, np.zeros(s.size)
    rows, columns = s.tables.pattern

    def looked_at(where, new):
        Y[L.MASS_POSITION, :n], w.layout[L.NEW_MASS] = where, new
        kernels.evaluate(0.0, Y, w.frames, w.gradients, w.numbers, w.layout)
        kernels.tangent(0.0, 1.0, *[0.0] * 12, Y, w.frames, w.gradients, w.numbers, w.layout, A)
        found = np.zeros((s.unknowns, s.unknowns))
        np.add.at(found, (rows, columns), A)
        kernels.inertia(L.INVERSE, L.UNKNOWN, L.TEMPORARY2, Y, w.numbers, w.layout)
        return found[:n, :n]

    w.layout[L.MASS_ROW] = L.MASS_POSITION
    former, other = state(s, 1)[0], state(s, 2)[0]
    there = s.M(0.0, former)
    for where, new in ((former, 1), (other, 0)):
        close(looked_at(where, new), there, 1e-13)
        close(Y[L.MX, :n], (there - np.diag(s.mass())) @ Y[L.UNKNOWN, :n], 1e-13)
        close(there @ Y[L.TEMPORARY2, :n], Y[L.UNKNOWN, :n], 1e-10)
    close(looked_at(other, 1), s.M(0.0, other), 1e-13)
    assert np.array_equal(Y[L.POSITION, :n], q) and np.abs(there - M).max() > 1e-2


def test_reactions_of_the_start_of_a_step_are_carried_over():
    """GP = M M_n^{-1} Phi_q(q_n)^T psi, n where KEEP was set."""
    s = chain()
    w, kernels, q, M_n = evaluated(s, sets=3)
    Y, n = w.vectors, s.n
    G_n = s.Phi_q(0.0, q)
    w.layout[L.KEEP] = 1
    for seed in (3, 4):  # nothing is kept the second time: n is still the earlier state
        Y[L.POSITION, :n], Y[L.VELOCITY, :n], psi = state(s, seed)
        Y[L.UNKNOWN, n : s.unknowns] = psi
        kernels.evaluate(0.0, Y, w.frames, w.gradients, w.numbers, w.layout)
        assert w.layout[L.KEEP] == 0
        M = s.M(0.0, Y[L.POSITION, :n])
        expected = M @ np.linalg.solve(M_n, G_n.T @ psi)
        close(Y[L.PAST_FORCE, :n], expected, 1e-10)
        assert np.abs(G_n.T @ psi - expected).max() > 1e-2
        close(
            Y[L.FORCE2, :n],
            s.Phi_q(0.0, Y[L.POSITION, :n]).T @ Y[L.UNKNOWN2, n : s.unknowns],
            1e-12,
        )
